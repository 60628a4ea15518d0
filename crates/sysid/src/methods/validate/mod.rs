//! How well a model does on data it has not seen, or why it is refused.
//!
//! A fit in percent means nothing without its horizon: one step ahead, the last measurement is a
//! good prediction of almost anything. So each fit names its horizon and stands beside that of the
//! last measurement held, residuals are tested for what they still hold of past and inputs, and a
//! model whose validation runs away is refused with the reason.
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

/// The thesis's mark for a good fit, percent.
pub const GOOD_FIT_PERCENT: f64 = 75.0;

/// How far ahead a prediction looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Horizon {
    /// This many samples, at least 1: the outputs up to that long ago are known.
    Steps(usize),
    /// Without end: the inputs and one start state are all that is known.
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

/// Why a validation gives no number.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Refusal {
    /// The model's shape is not that of the data, or the period differs.
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
    /// The validation data is, in part or whole, the data of the fit.
    #[error(
        "`{validation}` repeats rows {row} and on of `{estimation}`, which the model was fitted to"
    )]
    NotHeldOut {
        /// Name of the data of the fit.
        estimation: String,
        /// Name of the validation data.
        validation: String,
        /// Where in the data of the fit.
        row: usize,
    },
    /// The model itself runs away.
    #[error(
        "the model is unstable (spectral radius {spectral_radius:.4}): in {duration_s:.1} s of \
         simulation any error grows {growth:.1e}-fold, so its fit says nothing; validate it some \
         steps ahead"
    )]
    UnstableModel {
        /// The largest magnitude of a pole.
        spectral_radius: f64,
        /// Length of the validation data, s.
        duration_s: f64,
        /// Growth over that length.
        growth: f64,
    },
    /// The predictor runs away.
    #[error(
        "the predictor is unstable (spectral radius {spectral_radius:.4}): measurements do not \
         correct it"
    )]
    UnstablePredictor {
        /// The largest magnitude of a pole of A − K C.
        spectral_radius: f64,
    },
    /// What was predicted is out of all proportion.
    #[error(
        "output `{output}` runs away in validation ({horizon}): {factor:.1e} times what was measured"
    )]
    Diverged {
        /// The output.
        output: String,
        /// The horizon.
        horizon: Horizon,
        /// Largest predicted over largest measured deviation.
        factor: f64,
    },
    /// An output does not move, or the record is too short to test.
    #[error("`{experiment}` holds nothing to validate with: {reason}")]
    Nothing {
        /// The experiment's name.
        experiment: String,
        /// What is missing.
        reason: String,
    },
}

/// One output at one horizon.
#[derive(Debug, Clone, PartialEq)]
pub struct Score {
    /// The output.
    pub output: String,
    /// The horizon.
    pub horizon: Horizon,
    /// Fit, percent ([`fit_percent`]).
    pub fit_percent: f64,
    /// Fit, percent, of the last measurement held over the horizon; for a simulation that of the
    /// mean, 0. A model worth having does better.
    pub held_fit_percent: f64,
    /// Theil's coefficient.
    pub theil: Theil,
}

/// What validation showed.
#[derive(Debug, Clone, PartialEq)]
pub struct Validation {
    /// Name of the validation data.
    pub experiment: String,
    /// One score per horizon and output.
    pub scores: Vec<Score>,
    /// The one-step residuals against their own past and the inputs.
    pub residuals: ResidualTest,
}

impl Validation {
    /// The scores that keep the model from being called good: at the longest horizon asked for, a
    /// fit below [`GOOD_FIT_PERCENT`] or below what holding the last measurement gives.
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

/// Lags of the residual tests.
const LAGS: usize = 25;
/// Predictions this many times larger than the measurements have run away.
const RUNAWAY: f64 = 100.0;

/// Validates `model`, fitted on `estimation`, on `validation`; both about the trim of the
/// estimation data ([`Experiment::about`]).
///
/// The start state is fitted on the validation data, as nothing else knows it.
///
/// # Errors
/// A [`Refusal`] with its reason where the number would mean nothing: the data was used for the fit,
/// the model or its predictor is unstable over the horizon asked for, a prediction runs away, or an
/// output does not move.
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

/// Fit of the measurement `steps` ago; the first rows hold the first one.
fn held_fit(outputs: &DMatrix<f64>, steps: usize) -> Vec<f64> {
    let held = DMatrix::from_fn(outputs.nrows(), outputs.ncols(), |row, column| {
        outputs[(row.saturating_sub(steps), column)]
    });
    fit_percent(outputs, &held)
}

/// As many equal rows in a row are no accident.
const SHARED: usize = 8;

/// Where in `estimation` rows of `validation` turn up again.
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
    // Overlapping stretches of two records share the start of one or the other.
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
