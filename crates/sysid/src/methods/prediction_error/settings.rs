//! How to identify.

use crate::methods::least_squares::Limits;

/// What predicts the output.
#[derive(Debug, Clone, PartialEq)]
pub enum Form {
    /// The Kalman predictor. Holds one start for the σ of each process noise of the structure, in the
    /// unit of the state's rate, per sample.
    Innovations(Vec<f64>),
    /// The simulated output: process noise is left out, the gain is 0.
    OutputError,
}

/// How to identify.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// What predicts the output.
    pub form: Form,
    /// Outputs whose σ is held at a value, by name, in the output's unit. The others are estimated,
    /// from a start that the output's second differences give.
    pub held_sigma: Vec<(String, f64)>,
    /// Process noises whose σ is at most a value, by name, in the unit of the state's rate, per sample.
    pub largest_process_sigma: Vec<(String, f64)>,
    /// When to stop.
    pub limits: Limits,
    /// Which parameters to drop; none where `None`.
    pub dropping: Option<Dropping>,
    /// The time over which correlated innovations widen the bounds, s; 0 takes them as white and as
    /// large at all times.
    pub residual_correlation_s: f64,
    /// By how much bounds are widened for what the structure leaves out, which no innovation tells of; 1
    /// for none.
    pub widened: f64,
}

impl Settings {
    /// Innovations form from these process noises; noise estimated, nothing dropped, bounds of white
    /// innovations.
    #[must_use]
    pub fn innovations(process_sigma: Vec<f64>) -> Self {
        Self { form: Form::Innovations(process_sigma), ..Self::output_error() }
    }

    /// Output error; noise estimated, nothing dropped, bounds of white residuals.
    #[must_use]
    pub fn output_error() -> Self {
        Self {
            form: Form::OutputError,
            held_sigma: Vec::new(),
            largest_process_sigma: Vec::new(),
            limits: Limits::default(),
            dropping: None,
            residual_correlation_s: 0.0,
            widened: 1.0,
        }
    }
}

/// When a parameter is left out of the model: set to 0, or held at its start where an equation divides
/// by it.
///
/// # Source
/// Tischler and Remple, chapter 12: bound at most 20 %, insensitivity at most 10 % of the value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dropping {
    /// Largest Cramér–Rao bound, percent of the value.
    pub bound_percent: f64,
    /// Largest insensitivity, percent of the value.
    pub insensitivity_percent: f64,
    /// Largest rise of −2 ln L a parameter may be missed by; 2 is Akaike's price of a parameter. The
    /// rise counts by as much less as innovations that are not white widen the bound's variance.
    pub likelihood_rise: f64,
}

impl Default for Dropping {
    fn default() -> Self {
        Self { bound_percent: 20.0, insensitivity_percent: 10.0, likelihood_rise: 2.0 }
    }
}
