//! Positions of the sensors in the vehicle.

use super::LeverArm;
use crate::frames::{Body, Vector};

/// Positions of the inertial unit and the antenna, relative to the point of the solution. This point is the centre of
/// gravity, or the inertial unit itself.
///
/// ```
/// use hovernav::frames::Vector;
/// use hovernav::ins::Mounting;
///
/// let mounting = Mounting::default()
///     .with_imu_lever_arm_m(Vector::new(0.03, -0.02, 0.28))
///     .with_antenna_lever_arm_m(Vector::new(-0.35, 0.0, 0.2));
/// assert_eq!(mounting.antenna_from_imu().0.x(), -0.38);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mounting {
    /// Position of the inertial unit relative to the point of the solution, body axes, m.
    pub imu_lever_arm_m: Vector<Body>,
    /// Position of the GPS antenna relative to the point of the solution, body axes, m.
    pub antenna_lever_arm_m: Vector<Body>,
}

impl Mounting {
    /// This mounting with the inertial unit at `lever_arm_m` from the point of the solution, body axes, m.
    #[must_use]
    pub const fn with_imu_lever_arm_m(mut self, lever_arm_m: Vector<Body>) -> Self {
        self.imu_lever_arm_m = lever_arm_m;
        self
    }

    /// This mounting with the GPS antenna at `lever_arm_m` from the point of the solution, body axes, m.
    #[must_use]
    pub const fn with_antenna_lever_arm_m(mut self, lever_arm_m: Vector<Body>) -> Self {
        self.antenna_lever_arm_m = lever_arm_m;
        self
    }

    /// Lever arm from the inertial unit to the point of the solution.
    #[must_use]
    pub fn solution_from_imu(&self) -> LeverArm {
        LeverArm(-self.imu_lever_arm_m)
    }

    /// Lever arm from the inertial unit to the antenna.
    #[must_use]
    pub fn antenna_from_imu(&self) -> LeverArm {
        LeverArm(self.antenna_lever_arm_m - self.imu_lever_arm_m)
    }

    /// Lever arm from the antenna to the inertial unit.
    #[must_use]
    pub fn imu_from_antenna(&self) -> LeverArm {
        LeverArm(self.imu_lever_arm_m - self.antenna_lever_arm_m)
    }
}
