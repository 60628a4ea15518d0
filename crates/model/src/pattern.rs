//! Detection of a discrete A that is used as a continuous A, from its damping terms.

use std::fmt;

use super::linear::TimeDomain;
use super::state_space::StateSpace;

/// States whose diagonal term is a damping: rates and velocities.
const DAMPED: [&str; 6] = ["p", "q", "r", "u", "v", "w"];

/// Evidence that a one-step transition matrix is used as a continuous A: every damping term is positive and below one.
/// The `Display` text explains the evidence.
///
/// The diagonal of a transition matrix over a short period is near e^(damping·period), which is in (0, 1) for every
/// damped state. As continuous damping terms, the same numbers mean that every rate and every velocity grows. No
/// helicopter with a stabilizer bar and a rate gyro does that.
#[derive(Clone, Debug, PartialEq)]
pub struct StepTakenForRate {
    /// Assumed period of one step of the matrix, s.
    pub period_s: f64,
    /// For each state: its name, its diagonal term, and the damping if A is a one-step matrix, ln(term)/period, 1/s.
    pub dampings: Vec<(String, f64, f64)>,
}

impl StateSpace {
    /// Checks whether A has the diagonal of a one-step transition matrix. `period_s` is the sample period of the data.
    /// `None` if it does not, for a discrete model, and for a model without rates and velocities.
    #[must_use]
    pub fn step_taken_for_rate(&self, period_s: f64) -> Option<StepTakenForRate> {
        if self.time() != TimeDomain::Continuous {
            return None;
        }
        let mut dampings = Vec::new();
        for (row, state) in self.states().iter().enumerate() {
            if DAMPED.contains(&state.name.as_str()) {
                let term = self.a()[(row, row)];
                if !(term > 0.0 && term < 1.0) {
                    return None;
                }
                dampings.push((state.name.clone(), term, term.ln() / period_s));
            }
        }
        (!dampings.is_empty()).then_some(StepTakenForRate { period_s, dampings })
    }
}

impl fmt::Display for StepTakenForRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let list = |pick: &dyn Fn(&(String, f64, f64)) -> f64| {
            let shown = self.dampings.iter().map(|each| format!("{} {:.3}", each.0, pick(each)));
            shown.collect::<Vec<_>>().join(", ")
        };
        write!(
            f,
            "every damping of this continuous model lies between 0 and 1 ({}), so every rate and \
             velocity would grow by itself. Read as a step of {:.4} s they are {} 1/s, as damped \
             vehicles are: the matrix is very probably a discrete transition matrix used as a \
             continuous one",
            list(&|each| each.1),
            self.period_s,
            list(&|each| each.2),
        )
    }
}
