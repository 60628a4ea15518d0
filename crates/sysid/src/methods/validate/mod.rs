//! Validation of a model on new data, or the reason for rejecting it.
//!
//! A fit in percent is meaningless without its horizon: one step ahead, the last measurement predicts almost anything
//! well. Each fit therefore states its horizon, next to the fit of the last measurement held. The residuals are tested
//! for correlation with the past and the inputs. A model that diverges in validation is rejected with the reason.
//!
//! Source: L. Ljung, *System Identification*, 2nd ed., sections 16.5 and 16.6; R. Jategaonkar, *Flight
//! Vehicle System Identification*, chapter 11, for Theil's coefficient.

mod fit;
mod residual;

pub use fit::{Theil, fit_percent, theil};
pub use residual::{CorrelationTest, ResidualTest, residual_test};

use std::fmt;

use nalgebra::DMatrix;
use thiserror::Error;

use crate::methods::innovation::InnovationModel;
use crate::methods::subspace::fit_initial_state;
use crate::record::Experiment;
use hovernav_model::TimeDomain;

/// The thesis's limit of a good fit, percent.
pub const GOOD_FIT_PERCENT: f64 = 75.0;

/// Prediction horizon.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Horizon {
    /// Number of samples, at least 1; the outputs up to that many samples ago are known.
    Steps(usize),
    /// Unlimited: only the inputs and one initial state are known.
    Simulation,
}

impl fmt::Display for Horizon {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Steps(1) => write!(f, "1 step"),
            Self::Steps(steps) => write!(f, "{steps} steps"),
            Self::Simulation => write!(f, "simulation"),
        }
    }
}

/// Reasons why a validation gives no result.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Refusal {
    /// Numbers of signals or sample periods of model and data differ.
    #[error(
        "the model has {model_inputs} inputs, {model_outputs} outputs and a period of \
         {model_period_s} s, `{experiment}` {inputs}, {outputs} and {period_s} s"
    )]
    Mismatch {
        /// The experiment's name.
        experiment: String,
        /// Inputs of the model.
        model_inputs: usize,
        /// Outputs of the model.
        model_outputs: usize,
        /// Period of the model, s; 0 for a continuous one.
        model_period_s: f64,
        /// Inputs of the experiment.
        inputs: usize,
        /// Outputs of the experiment.
        outputs: usize,
        /// Period of the experiment, s.
        period_s: f64,
    },
    /// The validation data contain estimation data.
    #[error(
        "`{validation}` repeats rows {row} and on of `{estimation}`, which the model was fitted to"
    )]
    NotHeldOut {
        /// Name of the estimation data.
        estimation: String,
        /// Name of the validation data.
        validation: String,
        /// First repeated row in the estimation data.
        row: usize,
    },
    /// The model is unstable.
    #[error(
        "the model is unstable (spectral radius {spectral_radius:.4}): in {duration_s:.1} s of \
         simulation any error grows {growth:.1e}-fold, so its fit is meaningless; validate it a few \
         steps ahead instead"
    )]
    UnstableModel {
        /// Largest magnitude of a pole.
        spectral_radius: f64,
        /// Length of the validation data, s.
        duration_s: f64,
        /// Growth of an error over that length.
        growth: f64,
    },
    /// The predictor is unstable.
    #[error(
        "the predictor is unstable (spectral radius {spectral_radius:.4}): measurements do not \
         correct it"
    )]
    UnstablePredictor {
        /// Largest magnitude of a pole of A − K C.
        spectral_radius: f64,
    },
    /// The prediction is implausibly large.
    #[error(
        "output `{output}` diverges in validation ({horizon}): {factor:.1e} times the measured size"
    )]
    Diverged {
        /// The output.
        output: String,
        /// The horizon.
        horizon: Horizon,
        /// Largest predicted over largest measured deviation.
        factor: f64,
    },
    /// An output is constant, or the record is too short for the tests.
    #[error("`{experiment}` cannot be used for validation: {reason}")]
    Nothing {
        /// The experiment's name.
        experiment: String,
        /// The reason.
        reason: String,
    },
}

/// Score of one output at one horizon.
#[derive(Debug, Clone, PartialEq)]
pub struct Score {
    /// The output.
    pub output: String,
    /// The horizon.
    pub horizon: Horizon,
    /// Fit, percent ([`fit_percent`]).
    pub fit_percent: f64,
    /// Fit, percent, of the last measurement held over the horizon; for a simulation that of the mean, 0. A useful
    /// model does better.
    pub held_fit_percent: f64,
    /// Theil's coefficient.
    pub theil: Theil,
}

/// Result of a validation.
#[derive(Debug, Clone, PartialEq)]
pub struct Validation {
    /// Name of the validation data.
    pub experiment: String,
    /// One score per horizon and output.
    pub scores: Vec<Score>,
    /// Correlation of the one-step residuals with their own past and the inputs.
    pub residuals: ResidualTest,
}

impl Validation {
    /// Scores below the requirements of a good model. At the longest requested horizon the fit is below
    /// [`GOOD_FIT_PERCENT`] or below that of the last measurement held.
    #[must_use]
    pub fn shortcomings(&self) -> Vec<&Score> {
        let length = |horizon: Horizon| match horizon {
            Horizon::Steps(steps) => steps,
            Horizon::Simulation => usize::MAX,
        };
        let longest = self.scores.iter().map(|score| length(score.horizon)).max();
        self.scores
            .iter()
            .filter(|score| Some(length(score.horizon)) == longest)
            .filter(|score| score.fit_percent < GOOD_FIT_PERCENT.max(score.held_fit_percent))
            .collect()
    }
}

impl fmt::Display for Validation {
    /// A table, one line per score.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:<12} {:>12} {:>8} {:>8} {:>7}",
            "output", "horizon", "fit %", "held %", "Theil"
        )?;
        for Score { output, horizon, fit_percent, held_fit_percent, theil } in &self.scores {
            let horizon = horizon.to_string();
            let theil = theil.coefficient;
            writeln!(
                f,
                "{output:<12} {horizon:>12} {fit_percent:>8.2} {held_fit_percent:>8.2} {theil:>7.3}"
            )?;
        }
        Ok(())
    }
}

/// Number of lags of the residual tests.
const LAGS: usize = 25;
/// Ratio of prediction to measurement above which a prediction has diverged.
const RUNAWAY: f64 = 100.0;

/// Validates `model`, fitted on `estimation`, on `validation`; both as deviations from the trim of the estimation data
/// ([`Experiment::about`]).
///
/// The initial state is fitted on the validation data, because it is otherwise unknown.
///
/// # Errors
/// A [`Refusal`] with its reason where the result would be meaningless. The reasons are data used for estimation, an
/// unstable model or predictor, a diverging prediction, and a constant output.
pub fn validate(
    model: &InnovationModel,
    estimation: &Experiment,
    validation: &Experiment,
    horizons: &[Horizon],
) -> Result<Validation, Refusal> {
    check_shapes(model, validation)?;
    if let Some(row) = shared_rows(estimation, validation) {
        let (estimation, validation) = (estimation.name.clone(), validation.name.clone());
        return Err(Refusal::NotHeldOut { estimation, validation, row });
    }
    check_stability(model, validation, horizons)?;

    let start = fit_initial_state(model, validation);
    let (inputs, outputs) = (&validation.inputs, &validation.outputs);
    let mut scores = Vec::new();
    for &horizon in horizons {
        let predicted = match horizon {
            Horizon::Simulation => model.system.simulate(inputs, &start),
            Horizon::Steps(steps) => model.predict_ahead(inputs, outputs, &start, steps.max(1)),
        };
        check_proportion(validation, &predicted, horizon)?;
        let held = match horizon {
            Horizon::Simulation => vec![0.0; outputs.ncols()],
            Horizon::Steps(steps) => held_fit(outputs, steps.max(1)),
        };
        let fits = fit_percent(outputs, &predicted);
        for (column, (fit_percent, held_fit_percent)) in fits.into_iter().zip(held).enumerate() {
            scores.push(Score {
                output: validation.output_names[column].clone(),
                horizon,
                fit_percent,
                held_fit_percent,
                theil: theil(
                    outputs.column(column).as_slice(),
                    predicted.column(column).as_slice(),
                ),
            });
        }
    }
    let one_step = model.predict(inputs, outputs, &start);
    let residuals = residual_test(&(outputs - one_step), inputs, LAGS);
    Ok(Validation { experiment: validation.name.clone(), scores, residuals })
}

fn check_shapes(model: &InnovationModel, experiment: &Experiment) -> Result<(), Refusal> {
    let system = &model.system;
    let (inputs, outputs) = (experiment.inputs.ncols(), experiment.outputs.ncols());
    let model_period_s = match system.time {
        TimeDomain::Discrete { period_s } => period_s,
        TimeDomain::Continuous => 0.0,
    };
    let period = (model_period_s - experiment.period_s).abs() <= 1e-6 * experiment.period_s;
    if !period || system.input_count() != inputs || system.output_count() != outputs {
        return Err(Refusal::Mismatch {
            experiment: experiment.name.clone(),
            model_inputs: system.input_count(),
            model_outputs: system.output_count(),
            model_period_s,
            inputs,
            outputs,
            period_s: experiment.period_s,
        });
    }
    let nothing = |reason| Refusal::Nothing { experiment: experiment.name.clone(), reason };
    if experiment.samples() < 2 * LAGS {
        return Err(nothing(format!("{} samples, fewer than {}", experiment.samples(), 2 * LAGS)));
    }
    for (name, output) in experiment.output_names.iter().zip(experiment.outputs.column_iter()) {
        if output.max() == output.min() {
            return Err(nothing(format!("output `{name}` is constant")));
        }
    }
    Ok(())
}

fn check_stability(
    model: &InnovationModel,
    experiment: &Experiment,
    horizons: &[Horizon],
) -> Result<(), Refusal> {
    let spectral_radius = model.system.spectral_radius();
    if horizons.contains(&Horizon::Simulation) && spectral_radius >= 1.0 {
        return Err(Refusal::UnstableModel {
            spectral_radius,
            duration_s: experiment.duration_s(),
            growth: spectral_radius.powf(experiment.samples() as f64),
        });
    }
    let spectral_radius = model.predictor_spectral_radius();
    if spectral_radius >= 1.0 {
        return Err(Refusal::UnstablePredictor { spectral_radius });
    }
    Ok(())
}

fn check_proportion(
    experiment: &Experiment,
    predicted: &DMatrix<f64>,
    horizon: Horizon,
) -> Result<(), Refusal> {
    let columns = experiment.outputs.column_iter().zip(predicted.column_iter());
    for (name, (measured, predicted)) in experiment.output_names.iter().zip(columns) {
        let mean = measured.mean();
        let reach = measured.add_scalar(-mean).amax();
        let factor = predicted.add_scalar(-mean).amax() / reach;
        let finite = predicted.iter().all(|value| value.is_finite());
        if !finite || factor > RUNAWAY {
            return Err(Refusal::Diverged { output: name.clone(), horizon, factor });
        }
    }
    Ok(())
}

/// Fit of the measurement `steps` ago; the first rows hold the first measurement.
fn held_fit(outputs: &DMatrix<f64>, steps: usize) -> Vec<f64> {
    let held = DMatrix::from_fn(outputs.nrows(), outputs.ncols(), |row, column| {
        outputs[(row.saturating_sub(steps), column)]
    });
    fit_percent(outputs, &held)
}

/// Number of consecutive equal rows that chance does not explain.
const SHARED: usize = 8;

/// Row of `estimation` at which rows of `validation` recur.
fn shared_rows(estimation: &Experiment, validation: &Experiment) -> Option<usize> {
    if estimation.outputs.ncols() != validation.outputs.ncols()
        || estimation.inputs.ncols() != validation.inputs.ncols()
    {
        return None;
    }
    let equal = |row: usize, other: usize| {
        estimation.outputs.row(row) == validation.outputs.row(other)
            && estimation.inputs.row(row) == validation.inputs.row(other)
    };
    let rests = |other: usize| {
        (1..SHARED).all(|k| validation.outputs.row(other + k) == validation.outputs.row(other))
    };
    // If two records overlap, the overlap contains the start or the end of one of them. Here the validation data are
    // tested.
    let starts = [0, validation.samples().saturating_sub(SHARED)];
    let found = |other: usize| {
        if other + SHARED > validation.samples() || rests(other) {
            return None;
        }
        (0..(estimation.samples() + 1).saturating_sub(SHARED))
            .find(|row| (0..SHARED).all(|k| equal(row + k, other + k)))
    };
    starts.into_iter().find_map(found)
}

#[cfg(test)]
mod tests;
