//! Whether the vehicle rolls on wheels, by what its velocity has shown: then it moves along its road, and neither to the
//! side nor up from it, which holds it where fixes are absent.
//!
//! Across its own forward axis a car moves by what the unit is turned in it, a share of its speed, and by what its turns
//! make of where the unit stands from the axle that does not steer. Both are found while fixes are there, and what is
//! left says whether it is a vehicle on wheels: of nothing that flies is so little left.

use super::{root, square};
use crate::earth::STANDARD_GRAVITY_MPS2;
use crate::time::Time;

/// What the fixes have shown of the velocity to the right and downwards.
#[derive(Clone, Copy, Debug)]
pub(super) struct WheelWatch {
    right: Track,
    down: Track,
    /// How far it has turned while this was seen well, rad.
    turned_rad: f32,
    /// How far it banks in turns: sums of the sine of its bank times the centripetal acceleration in g, and of the
    /// square of that.
    banked: [f32; 2],
    /// Slowest and fastest that was seen, m/s.
    speeds_mps: [f32; 2],
    holds: bool,
    /// Whether [`news`](Self::news) has told that it does.
    told: bool,
    /// When it was last looked at.
    seen: Time,
}

/// To which side of the forward axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Across {
    Right,
    Down,
}

/// The line along which it rolls, in the unit's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line {
    /// Velocity across per forward velocity.
    pub slope: f32,
    /// Velocity across per rate about the axis that is square to both, m.
    pub arm_m: f32,
    /// Variance of what is left, (m/s)², such that what is seen once in [`INTERVAL_S`] may be taken for white.
    pub variance: f32,
}

/// A velocity across, as the filter has it after a fix.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub forward_mps: f32,
    pub rate_radps: f32,
    pub across_mps: f32,
    /// The filter's own variance of what is left of it, (m/s)².
    pub own_variance: f32,
}

/// Slower than this, m/s, nothing is learned: a hover is slow too.
pub(super) const SLOWEST_MPS: f32 = 3.0;
/// It is held this often, s.
pub(super) const INTERVAL_S: f64 = 0.2;
/// One-sigma of a car's velocity across: tyres that slip, a road that is uneven, m/s.
const USUAL_MPS: f32 = 0.1;
/// No less is believed to be left, m/s.
const LEAST_MPS: f32 = 0.05;
/// What is left goes on for this long, s.
const CORRELATED_S: f32 = 2.0;
/// One-sigma of the slope once it is found: what the heading was off throughout is in it.
const SLOPE_SIGMA: f32 = 0.003;
/// One-sigmas of slope and arm before anything is known: 6° and 1 m.
const SLOPE_PRIOR: f32 = 0.1;
const ARM_PRIOR_M: f32 = 1.0;
/// Memory of slope and arm, and of what is left, s.
const MEMORY_S: f32 = 300.0;
const LEFT_MEMORY_S: f32 = 60.0;
/// It rolls on wheels if no more than this is left, m/s, in at least so many seconds seen as well as a car's usual,
/// and half a turn.
const ROLLS_MPS: f32 = 0.15;
const ROLLS_S: f32 = 10.0;
const HALF_A_TURN_RAD: f32 = core::f32::consts::PI;
/// What flies banks into its turns by as much as takes the weight along, a share of 1; what rolls leans outwards.
const BANKS: f32 = 0.5;
/// What an angle of attack or leeway adds to the slope where it is faster or slower than was seen, per m/s of that.
const BEYOND: f32 = 0.005;
/// What is left after a vehicle has denied it, m/s.
const DENIED_MPS: f32 = 1.0;
/// Innovations that lean to one side by so many one-sigmas are those of a vehicle that leaves its road little by
/// little; a car's are within 0.3, for what is left goes on and is counted so often.
const LEANING: f32 = 0.75;
/// Readings further apart, s, count as so far apart.
const LONGEST_S: f32 = 1.0;

/// Least squares of one velocity across.
#[derive(Clone, Copy, Debug)]
struct Track {
    information: [f32; 3],
    moments: [f32; 2],
    /// Variance of what is left beyond the filter's own, (m/s)²; below zero by chance.
    left: f32,
    /// For how long it was seen, as well as a car's usual, s.
    seen_s: f32,
    /// Mean of the normalised innovations of late, while it is held.
    lean: f32,
}

impl Track {
    const UNSEEN: Self = Self {
        information: [SLOPE_INFORMATION, 0.0, ARM_INFORMATION],
        moments: [0.0; 2],
        left: 0.0,
        seen_s: 0.0,
        lean: 0.0,
    };

    /// Slope and arm, m.
    fn found(&self) -> [f32; 2] {
        let ([a, b, c], [x, y]) = (self.information, self.moments);
        // Above zero, by what is known beforehand.
        let determinant = a * c - b * b;
        [(c * x - b * y) / determinant, (a * y - b * x) / determinant]
    }

    fn told(&mut self, seen: &Seen, elapsed_s: f32) {
        let [slope, arm_m] = self.found();
        let Seen { forward_mps, rate_radps, across_mps, own_variance } = *seen;
        let left = across_mps - slope * forward_mps - arm_m * rate_radps;
        let variance = square(USUAL_MPS) + own_variance;
        let weight = elapsed_s / variance;
        let fade = 1.0 - elapsed_s / MEMORY_S;
        let row = [square(forward_mps), forward_mps * rate_radps, square(rate_radps)];
        let prior = [SLOPE_INFORMATION, 0.0, ARM_INFORMATION];
        for ((sum, row), prior) in self.information.iter_mut().zip(row).zip(prior) {
            *sum = fade * *sum + (1.0 - fade) * prior + weight * row;
        }
        for (sum, factor) in self.moments.iter_mut().zip([forward_mps, rate_radps]) {
            *sum = fade * *sum + weight * factor * across_mps;
        }
        let share_s = square(USUAL_MPS) * weight;
        self.seen_s = fade * self.seen_s + share_s;
        let newest = share_s / self.seen_s.clamp(1.0, LEFT_MEMORY_S);
        self.left += newest * (square(left) - own_variance - self.left);
    }
}

/// What is known of slope and arm before the first reading, as inverse variances; of the arm in 1/m².
const SLOPE_INFORMATION: f32 = 1.0 / (SLOPE_PRIOR * SLOPE_PRIOR);
const ARM_INFORMATION: f32 = 1.0 / (ARM_PRIOR_M * ARM_PRIOR_M);

impl WheelWatch {
    /// Has seen nothing.
    pub const UNSEEN: Self = Self {
        right: Track::UNSEEN,
        down: Track::UNSEEN,
        turned_rad: 0.0,
        banked: [0.0; 2],
        speeds_mps: [f32::INFINITY, 0.0],
        holds: false,
        told: false,
        seen: Time::ZERO,
    };

    /// Takes in the velocity to the right and downwards after a fix, and the sine of the bank to the right.
    ///
    /// # Source
    /// Equation (M17) of docs/equations.md.
    pub fn told(&mut self, time: Time, right: &Seen, down: &Seen, bank: f32) {
        let elapsed_s = ((time - self.seen) as f32).clamp(0.0, LONGEST_S);
        self.seen = time;
        let size =
            |seen: &Seen| seen.forward_mps + seen.rate_radps + seen.across_mps + seen.own_variance;
        // Written so that a NaN tells nothing.
        let sizes = size(right) + size(down) + bank;
        let speed_mps = right.forward_mps.abs();
        if !(speed_mps >= SLOWEST_MPS && sizes.is_finite()) {
            return;
        }
        let [slowest, fastest] = self.speeds_mps;
        self.speeds_mps = [slowest.min(speed_mps), fastest.max(speed_mps)];
        let centripetal = right.forward_mps * right.rate_radps / STANDARD_GRAVITY_MPS2 as f32;
        let fade = 1.0 - elapsed_s / MEMORY_S;
        for (sum, factor) in self.banked.iter_mut().zip([bank, centripetal]) {
            *sum = fade * *sum + elapsed_s * centripetal * factor;
        }
        let before_s = self.right.seen_s;
        self.right.told(right, elapsed_s);
        self.down.told(down, elapsed_s);
        self.turned_rad += (self.right.seen_s - before_s).max(0.0) * right.rate_radps.abs();
        let left = self.right.left.max(self.down.left);
        let [banked, turned] = self.banked;
        let banks = banked > BANKS * turned;
        self.holds = if self.holds {
            left < 2.0 * square(ROLLS_MPS) && !banks
        } else {
            left < square(ROLLS_MPS)
                && !banks
                && self.right.seen_s.min(self.down.seen_s) > ROLLS_S
                && self.turned_rad > HALF_A_TURN_RAD
        };
    }

    /// Whether the vehicle rolls on wheels, once when that has changed.
    pub fn news(&mut self) -> Option<bool> {
        let before = core::mem::replace(&mut self.told, self.holds);
        (before != self.holds).then_some(self.holds)
    }

    /// Whether to hold it at `time`, which then counts as the last.
    pub fn is_due(&mut self, time: Time) -> bool {
        let is_due = self.holds && time - self.seen >= INTERVAL_S;
        if is_due {
            self.seen = time;
        }
        is_due
    }

    /// Takes in the normalised innovations to the right and downwards with which it is about to be held. Gives whether
    /// nothing on wheels moves like that, one of them being beyond the `gate` or leaning: until fixes have shown it again
    /// it is not held.
    pub fn denies(&mut self, normalised: [f32; 2], gate: f32) -> bool {
        for (track, normalised) in [&mut self.right, &mut self.down].into_iter().zip(normalised) {
            track.lean += INTERVAL_S as f32 / CORRELATED_S * (normalised - track.lean);
        }
        // Written so that a NaN denies it.
        let upright = self.right.lean.abs() < LEANING && self.down.lean.abs() < LEANING;
        let denied = !(upright && normalised.iter().all(|size| size.abs() <= gate));
        if denied {
            self.holds = false;
            for track in [&mut self.right, &mut self.down] {
                (track.left, track.lean) = (square(DENIED_MPS), 0.0);
            }
        }
        denied
    }

    /// Along which line it rolls at a forward velocity, m/s.
    pub fn line(&self, across: Across, forward_mps: f32) -> Line {
        let track = match across {
            Across::Right => &self.right,
            Across::Down => &self.down,
        };
        let [slope, arm_m] = track.found();
        let [slowest, fastest] = self.speeds_mps;
        let speed_mps = forward_mps.abs();
        let beyond_mps = (speed_mps - fastest).max(slowest - speed_mps).max(0.0);
        let slope_sigma = SLOPE_SIGMA + BEYOND * beyond_mps;
        let once = track.left.max(square(LEAST_MPS)) + square(slope_sigma * forward_mps);
        Line { slope, arm_m, variance: once * CORRELATED_S / INTERVAL_S as f32 }
    }

    /// One-sigma of the velocity across, m/s, that it is held to.
    pub fn sigma_mps(&self) -> f32 {
        root(self.right.left.max(self.down.left).max(square(LEAST_MPS)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A drive of `seconds` at 10 m/s with turns to both sides, whose velocities across are `right` and `down`
    /// of the time and the rate of turn.
    fn driven(
        seconds: u32,
        right: impl Fn(f32, f32) -> f32,
        down: impl Fn(f32, f32) -> f32,
    ) -> WheelWatch {
        // Its springs let it lean outwards.
        banked(seconds, right, down, -0.05)
    }

    /// The same, its bank's sine a share of the centripetal acceleration in g.
    fn banked(
        seconds: u32,
        right: impl Fn(f32, f32) -> f32,
        down: impl Fn(f32, f32) -> f32,
        share: f32,
    ) -> WheelWatch {
        let mut watch = WheelWatch::UNSEEN;
        for second in 1..=seconds {
            let time = second as f32;
            let rate_radps = 0.3 * (0.2 * time).sin();
            let seen = |across_mps, rate_radps| Seen {
                forward_mps: 10.0,
                rate_radps,
                across_mps,
                own_variance: 0.0025,
            };
            let pitch_rate = 0.05 * (1.3 * time).sin();
            let (right, down) = (right(time, rate_radps), down(time, pitch_rate));
            let time = Time::ZERO + f64::from(second);
            watch.told(
                time,
                &seen(right, rate_radps),
                &seen(down, pitch_rate),
                share * rate_radps * 10.0 / 9.8,
            );
        }
        watch
    }

    #[test]
    fn a_car_whose_unit_is_turned_and_stands_off_its_axle_is_known_and_so_is_its_line() {
        let watch = driven(
            120,
            |t, rate| 0.3 + 1.2 * rate + 0.05 * (7.0 * t).sin(),
            |t, _| -0.2 + 0.05 * (5.0 * t).cos(),
        );
        assert!(watch.holds);
        let line = watch.line(Across::Right, 10.0);
        assert!((line.slope - 0.03).abs() < 0.003 && (line.arm_m - 1.2).abs() < 0.1, "{line:?}");
        assert!((watch.line(Across::Down, 10.0).slope + 0.02).abs() < 0.003);
        // Held five times a second, it is as sure as one look in two seconds.
        assert!((line.variance - 10.0 * (0.0025 + 0.0009)).abs() < 1e-4, "{line:?}");
    }

    #[test]
    fn what_sideslips_or_climbs_as_aircraft_do_is_not_on_wheels() {
        let wind = driven(600, |t, _| (0.01 * t).sin(), |_, _| 0.0);
        let climbs = driven(600, |_, _| 0.0, |t, _| 0.5 * (0.05 * t).sin());
        assert!(!wind.holds && !climbs.holds);
    }

    #[test]
    fn what_banks_into_its_turns_flies_however_still_the_air() {
        assert!(!banked(600, |_, _| 0.0, |_, _| 0.0, 1.0).holds);
    }

    #[test]
    fn beyond_the_speeds_that_were_seen_less_is_known_of_the_line() {
        let watch = driven(300, |_, _| 0.0, |_, _| 0.0);
        let variance = |forward_mps| watch.line(Across::Down, forward_mps).variance;
        assert!(variance(15.0) > 10.0 * variance(10.0));
    }

    #[test]
    fn a_straight_road_and_a_short_drive_tell_nothing() {
        let mut straight = WheelWatch::UNSEEN;
        let seen = Seen { forward_mps: 10.0, rate_radps: 0.0, across_mps: 0.0, own_variance: 0.0 };
        for second in 1..1000 {
            straight.told(Time::ZERO + f64::from(second), &seen, &seen, 0.0);
        }
        assert!(!straight.holds && !driven(8, |_, _| 0.0, |_, _| 0.0).holds);
    }

    #[test]
    fn a_car_that_lifts_off_is_let_go_within_seconds() {
        let mut watch = driven(300, |_, _| 0.0, |_, _| 0.0);
        assert!(watch.holds);
        let right =
            Seen { forward_mps: 10.0, rate_radps: 0.0, across_mps: 0.0, own_variance: 0.0025 };
        let mut seconds = 0;
        while watch.holds {
            seconds += 1;
            let time = Time::ZERO + f64::from(300 + seconds);
            watch.told(time, &right, &Seen { across_mps: -1.0, ..right }, 0.0);
        }
        assert!(seconds <= 4, "{seconds}");
    }

    #[test]
    fn a_car_that_leaves_its_road_without_fixes_is_let_go_at_once_or_within_two_seconds() {
        let held = driven(300, |_, _| 0.0, |_, _| 0.0);
        let after = |normalised: [f32; 2]| {
            let mut watch = held;
            (1..1000).find(|_| watch.denies(normalised, 5.0)).map(|count| (count, watch))
        };
        assert!(after([0.3, -0.5]).is_none());
        let (count, mut off) = after([0.1, -1.2]).unwrap();
        assert!(count <= 10 && !off.is_due(Time::ZERO + 400.0));
        let mut refused = held;
        assert!(refused.denies([0.0, -5.1], 5.0) && !refused.is_due(Time::ZERO + 400.0));
        let mut wrong = held;
        assert!(wrong.denies([f32::NAN, 0.0], 5.0));
    }

    #[test]
    fn slow_motion_and_what_is_no_number_change_nothing() {
        let mut watch = WheelWatch::UNSEEN;
        let good = Seen { forward_mps: 10.0, rate_radps: 0.3, across_mps: 0.1, own_variance: 0.01 };
        for (second, bad) in [
            Seen { forward_mps: 2.9, ..good },
            Seen { forward_mps: f32::NAN, ..good },
            Seen { rate_radps: f32::NAN, ..good },
            Seen { across_mps: f32::INFINITY, ..good },
            Seen { own_variance: f32::NAN, ..good },
        ]
        .into_iter()
        .enumerate()
        {
            watch.told(Time::ZERO + second as f64, &bad, &good, 0.0);
            watch.told(Time::ZERO + second as f64, &Seen { forward_mps: 1.0, ..good }, &bad, 0.0);
        }
        assert!(watch.right.seen_s == 0.0 && watch.right.found() == [0.0; 2]);
    }
}
