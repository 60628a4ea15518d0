//! Result of a search.

use nalgebra::DMatrix;

use super::estimates::Estimates;
use crate::methods::structure::Structure;
use hovernav_model::LinearModel;

/// Estimated unknowns of one record.
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
    /// Whether the predictor has a gain.
    pub innovations_form: bool,
    /// Sample period, s.
    pub period_s: f64,
    /// Number of samples in all experiments.
    pub samples: usize,
    /// The parameters with their bounds.
    pub estimates: Estimates,
    /// Estimated unknowns of each experiment.
    pub own: Vec<OwnValues>,
    /// Log of dropped and kept parameters, one sentence with the reason each.
    pub log: Vec<String>,
    /// Covariance of the innovations, outputs × outputs.
    pub innovations_covariance: DMatrix<f64>,
    /// Deviation of each output's innovations from white noise: their largest correlation at lags of 0.1 to 1 s, 0 to
    /// 1.
    pub innovations_correlation: Vec<f64>,
    /// Akaike's criterion, −2 ln L + 2 × unknowns.
    pub aic: f64,
    /// Akaike's final prediction error: det of the covariance × (N + unknowns)/(N − unknowns).
    pub fpe: f64,
    /// Number of linearisations of all searches.
    pub iterations: usize,
    /// Whether the last search converged.
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

    /// The identified model, continuous in time; the delays are in the estimates.
    #[must_use]
    pub fn linear(&self) -> LinearModel {
        self.structure.at(&self.theta[..self.structure.parameters.len()])
    }
}
