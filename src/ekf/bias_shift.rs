//! Change of the gyro biases when a vehicle sets off.

use super::square;

/// One-sigma of the change of a gyro bias when a vehicle starts to move, rad/s. The assumed one-sigma of the bias
/// applies if it is smaller. Vibration is rectified, and motors warm the inertial unit. The bias since power-on was
/// measured during the rest.
const SHAKEN_RADPS: f64 = 0.003;

/// Change of gyro biases between rest and motion. Its variance is limited by the assumed variance of the biases and by
/// the effect of vibration. A rest after a motion may show a smaller variance.
#[derive(Clone, Copy, Debug)]
pub(super) struct BiasShift {
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

    /// Learns from the largest square of the bias errors found in a rest.
    pub fn learn(&mut self, found: f64) {
        let before = if self.learned.is_finite() { f64::from(self.learned) } else { found };
        self.learned = (before + NEWEST * (found - before)) as f32;
    }
}

/// Weight of the newest rest.
const NEWEST: f64 = 0.5;
