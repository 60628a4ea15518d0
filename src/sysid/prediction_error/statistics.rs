//! What the innovations say of the estimates.

use nalgebra::DMatrix;

use super::problem::{Forced, Passed, Problem, solve_many};
use super::sweep::{Normal, Record};
use crate::sysid::least_squares::Quadratic;

/// σ of the white noise on an output, from its second differences: those of white noise have 6σ².
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

/// The covariance of the free parameters where innovations are white.
pub(super) fn white_covariance(at: &Quadratic) -> Option<DMatrix<f64>> {
    let count = at.gradient.len();
    solve_many(&at.information, &DMatrix::identity(count, count))
}

/// The covariance of the free parameters where innovations are correlated over `lags` samples, from
/// `white`, the one of white innovations.
///
/// With J̃ the sensitivities less what a record's own unknowns explain, M the information and R(l) the
/// innovations' autocovariance, M⁻¹ (Σₖₗ J̃ₖᵀ R(l) J̃ₖ₊ₗ) M⁻¹; Bartlett's window keeps the middle
/// positive.
///
/// # Source
/// Morelli and Klein (1997), *J. Aircraft* 34(2).
pub(super) fn colored_covariance(
    problem: &Problem<'_>,
    white: &DMatrix<f64>,
    forced: &Forced,
    passed: &Passed,
    lags: usize,
) -> Option<DMatrix<f64>> {
    let count = problem.free.len();
    let p = problem.structure.outputs.len();
    let correlations = autocovariances(&passed.normals, p, lags);
    let samples = problem.samples() as f64;
    let mut middle = DMatrix::from_fn(count, count, |row, column| {
        0.5 * samples * forced.spreads[row].dot(&forced.spreads[column])
    });
    for normal in &passed.normals {
        let rows = projected(normal, count)?;
        let length = rows.ncols() / p;
        for (lag, correlation) in correlations.iter().enumerate().take(length) {
            let mut later = DMatrix::zeros(count, (length - lag) * p);
            for sample in 0..length - lag {
                later.columns_mut(sample * p, p).gemm(
                    1.0,
                    &rows.columns((sample + lag) * p, p),
                    &correlation.transpose(),
                    0.0,
                );
            }
            let product = rows.columns(0, (length - lag) * p) * later.transpose();
            if lag > 0 {
                middle += product.transpose();
            }
            middle += product;
        }
    }
    Some(white * middle * white)
}

/// Tapered autocovariances of the whitened innovations over all records, lags 0 to `lags`.
fn autocovariances(normals: &[Normal], p: usize, lags: usize) -> Vec<DMatrix<f64>> {
    let mut found = vec![DMatrix::zeros(p, p); lags + 1];
    let mut samples = 0;
    for normal in normals {
        let length = normal.whitened.len() / p;
        samples += length;
        let errors = DMatrix::from_column_slice(p, length, &normal.whitened);
        for (lag, sum) in found.iter_mut().enumerate().take(length) {
            let early = errors.columns(0, length - lag);
            *sum += early * errors.columns(lag, length - lag).transpose();
        }
    }
    for (lag, sum) in found.iter_mut().enumerate() {
        *sum *= (1.0 - lag as f64 / (lags as f64 + 1.0)) / samples as f64;
    }
    found
}

/// Sensitivities of the parameters, parameters × (samples · outputs), less what the record's own
/// unknowns explain.
fn projected(normal: &Normal, count: usize) -> Option<DMatrix<f64>> {
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
