//! The filter itself: the state it holds, and its step with the inertial unit.

use core::marker::PhantomData;

use super::config::EkfConfig;
use super::covariance::Covariance;
use super::gate::Lockouts;
use super::history::History;
use super::layout::{self, ACCEL_BIAS, ATTITUDE, BASE, GYRO_BIAS, Layout, POSITION, VELOCITY};
use super::prediction::{ImuFault, Prediction, ResetCause};
use super::scalar::Scalar;
use super::square;
use super::trace::Trace;
use crate::earth::Local;
use crate::frames::{Body, Vector};
use crate::imu::{ImuErrors, ImuSample, Vibration};
use crate::ins::{Increment, Integrator, Mounting, NavState, Start};
use crate::time::Time;

/// Error-state Kalman filter around the strapdown mechanization, closed loop.
///
/// `L` chooses the error states, `N` is their padded number, `T` the covariance's number type; the
/// aliases [`BaseEkf`](super::BaseEkf) and [`FullEkf`](super::FullEkf) name the usual choices. It
/// allocates nothing, and every call does bounded work.
#[derive(Clone, Debug)]
pub struct Ekf<L, const N: usize, T = f64> {
    pub(super) config: EkfConfig,
    pub(super) mounting: Mounting,
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
    pub(super) gyro_vibration: Vibration,
    pub(super) accel_vibration: Vibration,
    pub(super) angular_rate_radps: Vector<Body>,
    layout: PhantomData<L>,
}

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// A filter that starts where alignment ended.
    #[must_use]
    pub fn new(config: EkfConfig, mounting: Mounting, start: Start) -> Self {
        const { assert!(layout::is_sound::<L, N>(), "the layout breaks its rules") };
        let mut filter = Self {
            config,
            mounting,
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

    pub(super) fn open_blocks(&mut self) {
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
    /// [`ImuFault`] says why a sample was refused; it changed nothing.
    pub fn predict(&mut self, sample: &ImuSample) -> Result<Prediction, ImuFault> {
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
    ) -> Result<Prediction, ImuFault> {
        if !sample.motion.is_finite() {
            return Err(ImuFault::NotFinite);
        }
        if sample.time <= self.integrator.time().unwrap_or(self.state.time) {
            return Err(ImuFault::NotLater);
        }
        let errors = self.imu_errors();
        let increment = match self.integrator.push(sample, &errors) {
            Some(increment) => increment,
            // The first sample's rates hold since the start.
            None => {
                let interval_s = sample.time - self.state.time;
                Increment::of_first_sample(&sample.motion, interval_s, &errors)
            }
        };
        let gap_s = increment.interval_s;
        let gap = gap_s > self.config.imu.gap_s;
        if gap_s > LONGEST_BRIDGE_S {
            self.state.time = sample.time;
            self.reset_covariance();
            return Ok(Prediction::Reset(ResetCause::LongGap { length_s: gap_s }));
        }
        self.watch_vibration(sample, increment.interval_s, gap);

        let before = self.state;
        let advance = self.state.advance(sample.time, &increment);
        if !self.state.is_valid() {
            self.state = NavState { time: sample.time, ..before };
            self.reset_covariance();
            return Ok(Prediction::Reset(ResetCause::Diverged));
        }
        let ground = advance.frame_rotation_rad * (1.0 / increment.interval_s);
        let rate = increment.angular_rate(&sample.motion, &errors);
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
        Ok(if gap { Prediction::BridgedGap { length_s: gap_s } } else { Prediction::Stepped })
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
        let mut grown = Ekf::<M, K, U>::new(self.config, self.mounting, start);
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

/// A gap longer than this, s, is not bridged: what happened in it nobody knows.
const LONGEST_BRIDGE_S: f64 = 60.0;
