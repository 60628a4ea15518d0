//! Choice between the estimates of the time domain and of the frequency domain.
//!
//! If a pilot or a controller moves a stick against gusts, process noise can replace the response to the stick. The
//! likelihood then has a second optimum with wrong derivatives and small bounds. The fit to responses at coherent
//! frequencies does not have this optimum. It therefore checks the time domain, and enters the search in the time
//! domain as one more measurement.

use std::fmt;

use rayon::prelude::*;

use super::found::Found;
use super::measured::Measured;
use super::search::Search;
use super::side_by_side::{PairCost, SideBySide};
use crate::methods::prediction_error;

/// Factor in the rejection of the time domain. It is rejected if its cost J of a coherent response exceeds a limit. The
/// limit is [`FACTOR`] times the cost of the frequency-domain fit, plus [`MARGIN`].
const FACTOR: f64 = 2.0;
/// Constant part of the limit of the cost J above which the time domain is rejected, see [`FACTOR`].
const MARGIN: f64 = 10.0;
/// Ratio of a parameter's bound in the frequency domain to that in the time domain below which both are merged. The
/// same gusts affect both domains: estimates with similar bounds have similar errors, and a merge does not improve
/// them.
const MUCH_BETTER: f64 = 0.25;

/// A parameter on which both domains differ by more than chance allows.
#[derive(Debug, Clone, PartialEq)]
pub struct Conflict {
    /// The parameter as identified by each domain alone.
    pub parameter: SideBySide,
    /// The response that the time domain fits worst, if the time domain was rejected. The search then uses the values
    /// of the frequency domain as further measurements.
    pub denied_by: Option<PairCost>,
}

impl fmt::Display for Conflict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let both = self.parameter.in_words();
        match &self.denied_by {
            Some(PairCost { stick, output, time, frequency, .. }) => write!(
                f,
                "{both}; used: the frequency domain, which fits {stick} to {output} better (cost J {frequency:.0}, not \
                 {time:.0})"
            ),
            None => write!(f, "{both}; used: the time domain, which fits every response as well"),
        }
    }
}

impl Search<'_> {
    /// Improves each of `parts` by the fit to the responses of `measured`. If the time domain was rejected, all
    /// parameters of this fit enter the search in the time domain. Otherwise only those enter on which both domains
    /// agree and whose bounds are much smaller in the frequency domain. A delay with a fixed lag never enters.
    ///
    /// # Source
    /// Tischler and Remple, chapter 14: the result of the frequency domain is the start of the time domain, and fixes
    /// the parameters that it determines well.
    pub(super) fn reconcile(
        &self,
        parts: &mut [Found],
        measured: Option<&Measured>,
    ) -> Vec<Conflict> {
        let Some(measured) = measured else { return Vec::new() };
        let conflicts = parts.par_iter_mut().map(|part| self.reconcile_part(part, measured));
        conflicts.flatten().collect()
    }

    fn reconcile_part(&self, part: &mut Found, measured: &Measured) -> Vec<Conflict> {
        let identified = &part.identified;
        let Ok(fitted) = measured.of_part(&identified.structure).fit(identified) else {
            return Vec::new();
        };
        let is_worse = |pair: &&PairCost| pair.time > FACTOR * pair.frequency + MARGIN;
        let worst = fitted.costs.iter().filter(is_worse);
        let worst = worst.max_by(|one, other| one.time.total_cmp(&other.time));
        let is_denied = worst.is_some();
        let is_better =
            |own: &SideBySide| !own.disagrees() && own.frequency.1 < MUCH_BETTER * own.time.1;
        let known: Vec<(usize, f64, f64)> = (fitted.places.iter().zip(&fitted.parameters))
            .filter(|(_, own)| is_denied || is_better(own))
            .filter(|(place, _)| !fitted.depends_on_lag(&identified.structure, **place))
            .map(|(&place, own)| (place, own.frequency.0, own.frequency.1))
            .collect();
        let apart = fitted.parameters.iter().filter(|own| own.disagrees());
        let conflicts = apart
            .map(|own| Conflict { parameter: own.clone(), denied_by: worst.cloned() })
            .collect();
        if !known.is_empty() {
            let settings = self.settings(&part.structure);
            let merged =
                prediction_error::identify_with(identified, &known, self.stretches, &settings);
            match merged {
                Ok(merged) => (part.identified, part.known) = (merged, known),
                Err(_) => return Vec::new(),
            }
        }
        conflicts
    }
}
