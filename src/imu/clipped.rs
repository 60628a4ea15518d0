//! Full-scale flags reported by the inertial unit.

/// Sensors that were at full scale during a sample, about the body axes forward, right, down. Motion beyond full scale
/// is lost. An IMU that sums many readings flags a sample if one of them was at full scale.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClippedAxes {
    /// Gyros.
    pub gyro: [bool; 3],
    /// Accelerometers.
    pub accel: [bool; 3],
}

impl ClippedAxes {
    /// No sensor clipped.
    pub const NONE: Self = Self { gyro: [false; 3], accel: [false; 3] };

    /// Whether any sensor was at full scale.
    #[must_use]
    pub fn any(&self) -> bool {
        self.gyro.iter().chain(&self.accel).any(|&clipped| clipped)
    }
}
