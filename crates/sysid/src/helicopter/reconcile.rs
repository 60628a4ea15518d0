//! The better of the estimates in the time and in the frequency domain.
//!
//! Process noise can replace the response to a stick where a pilot or a controller moves it against gusts: the
//! likelihood then has a second optimum with wrong derivatives and small bounds. Responses at coherent frequencies do
//! not have it. Their fit therefore judges the time domain, and joins it as one more measurement.

use std::fmt;

use rayon::prelude::*;

use super::found::Found;
use super::frequency_domain::{PairCost, SideBySide};
use super::identify::Search;
use super::measured::Measured;
use crate::methods::prediction_error;

/// The time domain is rejected where its cost J of any coherent response exceeds that of the responses' own fit by this
/// factor and by this difference.
const FACTOR: f64 = 2.0;
const MARGIN: f64 = 10.0;
/// Factor on the bounds of the responses' fit where the time domain fits as well: both come from the same gusts, and the
/// errors of neighbouring frequencies are alike.
const ALIKE: f64 = 2.0;

/// A parameter on which both domains differ by more than chance allows.
#[derive(Debug, Clone, PartialEq)]
pub struct Conflict {
    /// The parameter as identified by each domain alone.
    pub parameter: SideBySide,
    /// The response that the time domain fits worst, if it was rejected for it: the model then has the value of the
    /// frequency domain.
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
    /// Replaces each of `parts` by the better estimate. Where the time domain fits every coherent response of
    /// `measured` as well as the responses' own fit, the parameters on which both agree are merged by their information.
    /// Where it does not, the fit to the responses enters with all its parameters. Only the latter where not `merges`.
    ///
    /// # Source
    /// Tischler and Remple, chapter 14: the frequency domain's result starts the time domain and fixes what it knows.
    pub(super) fn reconcile(
        &self,
        parts: &mut [Found],
        measured: Option<&Measured>,
        merges: bool,
    ) -> Vec<Conflict> {
        let Some(measured) = measured else { return Vec::new() };
        let conflicts =
            parts.par_iter_mut().map(|part| self.reconcile_part(part, measured, merges));
        conflicts.flatten().collect()
    }

    fn reconcile_part(&self, part: &mut Found, measured: &Measured, merges: bool) -> Vec<Conflict> {
        let identified = &part.identified;
        let Ok(fitted) = measured.of_part(&identified.structure).fit(identified) else {
            return Vec::new();
        };
        let is_worse = |pair: &&PairCost| pair.time > FACTOR * pair.frequency + MARGIN;
        let worst = fitted.costs.iter().filter(is_worse);
        let worst = worst.max_by(|one, other| one.time.total_cmp(&other.time));
        let alike = if worst.is_some() { 1.0 } else { ALIKE };
        if worst.is_none() && !merges {
            return Vec::new();
        }
        let known: Vec<(usize, f64, f64)> = (fitted.places.iter().zip(&fitted.parameters))
            .filter(|(_, own)| worst.is_some() || !own.disagrees())
            .map(|(&place, own)| (place, own.frequency.0, alike * own.frequency.1))
            .collect();
        let settings = self.settings(part.kind);
        let starts = worst.is_some();
        let merged =
            prediction_error::identify_with(identified, &known, starts, self.stretches, &settings);
        let Ok(merged) = merged else { return Vec::new() };
        let apart = fitted.parameters.iter().filter(|own| own.disagrees());
        let conflicts = apart
            .map(|own| Conflict { parameter: own.clone(), denied_by: worst.cloned() })
            .collect();
        part.identified = merged;
        conflicts
    }
}
