//! The filter: its state, and its prediction with inertial samples.

mod accessors;
mod correction;
mod process;
mod unknown_heading;

use core::marker::PhantomData;

use crate::earth::LocalEarth;
use crate::ekf::gate::Gates;
use crate::ekf::kernel::covariance::Covariance;
use crate::ekf::kernel::history::History;
use crate::ekf::kernel::layout::{
    self, ACCEL_BIAS, ATTITUDE, GYRO_BIAS, Layout, POSITION, VELOCITY,
};
use crate::ekf::kernel::motion_sum::MotionSum;
use crate::ekf::kernel::trace::Trace;
use crate::ekf::outcome::prediction::{ImuFault, Prediction, ResetCause};
use crate::ekf::settings::config::EkfConfig;
use crate::ekf::watch::antenna::AntennaOffset;
use crate::ekf::watch::attitude_watch::AttitudeWatch;
use crate::ekf::watch::barometer::Barometer;
use crate::ekf::watch::bias_shift::BiasShift;
use crate::ekf::watch::excess::Excess;
use crate::ekf::watch::field_watch::FieldWatch;
use crate::ekf::watch::ground::Ground;
use crate::ekf::watch::heading_memory::HeadingMemory;
use crate::ekf::watch::heading_revision::HeadingRevision;
use crate::ekf::watch::level_force::LevelForce;
use crate::ekf::watch::net_turn::NetTurn;
use crate::ekf::watch::position_scatter::PositionScatter;
use crate::ekf::watch::rectification::Rectification;
use crate::ekf::watch::self_contradiction::SelfContradiction;
use crate::frames::{Body, Ned, Vector};
use crate::imu::{ImuSample, Integrity, Rest, Suspicion};
use crate::ins::{Increment, Integrator, Mounting, NavState, Start, UNKNOWN_HEIGHT_M};
use crate::matrix::square;
use crate::scalar::Scalar;
use crate::time::Time;

/// Largest one-sigma of the attitude after a gap, rad: linearisation is invalid beyond it.
pub(super) const MAX_HIDDEN_RAD: f64 = 0.5;

/// State derived from the samples alone, independent of the filter's estimates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Samples<T> {
    pub integrator: Integrator<T>,
    pub integrity: Integrity<T>,
    /// Suspected faults of the last sample.
    pub suspicion: Suspicion<T>,
    pub self_contradiction: SelfContradiction<T>,
    pub rest: Rest,
    pub rectification: Rectification,
    /// Time of the last sample that was rejected because its time was far ahead.
    pub far_ahead: Time,
    /// Mean rate, rad/s, over a second of rest that ended with the last sample.
    pub resting_rate_radps: Option<Vector<Body, T>>,
}

impl<T: Scalar> Samples<T> {
    const NONE: Self = Self {
        integrator: Integrator::EMPTY,
        integrity: Integrity::NONE,
        suspicion: Suspicion::NONE,
        self_contradiction: SelfContradiction::NONE,
        rest: Rest::NONE,
        rectification: Rectification::NONE,
        far_ahead: Time::NEVER,
        resting_rate_radps: None,
    };

    /// Whether a sample with a time far ahead follows another such sample. A single time far ahead is wrong: it would
    /// block all later samples. A second one shows that the inertial unit was off.
    #[inline(never)]
    fn confirms_far_ahead(&mut self, time: Time) -> bool {
        let before = core::mem::replace(&mut self.far_ahead, time);
        (0.0..=FOLLOWS_S).contains(&(time - before))
    }

    /// Resets every field separately, for the reason given at [`Gates::clear`].
    fn clear(&mut self) {
        self.integrator = Integrator::EMPTY;
        self.integrity = Integrity::NONE;
        self.suspicion = Suspicion::NONE;
        self.self_contradiction = SelfContradiction::NONE;
        self.rest = Rest::NONE;
        self.rectification = Rectification::NONE;
        self.far_ahead = Time::NEVER;
        self.resting_rate_radps = None;
    }
}

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
    pub(super) gates: Gates,
    /// Attitudes and magnetic headings.
    pub(super) heading: HeadingMemory,
    pub(super) attitude_watch: AttitudeWatch,
    /// Slow error of the last heading source: one-sigma, rad, and correlation time, s.
    pub(super) heading_wander: [f64; 2],
    /// Additional one-sigma of the heading source's slow error, rad, according to the fixes.
    pub(super) extra_heading_sigma_rad: f32,
    pub(super) field_watch: FieldWatch,
    /// Time at which the attitude was lost: by a gap, a reset, suspect samples, or a disturbed first field. `None`
    /// after the next attitude measurement or a found heading.
    pub(super) attitude_lost: Option<Time>,
    /// See [`Solution::heading_revision_rad`](crate::ekf::Solution::heading_revision_rad).
    pub(super) heading_revision: HeadingRevision<T>,
    pub(super) barometer: Barometer,
    pub(super) ground: Ground,
    pub(super) antenna_heading: HeadingMemory,
    /// Slow part of the latest fix's one-sigma: position horizontal and vertical, m, then velocity horizontal and
    /// vertical, m/s.
    pub(super) gps_wander: Option<[f32; 4]>,
    /// Motion over which the covariance is not propagated yet.
    pub(super) unpropagated: Option<MotionSum<T>>,
    /// Angular rate relative to the NED axes, less bias, rad/s.
    pub(super) angular_rate_radps: Vector<Body, T>,
    /// Time since the last relaxation of the parameters, up to the last propagation, s.
    pub(super) unrelaxed_s: T,
    /// Learned variances of the GPS errors, relative to the stated or configured ones: position, horizontal velocity
    /// and vertical velocity.
    pub(super) gps_learned: [f32; 3],
    pub(super) position_scatter: PositionScatter,
    pub(super) net_turn: NetTurn<T>,
    pub(super) level_force: LevelForce<T>,
    pub(super) antenna: AntennaOffset,
    /// Variances added by sensor noise over the last sample interval, mean of the three axes: angle, rad², and
    /// velocity, (m/s)².
    pub(super) step_variances: [T; 2],
    pub(super) excess: Excess,
    pub(super) bias_shift: BiasShift,
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
            gates: Gates::NONE,
            heading: HeadingMemory::NONE,
            attitude_watch: AttitudeWatch::NONE,
            heading_wander: usual_heading_wander(&config),
            extra_heading_sigma_rad: 0.0,
            field_watch: FieldWatch::NONE,
            attitude_lost: None,
            heading_revision: HeadingRevision::NONE,
            barometer: Barometer::BEFORE_FIRST_READING,
            ground: Ground::UNKNOWN,
            antenna_heading: HeadingMemory::NONE,
            gps_wander: None,
            unpropagated: None,
            angular_rate_radps: Vector::ZERO,
            unrelaxed_s: T::ZERO,
            gps_learned: [1.0; 3],
            position_scatter: PositionScatter::NONE,
            net_turn: NetTurn::NONE,
            level_force: LevelForce::NONE,
            antenna: AntennaOffset::BEFORE_FIRST_TURN,
            step_variances: [T::ZERO; 2],
            excess: Excess::NONE,
            bias_shift: BiasShift::UNKNOWN,
            samples: Samples::NONE,
            layout: PhantomData,
        }
    }

    /// Starts the filter again, in place, with the result of an alignment.
    pub(super) fn restart(&mut self, start: &Start) {
        self.parameters.fill(T::ZERO);
        self.history.clear();
        self.gates.clear();
        self.heading = HeadingMemory::NONE;
        self.attitude_watch = AttitudeWatch::NONE;
        self.heading_wander = usual_heading_wander(&self.config);
        self.extra_heading_sigma_rad = 0.0;
        self.field_watch = FieldWatch::NONE;
        self.attitude_lost = None;
        self.heading_revision = HeadingRevision::NONE;
        self.barometer = Barometer::BEFORE_FIRST_READING;
        self.ground = Ground::UNKNOWN;
        self.antenna_heading = HeadingMemory::NONE;
        self.gps_wander = None;
        self.unpropagated = None;
        self.angular_rate_radps = Vector::ZERO;
        self.unrelaxed_s = T::ZERO;
        self.gps_learned = [1.0; 3];
        self.position_scatter = PositionScatter::NONE;
        self.net_turn = NetTurn::NONE;
        self.level_force = LevelForce::NONE;
        self.antenna = AntennaOffset::BEFORE_FIRST_TURN;
        self.step_variances = [T::ZERO; 2];
        self.excess = Excess::NONE;
        self.bias_shift = BiasShift::UNKNOWN;
        self.samples.clear();
        self.restart_base(start);
        self.open_blocks();
        self.open_wander_of_start(start);
    }

    /// Replaces state and covariance by the values of `start`, with the accelerometer bias unknown.
    pub(super) fn restart_base(&mut self, start: &Start) {
        self.state = start.state.cast();
        self.covariance.clear();
        self.set_block(GYRO_BIAS, start.gyro_bias_radps.cast().to_array());
        self.set_block(ACCEL_BIAS, [T::ZERO; 3]);
        self.open(ATTITUDE, start.attitude_sigma_rad.to_array());
        self.open(VELOCITY, start.velocity_sigma_mps.to_array());
        self.open(POSITION, start.position_sigma_m.to_array());
        let imu = self.config.imu;
        let gyro_sigma = start.gyro_bias_sigma_radps.unwrap_or(imu.gyro_bias_sigma_radps);
        self.open(GYRO_BIAS, [gyro_sigma; 3]);
        self.open(ACCEL_BIAS, [imu.accel_bias_sigma_mps2; 3]);
    }

    /// Raises the variances of the slow GPS errors at a start. Position and velocity of a start come from a fix. Their
    /// error is the slow error of that fix with the opposite sign.
    ///
    /// # Source
    /// Equation (K14) of docs/equations.md.
    fn open_wander_of_start(&mut self, start: &Start) {
        let model = self.config.gps;
        let shares = (model.position_wander_share, model.velocity_wander_share);
        let [north_m, east_m, down_m] = start.position_sigma_m.to_array();
        let [.., usual_m] = model.position_sigma_m();
        // A height that no fix measured has no error of a fix.
        let down_m = if down_m < UNKNOWN_HEIGHT_M { down_m } else { usual_m };
        let position = Vector::new(north_m, east_m, down_m);
        let [position_h, _, position_v] = match L::GPS_POSITION {
            Some(first) => self.open_block_of_start(first, POSITION, shares.0, position, true),
            None => [0.0; 3],
        };
        // A start velocity from another source than a fix has a far larger one-sigma.
        let from_fix = start.velocity_sigma_mps.x() < UNKNOWN_VELOCITY_MPS;
        let velocity =
            if from_fix { start.velocity_sigma_mps } else { model.velocity_sigma_mps().into() };
        let [velocity_h, _, velocity_v] = match L::GPS_VELOCITY {
            Some(first) => self.open_block_of_start(first, VELOCITY, shares.1, velocity, from_fix),
            None => [0.0; 3],
        };
        self.gps_wander = Some([position_h, position_v, velocity_h, velocity_v].map(|m| m as f32));
    }

    /// Sets the one-sigmas of three slow errors, from state `first` on, to the fraction `share`, at most 0.99, of
    /// `sigma`. If `from_fix`, correlates each with the error of the state that the fix has set. These states start at
    /// index `of`. Returns the one-sigmas of the slow errors.
    fn open_block_of_start(
        &mut self,
        first: usize,
        of: usize,
        share: f64,
        sigma: Vector<Ned>,
        from_fix: bool,
    ) -> [f64; 3] {
        let sigmas = sigma.to_array().map(|sigma| share.min(0.99) * sigma);
        self.open(first, sigmas);
        for (axis, sigma) in sigmas.into_iter().enumerate().filter(|_| from_fix) {
            self.covariance.set_cross(of + axis, first + axis, -square(sigma));
        }
        sigmas
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
            let tilt = config.attitude.tilt_wander_rad;
            let [heading, _] = self.heading_wander;
            self.open(first, [tilt, tilt, heading]);
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

    pub(super) fn open(&mut self, first: usize, sigmas: [f64; 3]) {
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
            self.gates.suspect_filter(sample.time);
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
        self.angular_rate_radps = rate - self.state.body_to_ned.inverse() * ground;
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
        let whole = !(suspicion.is_clipped() || suspicion.stuck.any());
        self.samples.self_contradiction.add(advance.from_specific_force_mps, whole);
        Some(advance.frame_rotation_rad * (T::ONE / increment.interval_s))
    }

    /// A step over a gap: the state coasts, and the covariance grows by the possible motion. Returns the rotation rate
    /// of NED, rad/s, or `None`, as [`step`](Self::step) does.
    fn coast(&mut self, time: Time, trace: &mut impl Trace<T, N>) -> Option<Vector<Ned, T>> {
        self.catch_up(trace);
        let before = self.state;
        let interval_s = time.seconds_since(self.state.time);
        self.gates.suspect_filter(time);
        let rotation_rad = self.state.coast(time, self.angular_rate_radps);
        if !self.state.is_valid() {
            self.state = NavState { time, ..before };
            return None;
        }
        let transition = self.coasting(interval_s);
        self.propagate(&transition, trace);
        if interval_s.wide() * self.config.imu.gap_rate_radps >= MAX_HIDDEN_RAD {
            self.attitude_lost = Some(time);
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
/// [`Ekf::heading_wander`] before the first measured heading.
const fn usual_heading_wander(config: &EkfConfig) -> [f64; 2] {
    [config.attitude.heading_wander_rad, config.attitude.wander_time_s]
}

/// One-sigma of the level of a barometer before its first use, m. It is far larger than the one-sigma of any height. So
/// the first reading sets the level and does not correct the height.
const UNKNOWN_LEVEL_M: f64 = 100.0;
/// Longest time, s, between two samples with times far ahead, for the second to confirm the first.
const FOLLOWS_S: f64 = 1.0;
/// Longest gap that is bridged, s: the motion in a longer one is unknown.
const LONGEST_BRIDGE_S: f64 = 60.0;

#[cfg(test)]
mod tests;
