//! Heading from motion: search if no sensor gives the heading at the start, monitor afterwards.
//!
//! The gyros maintain one frame, in which the specific force is summed from fix to fix. Twelve hypotheses
//! (`Hypothesis`) of the attitude of that frame start 30° apart in heading. Each hypothesis has a velocity, an attitude
//! and a gyro bias. The fixes change the weights of the hypotheses: only near the right heading does the specific force
//! add up to the change of GPS velocity. The hypotheses use neither the filter nor its magnetometer, so errors of these
//! do not spread to them.
//!
//! While the heading is unknown, the hypotheses determine attitude and horizontal velocity, and the filter follows
//! them. An error-state filter linearises, and no linearisation holds over an unknown heading.
//!
//! # Source
//! D. L. Alspach and H. W. Sorenson (1972), Nonlinear Bayesian estimation using Gaussian sum approximations, *IEEE
//! Transactions on Automatic Control* 17 (4), 439–448. A bank of small filters next to a large one is the idea of P.
//! Riseborough's EKF-GSF in PX4.

mod hypothesis;
mod judgement;
mod method;
mod monitor;
mod motion;

pub use method::{HeadingMethod, NoHeadingSearch};
pub(super) use monitor::BetterHeading;
pub(super) use motion::HypothesisMotion;

use crate::earth::Geodetic;
use crate::ekf::kernel::history::History;
use crate::ekf::settings::config::GpsModel;
use crate::frames::{Body, Ned, Rotation, Vector, wrap_angle};
use crate::gps::Fix;
use crate::ins::{LeverArm, Start};
use crate::matrix::square;
use crate::scalar::{Scalar, single};
use crate::time::Time;
use hypothesis::{
    HYPOTHESES, HYPOTHESIS_SIGMA_RAD, Hypothesis, Measured, MeasuredMotion, Prior, Surprise, at,
};
use judgement::Judgement;

/// One-sigmas at the start of a monitor: of the tilt, rad (4°), and of the gyro bias, rad/s. The latter is zero: a
/// monitor uses the bias of the filter.
const PRIOR: Prior = Prior { axis: DOWN, tilt_sigma_rad: 0.07, bias_sigma_radps: 0.0 };
/// Random walk of tilt and heading that a monitor allows beyond the sensor noise, rad/√s. Without it the monitor would
/// attribute errors outside the states of a hypothesis to the heading.
const ANGLE_WALK_RAD: f64 = 0.0035;
/// Random walk of the velocity that a monitor allows beyond the sensor noise, m/s/√s, as [`ANGLE_WALK_RAD`] does for
/// the angles.
const VELOCITY_WALK_MPS: f64 = 0.1;
/// Minimum weight of a hypothesis: no hypothesis is ever excluded.
const MIN_WEIGHT: f64 = 1e-9;
/// Largest one-sigma of the heading over all hypotheses at which they agree, rad (8°).
const AGREED_RAD: f64 = 0.14;
/// Largest squared normalised innovation that a heading explains (five one-sigmas). If every hypothesis exceeds it,
/// receiver or inertial unit is in error, and the hypotheses start again.
const UNEXPLAINED: f32 = 25.0;
/// Memory of the information on the heading, s.
const EVIDENCE_S: f64 = 60.0;
/// Longest interval between fixes, s; the hypotheses start again after a longer one.
const LONGEST_S: f64 = 5.0;
/// Minimum speed, m/s, at which agreement alone proves a heading, for fixes one second apart. The limit grows with the
/// square root of the time between fixes. Slow fixes miss part of the motion of a vehicle carried or turned by hand.
const PROVEN_MPS: f64 = 5.0;
/// Time of agreement that proves the heading of a slower vehicle, s.
const PROVEN_S: f64 = 5.0;
/// Minimum information from motion, as a fraction of the information on an agreed heading. The one-sigma with which a
/// hypothesis starts corresponds to a fraction of 0.29.
const PROVEN_EVIDENCE: f64 = 0.25;
/// Minimum one-sigma of an unproven heading, rad: ±3 one-sigmas cover the circle.
const UNPROVEN_RAD: f64 = 1.05;
/// Minimum weight of the hypothesis at a two-antenna heading, as a fraction of the weight of the best hypothesis.
const MIN_SHARE: f64 = 0.01;
/// Factor on the one-sigma of a fix: the hypotheses have no states for its slow errors.
const WHITENED: f64 = 1.7;

/// A bank of hypotheses of the heading.
#[derive(Clone, Debug)]
pub struct HeadingSearch<T = f64> {
    hypotheses: [Hypothesis; HYPOTHESES],
    /// Attitude at the start of the bank, before it is turned for each hypothesis.
    start_to_ned: Rotation<Body, Ned, T>,
    /// Axis, NED, about which the attitude was unknown at the start.
    axis: Vector<Ned, f32>,
    prior: Prior,
    /// One-sigma of the heading at the start, rad; infinite if unknown.
    prior_sigma_rad: f64,
    /// Rotation from the present body axes to those at the start.
    body_to_start: Rotation<Body, Body, T>,
    /// Velocity change by specific force since the last fix, in the axes at the start, m/s.
    felt_mps: Vector<Body, T>,
    /// Time since the last fix, s.
    felt_s: T,
    /// Integral of the direction cosines since the last fix, s.
    turned_s: [[T; 3]; 3],
    /// Variances by sensor noise since the last fix: angle, rad², and velocity, (m/s)².
    variances: [T; 2],
    /// Motion between the validity of the last fix and its arrival.
    since_fix: MeasuredMotion,
    /// Gyro bias of the filter at the last fix, rad/s.
    filter_bias_radps: Option<Vector<Body, T>>,
    /// Vector from the inertial unit to the antenna at the last fix, in the axes at the start, m.
    arm_m: Vector<Body, T>,
    /// Time and position of the last fix, to which the hypotheses refer.
    last_fix: Option<(Time, Geodetic)>,
    /// Whether the heading is monitored, not searched.
    is_monitor: bool,
    /// Whether the vehicle was fast enough for its motion to show a heading.
    is_fast: bool,
    /// Start of the present agreement of the hypotheses on one heading, after sufficient motion.
    agreed_since: Option<Time>,
    /// Information of recent fixes on the heading, rad⁻².
    evidence: f32,
    judgement: Judgement,
}

/// Error model, antenna and gyro bias for a fix, as the filter assumes them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Receiver<'a, T> {
    /// Error model of the receiver.
    pub model: &'a GpsModel,
    /// One-sigmas of position, m, and velocity, m/s, NED.
    pub sigmas: ([f64; 3], [f64; 3]),
    /// White share of the variance of positions that the second differences of the fixes show.
    pub position_scatter: f64,
    /// Lever arm from the inertial unit to the antenna.
    pub antenna: LeverArm<T>,
    /// Gyro bias that the filter subtracts from the rates, rad/s.
    pub bias_radps: Vector<Body, T>,
}

impl HeadingSearch {
    /// Start of a filter whose heading a search has found: `start` turned about `axis`.
    ///
    /// # Source
    /// Equation (H1) of docs/equations.md.
    #[must_use]
    pub fn turned_start(
        mut start: Start,
        axis: Vector<Ned>,
        turn_rad: f64,
        sigma_rad: f64,
    ) -> Start {
        let [tilt_rad, ..] = start.attitude_sigma_rad.to_array();
        start.state.body_to_ned = start.state.body_to_ned.turned_in_to(axis * turn_rad);
        let sigma = |along: f64| {
            let share = square(along);
            Scalar::sqrt(square(tilt_rad) * (1.0 - share) + square(sigma_rad) * share)
        };
        let [north, east, down] = axis.to_array();
        start.attitude_sigma_rad = Vector::new(sigma(north), sigma(east), sigma(down));
        start
    }
}

impl<T: Scalar> HeadingSearch<T> {
    /// A bank without hypotheses.
    #[inline(always)]
    const fn empty() -> Self {
        Self {
            hypotheses: [Hypothesis::NONE; HYPOTHESES],
            start_to_ned: Rotation::IDENTITY,
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
        }
    }

    /// Restarts as the monitor of a heading, from the next fix on.
    // In place: a new value would be built on the stack first.
    pub(super) fn monitor(&mut self, body_to_ned: Rotation<Body, Ned, T>) {
        self.hypotheses.fill(Hypothesis::NONE);
        self.start_to_ned = body_to_ned;
        self.axis = DOWN;
        self.prior = PRIOR;
        self.prior_sigma_rad = f64::INFINITY;
        self.body_to_start = Rotation::IDENTITY;
        self.felt_mps = Vector::ZERO;
        self.felt_s = T::ZERO;
        self.turned_s = [[T::ZERO; 3]; 3];
        self.variances = [T::ZERO; 2];
        self.since_fix = MeasuredMotion::NONE;
        self.filter_bias_radps = None;
        self.arm_m = Vector::ZERO;
        self.last_fix = None;
        self.is_monitor = true;
        self.is_fast = false;
        self.agreed_since = None;
        self.evidence = 0.0;
        self.judgement = Judgement::NONE;
    }

    /// Starts again after samples that hid the motion: a monitor stays a monitor, and a search goes on about
    /// `body_to_ned` with the same uncertainty of the gyro bias.
    pub(super) fn interrupt(&mut self, body_to_ned: Rotation<Body, Ned, T>) {
        let (is_monitor, bias_sigma_radps) = (self.is_monitor, self.prior.bias_sigma_radps);
        self.monitor(body_to_ned);
        self.is_monitor = is_monitor;
        self.prior.bias_sigma_radps = bias_sigma_radps;
    }

    /// Starts a search from a start whose attitude about `axis` is unknown. The gyro bias has the one-sigma
    /// `bias_sigma_radps` unless the start states one.
    pub(super) fn start(&mut self, start: &Start, axis: Vector<Ned>, bias_sigma_radps: f64) {
        self.monitor(start.state.body_to_ned.cast());
        self.is_monitor = false;
        let [tilt_rad, ..] = start.attitude_sigma_rad.to_array();
        self.axis = axis.cast();
        self.prior = Prior {
            axis: self.axis,
            tilt_sigma_rad: tilt_rad as f32,
            bias_sigma_radps: start.gyro_bias_sigma_radps.unwrap_or(bias_sigma_radps) as f32,
        };
    }

    /// Starts a search about a heading of one-sigma `sigma_rad`, with one-sigmas of tilt, rad, and gyro bias, rad/s.
    pub(super) fn start_about(
        &mut self,
        body_to_ned: Rotation<Body, Ned, T>,
        sigma_rad: f64,
        [tilt_sigma_rad, bias_sigma_radps]: [f64; 2],
    ) {
        self.monitor(body_to_ned);
        self.is_monitor = false;
        self.is_fast = true;
        self.prior_sigma_rad = sigma_rad.max(f64::MIN_POSITIVE);
        self.prior.tilt_sigma_rad = tilt_sigma_rad as f32;
        self.prior.bias_sigma_radps = bias_sigma_radps as f32;
    }

    /// Adds a bias-corrected inertial sample whose noise adds `variances` to angle, rad², and velocity, (m/s)².
    pub(super) fn observe_sample(
        &mut self,
        rate_radps: Vector<Body, T>,
        force_mps2: Vector<Body, T>,
        variances: [T; 2],
        interval_s: T,
    ) {
        let turn_rad = rate_radps * interval_s;
        let halfway = self.body_to_start.turned_in_from(turn_rad * T::of(0.5));
        self.felt_mps += halfway * force_mps2 * interval_s;
        self.felt_s += interval_s;
        for (sum, row) in self.turned_s.iter_mut().zip(halfway.rows()) {
            for (sum, cosine) in sum.iter_mut().zip(row) {
                *sum += cosine * interval_s;
            }
        }
        for (sum, variance) in self.variances.iter_mut().zip(variances) {
            *sum += variance;
        }
        self.body_to_start = self.body_to_start.turned_in_from(turn_rad);
    }

    /// Subtracts a change of the filter's gyro bias from the hypotheses.
    fn follow_bias(&mut self, bias_radps: Vector<Body, T>) {
        let before = self.filter_bias_radps.replace(bias_radps);
        if let Some(before) = before.filter(|_| !self.is_monitor) {
            let change = (bias_radps - before).cast();
            for hypothesis in &mut self.hypotheses {
                hypothesis.correct_bias(change);
            }
        }
    }

    /// Motion until a fix. The velocity change `later_mps` over `later_s` came after the fix, and counts for the next
    /// fix.
    fn motion_until(&mut self, later_mps: Vector<Body, T>, later_s: T) -> MeasuredMotion {
        let felt_s = (self.felt_s - later_s).max(T::ZERO);
        let share = if self.felt_s > T::ZERO { felt_s / self.felt_s } else { T::ONE };
        let part = |share: T, velocity_mps: Vector<Body, T>, duration_s: T| MeasuredMotion {
            velocity_mps: velocity_mps.cast(),
            duration_s: single(duration_s),
            turned_s: self.turned_s.map(|row| row.map(|turned_s| single(turned_s * share))),
            variances: self.variances.map(|variance| single(variance * share)),
        };
        let mut felt = part(share, self.felt_mps - later_mps, felt_s);
        if self.is_monitor {
            let walks = [ANGLE_WALK_RAD, VELOCITY_WALK_MPS].map(|walk| square(walk) as f32);
            for (variance, walk) in felt.variances.iter_mut().zip(walks) {
                *variance += walk * felt.duration_s;
            }
        }
        let rest = T::ONE - share;
        self.since_fix = part(rest, later_mps, later_s);
        (self.felt_mps, self.felt_s) = (later_mps, later_s);
        self.turned_s = self.turned_s.map(|row| row.map(|turned_s| turned_s * rest));
        self.variances = self.variances.map(|variance| variance * rest);
        felt
    }

    /// Changes the weights of the hypotheses by a fix. The fix may be valid at an earlier moment within the `history`
    /// of the same samples.
    ///
    /// # Source
    /// Equations (H2), (H3) and (H5) of docs/equations.md.
    #[inline(never)]
    pub(super) fn fix(&mut self, fix: &Fix, receiver: &Receiver<'_, T>, history: &History<T>) {
        let Some(since) = history.motion_since(fix.time, self.body_to_start) else { return };
        if since.duration_s > self.felt_s {
            // The fix is older than the bank's start.
            return;
        }
        self.follow_bias(receiver.bias_radps);
        self.body_to_start = self.body_to_start.renormalised();
        let felt = self.motion_until(since.velocity_mps, since.duration_s);
        let arm_m = since.attitude * receiver.antenna.0;
        let moved_m = arm_m - core::mem::replace(&mut self.arm_m, arm_m);
        let before = self.last_fix.replace((fix.time, fix.position));
        let interval_s = before.map(|(time, _)| fix.time - time);
        let interval_s = interval_s.filter(|s| *s > 0.0 && *s <= LONGEST_S);
        let mut measured = self.measured(fix, receiver, before.zip(interval_s));
        let swing = match interval_s.filter(|_| measured.is_mean) {
            Some(interval_s) => moved_m * T::of(1.0 / interval_s),
            None => since.attitude * receiver.antenna.relative_velocity(since.angular_rate_radps),
        };
        measured.swing_mps = swing.cast();
        let Some(interval_s) = interval_s.filter(|_| self.has_begun()) else {
            self.begin(&measured);
            return;
        };
        let [north, east, _] = measured.axes.map(Option::unwrap_or_default);
        let surely_mps = f64::from(Scalar::hypot(north.0, east.0))
            - if measured.is_mean { 2.0 * f64::from(Scalar::sqrt(north.1)) } else { 0.0 };
        let min_mps = PROVEN_MPS * Scalar::sqrt(interval_s.clamp(0.05, 10.0));
        self.is_fast |= surely_mps > min_mps;
        let share = information_share(fix, receiver.model, interval_s.clamp(0.05, 10.0));
        let mut surprises = [0.0; HYPOTHESES];
        let (mut least_squares, mut information) = (f32::INFINITY, 0.0);
        for (hypothesis, surprise) in self.hypotheses.iter_mut().zip(&mut surprises) {
            let [.., before] = hypothesis.attitude_variances();
            let Surprise { horizontal_squares, minus_two_log } = hypothesis.step(&felt, &measured);
            let [.., after] = hypothesis.attitude_variances();
            information +=
                hypothesis.weight * f64::from(((before - after) / (before * after)).max(0.0));
            *surprise = share * f64::from(minus_two_log);
            least_squares = least_squares.min(horizontal_squares);
        }
        if least_squares > UNEXPLAINED || !self.hypotheses.iter().all(Hypothesis::is_sound) {
            self.begin(&measured);
            return;
        }
        self.evidence *= libm::exp(-interval_s / EVIDENCE_S) as f32;
        self.evidence += (share * information) as f32;
        self.weigh(&surprises);
        let agrees = self.has_evidence(PROVEN_EVIDENCE) && self.heading_spread().1 < AGREED_RAD;
        self.agreed_since = if agrees { self.agreed_since.or(Some(fix.time)) } else { None };
    }

    /// Velocity of a fix; for a fix without velocity, the mean since the fix `before`, an interval, s, earlier.
    fn measured(
        &self,
        fix: &Fix,
        receiver: &Receiver<'_, T>,
        before: Option<((Time, Geodetic), f64)>,
    ) -> Measured {
        let (gps, (position_m, velocity_mps)) = (receiver.model, receiver.sigmas);
        let down = fix.measured_down_mps();
        if let Some([north, east]) = fix.horizontal_velocity_mps {
            let usual = fix.velocity_sigma_mps.map_or(gps.velocity_sigma_mps(), Vector::to_array);
            let values = [Some(north), Some(east), down];
            let axes = core::array::from_fn(|axis| {
                let least = if self.is_monitor { at(&usual, axis) } else { gps.velocity_floor_mps };
                let sigma_mps = WHITENED * at(&velocity_mps, axis).max(least);
                let value = values.get(axis).copied().flatten()?;
                finite(value, square(sigma_mps))
            });
            return Measured { axes, is_mean: false, swing_mps: Vector::ZERO };
        }
        let Some(((_, place), interval_s)) = before else {
            return Measured { axes: [None; 3], is_mean: true, swing_mps: Vector::ZERO };
        };
        let moved_m = fix.position.displacement_from(&place).to_array();
        let share = square(gps.position_wander_share.min(1.0));
        let wandered = share * (2.0 * interval_s / gps.position_wander_time_s).min(2.0);
        let floor = 2.0 * square(gps.position_floor_m);
        let axes = core::array::from_fn(|axis| {
            if axis == 2 {
                return None;
            }
            let sigma_m = at(&position_m, axis);
            let white = (1.0 - share).max(receiver.position_scatter);
            let variance = (2.0 * white + wandered) * square(sigma_m) + floor;
            let value = at(&moved_m, axis) / interval_s;
            finite(value, variance / square(interval_s))
        });
        Measured { axes, is_mean: true, swing_mps: Vector::ZERO }
    }

    /// Whether the hypotheses have started at a fix.
    fn has_begun(&self) -> bool {
        self.hypotheses.iter().any(|hypothesis| hypothesis.weight > 0.0)
    }

    /// Starts the hypotheses at a fix, 30° apart about the attitude of the best hypothesis, or about that of the start.
    fn begin(&mut self, measured: &Measured) {
        let middle = match self.best().filter(|_| self.has_begun()) {
            Some(best) if best.is_sound() => best.start_to_ned,
            _ => self.start_to_ned.cast(),
        };
        let axis = self.prior.axis;
        let mut sum = 0.0;
        for (number, hypothesis) in self.hypotheses.iter_mut().enumerate() {
            let turn_rad = wrap_angle(2.0 * HYPOTHESIS_SIGMA_RAD * number as f64);
            let off = turn_rad / self.prior_sigma_rad;
            hypothesis.weight = libm::exp(-0.5 * square(off)).max(MIN_WEIGHT);
            hypothesis.start_to_ned = middle.turned_in_to(axis * turn_rad as f32);
            hypothesis.start(measured, &self.prior);
            sum += hypothesis.weight;
        }
        for hypothesis in &mut self.hypotheses {
            hypothesis.weight /= sum;
        }
        let Prior { bias_sigma_radps, .. } = self.prior;
        self.prior = Prior { bias_sigma_radps, ..PRIOR };
        (self.agreed_since, self.evidence) = (None, 0.0);
        self.judgement.forget();
    }

    /// Changes the weights of the hypotheses. `surprises` are minus twice the logarithms of their likelihoods.
    fn weigh(&mut self, surprises: &[f64; HYPOTHESES]) {
        let least = surprises.iter().fold(f64::INFINITY, |a, &b| a.min(b));
        let mut sum = 0.0;
        for (hypothesis, surprise) in self.hypotheses.iter_mut().zip(surprises) {
            hypothesis.weight *= libm::exp(-0.5 * (surprise - least).min(50.0));
            sum += hypothesis.weight;
        }
        for hypothesis in &mut self.hypotheses {
            hypothesis.weight = (hypothesis.weight / sum).max(MIN_WEIGHT);
        }
    }

    /// The hypothesis of the largest weight.
    fn best(&self) -> Option<&Hypothesis> {
        self.hypotheses.iter().max_by(|a, b| a.weight.total_cmp(&b.weight))
    }

    /// Mean heading of the hypotheses relative to the best one, clockwise, and one-sigma over all hypotheses, rad.
    ///
    /// # Source
    /// Equation (H4) of docs/equations.md.
    fn heading_spread(&self) -> (f64, f64) {
        let Some(best) = self.best() else { return (0.0, core::f64::consts::PI) };
        let (mut weights, mut off, mut variance) = (0.0, 0.0, 0.0);
        for hypothesis in &self.hypotheses {
            let apart = turn_between(best.start_to_ned, hypothesis.start_to_ned, DOWN);
            let [.., own] = hypothesis.attitude_variances();
            weights += hypothesis.weight;
            off += hypothesis.weight * apart;
            variance += hypothesis.weight * (f64::from(own) + square(apart));
        }
        let off = off / weights;
        (off, Scalar::sqrt((variance / weights - square(off)).max(0.0)))
    }

    /// Whether fixes during recent motion have given the fraction `share` of the information on an agreed heading.
    fn has_evidence(&self, share: f64) -> bool {
        f64::from(self.evidence) * square(AGREED_RAD) > share
    }

    /// Present attitude of a hypothesis.
    fn attitude(&self, hypothesis: &Hypothesis) -> Rotation<Body, Ned, T> {
        (hypothesis.start_to_ned.cast() * self.body_to_start).renormalised()
    }
}

/// A value and its variance in single precision, if both are finite in it.
fn finite(value: f64, variance: f64) -> Option<(f32, f32)> {
    let (value, variance) = (value as f32, variance as f32);
    (value * value + variance).is_finite().then_some((value, variance))
}

/// Down, NED.
const DOWN: Vector<Ned, f32> = Vector::new(0.0, 0.0, 1.0);

/// Turn about an axis from one attitude of the same axes to another, rad: the twist of their relative rotation.
fn turn_between(
    from: Rotation<Body, Ned, f32>,
    to: Rotation<Body, Ned, f32>,
    axis: Vector<Ned, f32>,
) -> f64 {
    let [x, y, z, w] = (to * from.inverse()).to_array();
    wrap_angle(2.0 * f64::from(Vector::new(x, y, z).dot(axis).atan2(w)))
}

/// Fraction of its information with which a fix changes the weights of the hypotheses. A fraction s of the fix's
/// one-sigma is a slow error with correlation time τ. For fixes Δt apart, the slow error acts as white noise of
/// variance s² 2τ/Δt. Without this factor a vehicle at rest would find a heading in the drift of its GPS.
///
/// # Source
/// Equation (H3) of docs/equations.md.
fn information_share(fix: &Fix, gps: &GpsModel, interval_s: f64) -> f64 {
    if fix.horizontal_velocity_mps.is_none() {
        return 1.0;
    }
    let wander = square(gps.velocity_wander_share) * 2.0 * gps.velocity_wander_time_s / interval_s;
    (square(WHITENED) / (1.0 + wander)).min(1.0)
}
