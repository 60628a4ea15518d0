//! What a reader asks of an identification first: its fit, its bounds, its strong correlations.

use super::identify::Identification;
use crate::methods::prediction_error::{Estimate, Fit, Status};

/// How sure the estimated parameters are: Cramér–Rao bounds, one sigma, in percent of the values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundSummary<'a> {
    /// The median over the parameters; of an even number the upper of the two in the middle.
    pub median_percent: f64,
    /// The worst.
    pub worst_percent: f64,
    /// The parameter that has it.
    pub worst: &'a str,
}

impl Identification {
    /// The fit to judge it by: over held-back test points where there are any, else over those that
    /// the parameters are from.
    #[must_use]
    pub fn fit(&self) -> &Fit {
        self.validation.as_ref().unwrap_or(&self.estimation)
    }

    /// The test points that [`fit`](Self::fit) goes over: indices into `test_points`.
    #[must_use]
    pub fn fit_points(&self) -> &[usize] {
        match self.validation {
            Some(_) => &self.validation_points,
            None => &self.estimation_points,
        }
    }

    /// The parameters of the structure, without its noises.
    #[must_use]
    pub fn parameters(&self) -> &[Estimate] {
        let list = &self.identified.estimates.list;
        list.get(..self.identified.structure.parameters.len()).unwrap_or(list)
    }

    /// The bounds without which a fit says nothing, less those of what ended on a limit of its search; `None`
    /// where nothing was estimated.
    #[must_use]
    pub fn bounds(&self) -> Option<BoundSummary<'_>> {
        let estimated = self.parameters().iter().filter(|own| own.status == Status::Free);
        let mut bounds: Vec<(f64, &str)> =
            estimated.map(|estimate| (estimate.bound_percent(), &*estimate.name)).collect();
        bounds.sort_by(|one, other| one.0.total_cmp(&other.0));
        let &(median_percent, _) = bounds.get(bounds.len() / 2)?;
        let &(worst_percent, worst) = bounds.last()?;
        Some(BoundSummary { median_percent, worst_percent, worst })
    }

    /// Pairs of parameters whose correlation exceeds `least` in size, strongest first; those of the
    /// noises are the filter's own affair.
    #[must_use]
    pub fn strong_correlations(&self, least: f64) -> Vec<(&str, &str, f64)> {
        let structure = &self.identified.structure;
        let mut pairs = self.identified.estimates.strong_correlations(least);
        pairs.retain(|(one, other, _)| {
            [one, other].iter().all(|name| structure.parameter(name).is_some())
        });
        pairs
    }
}
