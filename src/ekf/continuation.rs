//! One filter that goes on where another is, and what is asked of a filter before it does.

use super::filter::Ekf;
use super::layout::{BASE, Layout};
use super::level_force::LevelForce;
use super::scalar::Scalar;
use crate::frames::{Vector, wrap_angle};
use crate::gps::Fix;
use crate::ins::Start;
use crate::time::Time;

/// What gave the heading within this time, s, gives it.
const HEADING_GIVEN_S: f64 = 10.0;

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Starts anew, in place, at the state of a filter of another layout: base states and their
    /// covariance go over, blocks open anew.
    pub(super) fn continue_from<M: Layout<K>, const K: usize>(&mut self, other: &Ekf<M, K, T>) {
        self.restart(&Start {
            state: other.state.cast(),
            attitude_sigma_rad: Vector::ZERO,
            velocity_sigma_mps: Vector::ZERO,
            position_sigma_m: Vector::ZERO,
            gyro_bias_radps: Vector::ZERO,
            gyro_bias_sigma_radps: None,
        });
        self.take_base(other);
        self.samples = other.samples;
        self.own.gps_learned = other.own.gps_learned;
        self.gates = other.gates;
    }

    /// Takes over what a filter of another layout has of the base states, into a covariance that was cleared.
    fn take_base<M: Layout<K>, const K: usize>(&mut self, other: &Ekf<M, K, T>) {
        self.state = other.state;
        self.history.copy_from(&other.history);
        self.own.angular_rate_radps = other.own.angular_rate_radps;
        for (to, from) in self.parameters.iter_mut().zip(&other.parameters).take(BASE) {
            *to = *from;
        }
        self.covariance.take_over(&other.covariance, BASE);
        self.gps_wander = None;
        self.wander_unknown = M::GPS_POSITION.is_none();
    }

    /// Goes on, as the same filter, at the state of one of another layout that had the same samples: base states and
    /// their covariance go over, blocks stay what they are but for the slow errors of the fixes.
    // Its frame need not stand beneath a sample.
    #[inline(never)]
    pub(super) fn rejoin<M: Layout<K>, const K: usize>(&mut self, other: &Ekf<M, K, T>) {
        let turned = other.state.body_to_ned.heading_rad() - self.state.body_to_ned.heading_rad();
        self.heading_revision.replaced(wrap_angle(turned).wide());
        self.attitude_watch.corrected([0.0, 0.0, turned.wide() as f32]);
        let kept: [f64; N] = core::array::from_fn(|state| self.covariance.variance(state));
        self.covariance.clear();
        self.take_base(other);
        for (state, variance) in kept.into_iter().enumerate().skip(BASE) {
            self.covariance.set_variance(state, variance);
        }
        for first in [L::GPS_POSITION, L::GPS_VELOCITY].into_iter().flatten() {
            self.set_block(first, [T::ZERO; 3]);
        }
        self.gates.set_gps(&other.gates.gps());
        self.unpropagated = None;
        self.own.level_force = LevelForce::NONE;
        self.attitude_lost = None;
    }

    /// A fix at the time that it holds, by what is known of its delay, for a filter that has no state for it.
    pub(super) fn without_delay(&self, fix: &Fix) -> Fix {
        let estimate = |state: Option<usize>| state.map_or(T::ZERO, |state| self.estimate(state));
        let time = fix.time.offset_by(-estimate(L::GPS_DELAY).max(T::ZERO));
        // The place is of another time than the velocity.
        let moved = self.state.velocity_mps * estimate(L::LATENCY);
        Fix { time, position: fix.position.displaced(moved), ..*fix }
    }

    /// Whether something else than motion gave the heading not long before `time`.
    pub(super) fn had_heading(&self, time: Time) -> bool {
        let lately = |used: Time| time - used < HEADING_GIVEN_S;
        let by_attitude =
            self.heading_distrusted.is_none() && self.attitude_used.is_some_and(lately);
        by_attitude || lately(self.antenna_heading.used)
    }
}
