//! Detects a receiver that contradicts itself: no motion connects three successive fixes.
//!
//! Between two fixes the inertial unit measures the change of velocity, and the receiver's own velocities give the
//! change of position. Fixes depart from this prediction once if the receiver jumps. They depart to the same side each
//! time after a bias step, or if the filter has diverged. Departures to alternating sides come from a jammed,
//! reflected or broken receiver. Neither a wrong heading nor a tilt error of ten degrees causes them.

use super::BETWEEN_FIXES_S;
use crate::earth::Geodetic;
use crate::frames::{Ned, Vector};
use crate::gps::Fix;
use crate::matrix::square;
use crate::scalar::Scalar;
use crate::time::Time;

/// Comparison of successive fixes with the motion between them.
#[derive(Clone, Copy, Debug)]
pub(in crate::ekf) struct SelfContradiction<T> {
    last: Option<Reading>,
    /// Change of velocity by specific force since the last fix, m/s.
    felt_mps: Vector<Ned, T>,
    /// Whether samples since the last fix are missing or at full scale, so that `felt_mps` is incomplete.
    in_part: bool,
    unexplained: Unexplained,
    usual_mps: Usual,
    usual_m: Usual,
    /// Largest recent accelerations, horizontal and vertical, m/s².
    agility_mps2: [f32; 2],
    /// Number of recent contradictions minus the number of later usual fixes, 0 to [`MAX_CONTRADICTIONS`].
    contradictions: u8,
    /// Time of the last contradiction.
    contradicted: Time,
    /// Whether a contradiction is proven. Usual fixes end the proof once they have reduced `contradictions` to zero.
    proven: bool,
    /// Last change of the receiver's velocity minus the change measured by the inertial unit, m/s.
    left_mps: [f32; 3],
    /// Sum of these differences since a velocity jump, m/s.
    jump_mps: [f32; 3],
    /// Largest length of that sum, m/s; zero without a jump.
    farthest_mps: f32,
    /// Time of the velocity jump.
    jumped: Time,
}

#[derive(Clone, Copy, Debug)]
struct Reading {
    time: Time,
    position: Geodetic,
    velocity_mps: Option<Vector<Ned>>,
}

/// Unexplained part of a change from fix to fix: of velocity, m/s, and of position, m, NED. Zero within the usual
/// limits.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Unexplained {
    velocity_mps: [f32; 3],
    position_m: [f32; 3],
}

/// Mean squares of a change that the other measurements do not explain: horizontal, of one axis, and vertical, m² or
/// (m/s)². A receiver is judged by its own past: its stated one-sigmas may be too large, and faulty fixes enlarge the
/// learned one-sigmas.
#[derive(Clone, Copy, Debug)]
struct Usual {
    mean_squares: [f32; 2],
    /// Time over which the mean squares were learned, s, at most [`USUAL_S`].
    learned_s: f32,
}

impl Usual {
    const NONE: Self = Self { mean_squares: [0.0; 2], learned_s: 0.0 };

    /// Limits, horizontal and vertical, of a usual change from fix to fix. Each is `agreement`, plus `explained`, plus
    /// [`SIGMAS`] times the stated one-sigma or [`LEARNED`] times the learned root mean square, whichever is less.
    fn limits(
        &self,
        [sigma, _, sigma_down]: [f64; 3],
        agreement: f64,
        explained: [f64; 2],
    ) -> [f64; 2] {
        let mut limits = [sigma, sigma_down].map(|sigma| SIGMAS * sigma);
        for ((limit, square), explained) in limits.iter_mut().zip(self.mean_squares).zip(explained)
        {
            if self.learned_s >= LEARNED_S {
                *limit = limit.min(LEARNED * libm::sqrt(f64::from(square)));
            }
            *limit = agreement + *limit + explained;
        }
        limits
    }

    /// Updates the mean squares with a change, NED, over an interval, s. A change that exceeds `limits` is unusual.
    fn learn(
        &mut self,
        [north, east, down]: [f64; 3],
        limits: [f64; 2],
        interval_s: f32,
        is_usual: bool,
    ) {
        self.learned_s = (self.learned_s + interval_s).min(USUAL_S);
        let weight = if is_usual { 1.0 } else { UNUSUAL };
        let share = weight * (interval_s / self.learned_s).min(1.0);
        let squares = [(square(north) + square(east)) / 2.0, square(down)];
        for ((mean, new), limit) in self.mean_squares.iter_mut().zip(squares).zip(limits) {
            let most = square(MAX_LEARNED / LEARNED * limit);
            *mean += share * (new.min(most) as f32 - *mean);
        }
    }
}

/// One-sigmas of a fix, NED, and gravity.
#[derive(Clone, Copy, Debug)]
pub(in crate::ekf) struct FixSigmas {
    /// One-sigma of position, m.
    pub position_m: [f64; 3],
    /// One-sigma of velocity, m/s.
    pub velocity_mps: [f64; 3],
    /// Gravity, m/s².
    pub gravity_mps2: f64,
}

impl Unexplained {
    const NONE: Self = Self { velocity_mps: [0.0; 3], position_m: [0.0; 3] };

    /// Whether this departure is opposite to another, horizontally or vertically.
    fn opposes(&self, other: &Self) -> bool {
        let opposed =
            |[n, e, d]: [f32; 3], [on, oe, od]: [f32; 3]| n * on + e * oe < 0.0 || d * od < 0.0;
        opposed(self.velocity_mps, other.velocity_mps) || opposed(self.position_m, other.position_m)
    }
}

/// Shortest interval between compared fixes, s: over shorter ones, drift cannot be separated from motion.
const MIN_S: f64 = 0.8;
/// Usual error of a velocity change, m/s, from vibration and a swinging antenna.
const AGREEMENT_MPS: f64 = 1.0;
/// Factor on the product of recent acceleration and interval between two fixes. A heading error or a delay of the fixes
/// can cause a velocity difference up to this limit, so a smaller difference is no contradiction.
const EXPLAINS: f64 = 2.0;
/// Time constant of the recent acceleration, s.
const AGILE_S: f64 = 3.0;
/// Error of a velocity change from timing, as a fraction of the change.
const TIMING: f64 = 0.3;
/// Usual error of a change of position, m.
const AGREEMENT_M: f64 = 5.0;
/// Possible deviation of the velocity between two fixes from the mean of both, as a fraction of the velocity change.
const MEANWHILE: f64 = 0.5;
/// Time constant of the usual changes, s.
const USUAL_S: f32 = 30.0;
/// Time, s, after which the learned mean squares are used.
const LEARNED_S: f32 = 10.0;
/// Weight of an unusual change. Faulty fixes of one minute must not become usual, but a receiver that stays worse for
/// two minutes must.
const UNUSUAL: f32 = 0.25;
/// Largest change that is learned, in units of its limit divided by [`LEARNED`]. Larger changes are clamped.
const MAX_LEARNED: f64 = 2.0;
/// Limit of a usual change, in multiples of the learned root mean square.
const LEARNED: f64 = 5.0;
/// Limit of a usual change, in one-sigmas of a fix: five one-sigmas of the difference of two fixes.
const SIGMAS: f64 = 5.0 * core::f64::consts::SQRT_2;
/// Time, s, after a velocity jump in which fixes do not reset the filter. It ends early if the velocity returns.
const JUMPED_S: f64 = 15.0;
/// Number of contradictions from which fixes are rejected, even if a fix agrees with the filter by chance. Usual fixes
/// must withdraw all contradictions before fixes are used again.
const REJECTED_FROM: u8 = 2;
/// Longest time, s, for which a contradiction counts. While fixes are rejected the attitude drifts, and then no fix is
/// usual.
const CONTRADICTED_S: f64 = 30.0;
/// Upper limit of the number of contradictions.
const MAX_CONTRADICTIONS: u8 = 3;

impl<T: Scalar> SelfContradiction<T> {
    /// State before the first fix.
    pub const NONE: Self = Self {
        last: None,
        felt_mps: Vector::ZERO,
        in_part: false,
        unexplained: Unexplained::NONE,
        usual_mps: Usual::NONE,
        usual_m: Usual::NONE,
        agility_mps2: [0.0; 2],
        contradictions: 0,
        contradicted: Time::ZERO,
        proven: false,
        left_mps: [0.0; 3],
        jump_mps: [0.0; 3],
        farthest_mps: 0.0,
        jumped: Time::ZERO,
    };

    /// Adds the velocity change by specific force over a sample interval, m/s. `whole` is true if the inertial unit
    /// measured all of it.
    pub fn add(&mut self, felt_mps: Vector<Ned, T>, whole: bool) {
        self.felt_mps += felt_mps;
        self.in_part |= !whole;
    }

    /// Whether the last fixes contradicted each other, or a velocity jump has not returned. The filter is not reset to
    /// such fixes.
    pub fn is_suspected(&self) -> bool {
        self.contradictions > 0 || self.farthest_mps > 0.0
    }

    /// Whether the fixes contradicted each other repeatedly. Such fixes are rejected.
    pub const fn is_proven(&self) -> bool {
        self.proven
    }

    /// Feeds a fix; `own_mps` is the filter's velocity.
    ///
    /// # Source
    /// Equation (K15) of docs/equations.md.
    pub fn push(&mut self, fix: &Fix, own_mps: Vector<Ned>, expected: &FixSigmas) {
        let reading =
            Reading { time: fix.time, position: fix.position, velocity_mps: fix.velocity_mps() };
        let Some(before) = self.last else {
            self.begin(reading);
            return;
        };
        if self.contradictions > 0 && reading.time - self.contradicted > CONTRADICTED_S {
            self.contradictions = 0;
            self.proven = false;
        }
        let interval_s = reading.time - before.time;
        if (0.0..MIN_S).contains(&interval_s) {
            return;
        }
        let (felt_mps, in_part) = (self.felt_mps.cast(), self.in_part);
        self.begin(reading);
        if !(MIN_S..=BETWEEN_FIXES_S).contains(&interval_s) {
            self.unexplained = Unexplained::NONE;
            return;
        }
        let fallen_mps = Vector::new(0.0, 0.0, expected.gravity_mps2 * interval_s);
        let moved_mps = felt_mps + fallen_mps;
        self.note_agility(moved_mps, interval_s);
        let velocities = before.velocity_mps.zip(reading.velocity_mps);
        let change = velocities.filter(|_| !in_part).map(|(from, to)| to - from);
        let left_mps = change.map_or(Vector::ZERO, |change| change - moved_mps);
        let (from, to) = velocities.unwrap_or((own_mps, own_mps));
        let moved_m = reading.position.displacement_from(&before.position);
        let off_m = (moved_m - (from + to) * (0.5 * interval_s)).to_array();
        let turned_mps = if in_part { to - from } else { moved_mps };
        let meanwhile_m = MEANWHILE * turned_mps.norm() * interval_s;
        let agile_mps =
            self.agility_mps2.map(|agility| EXPLAINS * (f64::from(agility) * interval_s));
        let limits_mps = self.usual_mps.limits(expected.velocity_mps, AGREEMENT_MPS, agile_mps);
        let limits_m = self.usual_m.limits(expected.position_m, AGREEMENT_M, [meanwhile_m; 2]);
        let unexplained = Unexplained {
            velocity_mps: beyond(left_mps.to_array(), limits_mps),
            position_m: beyond(off_m, limits_m),
        };
        let is_usual = unexplained == Unexplained::NONE;
        if change.is_some() {
            self.usual_mps.learn(left_mps.to_array(), limits_mps, interval_s as f32, is_usual);
        }
        self.usual_m.learn(off_m, limits_m, interval_s as f32, is_usual);
        let is_impossible_at_any_attitude = change.is_some_and(|change| {
            is_impossible_at_any_attitude(change, felt_mps, fallen_mps, expected)
        });
        self.judge_jump(reading.time, left_mps, is_impossible_at_any_attitude);
        self.contradictions = if unexplained.opposes(&self.unexplained) {
            self.contradicted = reading.time;
            (self.contradictions + 1).min(MAX_CONTRADICTIONS)
        } else if is_usual {
            self.contradictions.saturating_sub(1)
        } else if self.proven {
            // Only successive usual fixes withdraw a proof.
            MAX_CONTRADICTIONS
        } else {
            self.contradictions
        };
        self.proven =
            self.contradictions >= REJECTED_FROM || self.proven && self.contradictions > 0;
        self.unexplained = unexplained;
    }

    /// Continues from a fix.
    fn begin(&mut self, reading: Reading) {
        (self.last, self.felt_mps, self.in_part) = (Some(reading), Vector::ZERO, false);
    }

    /// Largest recent accelerations, horizontal and vertical, m/s².
    pub const fn agility_mps2(&self) -> [f32; 2] {
        self.agility_mps2
    }

    /// Updates the largest recent accelerations with a measured change of velocity.
    fn note_agility(&mut self, moved_mps: Vector<Ned>, interval_s: f64) {
        let [north, east, down] = moved_mps.to_array();
        let left = libm::exp(-interval_s / AGILE_S) as f32;
        let now = [Scalar::hypot(north, east), libm::fabs(down)];
        for (agility, now) in self.agility_mps2.iter_mut().zip(now) {
            *agility = (*agility * left).max((now / interval_s) as f32);
        }
    }

    /// Feeds the part of a velocity change that the inertial unit did not measure, and whether no attitude explains it.
    /// A part that repeats from fix to fix is not a jump: it comes from a bias step or a wrong tilt.
    fn judge_jump(&mut self, time: Time, left: Vector<Ned>, is_impossible_at_any_attitude: bool) {
        let left = left.to_array().map(|left| left as f32);
        let before = core::mem::replace(&mut self.left_mps, left);
        if self.farthest_mps == 0.0 {
            if !is_impossible_at_any_attitude {
                return;
            }
            self.jumped = time;
        }
        let mut differs = [0.0; 3];
        let parts = self.jump_mps.iter_mut().zip(&mut differs).zip(left.into_iter().zip(before));
        for ((sum, differs), (left, before)) in parts {
            *sum += left;
            *differs = left - before;
        }
        let size_mps = length(self.jump_mps);
        self.farthest_mps = self.farthest_mps.max(size_mps);
        let goes_on =
            length(before) > AGREEMENT_MPS as f32 && length(differs) < 0.5 * length(before);
        let is_back = size_mps <= 0.5 * self.farthest_mps;
        if goes_on || is_back || time - self.jumped >= JUMPED_S {
            (self.jump_mps, self.farthest_mps) = ([0.0; 3], 0.0);
        }
    }
}

/// Whether no attitude makes the measured velocity change equal to `change` after gravity's `fallen_mps`. A rotation
/// preserves lengths, so the lengths are compared.
fn is_impossible_at_any_attitude(
    change: Vector<Ned>,
    felt_mps: Vector<Ned>,
    fallen_mps: Vector<Ned>,
    expected: &FixSigmas,
) -> bool {
    let [sigma, _, sigma_down] = expected.velocity_mps;
    let (asked_mps, felt_mps) = ((change - fallen_mps).norm(), felt_mps.norm());
    let usual_mps =
        AGREEMENT_MPS + SIGMAS * sigma.max(sigma_down) + TIMING * change.norm().min(felt_mps);
    libm::fabs(asked_mps - felt_mps) > usual_mps
}

fn length([x, y, z]: [f32; 3]) -> f32 {
    libm::sqrtf(x * x + y * y + z * z)
}

/// Sets the horizontal part of a vector to zero if within its limit, and likewise the vertical part.
fn beyond([north, east, down]: [f64; 3], [level, vertical]: [f64; 2]) -> [f32; 3] {
    let [north, east] =
        if square(north) + square(east) > square(level) { [north, east] } else { [0.0; 2] };
    let down = if libm::fabs(down) > vertical { down } else { 0.0 };
    [north, east, down].map(|part| part as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRAVITY_MPS2: f64 = 9.8;
    const EXPECTED: FixSigmas =
        FixSigmas { position_m: [2.0; 3], velocity_mps: [0.2; 3], gravity_mps2: GRAVITY_MPS2 };

    /// Contradictions after each of several fixes, one a second. The fixes have these velocities, north, and matching
    /// positions; the inertial unit measures `felt_mps` each second.
    fn contradictions(north_mps: impl IntoIterator<Item = f64>, felt_mps: [f64; 3]) -> Vec<u8> {
        let mut watch = SelfContradiction::<f64>::NONE;
        let mut position = Geodetic::from_degrees(48.0, 11.0, 500.0).unwrap();
        let mut before_mps = 0.0;
        north_mps
            .into_iter()
            .zip(1_u8..)
            .map(|(north_mps, second)| {
                let moved_m = 0.5 * (before_mps + north_mps);
                before_mps = north_mps;
                position = position.displaced(Vector::new(moved_m, 0.0, 0.0));
                let fix = Fix {
                    horizontal_velocity_mps: Some([north_mps, 0.0]),
                    down_velocity_mps: Some(0.0),
                    ..Fix::at(Time::ZERO + f64::from(second), position)
                };
                watch.add(felt_mps.into(), true);
                watch.push(&fix, Vector::ZERO, &EXPECTED);
                watch.contradictions
            })
            .collect()
    }

    const AT_REST: [f64; 3] = [0.0, 0.0, -GRAVITY_MPS2];

    #[test]
    fn readings_to_and_fro_that_nobody_felt_contradict_each_other_until_they_agree_again() {
        let told = [0.0, 8.0, -6.0, 9.0, -7.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        assert_eq!(contradictions(told, AT_REST), [0, 0, 1, 2, 3, 3, 2, 1, 0, 0]);
    }

    #[test]
    fn proof_ends_with_the_last_contradiction() {
        let told = [0.0, 8.0, -6.0, 9.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let mut watch = SelfContradiction::<f64>::NONE;
        let position = Geodetic::from_degrees(48.0, 11.0, 500.0).unwrap();
        let proven = told.into_iter().zip(1_u8..).map(|(north_mps, second)| {
            let fix = Fix {
                horizontal_velocity_mps: Some([north_mps, 0.0]),
                down_velocity_mps: Some(0.0),
                ..Fix::at(Time::ZERO + f64::from(second), position)
            };
            watch.add(AT_REST.into(), true);
            watch.push(&fix, Vector::ZERO, &EXPECTED);
            (watch.contradictions, watch.is_proven())
        });
        let proven: Vec<_> = proven.collect();
        assert!(proven.iter().any(|&(count, proven)| count == 1 && proven), "{proven:?}");
        assert!(proven.iter().all(|&(count, proven)| count > 0 || !proven), "{proven:?}");
        assert_eq!(proven.last(), Some(&(0, false)));
    }

    #[test]
    fn proof_ends_thirty_seconds_after_the_last_contradiction_of_a_slow_receiver() {
        let mut watch = SelfContradiction::<f64>::NONE;
        let start = Geodetic::from_degrees(48.0, 11.0, 500.0).unwrap();
        for (second, north_m) in [(0, 0.0), (1, 60.0), (2, -60.0), (3, 60.0), (4, -60.0)] {
            let position = start.displaced(Vector::new(north_m, 0.0, 0.0));
            let fix = Fix::at(Time::ZERO + f64::from(second), position);
            watch.push(&fix, Vector::ZERO, &EXPECTED);
        }
        assert!(watch.is_proven());
        // A fix each 3 s is too late for a comparison.
        for second in (7..41).step_by(3) {
            let fix = Fix::at(Time::ZERO + f64::from(second), start);
            watch.push(&fix, Vector::ZERO, &EXPECTED);
        }
        assert!(!watch.is_suspected());
    }

    #[test]
    fn a_jump_that_stays_and_one_that_comes_back_are_no_proof() {
        assert!(contradictions([0.0, 9.0, 9.0, 9.0, 9.0], AT_REST).iter().all(|&count| count == 0));
        assert_eq!(contradictions([0.0, 9.0, 0.0, 0.0, 0.0], AT_REST), [0, 0, 1, 0, 0]);
    }

    #[test]
    fn readings_within_stated_sigmas_contradict_the_past_of_a_better_receiver() {
        let [good, bad] = [[0.1, -0.1], [1.2, -1.2]].map(|pair| pair.into_iter().cycle());
        // The limit is 2.4 m/s as stated, and 1.7 m/s as learned.
        let told = good.clone().take(40).chain(bad.take(4)).chain(good.take(8));
        let found = contradictions(told, AT_REST);
        let (before, during) = found.split_at(40);
        assert_eq!(before, [0; 40]);
        assert_eq!(during, [0, 0, 1, 2, 1, 0, 0, 0, 0, 0, 0, 0]);
    }

    #[test]
    fn a_receiver_that_stays_worse_becomes_usual() {
        let mut usual = Usual { mean_squares: [0.01; 2], learned_s: USUAL_S };
        let stated = [9.0; 3];
        let mut within = |[north, east, down]: [f64; 3]| {
            let limits = usual.limits(stated, AGREEMENT_MPS, [0.0; 2]);
            let is_usual = beyond([north, east, down], limits) == [0.0; 3];
            usual.learn([north, east, down], limits, 1.0, is_usual);
            is_usual
        };
        let learned: Vec<bool> = (0..180).map(|_| within([4.0, -4.0, 5.0])).collect();
        assert!(learned.iter().take(30).all(|&usual| !usual), "{learned:?}");
        assert!(learned.iter().skip(120).all(|&usual| usual), "{learned:?}");
    }

    #[test]
    fn a_velocity_that_runs_away_as_a_lost_level_makes_it_does_not_contradict_itself() {
        let runs_away = (0..20).map(|second| 5.0 * f64::from(second));
        assert!(contradictions(runs_away, AT_REST).iter().all(|&count| count == 0));
    }

    #[test]
    fn a_change_that_was_felt_explains_itself_whatever_the_heading() {
        let to_and_fro = [0.0, 6.0, 0.0, 6.0, 0.0, 6.0];
        for felt_mps in [[6.0, 0.0, -GRAVITY_MPS2], [0.0, -6.0, -GRAVITY_MPS2]] {
            assert!(contradictions(to_and_fro, felt_mps).iter().all(|&count| count == 0));
        }
    }

    #[test]
    fn places_that_do_not_go_where_their_velocity_leads_contradict_each_other() {
        let mut watch = SelfContradiction::<f64>::NONE;
        let start = Geodetic::from_degrees(48.0, 11.0, 500.0).unwrap();
        let mut seen = [0; 5];
        for ((count, height_m), second) in
            seen.iter_mut().zip([0.0, 60.0, -60.0, 80.0, -10.0]).zip(1_u8..)
        {
            let fix = Fix::at(
                Time::ZERO + f64::from(second),
                start.displaced(Vector::new(0.0, 0.0, height_m)),
            );
            watch.push(&fix, Vector::ZERO, &EXPECTED);
            *count = watch.contradictions;
        }
        assert_eq!(seen, [0, 0, 1, 2, 3]);
    }
}
