//! Statistics of the innovations, for the uncertainty of the estimates.

use nalgebra::{DMatrix, DVector};

use super::problem::{Forced, Passed, Problem, solve_many};
use super::sweep::{Normal, Record};
use crate::methods::least_squares::Quadratic;

/// σ of the white noise on an output from its second differences, whose variance is 6σ².
///
/// # Source
/// Equation (I16) of docs/equations.md.
pub(super) fn noise_of(records: &[Record], output: usize, outputs: usize) -> f64 {
    let (mut squares, mut count, mut largest) = (0.0, 0.0, 0.0_f64);
    for record in records {
        let at = |sample: usize| record.outputs[sample * outputs + output];
        for sample in 2..record.samples {
            squares += (at(sample) - 2.0 * at(sample - 1) + at(sample - 2)).powi(2);
            count += 6.0;
        }
        largest = (0..record.samples).map(|sample| at(sample).abs()).fold(largest, f64::max);
    }
    let sigma = if count > 0.0 { (squares / count).sqrt() } else { 0.0 };
    sigma.max(1e-6 * largest).max(1e-12)
}

/// Standard deviation of an output about its mean in each record.
pub(super) fn deviation_of(records: &[Record], output: usize, outputs: usize) -> f64 {
    let (mut squares, mut count) = (0.0, 0);
    for record in records {
        let values = || record.outputs.iter().skip(output).step_by(outputs);
        let mean = values().sum::<f64>() / record.samples as f64;
        squares += values().map(|value| (value - mean).powi(2)).sum::<f64>();
        count += record.samples;
    }
    (squares / count.max(1) as f64).sqrt().max(1e-12)
}

/// Covariance of the free parameters for white innovations.
pub(super) fn white_covariance(at: &Quadratic) -> Option<DMatrix<f64>> {
    let count = at.gradient.len();
    solve_many(&at.information, &DMatrix::identity(count, count))
}

/// Covariance of the free parameters for innovations that are correlated over `lags` samples and of varying size. It is
/// computed from `white`, the covariance for white innovations of constant size. The factor `widened` on the bounds
/// applies to the information of the innovations, not to that of the priors.
///
/// With gₖ a sample's contribution to the cost's gradient and M the information, M⁻¹ (Σₖₗ wₗ gₖ gₖ₊ₗᵀ) M⁻¹; Bartlett's
/// window w keeps the middle factor positive. The position of a step between two samples of the stick is unknown, so
/// residuals are largest where the sensitivities are largest. Only the gradients themselves show that.
///
/// # Source
/// Newey and West (1987), *Econometrica* 55(3); for flight data Morelli and Klein (1997),
/// *J. Aircraft* 34(2).
/// Equation (I15) of docs/equations.md.
pub(super) fn colored_covariance(
    problem: &Problem<'_>,
    white: &DMatrix<f64>,
    forced: &Forced,
    passed: &Passed,
    lags: usize,
    widened: f64,
) -> Option<DMatrix<f64>> {
    let mut middle = scatter_of_gradients(problem, forced, passed, lags)? * widened.powi(2);
    for (place, _, sigma, weight) in problem.priors() {
        middle[(place, place)] += (weight / sigma).powi(2);
    }
    Some(white * middle * white)
}

/// Largest factor by which information is overstated; beyond it the flight contains no information.
pub(super) const MAX_OVERCONFIDENCE: f64 = 100.0;

/// Factor by which the information on each free parameter is overstated, at least 1. It is the variance of the cost's
/// gradient, correlated over `lags` samples, over the information.
pub(super) fn overconfidence(
    problem: &Problem<'_>,
    at: &Quadratic,
    forced: &Forced,
    passed: &Passed,
    lags: usize,
) -> Option<Vec<f64>> {
    let middle = scatter_of_gradients(problem, forced, passed, lags)?;
    let mut information = at.information.diagonal();
    for (place, _, sigma, weight) in problem.priors() {
        information[place] -= weight / (sigma * sigma);
    }
    let ratio = |place: usize| middle[(place, place)] / information[place].max(f64::MIN_POSITIVE);
    Some((0..information.len()).map(|place| ratio(place).clamp(1.0, MAX_OVERCONFIDENCE)).collect())
}

/// Σₖₗ wₗ gₖ gₖ₊ₗᵀ.
fn scatter_of_gradients(
    problem: &Problem<'_>,
    forced: &Forced,
    passed: &Passed,
    lags: usize,
) -> Option<DMatrix<f64>> {
    let count = problem.free.len();
    passed.normals.iter().try_fold(DMatrix::zeros(count, count), |middle, normal| {
        Some(middle + correlated_scatter(&gradients(problem, normal, forced)?, lags))
    })
}

/// Σₖₗ wₗ gₖ gₖ₊ₗᵀ of the columns g, with w Bartlett's window over `lags`. It is computed from the sums of `lags` + 1
/// neighbouring columns: their scatter, divided by `lags` + 1. In this scatter each gₖ gₖ₊ₗᵀ occurs `lags` + 1 − l
/// times.
pub(super) fn correlated_scatter(columns: &DMatrix<f64>, lags: usize) -> DMatrix<f64> {
    let length = columns.ncols();
    let mut sums = DMatrix::zeros(columns.nrows(), length + lags);
    let mut sum = DVector::zeros(columns.nrows());
    for (last, mut sums) in sums.column_iter_mut().enumerate() {
        if last < length {
            sum += columns.column(last);
        }
        if last > lags {
            sum -= columns.column(last - lags - 1);
        }
        sums.copy_from(&sum);
    }
    &sums * sums.transpose() / (lags + 1) as f64
}

/// Contribution of each sample to the cost's gradient, parameters × samples.
fn gradients(problem: &Problem<'_>, normal: &Normal, forced: &Forced) -> Option<DMatrix<f64>> {
    let (count, p) = (problem.free.len(), problem.structure.outputs.len());
    let errors = DVector::from_column_slice(&normal.whitened);
    let mut shares = shares(&projected(normal, count)?, &errors, p);
    for (sample, mut share) in shares.column_iter_mut().enumerate() {
        let error = errors.rows(sample * p, p);
        for (parameter, spread) in forced.spreads.iter().enumerate() {
            share[parameter] += 0.5 * (spread.trace() - error.dot(&(spread * error)));
        }
    }
    Some(shares)
}

/// Product of `rows`, parameters × (samples · outputs), and `errors` of each sample, parameters × samples.
pub(super) fn shares(rows: &DMatrix<f64>, errors: &DVector<f64>, outputs: usize) -> DMatrix<f64> {
    let mut shares = DMatrix::zeros(rows.nrows(), errors.len() / outputs);
    for (sample, mut share) in shares.column_iter_mut().enumerate() {
        let (rows, error) =
            (rows.columns(sample * outputs, outputs), errors.rows(sample * outputs, outputs));
        share.gemv(1.0, &rows, &error, 0.0);
    }
    shares
}

/// Sensitivities to the parameters, parameters × (samples · outputs). The part that the record's unknown initial state,
/// offsets and biases explain is removed.
pub(super) fn projected(normal: &Normal, count: usize) -> Option<DMatrix<f64>> {
    let columns = normal.gradient.len();
    let own = columns - count;
    let all = DMatrix::from_column_slice(
        columns,
        normal.sensitivities.len() / columns,
        &normal.sensitivities,
    );
    let across = normal.information.view((count, 0), (own, count)).into_owned();
    let inner = normal.information.view((count, count), (own, own)).into_owned();
    let eliminate = solve_many(&inner, &across)?;
    Some(all.rows(0, count) - eliminate.tr_mul(&all.rows(count, own)))
}

/// Largest absolute correlation of each output's whitened innovations at lags of 0.1 to 1 s.
pub(super) fn innovations_correlation(passed: &Passed, p: usize, period_s: f64) -> Vec<f64> {
    const APART_S: [f64; 2] = [0.1, 1.0];
    let [first, last] = APART_S.map(|apart_s| (apart_s / period_s).ceil() as usize);
    let product = |output: usize, lag: usize| -> f64 {
        let of = |normal: &Normal| -> f64 {
            let late = normal.whitened.iter().skip(lag * p + output).step_by(p);
            normal.whitened.iter().skip(output).step_by(p).zip(late).map(|(a, b)| a * b).sum()
        };
        passed.normals.iter().map(of).sum()
    };
    let largest = |output| {
        let sizes = (first..=last).map(|lag| product(output, lag).abs() / product(output, 0));
        sizes.fold(0.0, f64::max)
    };
    (0..p).map(largest).collect()
}

/// Σ ν νᵀ / N of the innovations themselves: L (Σ e eᵀ / N) Lᵀ.
pub(super) fn innovations_covariance(
    passed: &Passed,
    whitener: &DMatrix<f64>,
    samples: usize,
) -> Option<DMatrix<f64>> {
    let p = whitener.nrows();
    let lower = whitener.solve_lower_triangular(&DMatrix::identity(p, p))?;
    let scatter = passed.normals.iter().fold(DMatrix::zeros(p, p), |sum, one| sum + &one.scatter);
    Some(&lower * scatter * lower.transpose() / samples as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scatter_of_sums_is_bartletts() {
        let columns = DMatrix::from_fn(3, 17, |row, column| {
            ((7 * row + 13 * column * column) as f64 * 0.618).fract() - 0.4
        });
        for lags in [0, 1, 5, 16, 40] {
            let mut expected = DMatrix::zeros(3, 3);
            for (k, early) in columns.column_iter().enumerate() {
                for (l, late) in columns.column_iter().enumerate() {
                    let weight = 1.0 - k.abs_diff(l) as f64 / (lags + 1) as f64;
                    expected += early * late.transpose() * weight.max(0.0);
                }
            }
            let off = (correlated_scatter(&columns, lags) - &expected).amax();
            assert!(off < 1e-13 * expected.amax(), "{lags}: {off}");
        }
    }
}
