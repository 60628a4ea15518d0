//! Fraction of a measured output that a model explains.

use nalgebra::DMatrix;

/// Fit in percent of each output, 100·(1 − ‖y − ŷ‖/‖y − ȳ‖): 100 is perfect, 0 no better than the mean, and a response
/// of the wrong sign is negative. Both matrices are samples × outputs.
///
/// A constant output has no deviation, so its fit is NaN.
///
/// # Panics
/// Where the shapes differ.
///
/// # Source
/// Equation (I22) of docs/equations.md.
#[must_use]
pub fn fit_percent(measured: &DMatrix<f64>, predicted: &DMatrix<f64>) -> Vec<f64> {
    assert_eq!(measured.shape(), predicted.shape(), "one prediction per measurement");
    measured
        .column_iter()
        .zip(predicted.column_iter())
        .map(|(measured, predicted)| {
            let deviation = measured.add_scalar(-measured.mean()).norm();
            // The mean of a constant equals it only up to rounding.
            if deviation > 1e-13 * measured.norm() {
                100.0 * (1.0 - (measured - predicted).norm() / deviation)
            } else {
                f64::NAN
            }
        })
        .collect()
}

/// Theil's inequality coefficient, and the composition of the error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Theil {
    /// Root mean square of the error over the sum of those of both signals: 0 is perfect, 1 the worst; 0.25 to 0.3 is
    /// typical for a good flight model.
    pub coefficient: f64,
    /// Fraction of the squared error due to a constant offset.
    pub bias: f64,
    /// Fraction of the squared error due to a difference in the size of the movements.
    pub variance: f64,
    /// Remaining fraction, due to different movements. The three fractions sum to 1.
    pub covariance: f64,
}

/// Theil's coefficient of two signals of equal length. Equal signals have a coefficient and fractions of 0.
///
/// # Panics
/// Where the lengths differ.
///
/// # Source
/// Jategaonkar, *Flight Vehicle System Identification*, section 11.2.
/// Equation (I23) of docs/equations.md.
#[must_use]
pub fn theil(measured: &[f64], predicted: &[f64]) -> Theil {
    assert_eq!(measured.len(), predicted.len(), "one prediction per measurement");
    let count = measured.len() as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / count;
    let square = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>() / count;
    let error: f64 =
        measured.iter().zip(predicted).map(|(one, other)| (one - other).powi(2)).sum::<f64>()
            / count;
    if error == 0.0 {
        return Theil { coefficient: 0.0, bias: 0.0, variance: 0.0, covariance: 0.0 };
    }
    let (mean_one, mean_other) = (mean(measured), mean(predicted));
    let deviation = |values: &[f64], mean: f64| (square(values) - mean * mean).max(0.0).sqrt();
    let size_gap = deviation(measured, mean_one) - deviation(predicted, mean_other);
    let bias = (mean_one - mean_other).powi(2) / error;
    let variance = size_gap * size_gap / error;
    Theil {
        coefficient: error.sqrt() / (square(measured).sqrt() + square(predicted).sqrt()),
        bias,
        variance,
        covariance: 1.0 - bias - variance,
    }
}
