//! Range of flight in which the derivatives of a model are valid.

use std::fmt;

/// Flight near a trim: velocities in which linear derivatives are valid.
///
/// The horizontal velocity, forward and to the right of the heading, differs by less than `within_mps` from the forward
/// speed `speed_mps`. The vertical velocity is below 0.8 times `within_mps`, roll and pitch are below 25°.
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
        let ((sin_roll, cos_roll), (sin, cos)) = (roll_rad.sin_cos(), pitch_rad.sin_cos());
        let right = v * cos_roll - w * sin_roll;
        let below = v * sin_roll + w * cos_roll;
        let (forward, down) = (u * cos + below * sin, below * cos - u * sin);
        (forward - self.speed_mps).hypot(right) < self.within_mps
            && down.abs() < VERTICAL * self.within_mps
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

#[cfg(test)]
mod tests {
    use super::*;

    /// In fast level flight with the nose down, the body's own vertical velocity is large.
    #[test]
    fn level_flight_with_the_nose_down_is_not_a_descent() {
        let condition = FlightCondition { speed_mps: 14.0, ..FlightCondition::HOVER };
        let pitch_rad = -0.27f64;
        let velocity = [14.0 * pitch_rad.cos(), 0.0, 14.0 * pitch_rad.sin()];
        assert!(velocity[2] < -3.0 && condition.holds(velocity, [0.0, pitch_rad]));
        assert!(!condition.holds(velocity, [0.0, 0.0]), "the same velocity while level is a climb");
        assert!(!condition.holds([f64::NAN, 0.0, 0.0], [0.0, 0.0]));
        assert!(!FlightCondition::HOVER.holds(velocity, [0.0, pitch_rad]));
    }
}
