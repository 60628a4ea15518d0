//! Sum of the motion since the last propagation of the covariance.

use crate::frames::{Ned, Vector};
use crate::scalar::Scalar;

/// Sums over mechanization steps, so that one propagation of the covariance covers all of them. Couplings between
/// errors within the sum are neglected, as within one step.
#[derive(Clone, Copy, Debug)]
pub(in crate::ekf) struct MotionSum<T> {
    /// Duration, s.
    pub interval_s: T,
    /// Direction cosines of the attitude at the start of the last mechanization step, rows north, east, down.
    pub body_to_ned_rows: [[T; 3]; 3],
    /// Velocity change by specific force, m/s.
    pub force_mps: Vector<Ned, T>,
    /// Variance added by the gyros to the rotation about each of their axes, rad².
    pub angle_variance: [T; 3],
    /// Variance added by the accelerometers to the velocity change along each of their axes, (m/s)².
    pub velocity_variance: [T; 3],
}

impl<T: Scalar> MotionSum<T> {
    /// Adds the sum of earlier mechanization steps.
    pub fn add_before(&mut self, before: &Self) {
        self.interval_s += before.interval_s;
        self.force_mps += before.force_mps;
        self.angle_variance = sum(self.angle_variance, before.angle_variance);
        self.velocity_variance = sum(self.velocity_variance, before.velocity_variance);
    }
}

/// Sum of two triples, axis by axis.
pub(in crate::ekf) fn sum<T: Scalar>([ax, ay, az]: [T; 3], [bx, by, bz]: [T; 3]) -> [T; 3] {
    [ax + bx, ay + by, az + bz]
}
