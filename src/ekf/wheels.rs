//! Detects from the velocity whether the vehicle rolls on wheels. A vehicle on wheels moves along its road, not
//! sideways or upwards; this constraint limits the drift while fixes are absent.
//!
//! The velocity of a car across its own forward axis has two causes. A misaligned inertial unit adds a share of the
//! speed; the distance from the unsteered axle adds a share of the turn rate. Both are estimated while fixes are
//! available. The residual shows whether the vehicle rolls on wheels: no aircraft has so small a residual.

use super::{root, square};
use crate::earth::STANDARD_GRAVITY_MPS2;
use crate::time::Time;

/// Velocity to the right and downwards as observed with fixes.
#[derive(Clone, Copy, Debug)]
pub(super) struct WheelWatch {
    right: Track,
    down: Track,
    /// Accumulated turn while the velocity was observed well, rad.
    turned_rad: f32,
    /// Bank in turns: weighted sums of the sine of the bank times the centripetal acceleration in g, and of the square
    /// of that acceleration.
    banked: [f32; 2],
    /// Slowest and fastest observed speed, m/s.
    speeds_mps: [f32; 2],
    holds: bool,
    /// Whether [`news`](Self::news) has reported the present value of `holds`.
    told: bool,
    /// Time of the last observation or constraint.
    seen: Time,
}

/// Direction across the forward axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Across {
    Right,
    Down,
}

/// Line along which the vehicle rolls, in the inertial unit's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line {
    /// Velocity across per forward velocity.
    pub slope: f32,
    /// Velocity across per angular rate about the axis perpendicular to both, m.
    pub arm_m: f32,
    /// Variance of the residual, (m/s)², inflated so that samples every [`INTERVAL_S`] may count as white.
    pub variance: f32,
}

/// Velocity across, as estimated by the filter after a fix.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub forward_mps: f32,
    pub rate_radps: f32,
    pub across_mps: f32,
    /// Variance of the residual from the filter's own errors, (m/s)².
    pub own_variance: f32,
}

/// Slower motion, m/s, is ignored: a hover is slow too.
pub(super) const SLOWEST_MPS: f32 = 3.0;
/// Interval of the constraint, s.
pub(super) const INTERVAL_S: f64 = 0.2;
/// Usual one-sigma of a car's velocity across, from tyre slip and uneven roads, m/s.
const USUAL_MPS: f32 = 0.1;
/// Lower limit of the residual's one-sigma, m/s.
const LEAST_MPS: f32 = 0.05;
/// Correlation time of the residual, s.
const CORRELATED_S: f32 = 2.0;
/// One-sigma of the slope after estimation: it includes the mean heading error.
const SLOPE_SIGMA: f32 = 0.003;
/// One-sigmas of slope and arm before the first observation: 6° and 1 m.
const SLOPE_PRIOR: f32 = 0.1;
const ARM_PRIOR_M: f32 = 1.0;
/// Memory of slope and arm, and of the residual, s.
const MEMORY_S: f32 = 300.0;
const LEFT_MEMORY_S: f32 = 60.0;
/// The vehicle is found to roll on wheels with a residual below `ROLLS_MPS`, m/s. This requires `ROLLS_S` seconds of
/// observation as accurate as a car's usual residual, and half a turn.
const ROLLS_MPS: f32 = 0.15;
const ROLLS_S: f32 = 10.0;
const HALF_A_TURN_RAD: f32 = core::f32::consts::PI;
/// An aircraft banks into its turns; a vehicle on wheels rolls outwards. Threshold as a share of the coordinated bank.
const BANKS: f32 = 0.5;
/// Growth of the slope's one-sigma outside the observed speeds, per m/s, from angle of attack or sideslip.
const BEYOND: f32 = 0.005;
/// Residual assumed after a vehicle has violated the constraint, m/s.
const DENIED_MPS: f32 = 1.0;
/// Mean normalised innovation that indicates a vehicle slowly leaving its road. A car's mean stays within 0.3: the
/// residual is correlated, and [`Line::variance`] is inflated for it.
const LEANING: f32 = 0.75;
/// Longer intervals between readings, s, count as this one.
const LONGEST_S: f32 = 1.0;

/// Least squares of one component of the velocity across.
#[derive(Clone, Copy, Debug)]
struct Track {
    information: [f32; 3],
    moments: [f32; 2],
    /// Variance of the residual beyond the filter's own, (m/s)²; may be negative by chance.
    left: f32,
    /// Observation time, weighted by accuracy relative to a car's usual residual, s.
    seen_s: f32,
    /// Mean normalised innovation during the constraint.
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
        // Positive because of the prior.
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

/// Prior inverse variances of slope and arm, the latter in 1/m².
const SLOPE_INFORMATION: f32 = 1.0 / (SLOPE_PRIOR * SLOPE_PRIOR);
const ARM_INFORMATION: f32 = 1.0 / (ARM_PRIOR_M * ARM_PRIOR_M);

impl WheelWatch {
    /// State before the first observation.
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

    /// Feeds the velocity to the right and downwards after a fix, and the sine of the bank to the right.
    ///
    /// # Source
    /// Equation (M17) of docs/equations.md.
    pub fn told(&mut self, time: Time, right: &Seen, down: &Seen, bank: f32) {
        let elapsed_s = ((time - self.seen) as f32).clamp(0.0, LONGEST_S);
        self.seen = time;
        let size =
            |seen: &Seen| seen.forward_mps + seen.rate_radps + seen.across_mps + seen.own_variance;
        // The comparison also rejects NaN.
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

    /// Whether the vehicle rolls on wheels, once after each change.
    pub fn news(&mut self) -> Option<bool> {
        let before = core::mem::replace(&mut self.told, self.holds);
        (before != self.holds).then_some(self.holds)
    }

    /// Whether the constraint is due at `time`; if so, `time` becomes the last one.
    pub fn is_due(&mut self, time: Time) -> bool {
        let is_due = self.holds && time - self.seen >= INTERVAL_S;
        if is_due {
            self.seen = time;
        }
        is_due
    }

    /// Feeds the normalised innovations to the right and downwards, before the constraint is applied. Returns `true` if
    /// the motion is impossible on wheels: an innovation beyond `gate`, or one-sided innovations. The constraint then
    /// stops until fixes show wheels again.
    pub fn denies(&mut self, normalised: [f32; 2], gate: f32) -> bool {
        for (track, normalised) in [&mut self.right, &mut self.down].into_iter().zip(normalised) {
            track.lean += INTERVAL_S as f32 / CORRELATED_S * (normalised - track.lean);
        }
        // The comparison also counts NaN as a violation.
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

    /// Line along which the vehicle rolls at a forward velocity, m/s.
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

    /// One-sigma of the constrained velocity across, m/s.
    pub fn sigma_mps(&self) -> f32 {
        root(self.right.left.max(self.down.left).max(square(LEAST_MPS)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// State after a drive of `seconds` at 10 m/s with turns to both sides. `right` and `down` give the velocities
    /// across from time and turn rate.
    fn driven(
        seconds: u32,
        right: impl Fn(f32, f32) -> f32,
        down: impl Fn(f32, f32) -> f32,
    ) -> WheelWatch {
        // The springs let the car roll outwards.
        banked(seconds, right, down, -0.05)
    }

    /// Same drive; the sine of the bank is `share` of the centripetal acceleration in g.
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
        // Applied five times a second, the constraint is as accurate as one observation in two seconds.
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
