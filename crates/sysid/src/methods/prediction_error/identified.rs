//! What a search found.

use nalgebra::DMatrix;

use super::estimates::Estimates;
use crate::methods::structure::Structure;
use hovernav_model::LinearModel;

/// What a record had of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct OwnValues {
    /// The experiment's name.
    pub experiment: String,
    /// Initial state, one per state.
    pub initial_state: Vec<f64>,
    /// Constant forcing, one per offset of the structure, in the state's unit per second.
    pub offsets: Vec<f64>,
    /// Output biases, one per bias of the structure.
    pub biases: Vec<f64>,
}

/// An identified structure.
#[derive(Debug, Clone)]
pub struct Identified {
    /// The structure, as fitted: dropped parameters are held at their value.
    pub structure: Structure,
    /// Whether the predictor had a gain.
    pub innovations_form: bool,
    /// Sample period, s.
    pub period_s: f64,
    /// Samples in all experiments.
    pub samples: usize,
    /// The parameters with their bounds.
    pub estimates: Estimates,
    /// What each experiment had of its own.
    pub own: Vec<OwnValues>,
    /// What was dropped or kept, and why; one sentence each.
    pub log: Vec<String>,
    /// Covariance of the innovations, outputs × outputs, as found.
    pub innovations_covariance: DMatrix<f64>,
    /// How far each output's innovations, 0.1 to 1 s apart, are from white: their largest correlation,
    /// 0 to 1.
    pub innovations_correlation: Vec<f64>,
    /// Akaike's criterion, −2 ln L + 2 × unknowns.
    pub aic: f64,
    /// Akaike's final prediction error: det of the covariance × (N + unknowns)/(N − unknowns).
    pub fpe: f64,
    /// Linearisations made, all refits together.
    pub iterations: usize,
    /// Whether the last search stopped because there was nothing left to gain.
    pub converged: bool,
    /// The whole parameter vector: structure, ln σ of process noise, ln σ of measurement noise.
    pub(super) theta: Vec<f64>,
}

impl Identified {
    /// One-sigma of each process noise of the structure, in the unit of the state's rate, per sample.
    #[must_use]
    pub fn process_sigma(&self) -> Vec<f64> {
        let first = self.structure.parameters.len();
        let noises = self.theta.iter().skip(first).take(self.structure.noises.len());
        noises.map(|logarithm| logarithm.exp()).collect()
    }

    /// The identified model, continuous in time; delays are apart, in the estimates.
    #[must_use]
    pub fn linear(&self) -> LinearModel {
        self.structure.at(&self.theta[..self.structure.parameters.len()])
    }
}
