//! Range of flight in which the derivatives of a model are valid.

use std::fmt;

/// Flight near a trim: velocities in which linear derivatives are valid.
///
/// The horizontal velocity, body axes, differs by less than `within_mps` from the forward speed `speed_mps`. The vertical
/// velocity is below 0.8 times `within_mps`, roll and pitch are below 25°.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlightCondition {
    /// Forward speed of the trim over the ground, m/s; 0 for a hover.
    pub speed_mps: f64,
    /// Largest difference from this speed, m/s; above 0.
    pub within_mps: f64,
}

/// Largest bank and pitch, rad.
const STEEPEST_RAD: f64 = 0.44;
/// Largest vertical velocity, as a fraction of the largest difference of the horizontal one.
const VERTICAL: f64 = 0.8;

impl FlightCondition {
    /// Hover: at most 2.5 m/s.
    pub const HOVER: Self = Self { speed_mps: 0.0, within_mps: 2.5 };

    /// Whether the velocity (u, v, w), m/s, and roll and pitch, rad, are within the range; false for NaN.
    pub(super) fn holds(&self, [u, v, w]: [f64; 3], [roll_rad, pitch_rad]: [f64; 2]) -> bool {
        (u - self.speed_mps).hypot(v) < self.within_mps
            && w.abs() < VERTICAL * self.within_mps
            && roll_rad.abs().max(pitch_rad.abs()) < STEEPEST_RAD
    }

    /// Whether both numbers are usable.
    pub(super) fn is_valid(&self) -> bool {
        self.speed_mps.is_finite() && self.within_mps > 0.0 && self.within_mps.is_finite()
    }
}

impl fmt::Display for FlightCondition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.speed_mps == 0.0 {
            f.write_str("a hover")
        } else {
            write!(f, "{} m/s", self.speed_mps)
        }
    }
}
