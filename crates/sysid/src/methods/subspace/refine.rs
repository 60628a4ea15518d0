//! Refinement of a subspace model: the black-box output-error or prediction-error estimate.
//!
//! All entries of A, B, C, D, K and the initial state are free. The data cannot identify all of them, because a change
//! of basis leaves every output unchanged. Uniformly damped steps never move along such directions, which are
//! orthogonal to the gradient. That is equivalent to data-driven local coordinates, without computing them.
//!
//! Source: T. McKelvey, A. Helmersson & T. Ribarits (2004), "Data driven local coordinates for
//! multivariable linear systems", *Automatica* 40(9); A. Wills & B. Ninness (2008), "On gradient-based
//! search for multivariable system estimates", *IEEE Trans. Automatic Control* 53(1).

use nalgebra::{DMatrix, DVector};

use super::balance::balanced;
use super::responses::{forced_responses, free_responses};
use super::settings::{Identified, InputFit};
use crate::methods::innovation::InnovationModel;
use crate::methods::least_squares::{Cost, Limits, Quadratic, minimise};
use crate::record::Experiment;
use hovernav_model::linalg::{gram, spectral_radius};
use hovernav_model::{LinearModel, TimeDomain};

/// Criterion of the refinement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Criterion {
    /// Simulation from the inputs alone (output error). Only for stable models; K is zero.
    Simulation,
    /// One-step prediction from the past samples (prediction error), including K. Works for unstable vehicles too.
    OneStep,
}

/// Settings of the refinement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RefineSettings {
    /// Criterion to optimise.
    pub criterion: Criterion,
    /// Whether D is free; otherwise it stays unchanged.
    pub feedthrough: bool,
    /// Largest number of linearisations.
    pub max_steps: usize,
}

impl Default for RefineSettings {
    fn default() -> Self {
        Self { criterion: Criterion::Simulation, feedthrough: true, max_steps: 200 }
    }
}

/// Result of the refinement.
#[derive(Debug, Clone, PartialEq)]
pub struct Refined {
    /// The model.
    pub model: InnovationModel,
    /// The state at the first sample.
    pub initial_state: DVector<f64>,
    /// Sum of squared errors over outputs and samples, before and after the refinement. Each output is scaled by its
    /// own root mean square deviation.
    pub cost: [f64; 2],
    /// Number of linearisations.
    pub steps: usize,
    /// Whether the search converged.
    pub converged: bool,
}

/// Refines `start` on `experiment`, the data from which it was estimated, as deviations from the same trim.
///
/// `None` where `start` cannot be refined by this criterion: its simulation, or its one-step predictor, is unstable.
#[must_use]
pub fn refine(
    start: &Identified,
    experiment: &Experiment,
    settings: &RefineSettings,
) -> Option<Refined> {
    let problem = OutputError::new(experiment, start.model.system.order(), settings);
    let model = match settings.criterion {
        Criterion::Simulation if start.input_fit == InputFit::Simulation => {
            start.model.without_gain()
        }
        Criterion::Simulation => return None,
        Criterion::OneStep => start.model.clone(),
    };
    let (model, initial_state) = balanced(model, start.initial_state.clone());
    let theta = problem.pack(&model, &initial_state);
    let before = problem.cost(&theta)?;
    let limits = Limits { iterations: settings.max_steps, min_decrease: 1e-10 * before };
    let free = vec![f64::INFINITY; theta.len()];
    let bound: Vec<f64> = free.iter().map(|bound| -bound).collect();
    let end = minimise(&problem, &theta, &bound, &free, limits)?;
    let (model, initial_state) = problem.unpack(&end.theta);
    Some(Refined {
        model,
        initial_state,
        cost: [2.0 * before, 2.0 * end.at.cost],
        steps: end.iterations,
        converged: end.converged,
    })
}

/// The sum of squared errors of a predictor x(k+1) = Ā x + B̄ u + K y, ŷ = C x + D u. Here Ā = A − K C and B̄ = B − K
/// D. Without K it is the simulation.
struct OutputError<'a> {
    experiment: &'a Experiment,
    /// Inputs and, where K is free, outputs in adjacent columns: the signals that drive the predictor.
    drives: DMatrix<f64>,
    /// One over the root mean square deviation of each output.
    weights: Vec<f64>,
    order: usize,
    feedthrough: bool,
}

impl<'a> OutputError<'a> {
    fn new(experiment: &'a Experiment, order: usize, settings: &RefineSettings) -> Self {
        let inputs = experiment.inputs.ncols();
        let outputs = experiment.outputs.ncols();
        let with_gain = settings.criterion == Criterion::OneStep;
        let width = inputs + if with_gain { outputs } else { 0 };
        let mut drives = DMatrix::zeros(experiment.samples(), width);
        drives.columns_mut(0, inputs).copy_from(&experiment.inputs);
        if with_gain {
            drives.columns_mut(inputs, outputs).copy_from(&experiment.outputs);
        }
        let weights = experiment
            .outputs
            .column_iter()
            .map(|output| 1.0 / output.variance().sqrt().max(f64::MIN_POSITIVE))
            .collect();
        Self { experiment, drives, weights, order, feedthrough: settings.feedthrough }
    }

    fn inputs(&self) -> usize {
        self.experiment.inputs.ncols()
    }

    fn outputs(&self) -> usize {
        self.experiment.outputs.ncols()
    }

    /// Columns: Ā, B̄, K, C, D (where free), x(0), each column by column.
    fn pack(&self, model: &InnovationModel, initial_state: &DVector<f64>) -> Vec<f64> {
        let system = &model.system;
        let mut theta = Vec::new();
        theta.extend((&system.a - &model.gain * &system.c).iter());
        theta.extend((&system.b - &model.gain * &system.d).iter());
        if self.drives.ncols() > self.inputs() {
            theta.extend(model.gain.iter());
        }
        theta.extend(system.c.iter());
        if self.feedthrough {
            theta.extend(system.d.iter());
        }
        theta.extend(initial_state.iter());
        theta
    }

    fn predictor(&self, theta: &[f64]) -> Predictor {
        let (order, outputs, inputs) = (self.order, self.outputs(), self.inputs());
        let mut rest = theta;
        let mut take = |rows: usize, columns: usize| {
            let (head, tail) = rest.split_at(rows * columns);
            rest = tail;
            DMatrix::from_column_slice(rows, columns, head)
        };
        Predictor {
            transition: take(order, order),
            drive: take(order, self.drives.ncols()),
            output: take(outputs, order),
            direct: if self.feedthrough {
                take(outputs, inputs)
            } else {
                DMatrix::zeros(outputs, inputs)
            },
            initial_state: take(order, 1).column(0).into_owned(),
        }
    }

    fn unpack(&self, theta: &[f64]) -> (InnovationModel, DVector<f64>) {
        let predictor = self.predictor(theta);
        let inputs = self.inputs();
        let gains = self.drives.ncols() - inputs;
        let gain = if gains > 0 {
            predictor.drive.columns(inputs, gains).into_owned()
        } else {
            DMatrix::zeros(self.order, self.outputs())
        };
        let system = LinearModel {
            a: &predictor.transition + &gain * &predictor.output,
            b: predictor.drive.columns(0, inputs) + &gain * &predictor.direct,
            c: predictor.output,
            d: predictor.direct,
            time: TimeDomain::Discrete { period_s: self.experiment.period_s },
        };
        (InnovationModel { system, gain }, predictor.initial_state)
    }

    /// Weighted errors, stacked sample by sample, and the states, samples × states.
    fn errors(&self, predictor: &Predictor) -> (DVector<f64>, DMatrix<f64>) {
        let outputs = self.outputs();
        let states = predictor.states(&self.drives);
        let predicted = &states * predictor.output.transpose()
            + &self.experiment.inputs * predictor.direct.transpose();
        let errors = DVector::from_fn(self.experiment.samples() * outputs, |row, _| {
            let at = (row / outputs, row % outputs);
            self.weights[at.1] * (self.experiment.outputs[at] - predicted[at])
        });
        (errors, states)
    }

    /// The derivative of the weighted predictions, rows as the errors, columns as `theta`.
    fn jacobian(&self, predictor: &Predictor, states: &DMatrix<f64>) -> DMatrix<f64> {
        let (order, outputs, inputs) = (self.order, self.outputs(), self.inputs());
        let samples = self.experiment.samples();
        let mut signals = DMatrix::zeros(samples, order + self.drives.ncols());
        signals.columns_mut(0, order).copy_from(states);
        signals.columns_mut(order, self.drives.ncols()).copy_from(&self.drives);
        let driven = forced_responses(&predictor.transition, &predictor.output, &signals);
        let free = free_responses(&predictor.transition, &predictor.output, samples);

        let direct = if self.feedthrough { inputs } else { 0 };
        let width = driven.ncols() + outputs * (order + direct) + order;
        let mut jacobian = DMatrix::zeros(samples * outputs, width);
        jacobian.columns_mut(0, driven.ncols()).copy_from(&driven);
        for signal in 0..order + direct {
            let values = if signal < order {
                states.column(signal)
            } else {
                self.experiment.inputs.column(signal - order)
            };
            for output in 0..outputs {
                let mut column = jacobian.column_mut(driven.ncols() + signal * outputs + output);
                for (sample, value) in values.iter().enumerate() {
                    column[sample * outputs + output] = *value;
                }
            }
        }
        jacobian.columns_mut(width - order, order).copy_from(&free);
        for mut column in jacobian.column_iter_mut() {
            for (row, value) in column.iter_mut().enumerate() {
                *value *= self.weights[row % outputs];
            }
        }
        jacobian
    }
}

impl Cost for OutputError<'_> {
    fn cost(&self, theta: &[f64]) -> Option<f64> {
        let predictor = self.predictor(theta);
        (spectral_radius(&predictor.transition) < 1.0)
            .then(|| 0.5 * self.errors(&predictor).0.norm_squared())
            .filter(|cost| cost.is_finite())
    }

    fn quadratic(&self, theta: &[f64]) -> Option<Quadratic> {
        let predictor = self.predictor(theta);
        if spectral_radius(&predictor.transition) >= 1.0 {
            return None;
        }
        let (errors, states) = self.errors(&predictor);
        let jacobian = self.jacobian(&predictor, &states);
        Some(Quadratic {
            cost: 0.5 * errors.norm_squared(),
            gradient: -jacobian.tr_mul(&errors),
            information: gram(&jacobian),
        })
    }
}

struct Predictor {
    transition: DMatrix<f64>,
    drive: DMatrix<f64>,
    output: DMatrix<f64>,
    direct: DMatrix<f64>,
    initial_state: DVector<f64>,
}

impl Predictor {
    /// The states, samples × states.
    fn states(&self, drives: &DMatrix<f64>) -> DMatrix<f64> {
        let forcing = &self.drive * drives.transpose();
        let mut states = DMatrix::zeros(self.transition.nrows(), drives.nrows());
        let mut state = self.initial_state.clone();
        for (mut kept, forced) in states.column_iter_mut().zip(forcing.column_iter()) {
            kept.copy_from(&state);
            state.copy_from(&forced);
            state.gemv(1.0, &self.transition, &kept, 1.0);
        }
        states.transpose()
    }
}
