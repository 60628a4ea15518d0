//! Search for an axis of the inertial unit that is always zero, because it is not connected or not filled in.

use super::SetupFault;
use crate::imu::MeanRates;

/// Number of averages of zero for a fault.
const MIN_PARTS: u8 = 40;
/// Smallest rate with which a zero counts, rad/s: a coarse sensor at rest may read zeros.
const LEAST_RADPS: f32 = 0.02;

/// The axis that was zero in the last averages in motion: gyros x, y, z, then accelerometers x, y, z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DeadAxis {
    axis: u8,
    parts: u8,
}

impl DeadAxis {
    pub const NONE: Self = Self { axis: 0, parts: 0 };

    /// Adds the averages of an interval. Returns the fault once.
    pub fn push(&mut self, mean: &MeanRates<f32>) -> Option<SetupFault> {
        if mean.angular_rate_radps.norm() < LEAST_RADPS {
            return None;
        }
        let triads = [mean.angular_rate_radps, mean.specific_force_mps2].map(|of| of.to_array());
        let is_zero = |(_, value): &(u8, &f32)| **value == 0.0;
        let mut zeros = (0..6_u8).zip(triads.as_flattened()).filter(is_zero);
        let (axis, parts) = match (zeros.next(), zeros.next()) {
            (Some((axis, _)), None) if axis == self.axis => (axis, self.parts.saturating_add(1)),
            (Some((axis, _)), None) => (axis, 1),
            // A simulation in a plane has several zeros.
            _ => (0, 0),
        };
        *self = Self { axis, parts };
        (parts == MIN_PARTS).then_some(SetupFault::DeadAxis { is_gyro: axis < 3, axis: axis % 3 })
    }
}
