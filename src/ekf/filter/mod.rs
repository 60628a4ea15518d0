//! The filter: its state, and its prediction with inertial samples.

mod accessors;
mod correction;
mod memory;
mod process;
mod unknown_heading;

use core::marker::PhantomData;

use crate::earth::LocalEarth;
use crate::ekf::kernel::covariance::Covariance;
use crate::ekf::kernel::history::History;
use crate::ekf::kernel::layout::{
    self, ACCEL_BIAS, ATTITUDE, GYRO_BIAS, Layout, POSITION, VELOCITY,
};
use crate::ekf::kernel::trace::Trace;
use crate::ekf::outcome::prediction::{ImuFault, Prediction, ResetCause};
use crate::ekf::settings::config::EkfConfig;
use crate::frames::{Ned, Vector};
use crate::imu::ImuSample;
use crate::ins::{Increment, Mounting, NavState, Start, UNKNOWN_HEIGHT_M};
use crate::matrix::square;
use crate::scalar::Scalar;
use crate::time::Time;
use memory::{Memory, Samples};

/// Largest one-sigma of the attitude after a gap, rad: linearisation is invalid beyond it.
pub(super) const MAX_HIDDEN_RAD: f64 = 0.5;

/// Error-state Kalman filter around the strapdown mechanization, closed loop.
///
/// `L` chooses the error states, `N` is their padded number, `T` the numeric type. The aliases
/// [`BaseEkf`](crate::ekf::BaseEkf) and [`FullEkf`](crate::ekf::FullEkf) name the usual choices. The filter allocates nothing,
/// and every call does bounded work.
#[derive(Clone, Debug)]
pub struct Ekf<L, const N: usize, T = f64> {
    pub(super) config: EkfConfig,
    pub(super) mounting: Mounting,
    pub(super) state: NavState<T>,
    /// Estimates of the parameters, by state index; the first nine entries are not used.
    pub(super) parameters: [T; N],
    pub(super) covariance: Covariance<T, N>,
    pub(super) history: History<T>,
    pub(super) memory: Memory<T>,
    pub(super) samples: Samples<T>,
    layout: PhantomData<L>,
}

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// A filter that starts with the result of an alignment.
    #[must_use]
    pub fn new(config: EkfConfig, mounting: Mounting, start: Start) -> Self {
        let mut filter = Self::unstarted(config, mounting);
        filter.restart(&start);
        filter
    }

    /// A filter without a state, to be [`restart`](Self::restart)ed.
    // Built in place inside its caller.
    #[inline(always)]
    pub(super) const fn unstarted(config: EkfConfig, mounting: Mounting) -> Self {
        const { assert!(layout::is_sound::<L, N>(), "the layout breaks its rules") };
        Self {
            config,
            mounting,
            state: NavState::ORIGIN,
            parameters: [T::ZERO; N],
            covariance: Covariance::zero(),
            history: History::EMPTY,
            memory: Memory::before_first_reading(&config),
            samples: Samples::NONE,
            layout: PhantomData,
        }
    }

    /// Starts the filter again, in place, with the result of an alignment.
    pub(super) fn restart(&mut self, start: &Start) {
        self.parameters.fill(T::ZERO);
        self.history.clear();
        self.memory = Memory::before_first_reading(&self.config);
        self.samples = Samples::NONE;
        self.restart_base(start);
        self.set_block_sigmas();
        self.set_wander_of_start(start);
    }

    /// Replaces state and covariance by the values of `start`, with the accelerometer bias unknown.
    pub(super) fn restart_base(&mut self, start: &Start) {
        self.state = start.state.cast();
        self.covariance.clear();
        self.set_block(GYRO_BIAS, start.gyro_bias_radps.cast().to_array());
        self.set_block(ACCEL_BIAS, [T::ZERO; 3]);
        self.set_sigmas(ATTITUDE, start.attitude_sigma_rad.to_array());
        self.set_sigmas(VELOCITY, start.velocity_sigma_mps.to_array());
        self.set_sigmas(POSITION, start.position_sigma_m.to_array());
        let imu = self.config.imu;
        let gyro_sigma = start.gyro_bias_sigma_radps.unwrap_or(imu.gyro_bias_sigma_radps);
        self.set_sigmas(GYRO_BIAS, [gyro_sigma; 3]);
        self.set_sigmas(ACCEL_BIAS, [imu.accel_bias_sigma_mps2; 3]);
    }

    /// Raises the variances of the slow GPS errors at a start. Position and velocity of a start come from a fix. Their
    /// error is the slow error of that fix with the opposite sign.
    ///
    /// # Source
    /// Equation (K14) of docs/equations.md.
    fn set_wander_of_start(&mut self, start: &Start) {
        let model = self.config.gps;
        let shares = (model.position_wander_share, model.velocity_wander_share);
        let [north_m, east_m, down_m] = start.position_sigma_m.to_array();
        let [.., usual_m] = model.position_sigma_m();
        // A height that no fix measured has no error of a fix.
        let down_m = if down_m < UNKNOWN_HEIGHT_M { down_m } else { usual_m };
        let position = Vector::new(north_m, east_m, down_m);
        let [position_h, _, position_v] = match L::GPS_POSITION {
            Some(first) => self.set_slow_errors_of_start(first, POSITION, shares.0, position, true),
            None => [0.0; 3],
        };
        // A start velocity from another source than a fix has a far larger one-sigma.
        let from_fix = start.velocity_sigma_mps.x() < UNKNOWN_VELOCITY_MPS;
        let velocity =
            if from_fix { start.velocity_sigma_mps } else { model.velocity_sigma_mps().into() };
        let [velocity_h, _, velocity_v] = match L::GPS_VELOCITY {
            Some(first) => {
                self.set_slow_errors_of_start(first, VELOCITY, shares.1, velocity, from_fix)
            }
            None => [0.0; 3],
        };
        self.memory.gps_wander =
            Some([position_h, position_v, velocity_h, velocity_v].map(|m| m as f32));
    }

    /// Sets the one-sigmas of three slow errors, from state `first` on, to the fraction `share` of `sigma`, at most
    /// 0.99. If a fix has set the three states from index `of` on (`from_fix`), correlates each slow error with the
    /// error of its state. Returns the one-sigmas of the slow errors.
    fn set_slow_errors_of_start(
        &mut self,
        first: usize,
        of: usize,
        share: f64,
        sigma: Vector<Ned>,
        from_fix: bool,
    ) -> [f64; 3] {
        let sigmas = sigma.to_array().map(|sigma| share.min(0.99) * sigma);
        self.set_sigmas(first, sigmas);
        for (axis, sigma) in sigmas.into_iter().enumerate().filter(|_| from_fix) {
            self.covariance.set_cross(of + axis, first + axis, -square(sigma));
        }
        sigmas
    }

    pub(super) fn set_block_sigmas(&mut self) {
        let config = self.config;
        if let Some(first) = L::ATTITUDE_REFERENCE {
            let tilt = config.attitude.tilt_wander_rad;
            let [heading, _] = self.memory.heading_wander;
            self.set_sigmas(first, [tilt, tilt, heading]);
        }
        if let Some(state) = L::LATENCY {
            self.covariance.set_variance(state, square(config.gps.position_latency_sigma_s));
        }
        if let Some(state) = L::GPS_DELAY {
            self.covariance.set_variance(state, square(config.gps.delay_sigma_s));
        }
        if let Some(state) = L::BARO {
            self.covariance.set_variance(state, square(UNKNOWN_LEVEL_M));
        }
    }

    pub(super) fn set_sigmas(&mut self, first: usize, sigmas: [f64; 3]) {
        for (axis, sigma) in sigmas.into_iter().enumerate() {
            self.covariance.set_variance(first + axis, square(sigma));
        }
    }

    /// Advances the filter to the next sample of the inertial unit.
    ///
    /// # Errors
    /// [`ImuFault`] gives the reason why a sample was rejected. Such a sample changes neither estimates nor covariance.
    pub fn predict(&mut self, sample: &ImuSample) -> Result<Prediction, ImuFault> {
        self.predict_traced(sample, &mut ())
    }

    /// [`predict`](Self::predict), observed by `trace`.
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
        let last = self.samples.integrator.time().unwrap_or(self.state.time);
        if sample.time <= last {
            return Err(ImuFault::NotLater);
        }
        let interval_s: T = sample.time.seconds_since(last);
        if interval_s > T::of(LONGEST_BRIDGE_S) {
            if !self.samples.confirms_far_ahead(sample.time) {
                return Err(ImuFault::FarAhead);
            }
        } else {
            self.samples.far_ahead = Time::NEVER;
        }
        let motion = sample.motion.cast();
        let integrity = &mut self.samples.integrity;
        if integrity.is_stuck(&motion) && self.config.mechanisms.stuck_samples {
            return Err(ImuFault::Stuck);
        }
        if self.config.mechanisms.interpolated_samples
            && integrity.is_interpolated(&motion, interval_s)
        {
            return Err(ImuFault::Interpolated);
        }
        let errors = self.imu_errors();
        let integrated = self.samples.integrator.push_finite(sample.time, motion, &errors);
        // The first sample's rates are assumed constant since the start.
        let mut increment = integrated.unwrap_or_else(|| {
            let interval_s = sample.time.seconds_since(self.state.time);
            Increment::of_first_sample(&motion, interval_s, &errors)
        });
        let gap_s = increment.interval_s.wide();
        let gap = gap_s > self.config.imu.gap_s;
        if gap_s > LONGEST_BRIDGE_S {
            self.state.time = sample.time;
            self.reset_covariance();
            trace.reset(0..N);
            return Ok(Prediction::Reset(ResetCause::LongGap { length_s: gap_s }));
        }
        self.watch_samples(sample, &motion, increment.interval_s, gap);
        let suspicion = &self.samples.suspicion;
        let held = suspicion.withheld_mps2.dot(suspicion.withheld_mps2) > T::ZERO;
        if suspicion.is_suspect() || held {
            self.memory.gates.suspected = sample.time;
        }
        if held {
            increment.velocity_mps -= suspicion.withheld_mps2 * increment.interval_s;
        }
        let stepped = if gap {
            self.coast(sample.time, trace)
        } else {
            self.step(sample.time, &increment, trace)
        };
        let Some(ground) = stepped else {
            self.reset_covariance();
            trace.reset(0..N);
            return Ok(Prediction::Reset(ResetCause::Diverged));
        };
        let rate = increment.angular_rate(&motion, &errors);
        self.memory.angular_rate_radps = rate - self.state.body_to_ned.inverse() * ground;
        Ok(if gap { Prediction::BridgedGap { length_s: gap_s } } else { Prediction::Stepped })
    }

    /// One step of the mechanization and of the covariance. Returns the rotation rate of NED, rad/s. `None` if the step
    /// would lead to an invalid state; then only the time of the state changes.
    fn step(
        &mut self,
        time: Time,
        increment: &Increment<T>,
        trace: &mut impl Trace<T, N>,
    ) -> Option<Vector<Ned, T>> {
        let before = self.state;
        let advance = self.state.advance(time, increment);
        if !self.state.is_valid() {
            self.state = NavState { time, ..before };
            return None;
        }
        self.sum_up(increment, &advance, trace);
        self.history.push(time, increment, &advance);
        let suspicion = &self.samples.suspicion;
        let whole = !(suspicion.clipped.any() | suspicion.stuck.any());
        self.samples.self_contradiction.add(advance.from_specific_force_mps, whole);
        Some(advance.frame_rotation_rad * (T::ONE / increment.interval_s))
    }

    /// A step over a gap: the state coasts, and the covariance grows by the possible motion. Returns the rotation rate
    /// of NED, rad/s, or `None`, as [`step`](Self::step) does.
    fn coast(&mut self, time: Time, trace: &mut impl Trace<T, N>) -> Option<Vector<Ned, T>> {
        self.catch_up(trace);
        let before = self.state;
        let interval_s = time.seconds_since(self.state.time);
        self.memory.gates.suspected = time;
        let rotation_rad = self.state.coast(time, self.memory.angular_rate_radps);
        if !self.state.is_valid() {
            self.state = NavState { time, ..before };
            return None;
        }
        let transition = self.coasting(interval_s);
        self.propagate(&transition, trace);
        if interval_s.wide() * self.config.imu.gap_rate_radps >= MAX_HIDDEN_RAD {
            self.memory.attitude_lost = Some(time);
        }
        self.history.clear();
        self.history.coast(time, interval_s, rotation_rad);
        self.samples.self_contradiction.add(Vector::ZERO, false);
        let local = LocalEarth::about(&self.state.position);
        Some(local.earth_rate_radps + local.transport_rate(self.state.velocity_mps))
    }
}

/// Largest one-sigma, m/s, of a start velocity that comes from a fix.
const UNKNOWN_VELOCITY_MPS: f64 = 4.0;
/// One-sigma of the level of a barometer before its first use, m. It is far larger than the one-sigma of any height. So
/// the first reading sets the level and does not correct the height.
const UNKNOWN_LEVEL_M: f64 = 100.0;
/// Longest gap that is bridged, s: the motion in a longer one is unknown.
const LONGEST_BRIDGE_S: f64 = 60.0;

#[cfg(test)]
mod tests;
