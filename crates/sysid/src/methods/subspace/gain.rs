//! Innovation gain: the effect of an innovation on the state.

use nalgebra::{Cholesky, DMatrix};

use crate::methods::kalman::predicted_covariance;
use crate::record::Experiment;
use hovernav_model::linalg::least_squares;

/// K of x(k+1) = A x + B u + K e, from the unexplained scatter of the estimated `states`, states × instants. The first
/// instant is sample `first`. Zero where no filter exists for the scatter.
pub(super) fn innovation_gain(
    experiment: &Experiment,
    a: &DMatrix<f64>,
    c: &DMatrix<f64>,
    states: &DMatrix<f64>,
    first: usize,
    feedthrough: bool,
) -> DMatrix<f64> {
    let (order, outputs) = (a.nrows(), c.nrows());
    let steps = states.ncols() - 1;
    let now = states.columns(0, steps);
    let next = states.columns(1, steps);
    let inputs = experiment.inputs.rows(first, steps).into_owned();
    let measured = experiment.outputs.rows(first, steps);

    let unexplained_state = (next - a * now).transpose();
    let unexplained_output = (measured.transpose() - c * now).transpose();
    let mut both = DMatrix::zeros(steps, order + outputs);
    both.columns_mut(0, order).copy_from(&unexplained_state);
    both.columns_mut(order, outputs).copy_from(&unexplained_output);
    let mut direct = least_squares(inputs.clone(), &both);
    if !feedthrough {
        direct.columns_mut(order, outputs).fill(0.0);
    }
    let residuals = both - inputs * direct;
    let scatter = residuals.tr_mul(&residuals) / steps as f64;
    let process = scatter.view((0, 0), (order, order)).into_owned();
    let cross = scatter.view((0, order), (order, outputs)).into_owned();
    let mut noise = scatter.view((order, order), (outputs, outputs)).into_owned();
    // Without noise the matrix is singular; a small addition keeps the filter defined.
    let size = experiment.outputs.norm_squared() / experiment.outputs.len() as f64;
    for index in 0..outputs {
        noise[(index, index)] += 1e-12 * size;
    }
    steady_gain(a, c, &process, &cross, &noise).unwrap_or_else(|| DMatrix::zeros(order, outputs))
}

/// Gain of the steady-state one-step predictor for process noise Q, measurement noise R and their cross covariance S: K
/// = (A P Cᵀ + S)(C P Cᵀ + R)⁻¹.
///
/// P is the predicted state covariance for A − S R⁻¹ C and Q − S R⁻¹ Sᵀ. With these two, process noise and
/// measurement noise are uncorrelated.
///
/// # Source
/// Equation (I8) of docs/equations.md.
fn steady_gain(
    a: &DMatrix<f64>,
    c: &DMatrix<f64>,
    process: &DMatrix<f64>,
    cross: &DMatrix<f64>,
    noise: &DMatrix<f64>,
) -> Option<DMatrix<f64>> {
    let explained = Cholesky::new(noise.clone())?.solve(&cross.transpose()).transpose();
    let covariance = predicted_covariance(
        &(a - &explained * c),
        c,
        &(process - &explained * cross.transpose()),
        noise,
    )?;
    let innovation = c * &covariance * c.transpose() + noise;
    let moved = a * &covariance * c.transpose() + cross;
    Some(Cholesky::new(innovation)?.solve(&moved.transpose()).transpose())
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use nalgebra::dmatrix;

    #[test]
    fn the_scalar_random_walk_has_the_golden_gain() {
        let one = dmatrix![1.0];
        let gain = steady_gain(&one, &one, &one, &dmatrix![0.0], &one).unwrap();
        // P = (1 + √5)/2, K = P/(P + 1).
        assert_abs_diff_eq!(gain[0], (5_f64.sqrt() - 1.0) / 2.0, epsilon = 1e-12);
    }

    #[test]
    fn noise_that_enters_state_and_output_alike_is_all_gain() {
        // x+ = 0.5 x + 2 e, y = x + e: K must be 2.
        let gain = steady_gain(
            &dmatrix![0.5],
            &dmatrix![1.0],
            &dmatrix![4.0],
            &dmatrix![2.0],
            &dmatrix![1.0],
        );
        assert_abs_diff_eq!(gain.unwrap()[0], 2.0, epsilon = 1e-12);
    }
}
