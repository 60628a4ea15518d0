//! B, D and the initial state by linear least squares on the simulated or predicted output.

use nalgebra::{DMatrix, DVector};

use super::responses::{forced_responses, free_responses};
use crate::methods::innovation::InnovationModel;
use crate::record::Experiment;
use hovernav_model::linalg::least_squares;

/// Result of the least squares.
pub(super) struct InputMap {
    pub b: DMatrix<f64>,
    pub d: DMatrix<f64>,
    pub initial_state: DVector<f64>,
}

/// B, D and x(0) for given A, C and gain K. They give the best simulation if K = 0, otherwise the best one-step
/// prediction. The output is linear in all of them in both cases.
///
/// # Source
/// Equation (I7) of docs/equations.md.
pub(super) fn fit_inputs(
    experiment: &Experiment,
    a: &DMatrix<f64>,
    c: &DMatrix<f64>,
    gain: &DMatrix<f64>,
    feedthrough: bool,
) -> InputMap {
    let (order, outputs, inputs) = (a.nrows(), c.nrows(), experiment.inputs.ncols());
    let samples = experiment.samples();
    let predictor = a - gain * c;
    let direct = if feedthrough { outputs * inputs } else { 0 };
    let mut regressors = DMatrix::zeros(samples * outputs, order * inputs + direct + order);

    let driven = forced_responses(&predictor, c, &experiment.inputs);
    regressors.columns_mut(0, order * inputs).copy_from(&driven);
    if feedthrough {
        // D affects the output directly, and the state through −K D.
        for input in 0..inputs {
            for output in 0..outputs {
                let column = order * inputs + input * outputs + output;
                let mut regressor = regressors.column_mut(column);
                for state in 0..order {
                    let share = gain[(state, output)];
                    if share != 0.0 {
                        regressor.axpy(-share, &driven.column(input * order + state), 1.0);
                    }
                }
                for sample in 0..samples {
                    regressor[sample * outputs + output] += experiment.inputs[(sample, input)];
                }
            }
        }
    }
    let free = free_responses(&predictor, c, samples);
    regressors.columns_mut(order * inputs + direct, order).copy_from(&free);

    let solution = least_squares(regressors, &unexplained(experiment, &predictor, c, gain));
    let part = |first: usize, rows: usize, columns: usize| {
        DMatrix::from_column_slice(
            rows,
            columns,
            &solution.as_slice()[first..first + rows * columns],
        )
    };
    InputMap {
        b: part(0, order, inputs),
        d: if feedthrough {
            part(order * inputs, outputs, inputs)
        } else {
            DMatrix::zeros(outputs, inputs)
        },
        initial_state: DVector::from_column_slice(
            &solution.as_slice()[order * inputs + direct..order * inputs + direct + order],
        ),
    }
}

/// Measured outputs minus their prediction from past outputs alone, stacked sample by sample.
fn unexplained(
    experiment: &Experiment,
    predictor: &DMatrix<f64>,
    c: &DMatrix<f64>,
    gain: &DMatrix<f64>,
) -> DMatrix<f64> {
    let outputs = c.nrows();
    let mut left = DMatrix::from_column_slice(
        experiment.samples() * outputs,
        1,
        experiment.outputs.transpose().as_slice(),
    );
    if gain.iter().any(|&value| value != 0.0) {
        let order = predictor.nrows();
        let through = forced_responses(predictor, c, &experiment.outputs);
        for output in 0..outputs {
            for state in 0..order {
                let share = gain[(state, output)];
                left.column_mut(0).axpy(-share, &through.column(output * order + state), 1.0);
            }
        }
    }
    left
}

/// The initial state with which `model` explains `experiment` best: by simulation for a stable model, by one-step
/// prediction for an unstable model.
#[must_use]
pub fn fit_initial_state(model: &InnovationModel, experiment: &Experiment) -> DVector<f64> {
    let system = &model.system;
    let zero = DVector::zeros(system.order());
    let (transition, run) = if system.spectral_radius() < 1.0 {
        (system.a.clone(), system.simulate(&experiment.inputs, &zero))
    } else {
        (
            &system.a - &model.gain * &system.c,
            model.predict(&experiment.inputs, &experiment.outputs, &zero),
        )
    };
    let left = (&experiment.outputs - run).transpose();
    let mut left = DMatrix::from_column_slice(left.len(), 1, left.as_slice());
    let mut free = free_responses(&transition, &system.c, experiment.samples());
    // Each output is scaled by its own size, so that units do not affect the weights.
    for (output, signal) in experiment.outputs.column_iter().enumerate() {
        let size = signal.norm().max(f64::MIN_POSITIVE);
        for sample in 0..experiment.samples() {
            let row = sample * experiment.outputs.ncols() + output;
            left[row] /= size;
            free.row_mut(row).unscale_mut(size);
        }
    }
    least_squares(free, &left).column(0).into_owned()
}
