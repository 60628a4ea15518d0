//! Memory of the filter: samples and readings, next to state and covariance.

use crate::ekf::gate::Gates;
use crate::ekf::kernel::motion_sum::MotionSum;
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
use crate::frames::{Body, Vector};
use crate::imu::{Integrity, Rest, Suspicion};
use crate::ins::Integrator;
use crate::scalar::Scalar;
use crate::time::Time;

/// Longest time, s, between two samples with times far ahead, for the second to confirm the first.
const FOLLOWS_S: f64 = 1.0;

/// Gates, monitors and learned quantities of a filter. An alignment resets it as a whole.
#[derive(Clone, Copy, Debug)]
pub(in crate::ekf) struct Memory<T> {
    pub gates: Gates,
    /// Attitudes and magnetic headings.
    pub heading: HeadingMemory,
    pub attitude_watch: AttitudeWatch,
    /// Slow error of the last heading source: one-sigma, rad, and correlation time, s.
    pub heading_wander: [f64; 2],
    /// Additional one-sigma of the heading source's slow error, rad, according to the fixes.
    pub extra_heading_sigma_rad: f32,
    pub field_watch: FieldWatch,
    /// Time at which the attitude was lost: by a gap, a reset, suspect samples, or a disturbed first field. `None`
    /// after the next attitude measurement or a found heading.
    pub attitude_lost: Option<Time>,
    /// See [`Solution::heading_revision_rad`](crate::ekf::Solution::heading_revision_rad).
    pub heading_revision: HeadingRevision<T>,
    pub barometer: Barometer,
    pub ground: Ground,
    pub antenna_heading: HeadingMemory,
    /// Slow part of the latest fix's one-sigma: position horizontal and vertical, m, then velocity horizontal and
    /// vertical, m/s.
    pub gps_wander: Option<[f32; 4]>,
    /// Motion over which the covariance is not propagated yet.
    pub unpropagated: Option<MotionSum<T>>,
    /// Angular rate relative to the NED axes, less bias, rad/s.
    pub angular_rate_radps: Vector<Body, T>,
    /// Time since the last relaxation of the parameters, up to the last propagation, s.
    pub unrelaxed_s: T,
    /// Learned variances of the GPS errors, relative to the stated or configured ones: position, horizontal velocity
    /// and vertical velocity.
    pub gps_learned: [f32; 3],
    pub position_scatter: PositionScatter,
    pub net_turn: NetTurn<T>,
    pub level_force: LevelForce<T>,
    pub antenna: AntennaOffset,
    /// Variances added by sensor noise over the last sample interval, mean of the three axes: angle, rad², and
    /// velocity, (m/s)².
    pub step_variances: [T; 2],
    pub excess: Excess,
    pub bias_shift: BiasShift,
}

impl<T: Scalar> Memory<T> {
    /// The memory of a filter that has not been given any reading yet.
    #[inline(always)]
    pub const fn before_first_reading(config: &EkfConfig) -> Self {
        Self {
            gates: Gates::NONE,
            heading: HeadingMemory::NONE,
            attitude_watch: AttitudeWatch::NONE,
            heading_wander: [config.attitude.heading_wander_rad, config.attitude.wander_time_s],
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
        }
    }
}

/// State derived from the samples alone, independent of the filter's estimates.
#[derive(Clone, Copy, Debug)]
pub(in crate::ekf) struct Samples<T> {
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
    pub const NONE: Self = Self {
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
    pub fn confirms_far_ahead(&mut self, time: Time) -> bool {
        let before = core::mem::replace(&mut self.far_ahead, time);
        (0.0..=FOLLOWS_S).contains(&(time - before))
    }
}
