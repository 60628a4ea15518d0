//! A filter whose heading is unknown: the heading search has its attitude and horizontal velocity, the filter keeps
//! position, height and the errors of its sensors.

use super::antenna::AntennaOffset;
use super::excess::Excess;
use super::filter::Ekf;
use super::heading_search::{GuessedBias, GuessedMotion};
use super::layout::{ATTITUDE, BASE, GYRO_BIAS, Layout, POSITION, VELOCITY};
use super::level_force::LevelForce;
use super::measurement::{BiasShift, Report, Unusable};
use super::scalar::Scalar;
use super::square;
use super::trace::Trace;
use crate::frames::{Vector, wrap_angle};
use crate::gps::Fix;
use crate::ins::Start;
use crate::time::Time;

/// What gave the heading within this time, s, still gives it.
const HEADING_GIVEN_S: f64 = 10.0;

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Takes in a fix while the heading is unknown: position and height learn from it, the errors of the sensors do not.
    ///
    /// # Errors
    /// As [`update_gps`](Self::update_gps).
    #[inline(never)]
    pub(super) fn take_in_place(
        &mut self,
        fix: &Fix,
        report: &mut Report,
        trace: &mut impl Trace<T, N>,
    ) -> Result<(), Unusable> {
        self.catch_up(trace);
        // What disagrees with the position now is the filter's own fault: it follows every velocity.
        self.gates.doubt_filter(fix.time);
        let parameters = self.parameters;
        let variances: [f64; N] = core::array::from_fn(|state| self.covariance.variance(state));
        let [_, level, _] = self.gps_learned;
        let result = self.take_in_gps(fix, report, trace);
        let [_, learned, _] = &mut self.gps_learned;
        *learned = level;
        let learns = |state: usize| {
            let of = |first: usize| (first..first + 3).contains(&state);
            L::GPS_POSITION.is_some_and(of)
                || L::GPS_VELOCITY.is_some_and(of)
                || Some(state) == L::BARO
                || Some(state) == L::GROUND
        };
        for state in (GYRO_BIAS..N).filter(|state| !learns(*state)) {
            if let (Some(parameter), Some(before), Some(variance)) =
                (self.parameters.get_mut(state), parameters.get(state), variances.get(state))
            {
                *parameter = *before;
                self.covariance.set_variance(state, *variance);
            }
        }
        self.gates.forget_walk();
        self.excess = Excess::NONE;
        self.bias_shift = BiasShift::UNKNOWN;
        self.level_force = LevelForce::NONE;
        self.antenna = AntennaOffset::UNSEEN;
        result
    }

    /// Takes attitude and horizontal velocity from the heading search.
    ///
    /// # Source
    /// Equation (H6) of docs/equations.md.
    #[inline(never)]
    pub(super) fn follow(&mut self, motion: &GuessedMotion<T>, trace: &mut impl Trace<T, N>) {
        self.catch_up(trace);
        let turned = (motion.body_to_ned * self.state.body_to_ned.inverse()).rotation_vector();
        self.state.body_to_ned = motion.body_to_ned;
        self.open(ATTITUDE, motion.attitude_sigma_rad);
        // The search follows the slow errors of the fixes.
        let slow = |axis: usize| match L::GPS_VELOCITY {
            Some(first) => (self.estimate(first + axis), self.covariance.variance(first + axis)),
            None => (T::ZERO, 0.0),
        };
        let slow = [slow(0), slow(1)];
        let [north, east] = motion.velocity_mps.map(T::of);
        let [(slow_north, _), (slow_east, _)] = slow;
        self.state.velocity_mps =
            Vector::new(north - slow_north, east - slow_east, self.state.velocity_mps.z());
        let sigmas = motion.velocity_sigma_mps.into_iter().zip(slow);
        for (state, (sigma_mps, (_, slow))) in (VELOCITY..).zip(sigmas) {
            self.covariance.rescale(state, square(sigma_mps) + slow);
        }
        trace.reset(0..N);
        trace.turned(turned.cast());
    }

    /// Adds a gyro bias that the heading search has found.
    pub(super) fn add_gyro_bias(&mut self, found: &GuessedBias<T>) {
        let biases = found.bias_radps.to_array().into_iter().zip(found.sigma_radps);
        for (state, (bias, sigma_radps)) in (GYRO_BIAS..).zip(biases) {
            if let Some(parameter) = self.parameters.get_mut(state) {
                *parameter += bias;
            }
            let own = self.covariance.variance(state);
            self.covariance.set_variance(state, own.min(square(sigma_radps)));
        }
    }

    /// Goes on with a heading that the search has found, of at least `least_rad` one-sigma.
    pub(super) fn accept_heading(
        &mut self,
        motion: &GuessedMotion<T>,
        least_rad: f64,
        trace: &mut impl Trace<T, N>,
    ) {
        let before_rad = self.state.body_to_ned.heading_rad();
        self.follow(motion, trace);
        let turned_rad = wrap_angle((self.state.body_to_ned.heading_rad() - before_rad).wide());
        self.open_heading(least_rad);
        self.heading_revision.replaced(turned_rad);
        self.attitude_lost = None;
    }

    /// Goes on, as the same filter, from a second alignment: the motion goes over, the errors of the sensors stay.
    #[inline(never)]
    pub(super) fn realign(&mut self, start: &Start, trace: &mut impl Trace<T, N>) {
        self.catch_up(trace);
        let kept: [f64; N] = core::array::from_fn(|state| self.covariance.variance(state));
        let turned = start.state.body_to_ned.cast() * self.state.body_to_ned.inverse();
        self.covariance.clear();
        self.state = start.state.cast();
        self.set_block(GYRO_BIAS, start.gyro_bias_radps.cast().to_array());
        self.open(ATTITUDE, start.attitude_sigma_rad.to_array());
        self.open(VELOCITY, start.velocity_sigma_mps.to_array());
        self.open(POSITION, start.position_sigma_m.to_array());
        for (state, variance) in kept.into_iter().enumerate().skip(GYRO_BIAS) {
            self.covariance.set_variance(state, variance);
        }
        if let Some(sigma_radps) = start.gyro_bias_sigma_radps {
            self.open(GYRO_BIAS, [sigma_radps; 3]);
        }
        let sigma_mps2 = self.config.imu.accel_bias_sigma_mps2;
        self.open(super::layout::ACCEL_BIAS, [sigma_mps2; 3]);
        self.set_block(super::layout::ACCEL_BIAS, [T::ZERO; 3]);
        self.history.clear();
        self.level_force = LevelForce::NONE;
        self.attitude_lost = None;
        trace.reset(0..N);
        trace.turned(turned.rotation_vector().cast());
    }

    /// Whether something else than motion gave the heading not long before `time`.
    pub(super) fn had_heading(&self, time: Time) -> bool {
        let lately = |used: Time| time - used < HEADING_GIVEN_S;
        let by_attitude =
            self.heading_distrusted.is_none() && self.attitude_used.is_some_and(lately);
        by_attitude || lately(self.antenna_heading.used)
    }
}

const _: () = assert!(BASE > GYRO_BIAS);
