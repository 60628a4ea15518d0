//! Limits of findings that `estimate` and `fly` share.

/// Fraction of lost inertial samples beyond which the loss is reported.
pub const LOST_SAMPLES: f64 = 0.02;
/// Velocity error that vibration causes in one second, m/s, above which the vibration is high.
pub const HIGH_VIBRATION_MPS: f64 = 0.6;
/// Smallest growth of the fixes' delay, s, that shows a clock rate error.
pub const DRIFTED_S: f64 = 0.15;

/// Velocity error after one second, m/s, from vibration that is too fast for samples `interval_s` apart. It is the
/// velocity random walk of white noise. `squares`, (m/s²)², is the sum of squares of its second differences over
/// `count` samples.
#[must_use]
pub fn vibration_mps(squares: f64, count: f64, interval_s: f64) -> f64 {
    (squares / (6.0 * count.max(1.0))).sqrt() * interval_s.sqrt()
}
