//! Filter with unknown heading. The heading search provides attitude and horizontal velocity; the filter keeps
//! position, height and the errors of its sensors.

use super::Ekf;
use crate::ekf::gate::PositionDrift;
use crate::ekf::heading_search::HypothesisMotion;
use crate::ekf::kernel::layout::{ATTITUDE, BASE, GYRO_BIAS, Layout, POSITION, VELOCITY};
use crate::ekf::kernel::trace::Trace;
use crate::ekf::outcome::report::{Report, Unusable};
use crate::ekf::watch::antenna::AntennaOffset;
use crate::ekf::watch::bias_shift::BiasShift;
use crate::ekf::watch::excess::Excess;
use crate::ekf::watch::heading_memory::HeadingMemory;
use crate::ekf::watch::level_force::LevelForce;
use crate::frames::{Vector, wrap_angle};
use crate::gps::Fix;
use crate::ins::{NavState, Start};
use crate::matrix::square;
use crate::scalar::Scalar;
use crate::time::Time;

/// Minimum one-sigma of roll and pitch with a heading just found, rad: the hypotheses share their model errors.
const FOUND_TILT_RAD: f64 = 0.03;
/// Time, s, within which a heading source must have been used to count as available.
const HEADING_GIVEN_S: f64 = 10.0;
/// States of the filter that follow those of a hypothesis, in its order; it has no vertical velocity to follow.
const FOLLOWED: [Option<usize>; 9] = [
    Some(VELOCITY),
    Some(VELOCITY + 1),
    None,
    Some(ATTITUDE),
    Some(ATTITUDE + 1),
    Some(ATTITUDE + 2),
    Some(GYRO_BIAS),
    Some(GYRO_BIAS + 1),
    Some(GYRO_BIAS + 2),
];

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Fuses a fix while the heading is unknown. The fix corrects position, height and the slow errors of position,
    /// barometer and ground. It does not correct the other errors of the sensors.
    ///
    /// # Errors
    /// As [`update_gps`](Self::update_gps).
    #[inline(never)]
    pub(in crate::ekf) fn fuse_position(
        &mut self,
        fix: &Fix,
        report: &mut Report,
        trace: &mut impl Trace<T, N>,
    ) -> Result<(), Unusable> {
        self.catch_up(trace);
        if fix.horizontal_velocity_mps.is_none() {
            // Without a heading and a measured velocity, the filter has no evidence against a position.
            self.memory.gates.velocity_diverged = fix.time;
        }
        let parameters = self.parameters;
        let variances: [f64; N] = core::array::from_fn(|state| self.covariance.variance(state));
        let learned = self.memory.gps_learned;
        let result = self.fuse_gps(fix, report, trace);
        // Two kinds of errors are learned only with a known heading: those of velocities, and those of positions from
        // fixes without velocity.
        let [before, level, down] = learned;
        let [found, ..] = self.memory.gps_learned;
        let has_velocity = fix.horizontal_velocity_mps.is_some();
        self.memory.gps_learned = [if has_velocity { found } else { before }, level, down];
        let learns = |state: usize| {
            let of = |first: usize| (first..first + 3).contains(&state);
            L::GPS_POSITION.is_some_and(of) || Some(state) == L::BARO || Some(state) == L::GROUND
        };
        for state in (GYRO_BIAS..N).filter(|state| !learns(*state)) {
            if let (Some(parameter), Some(before), Some(variance)) =
                (self.parameters.get_mut(state), parameters.get(state), variances.get(state))
            {
                *parameter = *before;
                self.covariance.set_variance(state, *variance);
            }
        }
        self.memory.gates.drift = PositionDrift::NONE;
        self.memory.excess = Excess::NONE;
        self.memory.bias_shift = BiasShift::UNKNOWN;
        self.memory.level_force = LevelForce::NONE;
        self.memory.antenna = AntennaOffset::BEFORE_FIRST_TURN;
        result
    }

    /// Adopts attitude, horizontal velocity and gyro bias from the heading search. Returns `false`, and changes
    /// nothing, if they are impossible for a vehicle.
    ///
    /// # Source
    /// Equation (H6) of docs/equations.md.
    #[inline(never)]
    pub(in crate::ekf) fn follow(
        &mut self,
        motion: &HypothesisMotion<T>,
        trace: &mut impl Trace<T, N>,
    ) -> bool {
        self.catch_up(trace);
        let HypothesisMotion { body_to_ned, velocity_mps, .. } = *motion;
        let turned = (body_to_ned * self.state.body_to_ned.inverse()).rotation_vector();
        // The vertical velocity needs no heading, and the hypotheses have no accelerometer bias.
        let [north, east, _] = velocity_mps.to_array();
        let velocity_mps = Vector::new(north, east, self.state.velocity_mps.z());
        let state = NavState { body_to_ned, velocity_mps, ..self.state };
        if !state.is_valid() {
            return false;
        }
        self.state = state;
        let parameters = self.parameters.iter_mut().skip(GYRO_BIAS);
        for (parameter, bias) in parameters.zip(motion.bias_radps.to_array()) {
            *parameter += bias;
        }
        for state in FOLLOWED.into_iter().flatten() {
            self.covariance.set_variance(state, 0.0);
        }
        for (state, row) in FOLLOWED.into_iter().zip(&motion.covariance) {
            for (other, &value) in FOLLOWED.into_iter().zip(row) {
                if let (Some(state), Some(other)) = (state, other) {
                    self.covariance.set_cross(state, other, f64::from(value));
                }
            }
        }
        self.raise_heading_sigma(motion.heading_sigma_rad);
        // The velocity of the search contains the slow velocity errors of the fixes. The variance of the position is at
        // least that of its slow error.
        let [place, _, slow, _] = self.memory.gps_wander.unwrap_or_default().map(f64::from);
        for axis in 0..2 {
            self.covariance.add_variance(VELOCITY + axis, square(slow));
            if let Some(state) = L::GPS_VELOCITY.map(|first| first + axis) {
                self.reset_parameter(state, square(slow));
                self.covariance.set_cross(VELOCITY + axis, state, -square(slow));
            }
            self.covariance.raise_sigma(POSITION + axis, place);
        }
        trace.reset(0..N);
        trace.turned(turned.cast());
        true
    }

    /// Adopts a heading found by the search, with a one-sigma of at least `min_rad`. Returns `false` if its motion is
    /// impossible for a vehicle.
    pub(in crate::ekf) fn accept_heading(
        &mut self,
        motion: &HypothesisMotion<T>,
        min_rad: f64,
        trace: &mut impl Trace<T, N>,
    ) -> bool {
        let before_rad = self.state.body_to_ned.heading_rad();
        if !self.follow(motion, trace) {
            return false;
        }
        let turned_rad = wrap_angle((self.state.body_to_ned.heading_rad() - before_rad).wide());
        self.raise_heading_sigma(min_rad);
        for axis in [ATTITUDE, ATTITUDE + 1] {
            self.covariance.raise_sigma(axis, FOUND_TILT_RAD);
        }
        self.memory.heading_revision.replaced(turned_rad);
        self.memory.attitude_lost = None;
        true
    }

    /// Continues the same filter from a second alignment: motion and biases are replaced, the other sensor errors stay.
    #[inline(never)]
    pub(in crate::ekf) fn realign(&mut self, start: &Start, trace: &mut impl Trace<T, N>) {
        self.catch_up(trace);
        let kept: [f64; N] = core::array::from_fn(|state| self.covariance.variance(state));
        let turned = start.state.body_to_ned.cast() * self.state.body_to_ned.inverse();
        self.restart_base(start);
        for (state, variance) in kept.into_iter().enumerate().skip(BASE) {
            self.covariance.set_variance(state, variance);
        }
        self.history.clear();
        self.memory.level_force = LevelForce::NONE;
        self.memory.attitude_lost = None;
        trace.reset(0..N);
        trace.turned(turned.rotation_vector().cast());
    }

    /// Whether a source other than motion gave the heading shortly before `time`.
    pub(in crate::ekf) fn had_heading(&self, time: Time) -> bool {
        let lately = |memory: &HeadingMemory| memory.since_used_s(time) < HEADING_GIVEN_S;
        self.memory.heading.disagreed_at.is_none() && lately(&self.memory.heading)
            || lately(&self.memory.antenna_heading)
    }
}
