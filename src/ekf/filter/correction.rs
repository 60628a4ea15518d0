//! Changes of the estimate outside the propagation: corrections, and resets of the covariance.

use super::{Ekf, MAX_HIDDEN_RAD};
use crate::earth::LocalEarth;
use crate::ekf::kernel::covariance::{Relaxation, Transition};
use crate::ekf::kernel::layout::{ACCEL_BIAS, ATTITUDE, GYRO_BIAS, Layout, POSITION, VELOCITY};
use crate::ekf::kernel::trace::Trace;
use crate::ekf::watch::excess::Stepped;
use crate::ekf::watch::ground::Ground;
use crate::frames::{Ned, Vector};
use crate::ins::NavState;
use crate::matrix::square;
use crate::scalar::Scalar;
use crate::time::Time;

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Adds a correction of the whole error state to the estimates. Returns `true` if it reset the covariance instead.
    ///
    /// The reset replaces a correction that gives an invalid state or covariance. Only long gaps cause this: they raise
    /// the covariance beyond the range of the floating-point type.
    ///
    /// # Source
    /// Equation (K1) of docs/equations.md.
    pub(in crate::ekf) fn correct(&mut self, correction: &[T; N]) -> bool {
        let at = |state: usize| correction.get(state).copied().unwrap_or(T::ZERO);
        let block = |first: usize| Vector::<Ned, T>::new(at(first), at(first + 1), at(first + 2));
        let corrected = NavState {
            time: self.state.time,
            position: self.state.position.displaced(block(POSITION)),
            velocity_mps: self.state.velocity_mps + block(VELOCITY),
            body_to_ned: self.state.body_to_ned.turned_in_to(block(ATTITUDE)).renormalised(),
        };
        if !corrected.is_valid() || !self.covariance.is_valid() {
            self.reset_covariance();
            return true;
        }
        self.state = corrected;
        let (_, parameters) = self.parameters.split_at_mut(GYRO_BIAS);
        let (_, corrections) = correction.split_at(GYRO_BIAS);
        for (parameter, &value) in parameters.iter_mut().zip(corrections) {
            *parameter += value;
        }
        if let Some(first) = L::ATTITUDE_REFERENCE {
            let turned = block(ATTITUDE) + block(first);
            self.memory.attitude_watch.corrected(turned.cast().to_array());
            let reference_error = self.estimate(first + 2);
            self.memory.heading_revision.corrected(
                self.state.time,
                at(ATTITUDE + 2),
                reference_error,
            );
        }
        false
    }

    /// Resets attitude, velocity and position to variances so large that the next fixes determine them, and clears the
    /// history. The estimates stay. Sensor errors return to their initial variance; the variance of the barometer's
    /// level stays.
    pub(in crate::ekf) fn reset_covariance(&mut self) {
        self.memory.attitude_lost = Some(self.state.time);
        self.history.clear();
        let baro = L::BARO.map(|state| (state, self.covariance.variance(state)));
        self.covariance.clear();
        self.memory.unpropagated = None;
        self.set_sigmas(ATTITUDE, [MAX_HIDDEN_RAD; 3]);
        self.set_sigmas(VELOCITY, [RESET_VELOCITY_MPS; 3]);
        self.set_sigmas(POSITION, [RESET_POSITION_M; 3]);
        self.set_sigmas(GYRO_BIAS, [self.config.imu.gyro_bias_sigma_radps; 3]);
        self.set_sigmas(ACCEL_BIAS, [self.config.imu.accel_bias_sigma_mps2; 3]);
        self.set_block_sigmas();
        if let Some((state, variance)) = baro {
            self.covariance.set_variance(state, variance);
        }
        self.memory.gps_wander = None;
        self.memory.ground = Ground::UNKNOWN;
    }

    /// Raises the one-sigma of the heading to at least `sigma_rad`.
    pub(in crate::ekf) fn raise_heading_sigma(&mut self, sigma_rad: f64) {
        self.covariance.raise_sigma(ATTITUDE + 2, sigma_rad);
    }

    /// Turns the heading by `turn_rad`, sets its one-sigma to `sigma_rad`, and resets the variances of roll, pitch and
    /// velocity. The filter rejects each heading source until that source agrees again for some time.
    pub(in crate::ekf) fn turn_heading(&mut self, time: Time, turn_rad: f64, sigma_rad: f64) {
        let turn = Vector::new(T::ZERO, T::ZERO, T::of(turn_rad));
        self.state.body_to_ned = self.state.body_to_ned.turned_in_to(turn).renormalised();
        self.set_sigmas(ATTITUDE, [TURNED_TILT_RAD, TURNED_TILT_RAD, sigma_rad]);
        self.set_sigmas(VELOCITY, [TURNED_VELOCITY_MPS; 3]);
        self.memory.heading.disagreed_at = Some(time);
        self.memory.heading_revision.replaced(turn_rad);
        self.memory.attitude_watch.corrected([0.0, 0.0, turn_rad as f32]);
        self.memory.attitude_lost = None;
        self.memory.antenna_heading.disagreed_at = Some(time);
        self.memory.gates.suspected = time;
        self.memory.gates.heading_replaced = time;
        let [wander_rad, _] = self.memory.heading_wander;
        self.forget_heading_error(wander_rad);
    }

    /// Sets the estimate of the heading source's slow error to zero, with a one-sigma of `sigma_rad`.
    pub(in crate::ekf) fn forget_heading_error(&mut self, sigma_rad: f64) {
        if let Some(first) = L::ATTITUDE_REFERENCE {
            self.reset_parameter(first + 2, square(sigma_rad));
        }
    }

    /// Sets the estimate of a parameter to zero with the variance `variance`, and clears its correlations.
    pub(in crate::ekf) fn reset_parameter(&mut self, state: usize, variance: f64) {
        self.covariance.set_variance(state, variance);
        if let Some(parameter) = self.parameters.get_mut(state) {
            *parameter = T::ZERO;
        }
    }

    /// Whether to reset the filter to a measured attitude or heading. True for the first measurement within
    /// [`ATTITUDE_RESET_S`] after a gap, if its source is not suspect.
    pub(in crate::ekf) fn shall_reset_attitude(&mut self, time: Time) -> bool {
        let lost = self.memory.attitude_lost.take();
        self.memory.heading.disagreed_at.is_none()
            && lost.is_some_and(|lost| time - lost < ATTITUDE_RESET_S)
    }

    /// Turns the attitude to the measured one and raises the variances of the measured axes, from state `first` on. The
    /// update that follows then reduces them to the measurement's own uncertainty. After a turn of unknown size, a
    /// plain Kalman update would linearise about the wrong attitude.
    ///
    /// # Source
    /// Equation (K20) of docs/equations.md.
    pub(in crate::ekf) fn reset_attitude(
        &mut self,
        turn_rad: Vector<Ned, T>,
        first: usize,
        trace: &mut impl Trace<T, N>,
    ) {
        self.state.body_to_ned = self.state.body_to_ned.turned_in_to(turn_rad).renormalised();
        for axis in first..VELOCITY {
            self.covariance.set_variance(axis, square(MAX_HIDDEN_RAD));
        }
        self.memory.attitude_watch.corrected(turn_rad.cast().to_array());
        trace.reset(first..VELOCITY);
        trace.turned(turn_rad.cast());
    }

    /// Raises the variance of the biases that may have changed in a step; `stepped` holds the evidence. A step found
    /// from accepted innovations is small. If it is horizontal, the tilt variance grows too. A step found from rejected
    /// innovations is large and lies in the past. Attitude and velocity then receive the error accumulated since the
    /// step, with its correlation to the biases.
    ///
    /// # Source
    /// Equation (K19) of docs/equations.md.
    #[inline(never)]
    pub(in crate::ekf) fn raise_bias_sigmas(
        &mut self,
        stepped: Stepped,
        trace: &mut impl Trace<T, N>,
    ) {
        let imu = &self.config.imu;
        // Factors on the usual one-sigmas of the biases. A horizontal step within the gate may come from a gyro or an
        // accelerometer.
        let (gyro, accel) = match stepped {
            Stepped { far: true, .. } => (STEPPED_FAR_GYRO, STEPPED_ACCEL),
            Stepped { level: true, .. } => (1.0, 1.0),
            _ => (0.0, STEPPED_ACCEL),
        };
        let gyro = gyro * imu.gyro_bias_sigma_radps;
        let accel = accel * imu.accel_bias_sigma_mps2;
        let rows = self.state.body_to_ned.rows();
        let [.., downwards] = rows.map(|row| row.map(Scalar::wide));
        let down_mps2 = stepped.down_far.map_or(0.0, |growth| growth.rate_mps2);
        let gyro = square(gyro);
        let [x, y, z] = downwards.map(|share| square(accel).max(square(down_mps2 * share)));
        let relaxation = Relaxation::opening(GYRO_BIAS, [gyro, gyro, gyro, x, y, z]);
        let since_s = match stepped.down_far {
            _ if stepped.far => STEPPED_S,
            growth => growth.map_or(0.0, |growth| growth.left_s),
        };
        let small = stepped.level && since_s == 0.0;
        let tilt = if small { T::of(square(STEPPED_TILT_RAD)) } else { T::ZERO };
        let weight_mps2 = -LocalEarth::<T>::about(&self.state.position).gravity_mps2;
        let mut step = Transition::of_relaxation(relaxation);
        step.attitude_noise = [tilt, T::ZERO, T::ZERO, tilt, T::ZERO, T::ZERO];
        // For each propagation: factor of the tilt's effect on velocity, and factor of the biases' effect on attitude
        // and velocity. The last entry states whether the variances of the biases grow.
        let back_and_forth =
            [(-1.0, 0.0, false), (0.0, -1.0, true), (0.0, 1.0, false), (1.0, 0.0, false)];
        let here = [(0.0, 0.0, true)];
        for &(fallen, turned, opened) in if since_s > 0.0 { &back_and_forth[..] } else { &here } {
            step.force = [T::ZERO, T::ZERO, weight_mps2 * T::of(0.5 * since_s * fallen)];
            step.turn = rows.map(|row| row.map(|cosine| cosine * T::of(since_s * turned)));
            step.relaxation = opened.then_some(relaxation);
            self.propagate(&step, trace);
        }
    }

    /// Adds `variance` to the variance of a parameter.
    #[inline(never)]
    pub(in crate::ekf) fn add_parameter_variance(
        &mut self,
        state: usize,
        variance: f64,
        trace: &mut impl Trace<T, N>,
    ) {
        // One entry changes: a pass over the covariance would cost 2 000 instructions.
        self.covariance.add_variance(state, variance);
        trace.propagated(&Transition::of_relaxation(Relaxation::opening(state, [variance])));
    }

    /// Raises the variance of the gyro biases to at least `variance`, (rad/s)².
    #[inline(never)]
    pub(in crate::ekf) fn raise_gyro_bias_variance(
        &mut self,
        variance: f64,
        trace: &mut impl Trace<T, N>,
    ) {
        self.catch_up(trace);
        let missing = |axis| (variance - self.covariance.variance(GYRO_BIAS + axis)).max(0.0);
        self.apply(Relaxation::opening(GYRO_BIAS, [0, 1, 2].map(missing)), trace);
    }

    /// Adds `off_rad`² to the variances of the heading and of the heading source's slow error, if that is a state.
    /// Raises the additional one-sigma of the source to at least |`off_rad`|. Later fixes show whether filter or source
    /// is wrong.
    pub(in crate::ekf) fn suspect_heading(&mut self, off_rad: f64, trace: &mut impl Trace<T, N>) {
        self.memory.extra_heading_sigma_rad =
            self.memory.extra_heading_sigma_rad.max(libm::fabs(off_rad) as f32);
        let opened = square(off_rad);
        let relaxation = match L::ATTITUDE_REFERENCE {
            Some(first) => Relaxation::opening(first + 2, [opened]),
            None => Relaxation::default(),
        };
        let opened = T::of(opened);
        let attitude_noise = [T::ZERO, T::ZERO, T::ZERO, T::ZERO, T::ZERO, opened];
        let opening = Transition { attitude_noise, ..Transition::of_relaxation(relaxation) };
        self.propagate(&opening, trace);
    }

    /// One-sigma of the slow error of the heading source, `elapsed_s` after the previous call. Equals `usual_rad` if
    /// the source is not suspect.
    pub(in crate::ekf) fn heading_wander_rad(&mut self, usual_rad: f64, elapsed_s: f64) -> f64 {
        let field_rad = f64::from(self.memory.field_watch.heading_sigma_rad);
        let usual_rad =
            if field_rad == 0.0 { usual_rad } else { Scalar::hypot(usual_rad, field_rad) };
        if self.memory.extra_heading_sigma_rad == 0.0 {
            return usual_rad;
        }
        let left = libm::exp(-elapsed_s.clamp(0.0, SUSPECT_TIME_S) / SUSPECT_TIME_S) as f32;
        let extra_rad = self.memory.extra_heading_sigma_rad * left;
        self.memory.extra_heading_sigma_rad =
            if extra_rad > FORGOTTEN_RAD { extra_rad } else { 0.0 };
        Scalar::hypot(usual_rad, f64::from(extra_rad))
    }
}

/// One-sigma of roll and pitch after the heading was turned, rad.
const TURNED_TILT_RAD: f64 = 0.07;
/// One-sigma of velocity after the heading was turned, m/s.
const TURNED_VELOCITY_MPS: f64 = 2.0;
/// Longest time after a gap, s, within which a measured attitude replaces the filter's own attitude. A later
/// measurement is fused in an ordinary update.
const ATTITUDE_RESET_S: f64 = 5.0;
/// One-sigma added to an accelerometer bias after a vertical or large step, in multiples of the usual one-sigma.
const STEPPED_ACCEL: f64 = 3.0;
/// One-sigma added to a gyro bias after a large step, in multiples of the usual one-sigma.
const STEPPED_FAR_GYRO: f64 = 6.0;
/// One-sigma of the tilt error caused by a small step, rad.
const STEPPED_TILT_RAD: f64 = 0.02;
/// Typical time, s, from a bias step to its detection.
const STEPPED_S: f64 = 3.0;
/// Time constant, s, with which the additional one-sigma of a suspect heading reference decays.
const SUSPECT_TIME_S: f64 = 200.0;
/// Smallest additional one-sigma, rad. A smaller one is set to zero, because its decay would end in denormal numbers.
const FORGOTTEN_RAD: f32 = 1e-6;

/// One-sigma of velocity after a reset, m/s.
const RESET_VELOCITY_MPS: f64 = 50.0;
/// One-sigma of position after a reset, m.
const RESET_POSITION_M: f64 = 1e4;
