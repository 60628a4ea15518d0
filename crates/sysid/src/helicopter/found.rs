//! Result of a search, with or without a stabiliser bar.

use std::sync::Arc;

use super::model_structure::ModelStructure;
use crate::methods::prediction_error::{Estimate, Identified};

/// Factor on the bounds for effects that the structure omits: servo and governor dynamics. Tischler and Remple, section
/// 12.3, use 2.
pub(super) const WIDENED: f64 = 1.5;

/// Result of a search.
pub(super) struct Found {
    pub structure: Arc<ModelStructure>,
    pub identified: Identified,
    /// Counterpart without a stabiliser bar, if the selected model has a bar.
    pub without_bar: Option<Identified>,
    /// Results of the frequency domain that entered the search: index, value and one sigma of parameters.
    pub known: Vec<(usize, f64, f64)>,
    /// See [`Identification::passed_over`](super::Identification::passed_over).
    pub passed_over: Option<Identified>,
}

impl Found {
    pub const fn alone(structure: Arc<ModelStructure>, identified: Identified) -> Self {
        Self { structure, identified, without_bar: None, known: Vec::new(), passed_over: None }
    }

    /// Selects between the models `with` and `without` a stabiliser bar.
    pub fn of_two(structure: Arc<ModelStructure>, with: Identified, without: Identified) -> Self {
        if with.aic < without.aic - bars_price(&with, &without) {
            Self { without_bar: Some(without), ..Self::alone(structure, with) }
        } else {
            let passed_over = Some(with).filter(|with| with.aic < without.aic);
            Self { passed_over, ..Self::alone(structure, without) }
        }
    }
}

/// Smallest decrease of Akaike's criterion, from the model `without` to the model `with` the bar, that justifies the
/// bar. It is λ ln(N/λ) for each parameter that only the model with the bar identifies, with N samples. ln(N/λ) is
/// Schwarz's penalty for N/λ effective samples.
///
/// λ is at least 1. It is the factor by which innovations that are not white overstate the likelihood of these
/// parameters, divided by the square of `WIDENED`.
///
/// # Source
/// Schwarz (1978), *Annals of Statistics* 6(2); Gao and Song (2010), *JASA* 105(492), for a likelihood that treats
/// correlated data as independent. Equation (I32) of docs/equations.md.
fn bars_price(with: &Identified, without: &Identified) -> f64 {
    let is_told = |name: &str| without.estimates.get(name).is_some_and(Estimate::is_estimated);
    let names = with.free_parameters().map(|own| &*with.estimates.list[own].name);
    let names: Vec<&str> = names.filter(|name| !is_told(name)).collect();
    with.estimates.inflation(&names).map_or(f64::INFINITY, |inflation| {
        let often = (inflation / WIDENED.powi(2)).max(1.0);
        names.len() as f64 * often * (with.samples as f64 / often).max(1.0).ln()
    })
}
