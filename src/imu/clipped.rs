//! Marks of full scale, by the unit itself.

/// Which sensors of a sample stood at their full scale, about the body axes forward, right, down: what lay
/// beyond it is lost. A unit that sums up many readings marks a sample for one of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClippedAxes {
    /// Gyros.
    pub gyro: [bool; 3],
    /// Accelerometers.
    pub accel: [bool; 3],
}

impl ClippedAxes {
    /// None.
    pub const NONE: Self = Self { gyro: [false; 3], accel: [false; 3] };

    /// Whether any is.
    #[must_use]
    pub fn any(&self) -> bool {
        self.gyro.iter().chain(&self.accel).any(|&clipped| clipped)
    }
}
