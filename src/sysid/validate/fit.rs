//! How much of a measured output a model explains.

use nalgebra::DMatrix;

/// Fit in percent of each output, 100·(1 − ‖y − ŷ‖/‖y − ȳ‖): 100 is perfect, 0 no better than the
/// mean, and a model that runs the wrong way is below. Both matrices are samples × outputs.
///
/// A constant output has no deviation to explain: its fit is NaN.
///
/// # Panics
/// Where the shapes differ.
#[must_use]
pub fn fit_percent(measured: &DMatrix<f64>, predicted: &DMatrix<f64>) -> Vec<f64> {
    assert_eq!(measured.shape(), predicted.shape(), "one prediction per measurement");
    measured
        .column_iter()
        .zip(predicted.column_iter())
        .map(|(measured, predicted)| {
            let deviation = measured.add_scalar(-measured.mean()).norm();
            if deviation > 0.0 {
                100.0 * (1.0 - (measured - predicted).norm() / deviation)
            } else {
                f64::NAN
            }
        })
        .collect()
}
