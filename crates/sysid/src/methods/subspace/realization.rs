//! A, C and the whole model from the observability matrix.

use nalgebra::DMatrix;

use super::error::SubspaceError;
use super::gain::innovation_gain;
use super::input_fit::{InputMap, fit_inputs};
use super::projection::Projection;
use super::settings::{Identified, InputFit, SubspaceSettings};
use crate::methods::innovation::InnovationModel;
use crate::record::Experiment;
use hovernav_model::linalg::least_squares;
use hovernav_model::linalg::spectral_radius;
use hovernav_model::{LinearModel, TimeDomain};

/// Number of instants processed at a time, so that their states fit in a cache.
const BLOCK: usize = 512;

/// Distance from the unit circle to which the outermost pole of a model known to be stable is moved.
const EDGE: f64 = 1e-4;

/// The model of `order` states.
///
/// # Source
/// Equation (I6) of docs/equations.md.
pub(super) fn realize(
    experiment: &Experiment,
    projection: &Projection,
    order: usize,
    settings: &SubspaceSettings,
) -> Result<Identified, SubspaceError> {
    let SubspaceSettings { feedthrough, stable, .. } = *settings;
    let largest = projection.largest_order();
    if order == 0 || order > largest {
        return Err(SubspaceError::Order { order, horizon: projection.horizon, largest });
    }
    let outputs = experiment.outputs.ncols();
    let observability = projection.observability.columns(0, order).into_owned();
    let shifted = observability.rows_range(outputs..).into_owned();
    let kept = observability.rows(0, shifted.nrows()).into_owned();
    let mut a = least_squares(kept, &shifted);
    let c = observability.rows(0, outputs).into_owned();

    let radius = spectral_radius(&a);
    let finite = a.iter().chain(c.iter()).all(|value| value.is_finite());
    if !(finite && radius.is_finite()) {
        return Err(SubspaceError::Breakdown {
            experiment: experiment.name.clone(),
            step: "the shift of the observability matrix",
        });
    }
    if stable && radius >= 1.0 {
        a *= (1.0 - EDGE) / radius;
    }

    let states = states(experiment, projection, &observability);
    let gain = innovation_gain(experiment, &a, &c, &states, projection.horizon, feedthrough);
    let (fit, used_gain) = if spectral_radius(&a) < 1.0 {
        (InputFit::Simulation, DMatrix::zeros(order, outputs))
    } else {
        (InputFit::Prediction, gain.clone())
    };
    let InputMap { b, d, initial_state } = fit_inputs(experiment, &a, &c, &used_gain, feedthrough);
    let time = TimeDomain::Discrete { period_s: experiment.period_s };
    let system = LinearModel { time, a, b, c, d };
    if system.b.iter().chain(system.d.iter()).any(|value| !value.is_finite()) {
        return Err(SubspaceError::Breakdown {
            experiment: experiment.name.clone(),
            step: "the fit of B and D",
        });
    }
    Ok(Identified {
        model: InnovationModel { system, gain },
        initial_state,
        singular_values: projection.singular_values.clone(),
        input_fit: fit,
    })
}

/// The states implied by the past at every instant from `horizon` on, states × instants.
fn states(
    experiment: &Experiment,
    projection: &Projection,
    observability: &DMatrix<f64>,
) -> DMatrix<f64> {
    let horizon = projection.horizon;
    let map = least_squares(observability.clone(), &projection.past_to_future);
    let instants = experiment.samples() - horizon + 1;
    let mut states = DMatrix::zeros(observability.ncols(), instants);
    for first in (0..instants).step_by(BLOCK) {
        let length = BLOCK.min(instants - first);
        let mut block = states.columns_mut(first, length);
        let mut column = 0;
        for signals in [&experiment.inputs, &experiment.outputs] {
            for shift in first..first + horizon {
                for signal in signals.column_iter() {
                    block.ger(1.0, &map.column(column), &signal.rows(shift, length), 1.0);
                    column += 1;
                }
            }
        }
    }
    states
}
