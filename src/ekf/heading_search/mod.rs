//! Heading from motion: found where nothing gives it at the start, monitored afterwards.
//!
//! One attitude, turned by the gyros and levelled by the fixes, resolves the specific force in a level frame of unknown
//! direction. Twelve guesses at that direction, 30° apart, each carry a horizontal velocity and the tilt error of the level
//! frame from fix to fix. The fixes weigh the guesses: only near the right direction does specific force add up to the
//! change of GPS velocity. The filter and its magnetometer have no part in the guesses, so they cannot spread their own
//! mistake.
//!
//! While the heading is unknown, the guesses own attitude and horizontal velocity, and the filter follows them. An
//! error-state filter linearises, and no linearisation holds over an unknown heading.
//!
//! # Source
//! D. L. Alspach and H. W. Sorenson (1972), Nonlinear Bayesian estimation using Gaussian sum approximations,
//! *IEEE Transactions on Automatic Control* 17 (4), 439–448. A bank of small filters next to a large one is the idea of
//! P. Riseborough's EKF-GSF in PX4.

mod guess;
mod method;
mod monitor;

pub use method::{HeadingMethod, NoHeadingSearch};
pub(super) use monitor::BetterHeading;

use super::config::GpsModel;
use super::history::History;
use super::scalar::Scalar;
use super::square;
use crate::earth::{Geodetic, STANDARD_GRAVITY_MPS2};
use crate::frames::{Body, Ned, Rotation, Vector, wrap_angle};
use crate::gps::Fix;
use crate::ins::Start;
use crate::time::Time;
use guess::{Felt, Guess, Measured, Prior, Surprise};
use monitor::Judgement;

/// Number of guesses.
const GUESSES: usize = 12;
/// One-sigma of the direction of a guess at its start, rad: neighbours overlap at one sigma.
const GUESS_SIGMA_RAD: f64 = core::f64::consts::PI / GUESSES as f64;
/// Gravity, m/s².
const GRAVITY_MPS2: f32 = STANDARD_GRAVITY_MPS2 as f32;
/// One-sigmas at the start of a monitor: of the level, as an acceleration, m/s² (4°), and of the gyro bias, rad/s.
const PRIOR: Prior = Prior { level_mps2: [0.0; 2], level_sigma_mps2: 0.7, bias_sigma_radps: 0.0 };
/// Least weight of a guess: none is ever ruled out.
const LEAST_WEIGHT: f64 = 1e-9;
/// Random walks that a monitor allows beyond the noise of the sensors: of the level and direction, rad/√s, and of the
/// velocity, m/s/√s. Without them it would blame a heading for errors that the guesses have no states for.
const ANGLE_WALK_RAD: f64 = 0.0035;
const VELOCITY_WALK_MPS: f64 = 0.1;
/// Largest one-sigma over all guesses at which they agree, rad (8°).
const AGREED_RAD: f64 = 0.14;
/// Largest squared normalised innovation that a heading explains (five one-sigmas): beyond it for every guess, receiver
/// or inertial unit is in error, and the guesses start again.
const UNEXPLAINED: f32 = 25.0;
/// Memory of the information on the direction, s.
const EVIDENCE_S: f64 = 60.0;
/// Longest interval between fixes, s; the guesses start again after a longer one.
const LONGEST_S: f64 = 5.0;
/// Least speed, m/s, at fixes one second apart, at which agreement alone proves a heading; it grows with the square root
/// of the time between fixes. A vehicle that is carried or turned by hand moves its unit in ways that slow fixes miss.
const PROVEN_MPS: f64 = 5.0;
/// Time of agreement that proves the heading of a slower vehicle, s.
const PROVEN_S: f64 = 5.0;
/// Share of the information on that heading from motion within a guess: the guesses start with 0.29 of it.
const PROVEN_EVIDENCE: f64 = 0.25;
/// One-sigma of a heading that is not proven, at least, rad: three of it are the circle.
const UNPROVEN_RAD: f64 = 1.05;
/// Least likelihood of a heading of two antennas, as a share of that of the best guess.
const LEAST_SHARE: f64 = 0.01;
/// Factor on the one-sigma of a fix: the guesses have no states for its slow errors.
const WHITENED: f64 = 1.7;
/// Information share of a velocity from the difference of two positions: neighbours share a position.
const DIFFERENCE_SHARE: f64 = 0.5;

/// A bank of guesses at the heading.
#[derive(Clone, Debug)]
pub struct HeadingSearch<T = f64> {
    guesses: [Guess; GUESSES],
    body_to_level: Rotation<Body, Ned, T>,
    felt_mps: Vector<Ned, T>,
    felt_s: T,
    /// Integral of the direction cosines from body to level axes, s, and variances by sensor noise, as `felt_mps`.
    turned_s: [[T; 3]; 3],
    variances: [T; 2],
    /// What was felt between the last fix and the last sample before it arrived.
    since_fix: Felt,
    /// Time and position of the fix that the guesses hold at.
    last_fix: Option<(Time, Geodetic)>,
    /// Whether the heading is monitored, not searched.
    is_monitor: bool,
    /// One-sigma of the level frame's direction about that of the filter, rad; infinite where unknown.
    prior_sigma_rad: f64,
    prior: Prior,
    /// Whether a speed alone has proven that the motion can tell a heading.
    is_fast: bool,
    /// Time of the first of the last fixes at which the guesses agreed on a heading that motion has shown.
    agreed_since: Option<Time>,
    /// Information of recent fixes on the direction, rad⁻².
    evidence: f32,
    judgement: Judgement,
}

/// Motion by the best guess, with one-sigmas over all guesses.
#[derive(Clone, Copy, Debug)]
pub struct GuessedMotion<T> {
    /// Attitude.
    pub body_to_ned: Rotation<Body, Ned, T>,
    /// One-sigma of roll and pitch, rad.
    pub tilt_sigma_rad: f64,
    /// One-sigma of the heading, rad.
    pub heading_sigma_rad: f64,
    /// Velocity north and east, m/s.
    pub velocity_mps: [f64; 2],
    /// One-sigma of each, m/s.
    pub velocity_sigma_mps: [f64; 2],
    /// Clockwise turn of the heading since the start of the search that the vehicle did not make, rad.
    pub turn_rad: f64,
    /// Whether the heading is found.
    pub is_found: bool,
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
    /// A bank without guesses.
    #[inline(always)]
    const fn empty() -> Self {
        Self {
            guesses: [Guess::NONE; GUESSES],
            body_to_level: Rotation::IDENTITY,
            felt_mps: Vector::ZERO,
            felt_s: T::ZERO,
            turned_s: [[T::ZERO; 3]; 3],
            variances: [T::ZERO; 2],
            since_fix: Felt::NONE,
            last_fix: None,
            is_monitor: true,
            prior_sigma_rad: f64::INFINITY,
            prior: PRIOR,
            is_fast: false,
            agreed_since: None,
            evidence: 0.0,
            judgement: Judgement::NONE,
        }
    }

    /// Starts again at the next fix, from a level attitude.
    // In place: a new value would be built on the stack first.
    fn restart(&mut self, body_to_level: Rotation<Body, Ned, T>) {
        self.guesses.fill(Guess::NONE);
        self.body_to_level = body_to_level;
        self.felt_mps = Vector::ZERO;
        self.felt_s = T::ZERO;
        self.turned_s = [[T::ZERO; 3]; 3];
        self.variances = [T::ZERO; 2];
        self.since_fix = Felt::NONE;
        self.last_fix = None;
        self.is_monitor = true;
        self.prior_sigma_rad = f64::INFINITY;
        self.prior = PRIOR;
        self.is_fast = false;
        self.agreed_since = None;
        self.evidence = 0.0;
        self.judgement = Judgement::NONE;
    }

    /// Starts a search from a start that is open about `axis`, the direction of gravity less acceleration.
    ///
    /// # Source
    /// Equation (H1) of docs/equations.md.
    fn start(&mut self, start: &Start, axis: Vector<Ned>, bias_sigma_radps: f64) {
        let [north, east, down] = axis.to_array();
        // The level frame takes the felt force for gravity; its tilt error is what the vehicle accelerates by.
        let tilt = Vector::new(-east, north, 0.0);
        let level = if tilt.norm() > 0.0 {
            tilt * (-Scalar::atan2(tilt.norm(), down) / tilt.norm())
        } else {
            Vector::ZERO
        };
        self.restart(start.state.body_to_ned.turned_in_to(level).cast());
        self.is_monitor = false;
        let scale = -STANDARD_GRAVITY_MPS2 / down.max(0.1);
        let [tilt_rad, ..] = start.attitude_sigma_rad.to_array();
        self.prior = Prior {
            level_mps2: [north, east].map(|part| (scale * part) as f32),
            level_sigma_mps2: GRAVITY_MPS2 * tilt_rad as f32,
            bias_sigma_radps: start.gyro_bias_sigma_radps.unwrap_or(bias_sigma_radps) as f32,
        };
    }

    /// Starts a search about a heading of one-sigma `sigma_rad`.
    fn start_about(&mut self, body_to_ned: Rotation<Body, Ned, T>, sigma_rad: f64) {
        self.restart(body_to_ned);
        self.prior_sigma_rad = sigma_rad.max(f64::MIN_POSITIVE);
        self.is_fast = true;
        self.is_monitor = false;
    }

    /// Adds an inertial sample, less bias, whose noise adds `variances` to angle, rad², and velocity, (m/s)².
    fn feel(
        &mut self,
        rate_radps: Vector<Body, T>,
        force_mps2: Vector<Body, T>,
        variances: [T; 2],
        interval_s: T,
    ) {
        let turn_rad = rate_radps * interval_s;
        let halfway = self.body_to_level.turned_in_from(turn_rad * T::of(0.5));
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
        self.body_to_level = self.body_to_level.turned_in_from(turn_rad);
    }

    /// What was felt until a fix, of which `later_mps` over `later_s` came after it; the latter is left for the next fix.
    fn felt_until(&mut self, later_mps: Vector<Ned, T>, later_s: T) -> Felt {
        let felt_s = (self.felt_s - later_s).max(T::ZERO);
        let share = if self.felt_s > T::ZERO { felt_s / self.felt_s } else { T::ONE };
        let single = |value: T| value.wide() as f32;
        let part = |share: T, velocity_mps: Vector<Ned, T>, duration_s: T| Felt {
            velocity_mps: level_parts(velocity_mps),
            duration_s: single(duration_s),
            turned_s: self.turned_s.map(|row| row.map(|turned_s| single(turned_s * share))),
            angle_variance: single(self.variances[0] * share),
            velocity_variance: single(self.variances[1] * share),
        };
        let mut felt = part(share, self.felt_mps - later_mps, felt_s);
        if self.is_monitor {
            felt.angle_variance += square(ANGLE_WALK_RAD) as f32 * felt.duration_s;
            felt.velocity_variance += square(VELOCITY_WALK_MPS) as f32 * felt.duration_s;
        }
        let rest = T::ONE - share;
        self.since_fix = part(rest, later_mps, later_s);
        (self.felt_mps, self.felt_s) = (later_mps, later_s);
        self.turned_s = self.turned_s.map(|row| row.map(|turned_s| turned_s * rest));
        self.variances = self.variances.map(|variance| variance * rest);
        felt
    }

    /// Weighs the guesses by a fix, which may hold at an earlier moment within the `history` of the same samples.
    ///
    /// # Source
    /// Equations (H2), (H3) and (H5) of docs/equations.md.
    fn fix(
        &mut self,
        fix: &Fix,
        sigmas: ([f64; 3], [f64; 3]),
        gps: &GpsModel,
        history: &History<T>,
    ) {
        let Some((later_mps, later_s)) = history.felt_since(fix.time, self.body_to_level) else {
            return;
        };
        let felt = self.felt_until(later_mps, later_s);
        let before = self.last_fix.replace((fix.time, fix.position));
        let interval_s = before.map(|(time, _)| fix.time - time);
        let interval_s = interval_s.filter(|s| *s > 0.0 && *s <= LONGEST_S);
        let mut measured = measured(fix, sigmas, gps, before.zip(interval_s));
        if self.is_monitor && !measured.is_mean {
            let usual = fix.velocity_sigma_mps.map_or(gps.velocity_sigma_mps(), Vector::to_array);
            measured.variance = measured.variance.max(square(WHITENED * usual[0]) as f32);
        }
        let Some(interval_s) = interval_s.filter(|_| self.has_begun()) else {
            self.begin(&measured);
            return;
        };
        let speed_mps = Scalar::hypot(measured.velocity_mps[0], measured.velocity_mps[1]);
        let least_mps = PROVEN_MPS * Scalar::sqrt(interval_s.clamp(0.05, 10.0));
        self.is_fast |= f64::from(speed_mps - 2.0 * Scalar::sqrt(measured.variance)) > least_mps
            || (!measured.is_mean && f64::from(speed_mps) > least_mps);
        let share = information_share(fix, gps, interval_s.clamp(0.05, 10.0));
        let mut surprises = [0.0; GUESSES];
        let (mut least_squares, mut told) = (f32::INFINITY, 0.0);
        for (guess, surprise) in self.guesses.iter_mut().zip(&mut surprises) {
            let before = guess.direction_variance();
            let Surprise { squares, logarithms } = guess.step(&felt, &measured);
            let after = guess.direction_variance();
            told += guess.weight * f64::from(((before - after) / (before * after)).max(0.0));
            *surprise = share * f64::from(squares + logarithms);
            least_squares = least_squares.min(squares);
        }
        if least_squares > UNEXPLAINED {
            self.begin(&measured);
            return;
        }
        if !self.guesses.iter().all(Guess::is_sound) {
            self.restart(self.body_to_level);
            return;
        }
        self.evidence *= libm::exp(-interval_s / EVIDENCE_S) as f32;
        self.evidence += (share * told) as f32;
        self.weigh(&surprises);
        self.level();
        let agrees = self.has_evidence(PROVEN_EVIDENCE) && self.direction().1 < AGREED_RAD;
        self.agreed_since = if agrees { self.agreed_since.or(Some(fix.time)) } else { None };
    }

    /// Whether the guesses hold at a fix.
    fn has_begun(&self) -> bool {
        self.guesses.iter().any(|guess| guess.weight > 0.0)
    }

    /// Starts the guesses at a fix.
    fn begin(&mut self, measured: &Measured) {
        let mut sum = 0.0;
        for (number, guess) in self.guesses.iter_mut().enumerate() {
            let direction_rad = wrap_angle(2.0 * GUESS_SIGMA_RAD * number as f64);
            let off = direction_rad / self.prior_sigma_rad;
            let weight = libm::exp(-0.5 * square(off)).max(LEAST_WEIGHT);
            *guess = Guess::start(direction_rad as f32, weight, measured, &self.prior);
            sum += weight;
        }
        for guess in &mut self.guesses {
            guess.weight /= sum;
        }
        self.prior = Prior { bias_sigma_radps: self.prior.bias_sigma_radps, ..PRIOR };
        (self.agreed_since, self.evidence) = (None, 0.0);
        self.judgement.forget();
    }

    /// Weighs the guesses by minus twice the logarithms of their likelihoods.
    fn weigh(&mut self, surprises: &[f64; GUESSES]) {
        let least = surprises.iter().fold(f64::INFINITY, |a, &b| a.min(b));
        let mut sum = 0.0;
        for (guess, surprise) in self.guesses.iter_mut().zip(surprises) {
            guess.weight *= libm::exp(-0.5 * (surprise - least).min(50.0));
            sum += guess.weight;
        }
        for guess in &mut self.guesses {
            guess.weight = (guess.weight / sum).max(LEAST_WEIGHT);
        }
    }

    /// Turns the level frame by the mean tilt error of the guesses.
    fn level(&mut self) {
        let mut off = [0.0; 2];
        for guess in &self.guesses {
            for (off, level) in off.iter_mut().zip(guess.level_mps2()) {
                *off += guess.weight as f32 * level;
            }
        }
        for guess in &mut self.guesses {
            guess.level_by(off);
        }
        self.body_to_level = self.body_to_level.turned_in_to(tilt_rad(off)).renormalised();
    }

    /// The guess of the largest weight.
    fn best(&self) -> Option<&Guess> {
        self.guesses.iter().max_by(|a, b| a.weight.total_cmp(&b.weight))
    }

    /// Direction of the level frame and its one-sigma over all guesses, rad.
    ///
    /// # Source
    /// Equation (H4) of docs/equations.md.
    fn direction(&self) -> (f64, f64) {
        let middle = self.best().map_or(0.0, |best| f64::from(best.direction_rad()));
        let (mut weights, mut off, mut variance) = (0.0, 0.0, 0.0);
        for guess in &self.guesses {
            let apart = wrap_angle(f64::from(guess.direction_rad()) - middle);
            weights += guess.weight;
            off += guess.weight * apart;
            variance += guess.weight * (f64::from(guess.direction_variance()) + square(apart));
        }
        let off = off / weights;
        (middle + off, Scalar::sqrt((variance / weights - square(off)).max(0.0)))
    }

    /// Whether the fixes of recent motion have given this share of the information on an agreed direction.
    fn has_evidence(&self, share: f64) -> bool {
        f64::from(self.evidence) * square(AGREED_RAD) > share
    }

    /// Gyro bias of the best guess beyond that of the filter, rad/s, and its one-sigmas over all guesses: it is left out of
    /// the guesses.
    fn take_bias(&mut self) -> Option<(Vector<Body, T>, [f64; 3])> {
        let best = self.best().filter(|_| self.has_begun())?.bias_radps();
        let (mut variances, mut weights) = ([0.0; 3], 0.0);
        for guess in &self.guesses {
            for ((sum, (bias, variance)), (middle, _)) in
                variances.iter_mut().zip(guess.bias_radps()).zip(best)
            {
                *sum += guess.weight * f64::from(variance + square(bias - middle));
            }
            weights += guess.weight;
        }
        let bias_radps = best.map(|(bias, _)| bias);
        for guess in &mut self.guesses {
            guess.correct_bias(bias_radps);
        }
        let [p, q, r] = bias_radps.map(|bias| T::of(f64::from(bias)));
        Some((Vector::new(p, q, r), variances.map(|sum| Scalar::sqrt(sum / weights))))
    }

    /// Motion by the best guess now; `None` before the first fix.
    ///
    /// # Source
    /// Equation (H4) of docs/equations.md.
    fn motion(&self) -> Option<GuessedMotion<T>> {
        let (time, _) = self.last_fix?;
        let best = self.best().filter(|_| self.has_begun())?;
        let (velocity_mps, level) = (best.velocity_after(&self.since_fix), best.level_mps2());
        let mut spread = [0.0; 4];
        let [mut weights, mut own_velocity, mut own_level] = [0.0; 3];
        for guess in &self.guesses {
            let there = guess.velocity_after(&self.since_fix);
            let apart = [
                there[0] - velocity_mps[0],
                there[1] - velocity_mps[1],
                guess.level_mps2()[0] - level[0],
                guess.level_mps2()[1] - level[1],
            ];
            for (sum, apart) in spread.iter_mut().zip(apart) {
                *sum += guess.weight * square(f64::from(apart));
            }
            own_velocity += guess.weight * f64::from(guess.velocity_variance());
            own_level += guess.weight * f64::from(guess.level_variance());
            weights += guess.weight;
        }
        let [north, east, x, y] = spread;
        let sigma = |variance: f64| Scalar::sqrt(variance / weights);
        let (direction_rad, agreed_rad) = self.direction();
        let apart = wrap_angle(f64::from(best.direction_rad()) - direction_rad);
        let is_proven =
            self.is_fast || self.agreed_since.is_some_and(|since| time - since >= PROVEN_S);
        let least_rad = if is_proven { 0.0 } else { UNPROVEN_RAD };
        let turn = Vector::new(T::ZERO, T::ZERO, T::of(f64::from(best.direction_rad())));
        let body_to_level = self.body_to_level.turned_in_to(tilt_rad(level));
        Some(GuessedMotion {
            body_to_ned: body_to_level.turned_in_to(turn).renormalised(),
            tilt_sigma_rad: sigma(own_level + 0.5 * (x + y)) / STANDARD_GRAVITY_MPS2,
            heading_sigma_rad: Scalar::hypot(agreed_rad, apart)
                .min(core::f64::consts::PI)
                .max(least_rad),
            velocity_mps: velocity_mps.map(f64::from),
            velocity_sigma_mps: [sigma(own_velocity + north), sigma(own_velocity + east)],
            turn_rad: wrap_angle(f64::from(best.direction_rad())),
            is_found: is_proven && agreed_rad < AGREED_RAD,
        })
    }

    /// Motion by the guess whose attitude points a baseline of the body nearest to `heading_rad`, clockwise from north;
    /// `None` where the fixes deny it.
    fn motion_at(&self, baseline: Vector<Body>, heading_rad: f64) -> Option<GuessedMotion<T>> {
        let mut motion = self.motion()?;
        let best = self.best()?;
        let pointed = (motion.body_to_ned * baseline.cast()).azimuth_rad().wide();
        let turn_rad = wrap_angle(heading_rad - pointed);
        let direction_rad = f64::from(best.direction_rad()) + turn_rad;
        let off = |guess: &&Guess| {
            libm::fabs(wrap_angle(f64::from(guess.direction_rad()) - direction_rad))
        };
        let nearest = self.guesses.iter().min_by(|a, b| off(a).total_cmp(&off(b)))?;
        if nearest.weight < LEAST_SHARE * best.weight {
            return None;
        }
        let turn = Vector::new(T::ZERO, T::ZERO, T::of(turn_rad));
        motion.body_to_ned = motion.body_to_ned.turned_in_to(turn);
        motion.velocity_mps = nearest.velocity_after(&self.since_fix).map(f64::from);
        motion.turn_rad = wrap_angle(direction_rad);
        motion.heading_sigma_rad = GUESS_SIGMA_RAD;
        Some(motion)
    }
}

/// North and east, or the two level axes, of a vector.
fn level_parts<T: Scalar>(vector: Vector<Ned, T>) -> [f32; 2] {
    let [x, y, _] = vector.to_array();
    [x, y].map(|part| part.wide() as f32)
}

/// The turn by which a level frame loses the tilt error that acts as this acceleration.
fn tilt_rad<T: Scalar>([x, y]: [f32; 2]) -> Vector<Ned, T> {
    let turn = |part: f32| T::of(f64::from(part / GRAVITY_MPS2));
    Vector::new(turn(y), turn(-x), T::ZERO)
}

/// The horizontal velocity of a fix, or the mean one since the fix `before`, an interval, s, earlier.
fn measured(
    fix: &Fix,
    (position_m, velocity_mps): ([f64; 3], [f64; 3]),
    gps: &GpsModel,
    before: Option<((Time, Geodetic), f64)>,
) -> Measured {
    if let Some([north, east]) = fix.horizontal_velocity_mps {
        let [sigma_mps, ..] = velocity_mps;
        let sigma_mps = WHITENED * sigma_mps.max(gps.velocity_floor_mps);
        return Measured {
            velocity_mps: [north as f32, east as f32],
            variance: square(sigma_mps) as f32,
            is_mean: false,
        };
    }
    let Some(((_, place), interval_s)) = before else {
        return Measured { velocity_mps: [0.0; 2], variance: square(UNKNOWN_MPS), is_mean: true };
    };
    let moved: Vector<Ned> = fix.position.displacement_from(&place);
    let [sigma_m, ..] = position_m;
    let share = square(gps.position_wander_share.min(1.0));
    let wandered = share * (2.0 * interval_s / gps.position_wander_time_s).min(2.0);
    let variance =
        (2.0 * (1.0 - share) + wandered) * square(sigma_m) + 2.0 * square(gps.position_floor_m);
    let [north, east, _] = (moved * (1.0 / interval_s)).to_array();
    Measured {
        velocity_mps: [north as f32, east as f32],
        variance: (variance / square(interval_s)) as f32,
        is_mean: true,
    }
}

/// One-sigma of the velocity at a first fix that has none, m/s.
const UNKNOWN_MPS: f32 = 10.0;

/// The share of its information by which a fix weighs the guesses. A share s of the one-sigma that wanders with
/// correlation time τ weighs, at fixes Δt apart, like white noise of variance s² 2τ/Δt: without this a vehicle at rest
/// would find a heading in the wander of its GPS.
///
/// # Source
/// Equation (H3) of docs/equations.md.
fn information_share(fix: &Fix, gps: &GpsModel, interval_s: f64) -> f64 {
    if fix.horizontal_velocity_mps.is_none() {
        return DIFFERENCE_SHARE;
    }
    let wander = square(gps.velocity_wander_share) * 2.0 * gps.velocity_wander_time_s / interval_s;
    (square(WHITENED) / (1.0 + wander)).min(1.0)
}
