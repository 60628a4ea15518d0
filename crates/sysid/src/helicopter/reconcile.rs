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
/// Largest bound of a parameter in the fit to the responses, as a part of its bound in the time domain, for which a merge
/// is worth it. Both come from the same gusts: estimates of like bounds err alike, and two of them are no better than
/// one.
const MUCH_BETTER: f64 = 0.25;

/// A parameter on which both domains differ by more than chance allows.
#[derive(Debug, Clone, PartialEq)]
pub struct Conflict {
    /// The parameter as identified by each domain alone.
    pub parameter: SideBySide,
    /// The response that the time domain fits worst, if this fit was rejected. The model then has the value of the
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
    /// Replaces each of `parts` by the better estimate. Where the time domain fits a coherent response of `measured`
    /// worse than the responses' own fit does, that fit enters with all its parameters. Elsewhere it enters with those on
    /// which both agree and which it knows much better.
    ///
    /// # Source
    /// Tischler and Remple, chapter 14: the frequency domain's result starts the time domain, and fixes its well-known parameters.
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
            let settings = self.settings(part.kind);
            let merged =
                prediction_error::identify_with(identified, &known, self.stretches, &settings);
            match merged {
                Ok(merged) => part.identified = merged,
                Err(_) => return Vec::new(),
            }
        }
        conflicts
    }
}
