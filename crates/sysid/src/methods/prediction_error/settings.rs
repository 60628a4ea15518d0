//! Settings of the identification.

use crate::methods::least_squares::Limits;

/// Predictor of the outputs.
#[derive(Debug, Clone, PartialEq)]
pub enum Form {
    /// The Kalman predictor. Contains the initial σ of each process noise of the structure, in the unit of the state's
    /// rate, per sample.
    Innovations(Vec<f64>),
    /// The simulated output: no process noise, zero gain.
    OutputError,
}

/// Settings of the identification.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Predictor of the outputs.
    pub form: Form,
    /// Outputs whose σ is fixed at a value, by name, in the output's unit. The others are estimated, starting from the
    /// output's second differences.
    pub held_sigma: Vec<(String, f64)>,
    /// Upper limits of process noises, by name: σ in the unit of the state's rate, per sample.
    pub largest_process_sigma: Vec<(String, f64)>,
    /// Stopping criteria.
    pub limits: Limits,
    /// Criteria for dropping parameters; `None` drops nothing.
    pub dropping: Option<Dropping>,
    /// Longest correlation time of the innovations that widens the bounds, s. 0 assumes white innovations of constant
    /// size.
    pub residual_correlation_s: f64,
    /// Factor on the bounds for effects that the structure omits and the innovations do not show; 1 for no widening.
    pub widened: f64,
}

impl Settings {
    /// Innovations form with these initial process noises: noise estimated, nothing dropped, bounds for white
    /// innovations.
    #[must_use]
    pub fn innovations(process_sigma: Vec<f64>) -> Self {
        Self { form: Form::Innovations(process_sigma), ..Self::output_error() }
    }

    /// Output error: noise estimated, nothing dropped, bounds for white residuals.
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

/// Criteria for dropping a parameter from the model. A dropped parameter is 0, or keeps its initial value where an
/// equation divides by it.
///
/// # Source
/// Tischler and Remple, chapter 12: bound at most 20 %, insensitivity at most 10 % of the value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dropping {
    /// Largest Cramér–Rao bound, percent of the value.
    pub bound_percent: f64,
    /// Largest insensitivity, percent of the value.
    pub insensitivity_percent: f64,
    /// Largest rise of −2 ln L for dropping a parameter; 2 is Akaike's penalty per parameter. The rise is divided by
    /// the factor by which coloured innovations increase the variance.
    pub likelihood_rise: f64,
}

impl Default for Dropping {
    fn default() -> Self {
        Self { bound_percent: 20.0, insensitivity_percent: 10.0, likelihood_rise: 2.0 }
    }
}
