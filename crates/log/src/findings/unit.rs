//! Names and readings of the inertial unit's axes.

use crate::rates::Rates;

pub(super) const AXES: [&str; 6] =
    ["gyro x", "gyro y", "gyro z", "accelerometer x", "accelerometer y", "accelerometer z"];

/// Reading of one axis, by its index in [`AXES`], rad/s or m/s².
pub(super) fn component(at: &Rates, axis: usize) -> f64 {
    if axis < 3 { at.turn_radps[axis] } else { at.force_mps2[axis - 3] }
}
