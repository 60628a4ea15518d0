//! Grey-box identification by prediction error: the parameters of a [`Structure`] whose Kalman
//! predictor leaves the smallest innovations, and how well the data know them.
//!
//! # Method
//! The innovations ν of the steady predictor are those of a maximum-likelihood estimate:
//! −ln L = ½ Σ νᵀ S⁻¹ ν + N/2 ln det S. The gain is not a parameter. What is estimated is the standard
//! deviation of every process and measurement noise, and gain and S follow from the Riccati equation.
//! That keeps the noise model at a dozen numbers with a meaning, where a free gain of an R-50 would
//! have 104, and the sensitivities stay analytic, as the gain's derivative solves a Lyapunov
//! equation. A record's initial state, its offsets (trim, mean wind) and its output biases enter the
//! innovations linearly and are solved away exactly. The search is Fisher's scoring with Marquardt's
//! damping.
//!
//! On an unstable plant use [`Form::Innovations`]: a free run over more than a few time constants of
//! the instability fits its own divergence.
//!
//! # Source
//! Ljung, *System Identification*, second edition, chapter 7; Jategaonkar, *Flight Vehicle System
//! Identification*, second edition, chapter 5 (filter error method); Tischler and Remple, *Aircraft
//! and Rotorcraft System Identification*, chapters 12–13 (bounds, insensitivities, what to drop).

mod dropping;
mod estimates;
mod fit;
mod held;
mod predictor;
mod problem;
mod statistics;
mod sweep;
#[cfg(test)]
mod tests;

use std::cell::RefCell;

use nalgebra::DMatrix;
use thiserror::Error;

pub use dropping::Dropping;
pub use estimates::{Estimate, Estimates, Status};
pub use fit::{ChannelFit, Fit, Run};

use self::problem::Problem;
use self::sweep::Record;
use super::least_squares::{Limits, minimise};
use super::structure::{Matrices, Structure};
use super::{Experiment, ExperimentError};

/// Why nothing could be identified.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum PredictionErrorError {
    /// An experiment lacks a signal the structure names.
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
    /// No experiments, or sampled at different periods.
    #[error("{structure}: found sample periods {periods_s:?} s, expected one period for all")]
    Periods {
        /// The structure's name.
        structure: String,
        /// The experiments' periods, s.
        periods_s: Vec<f64>,
    },
    /// Every parameter is held.
    #[error("{structure}: no parameter is free")]
    NothingFree {
        /// The structure's name.
        structure: String,
    },
    /// More unknowns than numbers measured.
    #[error("{structure}: {unknowns} unknowns against {numbers} measured numbers")]
    TooShort {
        /// The structure's name.
        structure: String,
        /// Parameters, noises, initial states, offsets and biases.
        unknowns: usize,
        /// Samples times outputs.
        numbers: usize,
    },
    /// One start per process noise is needed, positive and finite.
    #[error("{structure}: found process noise {found:?}, expected {expected} positive numbers")]
    ProcessNoise {
        /// The structure's name.
        structure: String,
        /// What was given.
        found: Vec<f64>,
        /// How many noises the structure has.
        expected: usize,
    },
    /// At its starts the structure has no stable predictor: something unstable is neither measured nor
    /// driven by noise.
    #[error("{structure}: no stable predictor at the start values")]
    Start {
        /// The structure's name.
        structure: String,
    },
    /// At the end of the search the parameters' information cannot be inverted.
    #[error("{structure}: the data cannot tell the parameters apart")]
    Singular {
        /// The structure's name.
        structure: String,
    },
}

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
    /// When to stop.
    pub limits: Limits,
    /// Which parameters to drop; none where `None`.
    pub dropping: Option<Dropping>,
    /// The time over which correlated innovations widen the bounds, s; 0 takes them as white and as
    /// large at all times.
    pub residual_correlation_s: f64,
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
            limits: Limits::default(),
            dropping: None,
            residual_correlation_s: 0.0,
        }
    }
}

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
    /// Akaike's criterion, −2 ln L + 2 × unknowns.
    pub aic: f64,
    /// Akaike's final prediction error: det of the covariance × (N + unknowns)/(N − unknowns).
    pub fpe: f64,
    /// Linearisations made, all refits together.
    pub iterations: usize,
    /// Whether the last search stopped because there was nothing left to gain.
    pub converged: bool,
    /// The whole parameter vector: structure, ln σ of process noise, ln σ of measurement noise.
    theta: Vec<f64>,
}

impl Identified {
    /// The model's matrices, continuous in time; delays are apart, in the estimates.
    #[must_use]
    pub fn matrices(&self) -> Matrices {
        self.structure.at(&self.theta[..self.structure.parameters.len()])
    }
}

/// Identifies `structure` on `experiments`.
///
/// The signals are found by name; an experiment may hold others.
///
/// # Errors
/// See [`PredictionErrorError`].
pub fn identify(
    structure: &Structure,
    experiments: &[Experiment],
    settings: &Settings,
) -> Result<Identified, PredictionErrorError> {
    let name = || structure.name.clone();
    let periods_s: Vec<f64> = experiments.iter().map(|experiment| experiment.period_s).collect();
    let period_s = periods_s.first().copied().unwrap_or(f64::NAN);
    // A thousandth of a period is far below what a period moves an estimate by.
    if !periods_s.iter().all(|other| (other / period_s - 1.0).abs() < 1e-3) || periods_s.is_empty()
    {
        return Err(PredictionErrorError::Periods { structure: name(), periods_s });
    }
    let records = experiments
        .iter()
        .map(|experiment| Record::new(structure, experiment))
        .collect::<Result<Vec<_>, _>>()?;
    let (base, free) = start(structure, &records, settings)?;
    let problem = Problem {
        structure,
        records: &records,
        period_s,
        innovations: settings.form != Form::OutputError,
        base,
        free,
        own: RefCell::new(Problem::guesses(structure, &records)),
    };
    let own = problem.own.borrow().values.iter().map(Vec::len).sum::<usize>();
    let (unknowns, numbers) =
        (problem.free.len() + own, problem.samples() * structure.outputs.len());
    if unknowns >= numbers {
        return Err(PredictionErrorError::TooShort { structure: name(), unknowns, numbers });
    }
    dropping::search(problem, settings)
}

/// The whole parameter vector at its start, and which entries are free.
fn start(
    structure: &Structure,
    records: &[Record],
    settings: &Settings,
) -> Result<(Vec<f64>, Vec<usize>), PredictionErrorError> {
    let own = structure.parameters.len();
    let mut free: Vec<usize> =
        (0..own).filter(|&index| !structure.parameters[index].fixed).collect();
    if free.is_empty() {
        return Err(PredictionErrorError::NothingFree { structure: structure.name.clone() });
    }
    let expected = structure.noises.len();
    let process = match &settings.form {
        Form::Innovations(sigmas)
            if sigmas.len() == expected && sigmas.iter().all(|&s| s > 0.0 && s.is_finite()) =>
        {
            sigmas.clone()
        }
        Form::Innovations(sigmas) => {
            return Err(PredictionErrorError::ProcessNoise {
                structure: structure.name.clone(),
                found: sigmas.clone(),
                expected,
            });
        }
        Form::OutputError => vec![1.0; expected],
    };
    if settings.form != Form::OutputError {
        free.extend(own..own + expected);
    }
    let mut measurement = Vec::new();
    for (output, name) in structure.outputs.iter().enumerate() {
        if let Some((_, sigma)) = settings.held_sigma.iter().find(|(held, _)| held == name) {
            measurement.push(*sigma);
        } else {
            measurement.push(statistics::noise_of(records, output, structure.outputs.len()));
            free.push(own + expected + output);
        }
    }
    let mut base = structure.start();
    base.extend(process.iter().chain(&measurement).map(|sigma| sigma.ln()));
    Ok((base, free))
}

/// One search from where `problem` stands.
fn search(
    problem: &Problem<'_>,
    start: &[f64],
    limits: Limits,
) -> Result<super::least_squares::Minimum, PredictionErrorError> {
    // A noise a thousand times off its start is not there, or not noise.
    const WIDEST: f64 = 7.0;
    let bound = |side: fn(&super::structure::Parameter) -> f64, widen: f64| -> Vec<f64> {
        let free = problem.free.iter();
        free.map(|&index| match problem.structure.parameters.get(index) {
            Some(parameter) => side(parameter),
            None => problem.base[index] + widen,
        })
        .collect()
    };
    let lower = bound(|parameter| parameter.lower, -WIDEST);
    let upper = bound(|parameter| parameter.upper, WIDEST);
    minimise(problem, start, &lower, &upper, limits)
        .ok_or_else(|| PredictionErrorError::Start { structure: problem.structure.name.clone() })
}
