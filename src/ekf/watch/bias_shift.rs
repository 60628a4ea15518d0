//! Change of the gyro biases when a vehicle sets off.

use crate::matrix::square;

/// One-sigma of the change of a gyro bias when a vehicle starts to move, rad/s. The assumed one-sigma of the bias
/// applies if it is smaller. The causes are rectified vibration, and motors that warm the inertial unit. A rest shows
/// only the bias before this change.
const SHAKEN_RADPS: f64 = 0.003;

/// Change of gyro biases between rest and motion. Its variance is at most the assumed variance of the biases, and at
/// most the square of [`SHAKEN_RADPS`]. Bias changes found in earlier rests may reduce it.
#[derive(Clone, Copy, Debug)]
pub(in crate::ekf) struct BiasShift {
    /// Variance, (rad/s)²; infinite before the first rest after a motion.
    learned: f32,
    /// Whether the vehicle has stayed at rest since the last update at rest; true before the first one.
    pub rests: bool,
}

impl BiasShift {
    /// State before the first rest.
    pub const UNKNOWN: Self = Self { learned: f32::INFINITY, rests: true };

    /// Variance to which the bias variances are raised when a rest ends, (rad/s)².
    pub fn variance(&self, assumed: f64) -> f64 {
        f64::from(self.learned).min(assumed).min(square(SHAKEN_RADPS))
    }

    /// Updates the variance by a rest after a motion. `found` is the largest squared difference, (rad/s)², between
    /// measured and estimated bias of an axis.
    pub fn learn(&mut self, found: f64) {
        let before = if self.learned.is_finite() { f64::from(self.learned) } else { found };
        self.learned = (before + NEWEST * (found - before)) as f32;
    }
}

/// Weight of the newest rest.
const NEWEST: f64 = 0.5;
