//! Identification of the same helicopter from the same flight in the frequency domain, as a cross-check.

use super::flight::FlightRecord;
use super::identify::Identification;
use super::measured::{Basis, Fitted, Measured};
use super::side_by_side::{PairCost, SideBySide};
use crate::methods::frequency::{FrequencyError, FrequencyResponse, Responses};

/// Identification of a flight in the frequency domain.
#[derive(Debug, Clone, PartialEq)]
pub struct FrequencyDomain {
    /// Excitation from which the responses are computed.
    pub basis: Basis,
    /// The flight's responses of all outputs to all sticks that moved, conditioned on the other sticks.
    pub measured: FrequencyResponse,
    /// Responses of the model identified in the time domain, at the same frequencies.
    pub modelled: Responses,
    /// Parameters identifiable from the responses, by both methods.
    pub parameters: Vec<SideBySide>,
    /// Parameters not identifiable from the responses. They are fixed at their time-domain values, or their bound is
    /// hardly below the sigma of the prior.
    pub untold: Vec<String>,
    /// Costs of every response that was coherent at enough frequencies.
    pub costs: Vec<PairCost>,
    /// Mean cost of the time-domain model, and of the model fitted to the responses.
    pub mean_cost: (f64, f64),
    /// Whether the fit converged.
    pub converged: bool,
}

impl FrequencyDomain {
    /// Fits the equations of `found` to the frequency responses of `record`, the flight that `found` comes from.
    ///
    /// The fit uses the responses alone. Up to 4 Hz a servo lag is equivalent to a delay. Servo lags are therefore
    /// fixed unless the flight excites much higher frequencies. Parameters that are not identifiable from the responses
    /// are fixed in groups, and the fit is repeated after each group. The bounds of the others include the time-domain
    /// bounds of all fixed parameters.
    ///
    /// # Errors
    /// [`FrequencyError`] where no stick moved independently, or no output responds coherently to a stick.
    ///
    /// # Source
    /// Tischler & Remple, chapters 9 to 12.
    pub fn of(found: &Identification, record: &FlightRecord) -> Result<Self, FrequencyError> {
        let structure = &found.identified.structure;
        let moved = record.clone().with_dead_bands(found.dead_bands);
        let clean = moved.without_tones(&found.tones, &[]).within(found.condition);
        let measured = Measured::of(structure, &found.test_points, &[], &clean)?;
        let fitted = measured.fit(&found.identified)?;
        let Fitted { parameters, untold, costs, mean_cost, converged, modelled, .. } = fitted;
        let Measured { basis, all: measured, .. } = measured;
        Ok(Self { basis, measured, modelled, parameters, untold, costs, mean_cost, converged })
    }
}

impl FrequencyDomain {
    /// One sentence for each parameter whose two values differ by more than chance allows.
    pub fn disagreements(&self) -> impl Iterator<Item = String> {
        self.parameters.iter().filter(|own| own.disagrees()).map(SideBySide::in_words)
    }
}
