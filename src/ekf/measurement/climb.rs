//! Climb: near the ground a vehicle neither climbs nor sinks for long.

use super::update::ScalarMeasurement;
use crate::ekf::filter::Ekf;
use crate::ekf::kernel::covariance::Sensitivity;
use crate::ekf::kernel::layout::{Layout, VELOCITY};
use crate::ekf::kernel::trace::Trace;
use crate::ekf::outcome::innovation::Channel;
use crate::matrix::square;
use crate::scalar::Scalar;
use crate::time::Time;

/// One-sigma of the vertical velocity of a vehicle without a measured height, m/s.
const CLIMB_MPS: f64 = 5.0;

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Bounds the vertical velocity of a filter without height measurements. Once its one-sigma exceeds 5 m/s, a
    /// measurement of 0 ± 5 m/s is fused. Otherwise the vertical channel would diverge with the accelerometers' bias.
    ///
    /// # Source
    /// Equation (M19) of docs/equations.md.
    #[inline(never)]
    pub(super) fn bound_climb(&mut self, time: Time, trace: &mut impl Trace<T, N>) {
        let state = VELOCITY + 2;
        if self.covariance.variance(state) < square(CLIMB_MPS) {
            return;
        }
        let climb = ScalarMeasurement::new(
            Channel::RestVelocityDown,
            -self.state.velocity_mps.z(),
            T::of(square(CLIMB_MPS)),
            Sensitivity::default().with(state, T::ONE),
        );
        self.update_one(time, Some(climb), trace);
    }
}
