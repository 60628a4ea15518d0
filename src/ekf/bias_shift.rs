//! Change of the gyro biases when a vehicle sets off.

use super::square;

/// One-sigma of the change of a gyro bias when a vehicle sets off, rad/s, unless the assumed one-sigma of the bias is
/// smaller: shaking rectifies, motors warm the inertial unit. The rest itself has measured the bias since power-on.
const SHAKEN_RADPS: f64 = 0.003;

/// Change of gyro biases between rest and motion: limited by their assumed size and by the effect of shaking, until a
/// rest after a motion has shown less.
#[derive(Clone, Copy, Debug)]
pub(super) struct BiasShift {
    /// Variance, (rad/s)²; infinite before the first rest after a motion.
    learned: f32,
    /// Whether the last second but one was at rest, or nothing is known of it.
    pub rests: bool,
}

impl BiasShift {
    /// State before the first rest.
    pub const UNKNOWN: Self = Self { learned: f32::INFINITY, rests: true };

    /// Variance to which the biases open when a rest ends.
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
