//! A selection among the six sensors of the inertial unit.

/// Some of the gyros and accelerometers, about the body axes forward, right, down: those at full scale, or stuck ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ImuAxes {
    /// Gyros.
    pub gyro: [bool; 3],
    /// Accelerometers.
    pub accel: [bool; 3],
}

impl ImuAxes {
    /// No sensor.
    pub const NONE: Self = Self { gyro: [false; 3], accel: [false; 3] };

    /// Whether any sensor is selected.
    #[must_use]
    pub const fn any(&self) -> bool {
        any(self.gyro) | any(self.accel)
    }
}

/// Whether any element is true; without branches.
pub(super) const fn any([x, y, z]: [bool; 3]) -> bool {
    x | y | z
}
