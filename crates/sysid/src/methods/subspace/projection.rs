//! Projection of the future outputs on the past inputs and outputs.

use std::ops::Range;

use nalgebra::{DMatrix, DMatrixView};

use super::error::SubspaceError;
use super::settings::Weighting;
use crate::record::Experiment;
use hovernav_model::linalg::add_gram;

/// The weighted projection of the future outputs on past inputs and outputs, factored.
pub(super) struct Projection {
    /// The extended observability matrix over all singular values, horizon·outputs × directions. Its first columns are
    /// the matrix of any lower order.
    pub observability: DMatrix<f64>,
    /// Singular values in falling order.
    pub singular_values: Vec<f64>,
    /// Map from a past (inputs, then outputs, oldest first) to the future outputs that it implies, horizon·outputs ×
    /// horizon·(inputs + outputs).
    pub past_to_future: DMatrix<f64>,
    /// Number of past and of future samples.
    pub horizon: usize,
    outputs: usize,
}

/// Smallest ratio of a triangular factor's diagonal for the normal equations. Below it rotations are used, because the
/// error of the normal equations grows with the square of the condition number.
const WELL_CONDITIONED: f64 = 1e-5;

/// Smallest size of a direction of the inputs that counts as excitation, relative to the largest.
const EXCITED: f64 = 1e-9;

impl Projection {
    /// Projects with `horizon` past and future samples. The signals should be scaled ([`super::scales::Scales`]), so
    /// that units do not affect the weights.
    ///
    /// # Source
    /// Equation (I5) of docs/equations.md.
    pub fn of(
        experiment: &Experiment,
        horizon: usize,
        weighting: Weighting,
    ) -> Result<Self, SubspaceError> {
        let (inputs, outputs) = (experiment.inputs.ncols(), experiment.outputs.ncols());
        let rows = 2 * horizon * (inputs + outputs);
        let needed = 2 * horizon + rows;
        if horizon < 2 {
            return Err(SubspaceError::Order { order: 1, horizon, largest: 0 });
        }
        if experiment.samples() < needed {
            return Err(SubspaceError::TooShort {
                experiment: experiment.name.clone(),
                samples: experiment.samples(),
                horizon,
                needed,
            });
        }
        let factor = triangular_factor(experiment, horizon);
        let future_inputs = horizon * inputs;
        let past = horizon * (inputs + outputs);
        let future = horizon * outputs;
        check_excitation(experiment, &factor, future_inputs, horizon * inputs)?;

        let block = |row: usize, rows: usize, column: usize, columns: usize| {
            factor.view((row, column), (rows, columns))
        };
        let r21 = block(future_inputs, past, 0, future_inputs);
        let r22 = block(future_inputs, past, future_inputs, past);
        let r32 = block(future_inputs + past, future, future_inputs, past);
        let r33 = block(future_inputs + past, future, future_inputs + past, future);
        let past_to_future = divide_by_triangle(&r32, &r22);
        let (weighted, weight) = match weighting {
            Weighting::N4sid => {
                let mut both = DMatrix::zeros(past, future_inputs + past);
                both.columns_mut(0, future_inputs).copy_from(&r21);
                both.columns_mut(future_inputs, past).copy_from(&r22);
                (&past_to_future * both, None)
            }
            Weighting::Moesp => (r32.into_owned(), None),
            Weighting::Cva => {
                let mut scatter = r32 * r32.transpose() + r33 * r33.transpose();
                // Without noise the scatter is singular. The floor limits the effect of rounding.
                let floor = 1e-14 * scatter.trace();
                for index in 0..future {
                    scatter[(index, index)] += floor;
                }
                let factor = scatter.cholesky().ok_or_else(|| breakdown(experiment))?.unpack();
                let weighted =
                    factor.solve_lower_triangular(&r32).ok_or_else(|| breakdown(experiment))?;
                (weighted, Some(factor))
            }
        };
        // Only the left singular vectors are needed. The eigenvectors of the small square matrix are cheaper, but lose
        // half the digits that determine the order.
        let svd = weighted.transpose().qr().r().transpose().svd(true, false);
        let (Some(left), values) = (svd.u, svd.singular_values) else {
            return Err(breakdown(experiment));
        };
        if values.iter().any(|value| !value.is_finite()) {
            return Err(breakdown(experiment));
        }
        let mut observability = match weight {
            Some(factor) => factor * left,
            None => left,
        };
        for (mut column, value) in observability.column_iter_mut().zip(values.iter()) {
            column *= value.sqrt();
        }
        Ok(Self {
            observability,
            singular_values: values.iter().copied().collect(),
            past_to_future,
            horizon,
            outputs,
        })
    }

    /// Largest number of states for this horizon.
    pub fn largest_order(&self) -> usize {
        ((self.horizon - 1) * self.outputs).min(self.singular_values.len())
    }
}

fn breakdown(experiment: &Experiment) -> SubspaceError {
    SubspaceError::Breakdown { experiment: experiment.name.clone(), step: "the projection" }
}

/// Number of instants stacked at a time, so that their rows fit in a cache.
const BLOCK: usize = 512;

/// Transposed block Hankel matrices of the instants `rows`, one row per instant. The columns are future inputs, past
/// inputs, past outputs, future outputs, each oldest first.
fn stacked(experiment: &Experiment, horizon: usize, rows: Range<usize>) -> DMatrix<f64> {
    let signals = experiment.inputs.ncols() + experiment.outputs.ncols();
    let mut columns = Vec::with_capacity(rows.len() * 2 * horizon * signals);
    let mut push = |signals: &DMatrix<f64>, first: usize| {
        for shift in first..first + horizon {
            for column in signals.column_iter() {
                columns.extend(column.rows(rows.start + shift, rows.len()).iter());
            }
        }
    };
    push(&experiment.inputs, horizon);
    push(&experiment.inputs, 0);
    push(&experiment.outputs, 0);
    push(&experiment.outputs, horizon);
    DMatrix::from_vec(rows.len(), 2 * horizon * signals, columns)
}

/// The lower triangular L with L Lᵀ = dataᵀ data, `data` the [`stacked`] rows of all instants.
///
/// The normal equations are many times faster than rotations of the tall matrix, and as accurate for well-conditioned
/// data (SLICOT's IB01AD chooses likewise).
fn triangular_factor(experiment: &Experiment, horizon: usize) -> DMatrix<f64> {
    let instants = experiment.samples() - 2 * horizon + 1;
    let blocks = || {
        let first = (0..instants).step_by(BLOCK);
        first.map(|first| stacked(experiment, horizon, first..(first + BLOCK).min(instants)))
    };
    let columns = 2 * horizon * (experiment.inputs.ncols() + experiment.outputs.ncols());
    let mut squares = DMatrix::zeros(columns, columns);
    for block in blocks() {
        add_gram(&mut squares, &block);
    }
    if let Some(factor) = squares.cholesky() {
        let factor = factor.unpack();
        let diagonal = factor.diagonal();
        if diagonal.min() > WELL_CONDITIONED * diagonal.max() {
            return factor;
        }
    }
    let mut factor = DMatrix::zeros(0, columns);
    for block in blocks() {
        let above = factor.nrows();
        let mut both = factor.resize_vertically(above + block.nrows(), 0.0);
        both.rows_mut(above, block.nrows()).copy_from(&block);
        factor = both.qr().unpack_r();
    }
    factor.transpose()
}

fn check_excitation(
    experiment: &Experiment,
    factor: &DMatrix<f64>,
    future: usize,
    past: usize,
) -> Result<(), SubspaceError> {
    let inputs = experiment.inputs.ncols();
    let diagonal = factor.diagonal();
    let largest = diagonal.rows(0, future).amax();
    match (0..future + past).find(|&index| diagonal[index].abs() <= EXCITED * largest) {
        Some(index) => Err(SubspaceError::NotExciting {
            experiment: experiment.name.clone(),
            input: experiment.input_names[index % inputs].clone(),
        }),
        None => Ok(()),
    }
}

/// x with x · triangle = left; directions missing in the triangle are ignored.
fn divide_by_triangle(
    left: &DMatrixView<'_, f64>,
    triangle: &DMatrixView<'_, f64>,
) -> DMatrix<f64> {
    let diagonal = triangle.diagonal().abs();
    if diagonal.min() > 1e-10 * diagonal.max()
        && let Some(solution) = triangle.tr_solve_lower_triangular(&left.transpose())
    {
        return solution.transpose();
    }
    let svd = triangle.transpose().svd(true, true);
    let tolerance = 1e-10 * svd.singular_values.max();
    svd.solve(&left.transpose(), tolerance).map_or_else(
        |_| DMatrix::zeros(left.nrows(), triangle.nrows()),
        |solution| solution.transpose(),
    )
}
