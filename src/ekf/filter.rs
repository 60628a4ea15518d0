//! The filter itself: the state, the step of the inertial unit, the correction.

use core::fmt;
use core::marker::PhantomData;

use super::config::EkfConfig;
use super::covariance::{Covariance, Gain, Sensitivity, Transition};
use super::gate::Lockouts;
use super::history::History;
use super::layout::{ACCEL_BIAS, ATTITUDE, BASE, GYRO_BIAS, Layout, POSITION, VELOCITY};
use super::scalar::Scalar;
use super::solution::Solution;
use crate::earth::Local;
use crate::frames::{Body, Ned, Rotation, Vector};
use crate::imu::{ImuSample, Motion, Vibration};
use crate::ins::{Advance, ImuErrors, Increment, Integrator, LeverArm, NavState, Start};
use crate::time::Time;

/// Why a sample of the inertial unit was not used as it came.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ImuFault {
    /// A component is NaN, infinite or beyond what units measure; the sample is passed over.
    NotFinite,
    /// Not later than the sample before; passed over.
    NotLater,
    /// The interval before it, s, is longer than the configured gap; bridged, or, beyond a minute,
    /// taken for the loss of all but the place.
    Gap(f64),
    /// The step would have led to where NED does not exist, or beyond 10 km/s: not taken, and taken
    /// for the loss of all but the place.
    Astray,
}

impl fmt::Display for ImuFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite => f.write_str("not finite: passed over"),
            Self::NotLater => f.write_str("not later than the sample before: passed over"),
            Self::Gap(length_s) => write!(f, "none for {length_s:.3} s: bridged"),
            Self::Astray => f.write_str("it would lead off the Earth: not followed"),
        }
    }
}

/// Watches a filter at work: what a smoother needs to go back over it.
pub trait Trace<T, const N: usize> {
    /// The covariance was propagated.
    fn propagated(&mut self, step: &Transition<T, N>);
    /// A scalar measurement was taken in.
    fn updated(&mut self, sensitivity: &Sensitivity<T>, gain: &Gain<T, N>, innovation: f64);
}

/// Watches nothing.
impl<T, const N: usize> Trace<T, N> for () {
    #[inline(always)]
    fn propagated(&mut self, _: &Transition<T, N>) {}
    #[inline(always)]
    fn updated(&mut self, _: &Sensitivity<T>, _: &Gain<T, N>, _: f64) {}
}

/// Error-state Kalman filter around the strapdown mechanization, closed loop.
///
/// `L` chooses the error states, `N` is their padded number, `T` the covariance's number type; the
/// aliases [`BaseEkf`](super::BaseEkf) and [`FullEkf`](super::FullEkf) name the usual choices. It
/// allocates nothing, and every call does bounded work.
#[derive(Clone, Debug)]
pub struct Ekf<L, const N: usize, T = f64> {
    pub(super) config: EkfConfig,
    pub(super) state: NavState,
    /// Estimates of the states that are parameters; the first nine are not used.
    pub(super) parameters: [f64; N],
    pub(super) covariance: Covariance<T, N>,
    pub(super) history: History,
    pub(super) lockouts: Lockouts,
    pub(super) attitude_used: Option<Time>,
    pub(super) baro_offset_m: Option<f64>,
    /// Slow part of the latest fix's one-sigma: position h, v (m), velocity h, v (m/s).
    pub(super) gps_wander: Option<[f64; 4]>,
    /// Learned size of the GPS errors against the configured: variances of position and velocity.
    pub(super) gps_learned: [f64; 2],
    integrator: Integrator,
    gyro_vibration: Vibration,
    accel_vibration: Vibration,
    pub(super) angular_rate_radps: Vector<Body>,
    layout: PhantomData<L>,
}

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// A filter that starts where alignment ended.
    #[must_use]
    pub fn new(config: EkfConfig, start: Start) -> Self {
        let mut filter = Self {
            config,
            state: start.state,
            parameters: [0.0; N],
            covariance: Covariance::zero(),
            history: History::default(),
            lockouts: Lockouts::default(),
            attitude_used: None,
            baro_offset_m: None,
            gps_wander: None,
            gps_learned: [1.0; 2],
            integrator: Integrator::default(),
            gyro_vibration: Vibration::default(),
            accel_vibration: Vibration::default(),
            angular_rate_radps: Vector::ZERO,
            layout: PhantomData,
        };
        filter.set_block(GYRO_BIAS, start.gyro_bias_radps.to_array());
        filter.open(ATTITUDE, start.attitude_sigma_rad.to_array());
        filter.open(VELOCITY, start.velocity_sigma_mps.to_array());
        filter.open(POSITION, start.position_sigma_m.to_array());
        let gyro_sigma = start.gyro_bias_sigma_radps.unwrap_or(config.imu.gyro_bias_sigma_radps);
        filter.open(GYRO_BIAS, [gyro_sigma; 3]);
        filter.open(ACCEL_BIAS, [config.imu.accel_bias_sigma_mps2; 3]);
        filter.open_blocks();
        filter
    }

    fn open_blocks(&mut self) {
        let config = self.config;
        if let Some(first) = L::GYRO_SCALE {
            self.open(first, [config.imu.gyro_scale_sigma; 3]);
        }
        if let Some(first) = L::ACCEL_SCALE {
            self.open(first, [config.imu.accel_scale_sigma; 3]);
        }
        if let Some(first) = L::ATTITUDE_REFERENCE {
            let attitude = config.attitude;
            self.open(
                first,
                [attitude.tilt_wander_rad, attitude.tilt_wander_rad, attitude.heading_wander_rad],
            );
        }
        if let Some(state) = L::LATENCY {
            self.covariance.set_variance(state, square(config.gps.position_latency_sigma_s));
        }
        if let Some(state) = L::BARO {
            self.covariance.set_variance(state, square(config.baro.wander_m));
        }
    }

    pub(super) fn open(&mut self, first: usize, sigmas: [f64; 3]) {
        for (axis, sigma) in sigmas.into_iter().enumerate() {
            self.covariance.set_variance(first + axis, square(sigma));
        }
    }

    /// Advances the filter to the next sample of the inertial unit.
    ///
    /// # Errors
    /// [`ImuFault`] says why a sample was passed over, or that it ended a gap; the filter goes on
    /// either way.
    pub fn predict(&mut self, sample: &ImuSample) -> Result<(), ImuFault> {
        self.predict_traced(sample, &mut ())
    }

    /// [`predict`](Self::predict), watched by `trace`.
    ///
    /// # Errors
    /// As [`predict`](Self::predict).
    pub fn predict_traced(
        &mut self,
        sample: &ImuSample,
        trace: &mut impl Trace<T, N>,
    ) -> Result<(), ImuFault> {
        if !sample.motion.is_finite() {
            return Err(ImuFault::NotFinite);
        }
        if sample.time <= self.integrator.time().unwrap_or(self.state.time) {
            return Err(ImuFault::NotLater);
        }
        let errors = self.imu_errors();
        let increment = match self.integrator.push(sample, &errors) {
            Some(increment) => increment,
            None => self.first_increment(sample, &errors),
        };
        let gap_s = increment.interval_s;
        let gap = gap_s > self.config.imu.gap_s;
        if gap_s > LONGEST_BRIDGE_S {
            self.state.time = sample.time;
            self.lose_track();
            return Err(ImuFault::Gap(gap_s));
        }
        self.watch_vibration(sample, increment.interval_s, gap);

        let before = self.state;
        let advance = self.state.advance(sample.time, &increment);
        if !self.state.is_valid() {
            self.state = NavState { time: sample.time, ..before };
            self.lose_track();
            return Err(ImuFault::Astray);
        }
        let ground = advance.frame_rotation_rad * (1.0 / increment.interval_s);
        let rate = match sample.motion {
            Motion::Rates { angular_rate_radps, .. } => errors.rate(angular_rate_radps, 1.0),
            Motion::Increments { .. } => increment.rotation_rad * (1.0 / increment.interval_s),
        };
        self.angular_rate_radps = rate - self.state.body_to_ned.inverse() * ground;

        let step = self.transition(&increment, &advance, before.body_to_ned, gap);
        self.covariance.propagate::<L>(&step);
        for (parameter, decay) in self.parameters.iter_mut().zip(&step.decay).skip(GYRO_BIAS) {
            *parameter *= decay.wide();
        }
        trace.propagated(&step);
        if gap {
            self.history.clear();
        }
        self.history.push(sample.time, &increment, &advance);
        if gap { Err(ImuFault::Gap(gap_s)) } else { Ok(()) }
    }

    /// The first sample has none before it to make an interval with: its own rates hold since the
    /// start.
    fn first_increment(&self, sample: &ImuSample, errors: &ImuErrors) -> Increment {
        let interval_s = sample.time - self.state.time;
        let (rotation_rad, velocity_mps) = match sample.motion {
            Motion::Rates { angular_rate_radps, specific_force_mps2 } => (
                errors.rate(angular_rate_radps, 1.0) * interval_s,
                errors.force(specific_force_mps2, 1.0) * interval_s,
            ),
            Motion::Increments { angle_rad, velocity_mps } => {
                (errors.rate(angle_rad, interval_s), errors.force(velocity_mps, interval_s))
            }
        };
        Increment { interval_s, rotation_rad, velocity_mps }
    }

    /// Where the way here is lost, nothing is known but where it was lost, and what was known of the
    /// sensors: everything opens so wide that the next fixes decide.
    pub(super) fn lose_track(&mut self) {
        self.history.clear();
        self.covariance = Covariance::zero();
        self.open(ATTITUDE, [MOST_HIDDEN_RAD; 3]);
        self.open(VELOCITY, [LOST_VELOCITY_MPS; 3]);
        self.open(POSITION, [LOST_POSITION_M; 3]);
        self.open(GYRO_BIAS, [self.config.imu.gyro_bias_sigma_radps; 3]);
        self.open(ACCEL_BIAS, [self.config.imu.accel_bias_sigma_mps2; 3]);
        self.open_blocks();
        self.gps_wander = None;
    }

    fn watch_vibration(&mut self, sample: &ImuSample, interval_s: f64, gap: bool) {
        if gap {
            self.gyro_vibration.interrupt();
            self.accel_vibration.interrupt();
        }
        let (rate, force) = match sample.motion {
            Motion::Rates { angular_rate_radps, specific_force_mps2 } => {
                (angular_rate_radps, specific_force_mps2)
            }
            Motion::Increments { angle_rad, velocity_mps } => {
                (angle_rad * (1.0 / interval_s), velocity_mps * (1.0 / interval_s))
            }
        };
        self.gyro_vibration.push(rate, interval_s);
        self.accel_vibration.push(force, interval_s);
    }

    fn transition(
        &self,
        increment: &Increment,
        advance: &Advance,
        body_to_ned: Rotation<Body, Ned>,
        gap: bool,
    ) -> Transition<T, N> {
        let interval_s = increment.interval_s;
        let imu = &self.config.imu;
        let c = body_to_ned.matrix().transpose().to_cols_array_2d();
        let scaled =
            |factors: [f64; 3]| c.map(|row| core::array::from_fn(|k| T::of(row[k] * factors[k])));
        let mut decay = [T::ONE; N];
        let mut noise = [T::ZERO; N];
        let mut markov = |first: usize, sigmas: [f64; 3], time_s: f64| {
            let lost = interval_s / time_s;
            for (axis, sigma) in sigmas.into_iter().enumerate() {
                if let (Some(decay), Some(noise)) =
                    (decay.get_mut(first + axis), noise.get_mut(first + axis))
                {
                    // exp(−x) to second order; steps are far shorter than any correlation time.
                    *decay = T::of((1.0 - lost * (1.0 - 0.5 * lost)).max(0.0));
                    *noise = T::of(2.0 * sigma * sigma * lost.min(0.5));
                }
            }
        };
        markov(GYRO_BIAS, [imu.gyro_bias_sigma_radps; 3], imu.gyro_bias_time_s);
        markov(ACCEL_BIAS, [imu.accel_bias_sigma_mps2; 3], imu.accel_bias_time_s);
        let [position_h, position_v, velocity_h, velocity_v] = self.gps_wander.unwrap_or_default();
        if let Some(first) = L::GPS_POSITION {
            let sigmas = [position_h, position_h, position_v];
            markov(first, sigmas, self.config.gps.position_wander_time_s);
        }
        if let Some(first) = L::GPS_VELOCITY {
            let sigmas = [velocity_h, velocity_h, velocity_v];
            markov(first, sigmas, self.config.gps.velocity_wander_time_s);
        }
        if let Some(first) = L::ATTITUDE_REFERENCE {
            let attitude = &self.config.attitude;
            let (tilt, heading) = (attitude.tilt_wander_rad, attitude.heading_wander_rad);
            markov(first, [tilt, tilt, heading], attitude.wander_time_s);
        }
        if let Some(state) = L::BARO {
            let (wander, time_s) = (self.config.baro.wander_m, self.config.baro.wander_time_s);
            markov(state, [wander, 0.0, 0.0], time_s);
        }
        let hidden_velocity = if gap { imu.gap_acceleration_mps2 * interval_s } else { 0.0 };
        let hidden_angle =
            if gap { (imu.gap_rate_radps * interval_s).min(MOST_HIDDEN_RAD) } else { 0.0 };
        for state in noise.iter_mut().skip(POSITION).take(3) {
            *state = T::of(square(0.5 * hidden_velocity * interval_s));
        }
        let sensed = |walk: f64, share: f64, alike_s: f64, vibration: [f64; 3], hidden: f64| {
            let alike_s = alike_s.max(interval_s);
            vibration.map(|variance| {
                square(walk).max(square(share) * variance * alike_s) * interval_s + square(hidden)
            })
        };
        let gyro = sensed(
            imu.angle_random_walk_rad,
            imu.gyro_vibration_share,
            interval_s,
            self.gyro_vibration.variance(),
            hidden_angle,
        );
        let accel = sensed(
            imu.velocity_random_walk_mps,
            imu.accel_vibration_share,
            imu.accel_vibration_time_s,
            self.accel_vibration.variance(),
            hidden_velocity,
        );
        Transition {
            interval_s: T::of(interval_s),
            turn: scaled([interval_s; 3]),
            force: advance.from_specific_force_mps.to_array().map(T::of),
            scaled_rotation: scaled(increment.rotation_rad.to_array()),
            scaled_velocity: scaled(increment.velocity_mps.to_array()),
            decay,
            attitude_noise: turned(&c, gyro),
            velocity_noise: turned(&c, accel),
            noise,
        }
    }

    /// Adds a correction of the whole error state to the estimates. One that leads astray, or has left
    /// no valid covariance, can only come of gaps that have opened the filter beyond what rounding
    /// bears: then all but the place is lost.
    pub(super) fn correct(&mut self, correction: &[T; N]) {
        let at = |state: usize| correction.get(state).map_or(0.0, |value| value.wide());
        let block = |first: usize| Vector::<Ned>::new(at(first), at(first + 1), at(first + 2));
        let corrected = NavState {
            time: self.state.time,
            position: self.state.position.displaced(block(POSITION)),
            velocity_mps: self.state.velocity_mps + block(VELOCITY),
            body_to_ned: self.state.body_to_ned.turned_in_to(block(ATTITUDE)).renormalised(),
        };
        if !corrected.is_valid() || !self.covariance.is_valid() {
            self.lose_track();
            return;
        }
        self.state = corrected;
        for (parameter, value) in self.parameters.iter_mut().zip(correction).skip(GYRO_BIAS) {
            *parameter += value.wide();
        }
    }

    /// What is known of the inertial unit's own errors.
    #[must_use]
    pub fn imu_errors(&self) -> ImuErrors {
        ImuErrors {
            gyro_bias_radps: self.block(GYRO_BIAS).into(),
            accel_bias_mps2: self.block(ACCEL_BIAS).into(),
            gyro_scale: L::GYRO_SCALE.map_or([0.0; 3], |first| self.block(first)),
            accel_scale: L::ACCEL_SCALE.map_or([0.0; 3], |first| self.block(first)),
        }
    }

    /// The estimates of three consecutive parameters.
    pub(super) fn block(&self, first: usize) -> [f64; 3] {
        core::array::from_fn(|axis| self.parameters.get(first + axis).copied().unwrap_or(0.0))
    }

    fn set_block(&mut self, first: usize, values: [f64; 3]) {
        for (axis, value) in values.into_iter().enumerate() {
            if let Some(parameter) = self.parameters.get_mut(first + axis) {
                *parameter = value;
            }
        }
    }

    /// The estimate of one parameter: a bias, a scale factor, a latency. Zero for a state that is
    /// none or is not there.
    #[must_use]
    pub fn parameter(&self, state: usize) -> f64 {
        self.parameters.get(state).copied().unwrap_or(0.0)
    }

    /// The state of the inertial unit.
    #[must_use]
    pub const fn state(&self) -> &NavState {
        &self.state
    }

    /// The covariance of the error state.
    #[must_use]
    pub const fn covariance(&self) -> &Covariance<T, N> {
        &self.covariance
    }

    /// The settings.
    #[must_use]
    pub const fn config(&self) -> &EkfConfig {
        &self.config
    }

    /// The start of a filter of another layout at this one's state: base states and their
    /// covariance go over, blocks open anew.
    #[must_use]
    pub fn grown<M: Layout<K>, const K: usize, U: Scalar>(&self) -> Ekf<M, K, U> {
        let start = Start {
            state: self.state,
            attitude_sigma_rad: Vector::ZERO,
            velocity_sigma_mps: Vector::ZERO,
            position_sigma_m: Vector::ZERO,
            gyro_bias_radps: Vector::ZERO,
            gyro_bias_sigma_radps: None,
        };
        let mut grown = Ekf::<M, K, U>::new(self.config, start);
        grown.history = self.history;
        grown.integrator = self.integrator;
        grown.gyro_vibration = self.gyro_vibration;
        grown.accel_vibration = self.accel_vibration;
        grown.angular_rate_radps = self.angular_rate_radps;
        for (to, from) in grown.parameters.iter_mut().zip(&self.parameters).take(BASE) {
            *to = *from;
        }
        grown.covariance.take_over(&self.covariance, BASE);
        grown.gps_learned = self.gps_learned;
        grown
    }

    /// Position, velocity, attitude and their one-sigma now, at the point of the solution.
    #[must_use]
    pub fn solution(&self) -> Solution {
        let lever_arm = LeverArm(-self.config.imu_lever_arm_m);
        let state = &self.state;
        let errors = self.imu_errors();
        Solution {
            time: state.time,
            position: lever_arm.position(&state.position, state.body_to_ned),
            velocity_mps: lever_arm.velocity(
                state.velocity_mps,
                state.body_to_ned,
                self.angular_rate_radps,
            ),
            body_to_ned: state.body_to_ned,
            angular_rate_radps: self.angular_rate_radps,
            position_sigma_m: self.point_sigma(POSITION, lever_arm.0),
            velocity_sigma_mps: self
                .point_sigma(VELOCITY, self.angular_rate_radps.cross(lever_arm.0)),
            attitude_sigma_rad: self.euler_sigma(),
            gyro_bias_radps: errors.gyro_bias_radps,
            accel_bias_mps2: errors.accel_bias_mps2,
            gyro_bias_sigma_radps: self.sigma_block(GYRO_BIAS).into(),
            accel_bias_sigma_mps2: self.sigma_block(ACCEL_BIAS).into(),
        }
    }

    fn sigma_block(&self, first: usize) -> [f64; 3] {
        core::array::from_fn(|axis| libm::sqrt(self.covariance.variance(first + axis).max(0.0)))
    }

    /// Opens the heading to at least `sigma_rad`.
    pub(super) fn open_heading(&mut self, sigma_rad: f64) {
        let missing = square(sigma_rad) - self.covariance.variance(ATTITUDE + 2);
        self.covariance.add_variance(ATTITUDE + 2, missing.max(0.0));
    }

    /// One-sigma of a position or velocity moved by a body vector that turns with the attitude.
    fn point_sigma(&self, first: usize, moved_by: Vector<Body>) -> Vector<Ned> {
        let arm = (self.state.body_to_ned * moved_by).to_array();
        let p = &self.covariance;
        let sigma = |axis: usize| {
            // δ(point) = δ(unit) − [arm ×] ψ.
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            let terms =
                [(first + axis, 1.0), (ATTITUDE + next, arm[last]), (ATTITUDE + last, -arm[next])];
            let mut variance = 0.0;
            for (i, a) in terms {
                for (j, b) in terms {
                    variance += a * b * p.entry(i, j);
                }
            }
            libm::sqrt(variance.max(0.0))
        };
        Vector::new(sigma(0), sigma(1), sigma(2))
    }

    /// One-sigma of roll, pitch and yaw, rad, from the attitude error in NED.
    fn euler_sigma(&self) -> [f64; 3] {
        // Sines and cosines stand in the direction of the nose.
        let nose = self.state.body_to_ned.matrix().x_axis;
        let level = libm::sqrt(nose.x * nose.x + nose.y * nose.y);
        // Upright, yaw is any; the limit bounds what one over its cosine does to roll and yaw.
        let (sin_yaw, cos_yaw) =
            if level > 1e-6 { (nose.y / level, nose.x / level) } else { (0.0, 1.0) };
        let cos_pitch = level.max(0.02);
        let tan_pitch = -nose.z / cos_pitch;
        let rows = [
            [cos_yaw / cos_pitch, sin_yaw / cos_pitch, 0.0],
            [-sin_yaw, cos_yaw, 0.0],
            [cos_yaw * tan_pitch, sin_yaw * tan_pitch, 1.0],
        ];
        let p = self.covariance.block(ATTITUDE, ATTITUDE);
        rows.map(|row| {
            let mut variance = 0.0;
            for (a, line) in row.iter().zip(&p) {
                for (b, value) in row.iter().zip(line) {
                    variance += a * b * value;
                }
            }
            libm::sqrt(variance.max(0.0)).min(core::f64::consts::PI)
        })
    }

    /// Whether state and covariance are finite and in range. It stays so for any input that the
    /// filter accepts; a flight computer checks it all the same.
    #[must_use]
    pub fn is_healthy(&self) -> bool {
        self.state.is_valid() && self.covariance.is_valid()
    }

    /// Gravity at the present place, m/s², for whoever wants to level by it.
    #[must_use]
    pub fn gravity_mps2(&self) -> f64 {
        Local::at(&self.state.position).gravity_mps2
    }
}

/// No gap opens the attitude further than this, rad: beyond it no linearisation holds.
const MOST_HIDDEN_RAD: f64 = 0.5;

/// A gap longer than this, s, is not bridged: what happened in it nobody knows.
const LONGEST_BRIDGE_S: f64 = 60.0;
/// One-sigmas of velocity, m/s, and position, m, of a vehicle that has lost its way.
const LOST_VELOCITY_MPS: f64 = 50.0;
const LOST_POSITION_M: f64 = 1e4;

/// C diag(v) Cᵀ, upper triangle by rows.
fn turned<T: Scalar>(c: &[[f64; 3]; 3], variance: [f64; 3]) -> [T; 6] {
    let entry = |i: usize, j: usize| {
        T::of(
            c[i][0] * variance[0] * c[j][0]
                + c[i][1] * variance[1] * c[j][1]
                + c[i][2] * variance[2] * c[j][2],
        )
    };
    [entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)]
}

pub(super) fn square(value: f64) -> f64 {
    value * value
}
