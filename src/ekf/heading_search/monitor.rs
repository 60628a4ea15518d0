//! A heading watched from outside: whether the fixes bear it out, for as long as the filter runs.
//!
//! One attitude, levelled by what the fixes say of it and turned by the gyros alone, resolves the
//! specific force in axes that are level but point anywhere. Twelve guesses at where they point each
//! carry a velocity, that direction and the level's error from fix to fix; only near the right one does
//! what was felt add up to what the fixes say. Nothing else knows of the heading: neither the filter
//! nor its magnetometer can talk the guesses into their own mistake.
//!
//! # Source
//! Sectors and weights are those of the search, equations (H2) to (H4) of docs/equations.md, over the
//! states of equation (H5). The bank of small filters beside the large one is the idea of P. Riseborough's
//! EKF-GSF.
#![expect(clippy::indexing_slicing, reason = "indices below the constant lengths of the arrays")]

use super::super::config::GpsModel;
use super::super::history::History;
use super::super::scalar::Scalar;
use super::super::square;
use super::{SECTOR_SIGMA_RAD, SECTORS, WHITENED, information_shares};
use crate::earth::STANDARD_GRAVITY_MPS2;
use crate::frames::{Body, Ned, Rotation, Vector, wrap_angle};
use crate::gps::Fix;
use crate::time::Time;

/// States: velocity north and east, direction of the level axes, error of the level as an acceleration in them; and
/// where the last two begin.
const STATES: usize = 5;
const DIRECTION: usize = 2;
const LEVEL: usize = 3;

/// One-sigma of the level at the start, as an acceleration, m/s²: 4°.
const LEVEL_SIGMA_MPS2: f64 = 0.7;
/// By how much the level wanders, m/s²/√s, as gyro biases do it: 0.2°/√s.
const LEVEL_WALK_MPS2: f64 = 0.035;
/// By how much the direction wanders, rad/√s.
const DIRECTION_WALK_RAD: f64 = 0.004;
/// By how much vibration moves the velocity, m/s/√s.
const VELOCITY_WALK_MPS: f64 = 0.1;
/// Share of a change of velocity that times which do not agree leave.
const TIMING: f64 = 0.1;
/// No guess is ever ruled out.
const LEAST_WEIGHT: f64 = 1e-9;
/// The guesses agree when their one-sigma is below this, rad (8°).
const AGREED_RAD: f64 = 0.14;
/// A heading further off than this, rad (25°), and than so many one-sigmas, is wrong.
const WRONG_RAD: f64 = 0.44;
const WRONG_SIGMAS: f64 = 4.0;
/// A heading further off than this, rad (5°), and than so many one-sigmas of both, is in doubt.
const DOUBTED_RAD: f64 = 0.09;
const DOUBTED_SIGMAS: f64 = 2.5;
/// For at least this long, s, and so many fixes.
const WRONG_S: f64 = 5.0;
const WRONG_FIXES: u8 = 4;
/// What not even the best guess is within, as a squared normalised innovation (five one-sigmas), no heading
/// explains: the receiver or the inertial unit errs, and the guesses begin anew.
const UNEXPLAINED: f64 = 25.0;
/// Memory of what turns and changes of speed told of the direction, s.
const EVIDENCE_S: f64 = 60.0;
/// Fixes further apart than this, s, begin anew.
const LONGEST_S: f64 = 5.0;

/// A guess at the direction of the level axes.
#[derive(Clone, Copy, Debug)]
struct Guess<T> {
    weight: f64,
    state: [T; STATES],
    covariance: [[T; STATES]; STATES],
}

/// The guesses, and what was felt since the last fix.
#[derive(Clone, Debug)]
pub(super) struct Monitor<T> {
    guesses: [Guess<T>; SECTORS],
    body_to_level: Rotation<Body, Ned, T>,
    felt_mps: Vector<Ned, T>,
    felt_s: T,
    /// The fix that the guesses hold at; none before the first.
    last_fix: Option<Time>,
    /// Since when, and at how many fixes, the heading has been wrong.
    wrong_since: Option<Time>,
    wrong_fixes: u8,
    /// Whether the guesses agree with the heading, and motion of late was enough to tell.
    bears_out: bool,
    /// What the fixes of late have told of the direction, rad⁻².
    evidence: f32,
}

/// A heading that the fixes bear out, where that of the filter is wrong or in doubt.
#[derive(Clone, Copy, Debug)]
pub struct BetterHeading {
    /// By how much the filter's heading has to turn, clockwise, rad.
    pub turn_rad: f64,
    /// One-sigma of the heading then, rad.
    pub sigma_rad: f64,
    /// Whether it is so far off that it has to be replaced; else the filter has to be less sure of its own.
    pub replaces: bool,
}

impl<T: Scalar> Guess<T> {
    const NONE: Self =
        Self { weight: 0.0, state: [T::ZERO; STATES], covariance: [[T::ZERO; STATES]; STATES] };

    /// A guess that starts at a fix.
    fn start(direction_rad: f64, velocity_mps: [f64; 2], sigma_mps: f64) -> Self {
        let mut guess = Self { weight: 1.0 / SECTORS as f64, ..Self::NONE };
        guess.state = [velocity_mps[0], velocity_mps[1], direction_rad, 0.0, 0.0].map(T::of);
        let (velocity, level) = (square(sigma_mps), square(LEVEL_SIGMA_MPS2));
        let sigmas = [velocity, velocity, square(SECTOR_SIGMA_RAD), level, level];
        for (state, variance) in sigmas.into_iter().enumerate() {
            guess.covariance[state][state] = T::of(variance);
        }
        guess
    }

    /// Equation (H5) of docs/equations.md.
    fn predict(&mut self, felt_mps: [T; 2], felt_s: T) {
        let (sin, cos) = self.state[DIRECTION].sincos();
        let x = felt_mps[0] + self.state[LEVEL] * felt_s;
        let y = felt_mps[1] + self.state[LEVEL + 1] * felt_s;
        let change = [cos * x - sin * y, sin * x + cos * y];
        // F is the identity but for the two rows of velocity.
        let rows =
            [[-change[1], cos * felt_s, -sin * felt_s], [change[0], sin * felt_s, cos * felt_s]];
        let p = &mut self.covariance;
        for (axis, row) in rows.iter().enumerate() {
            let moved: [T; STATES] = core::array::from_fn(|column| {
                row[0] * p[DIRECTION][column]
                    + row[1] * p[DIRECTION + 1][column]
                    + row[2] * p[DIRECTION + 2][column]
            });
            for (value, moved) in p[axis].iter_mut().zip(moved) {
                *value += moved;
            }
        }
        for line in p.iter_mut() {
            for (axis, row) in rows.iter().enumerate() {
                line[axis] += row[0] * line[DIRECTION]
                    + row[1] * line[DIRECTION + 1]
                    + row[2] * line[DIRECTION + 2];
            }
        }
        let shaken = T::of(square(VELOCITY_WALK_MPS)) * felt_s
            + T::of(square(TIMING)) * (square(felt_mps[0]) + square(felt_mps[1]));
        let level = T::of(square(LEVEL_WALK_MPS2)) * felt_s;
        let noise = [shaken, shaken, T::of(square(DIRECTION_WALK_RAD)) * felt_s, level, level];
        for (state, variance) in noise.into_iter().enumerate() {
            p[state][state] += variance;
        }
        self.state[0] += change[0];
        self.state[1] += change[1];
    }

    /// Takes in a velocity; gives the squared normalised innovations, and the logarithms of their variances.
    fn update(&mut self, velocity_mps: [T; 2], variance: T) -> [T; 2] {
        let [mut squares, mut logarithms] = [T::ZERO; 2];
        for (axis, measured) in velocity_mps.into_iter().enumerate() {
            let seen: [T; STATES] = core::array::from_fn(|state| self.covariance[state][axis]);
            let total = seen[axis] + variance;
            let innovation = measured - self.state[axis];
            squares += square(innovation) / total;
            logarithms += total.ln();
            for row in 0..STATES {
                self.state[row] += seen[row] / total * innovation;
                for column in 0..STATES {
                    self.covariance[row][column] -= seen[row] * seen[column] / total;
                }
            }
        }
        [squares, logarithms]
    }

    /// Whether rounding has left it a covariance.
    fn is_sound(&self) -> bool {
        self.state.iter().all(|value| value.is_finite())
            && (0..STATES).all(|state| self.covariance[state][state] >= T::ZERO)
    }
}

impl<T: Scalar> Monitor<T> {
    /// A monitor that has heard nothing.
    // No constant, which would be copied from where constants are.
    #[inline(always)]
    pub const fn none() -> Self {
        Self {
            guesses: [Guess::NONE; SECTORS],
            body_to_level: Rotation::IDENTITY,
            felt_mps: Vector::ZERO,
            felt_s: T::ZERO,
            last_fix: None,
            wrong_since: None,
            wrong_fixes: 0,
            bears_out: false,
            evidence: 0.0,
        }
    }

    /// Begins anew at the next fix, from a level attitude.
    // In place: put together as a whole it would stand on the stack first.
    pub fn restart(&mut self, body_to_level: Rotation<Body, Ned, T>) {
        self.guesses.fill(Guess::NONE);
        self.body_to_level = body_to_level;
        self.felt_mps = Vector::ZERO;
        self.felt_s = T::ZERO;
        self.last_fix = None;
        self.wrong_since = None;
        self.wrong_fixes = 0;
        self.bears_out = false;
        self.evidence = 0.0;
    }

    /// Takes in what was felt over a sample's interval, less bias.
    pub fn feel(
        &mut self,
        rate_radps: Vector<Body, T>,
        force_mps2: Vector<Body, T>,
        interval_s: T,
    ) {
        let turn_rad = rate_radps * interval_s;
        let halfway = self.body_to_level.turned_in_from(turn_rad * T::of(0.5));
        self.felt_mps += halfway * force_mps2 * interval_s;
        self.felt_s += interval_s;
        self.body_to_level = self.body_to_level.turned_in_from(turn_rad);
    }

    /// Takes in a fix, which may hold at an earlier moment, for as long as the `history` of the same samples reaches.
    pub fn fix(&mut self, fix: &Fix, gps: &GpsModel, history: &History<T>) {
        let Some(velocity_mps) = fix.horizontal_velocity_mps else { return };
        let Some((later_mps, later_s)) = history.felt_since(fix.time, self.body_to_level) else {
            return;
        };
        let [sigma_mps, ..] =
            fix.velocity_sigma_mps.map_or(gps.velocity_sigma_mps(), Vector::to_array);
        let sigma_mps = WHITENED * sigma_mps.max(gps.velocity_floor_mps);
        let interval_s = self.last_fix.map(|last| fix.time - last);
        let felt_mps = (self.felt_mps - later_mps).to_array();
        let felt_s = (self.felt_s - later_s).max(T::ZERO);
        (self.felt_mps, self.felt_s) = (later_mps, later_s);
        let Some(interval_s) = interval_s.filter(|s| (0.0..=LONGEST_S).contains(s)) else {
            self.begin(fix.time, velocity_mps, sigma_mps);
            return;
        };
        self.last_fix = Some(fix.time);
        let [_, share] = information_shares(fix, gps, interval_s.clamp(0.05, 10.0));
        let variance = square(T::of(sigma_mps));
        let mut surprises = [0.0; SECTORS];
        let (mut least_squares, mut told) = (f64::INFINITY, T::ZERO);
        for (guess, surprise) in self.guesses.iter_mut().zip(&mut surprises) {
            guess.predict([felt_mps[0], felt_mps[1]], felt_s);
            let before = guess.covariance[DIRECTION][DIRECTION];
            let [squares, logarithms] = guess.update(velocity_mps.map(T::of), variance);
            let after = guess.covariance[DIRECTION][DIRECTION];
            told += T::of(guess.weight) * (before - after) / (before * after);
            *surprise = share * (squares + logarithms).wide();
            least_squares = least_squares.min(squares.wide());
        }
        if least_squares > UNEXPLAINED {
            self.begin(fix.time, velocity_mps, sigma_mps);
            return;
        }
        if !self.guesses.iter().all(Guess::is_sound) {
            self.restart(self.body_to_level);
            return;
        }
        self.evidence *= libm::exp(-interval_s / EVIDENCE_S) as f32;
        self.evidence += (share * told.wide()) as f32;
        let least = surprises.iter().fold(f64::INFINITY, |a, &b| a.min(b));
        let mut sum = 0.0;
        for (guess, surprise) in self.guesses.iter_mut().zip(surprises) {
            guess.weight *= libm::exp(-0.5 * (surprise - least).min(50.0));
            sum += guess.weight;
        }
        for guess in &mut self.guesses {
            guess.weight = (guess.weight / sum).max(LEAST_WEIGHT);
        }
        self.level();
    }

    fn begin(&mut self, time: Time, velocity_mps: [f64; 2], sigma_mps: f64) {
        for (sector, guess) in self.guesses.iter_mut().enumerate() {
            let direction_rad = 2.0 * SECTOR_SIGMA_RAD * sector as f64;
            *guess = Guess::start(direction_rad, velocity_mps, sigma_mps);
        }
        self.last_fix = Some(time);
        (self.wrong_fixes, self.bears_out, self.evidence) = (0, false, 0.0);
    }

    /// Turns the level axes by what the guesses agree they are off.
    fn level(&mut self) {
        let mut off = [T::ZERO; 2];
        for guess in &self.guesses {
            let weight = T::of(guess.weight);
            off[0] += weight * guess.state[LEVEL];
            off[1] += weight * guess.state[LEVEL + 1];
        }
        for guess in &mut self.guesses {
            guess.state[LEVEL] -= off[0];
            guess.state[LEVEL + 1] -= off[1];
        }
        let gravity_mps2 = T::of(STANDARD_GRAVITY_MPS2);
        let turn = Vector::new(off[1] / gravity_mps2, -off[0] / gravity_mps2, T::ZERO);
        self.body_to_level = self.body_to_level.turned_in_to(turn).renormalised();
    }

    /// The direction of the level axes and its one-sigma, rad, over all guesses.
    fn direction(&self) -> (f64, f64) {
        let best = self.guesses.iter().max_by(|a, b| a.weight.total_cmp(&b.weight));
        let middle = best.map_or(0.0, |best| best.state[DIRECTION].wide());
        let (mut weights, mut off, mut variance) = (0.0, 0.0, 0.0);
        for guess in &self.guesses {
            let apart = wrap_angle(guess.state[DIRECTION].wide() - middle);
            weights += guess.weight;
            off += guess.weight * apart;
            variance +=
                guess.weight * (guess.covariance[DIRECTION][DIRECTION].wide() + square(apart));
        }
        let off = off / weights;
        (middle + off, Scalar::sqrt((variance / weights - square(off)).max(0.0)))
    }

    /// By how much an attitude's heading has to turn, clockwise, and one-sigma, rad, by what the guesses
    /// agree on; `None` while they do not.
    pub fn off(&self, body_to_ned: Rotation<Body, Ned, T>) -> Option<BetterHeading> {
        self.last_fix?;
        let (direction_rad, sigma_rad) = self.direction();
        let [north, east, _] = (body_to_ned * self.body_to_level.inverse()).rows();
        let own_rad = (east[0] - north[1]).atan2(north[0] + east[1]).wide();
        let turn_rad = wrap_angle(direction_rad - own_rad);
        let replaces = libm::fabs(turn_rad) > WRONG_RAD.max(WRONG_SIGMAS * sigma_rad);
        (sigma_rad < AGREED_RAD).then_some(BetterHeading { turn_rad, sigma_rad, replaces })
    }

    /// The better heading, where that of an attitude, of one-sigma `own_sigma_rad`, is wrong or in doubt and
    /// has been for a while.
    pub fn judge(
        &mut self,
        time: Time,
        body_to_ned: Rotation<Body, Ned, T>,
        own_sigma_rad: T,
    ) -> Option<BetterHeading> {
        let is_doubtful = |off: &BetterHeading| {
            let sigma_rad = Scalar::hypot(off.sigma_rad, own_sigma_rad.wide());
            off.replaces || libm::fabs(off.turn_rad) > DOUBTED_RAD.max(DOUBTED_SIGMAS * sigma_rad)
        };
        let off = self.off(body_to_ned);
        let doubtful = off.filter(is_doubtful);
        self.bears_out = off.is_some()
            && doubtful.is_none()
            && f64::from(self.evidence) * square(AGREED_RAD) > 1.0;
        let Some(better) = doubtful else {
            self.wrong_fixes = 0;
            return None;
        };
        if self.wrong_fixes == 0 {
            self.wrong_since = Some(time);
        }
        self.wrong_fixes = self.wrong_fixes.saturating_add(1);
        let since = self.wrong_since.is_some_and(|since| time - since >= WRONG_S);
        let lasts = since && self.wrong_fixes >= WRONG_FIXES;
        if lasts {
            self.wrong_fixes = 0;
        }
        lasts.then_some(better)
    }

    /// Whether what the vehicle did of late bore out the heading that was [judged](Self::judge) last.
    pub fn bears_out(&self) -> bool {
        self.bears_out
    }
}
