//! Memory of the bank between fixes.

use super::hypothesis::{MeasuredMotion, Prior};
use super::judgement::Judgement;
use crate::earth::Geodetic;
use crate::frames::{Body, Ned, Rotation, Vector};
use crate::scalar::Scalar;
use crate::time::Time;

/// Down, NED.
pub(super) const DOWN: Vector<Ned, f32> = Vector::new(0.0, 0.0, 1.0);
/// One-sigmas at the start of a monitor: of the tilt, rad (4°), and of the gyro bias, rad/s. The latter is zero: a
/// monitor uses the bias of the filter.
pub(super) const PRIOR: Prior = Prior { axis: DOWN, tilt_sigma_rad: 0.07, bias_sigma_radps: 0.0 };

/// What a bank knows beside its hypotheses. It is reset as a whole.
#[derive(Clone, Debug)]
pub(super) struct Memory<T> {
    /// Axis, NED, about which the attitude was unknown at the start.
    pub axis: Vector<Ned, f32>,
    pub prior: Prior,
    /// One-sigma of the heading at the start, rad; infinite if unknown.
    pub prior_sigma_rad: f64,
    /// Rotation from the present body axes to those at the start.
    pub body_to_start: Rotation<Body, Body, T>,
    /// Velocity change by specific force since the last fix, in the axes at the start, m/s.
    pub felt_mps: Vector<Body, T>,
    /// Time since the last fix, s.
    pub felt_s: T,
    /// Integral of the direction cosines since the last fix, s.
    pub turned_s: [[T; 3]; 3],
    /// Variances by sensor noise since the last fix: angle, rad², and velocity, (m/s)².
    pub variances: [T; 2],
    /// Motion between the validity of the last fix and its arrival.
    pub since_fix: MeasuredMotion,
    /// Gyro bias of the filter at the last fix, rad/s.
    pub filter_bias_radps: Option<Vector<Body, T>>,
    /// Vector from the inertial unit to the antenna at the last fix, in the axes at the start, m.
    pub arm_m: Vector<Body, T>,
    /// Time and position of the last fix, to which the hypotheses refer.
    pub last_fix: Option<(Time, Geodetic)>,
    /// Whether the heading is monitored, not searched.
    pub is_monitor: bool,
    /// Whether the vehicle was fast enough for its motion to show a heading.
    pub is_fast: bool,
    /// Start of the present agreement of the hypotheses on one heading, after sufficient motion.
    pub agreed_since: Option<Time>,
    /// Information of recent fixes on the heading, rad⁻².
    pub evidence: f32,
    pub judgement: Judgement,
}

impl<T: Scalar> Memory<T> {
    /// Memory of a monitor before its first fix.
    pub const START: Self = Self {
        axis: DOWN,
        prior: PRIOR,
        prior_sigma_rad: f64::INFINITY,
        body_to_start: Rotation::IDENTITY,
        felt_mps: Vector::ZERO,
        felt_s: T::ZERO,
        turned_s: [[T::ZERO; 3]; 3],
        variances: [T::ZERO; 2],
        since_fix: MeasuredMotion::NONE,
        filter_bias_radps: None,
        arm_m: Vector::ZERO,
        last_fix: None,
        is_monitor: true,
        is_fast: false,
        agreed_since: None,
        evidence: 0.0,
        judgement: Judgement::NONE,
    };
}
