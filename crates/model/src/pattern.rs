//! A discrete matrix taken for a continuous one gives itself away by its dampings.

use std::fmt;

use super::linear::TimeDomain;
use super::state_space::StateSpace;

/// The states whose own diagonal term is a damping: rates and velocities.
const DAMPED: [&str; 6] = ["p", "q", "r", "u", "v", "w"];

/// Every damping of a continuous model is positive and below one: the mark of a one-step transition
/// matrix taken for a continuous one. Shown, it explains itself.
///
/// The diagonal of a transition matrix over a short period is near e^(damping·period), in (0, 1) for
/// anything that is damped. The same numbers as continuous dampings say that every rate and every
/// velocity grows by itself, which no helicopter with a stabilizer bar and a rate gyro does.
#[derive(Clone, Debug, PartialEq)]
pub struct StepTakenForRate {
    /// The period at which the matrix is read as a step, s.
    pub period_s: f64,
    /// State, the term as it stands, the damping it means if the matrix is a step: ln(term)/period, 1/s.
    pub dampings: Vec<(String, f64, f64)>,
}

impl StateSpace {
    /// Looks for the pattern. `period_s` is the period at which the data were sampled; none is found
    /// in a discrete model, or in one that has no rate and no velocity.
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
             vehicles are: the matrix is very probably a discrete transition matrix taken for a \
             continuous one",
            list(&|each| each.1),
            self.period_s,
            list(&|each| each.2),
        )
    }
}
