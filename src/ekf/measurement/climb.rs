//! Climb: what flies near the ground neither climbs nor sinks for long.

use super::super::covariance::Sensitivity;
use super::super::filter::Ekf;
use super::super::gate::Group;
use super::super::innovation::Channel;
use super::super::layout::{Layout, VELOCITY};
use super::super::scalar::Scalar;
use super::super::square;
use super::super::trace::Trace;
use super::{Report, ScalarMeasurement};
use crate::time::Time;

/// One-sigma of the velocity up or down of a vehicle about which nothing else is known, m/s.
const CLIMB_MPS: f64 = 5.0;

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Keeps the vertical velocity of a filter that has long been told no height to what vehicles do: it is taken for
    /// nought ± 5 m/s whenever it is less sure than that. The vertical would else run away with the accelerometers' bias.
    ///
    /// # Source
    /// Equation (M19) of docs/equations.md.
    #[inline(never)]
    pub(super) fn bound_climb(&mut self, time: Time, trace: &mut impl Trace<T, N>) {
        let state = VELOCITY + 2;
        if self.covariance.variance(state) < square(CLIMB_MPS) {
            return;
        }
        let axis = ScalarMeasurement {
            channel: Channel::RestVelocityDown,
            group: Group::RestVelocity,
            innovation: -self.state.velocity_mps.z(),
            noise: T::of(square(CLIMB_MPS)),
            sensitivity: Sensitivity::default().with(state, T::ONE),
        };
        let axes = [Some(axis), None, None, None, None, None];
        self.update_sequentially(time, &axes, &mut Report::default(), trace);
    }
}
