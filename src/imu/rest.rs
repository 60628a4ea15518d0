//! Whether the vehicle stands still, by its samples, fixes and magnetic field.

use super::MeanRates;
use crate::frames::{Body, Vector};
use crate::scalar::Scalar;
use crate::time::Time;

/// Watches for rest: seconds in which nothing shakes, nothing changes and no fix moves.
///
/// An engine, a rotor or a road shakes a unit by more than 0.1 m/s². A mast that pans, or a boat that swings, may turn
/// as smoothly as a gyro's bias: but no bias changes by 0.1 °/s within a minute, nor does it turn the magnetic field.
/// Where the fixes have no velocity there is no rest.
#[derive(Clone, Copy, Debug)]
pub struct Rest {
    second: Second,
    /// Means of the second before, where that was still.
    before: Option<[f32; AXES]>,
    /// What the seconds of late had in common, where all were still.
    stillness: Option<Stillness>,
    /// The latest magnetic field of the second under way.
    field: Option<[f32; 3]>,
    /// When the last fix came, and the mean velocity of those of late, north, east and down, m/s.
    fixes: (Time, Option<[f32; 3]>),
    /// Whether the vehicle has not moved since a second of rest.
    rests: bool,
    /// Whether the last sample ended the second after a rest.
    moves_off: bool,
    /// How long the fixes have been slow without a second that moved, s.
    slow_s: f32,
}

/// Rates, then forces.
const AXES: usize = 6;

/// Largest standard deviations of a unit at rest: gyros, rad/s, and accelerometers, m/s².
const STILL_RADPS: f32 = 0.012;
const STILL_MPS2: f32 = 0.1;
/// Largest change of the means from one second to the next, likewise.
const STEADY_RADPS: f32 = 0.005;
const STEADY_MPS2: f32 = 0.05;
/// Largest change of a mean rate from that of the seconds of late, rad/s: noise, warming up.
const DRIFT_RADPS: f32 = 0.002;
/// Sine of the largest turn of the magnetic field from that of the seconds of late.
const FIELD_TURN: f32 = 0.07;
/// How late these are, s.
const STILLNESS_S: f32 = 60.0;
/// No gyro bias is larger than this, rad/s; what turns faster is no vehicle at rest.
const LARGEST_BIAS_RADPS: f32 = 0.05;
/// Fixes of a vehicle at rest have a velocity below this, m/s, and a mean below that; likewise downwards.
const FIX_MPS: f32 = 0.5;
const FIX_MEAN_MPS: f32 = 0.15;
const FIX_DOWN_MPS: f32 = 1.0;
const FIX_MEAN_DOWN_MPS: f32 = 0.25;
/// The mean is that of as long as the fixes have been slow, s, between these; what a receiver's errors leave of it falls
/// with the root.
const FIX_MEMORY_S: core::ops::RangeInclusive<f32> = 5.0..=30.0;
/// A fix counts for so long, s.
const FIX_S: f64 = 3.0;
/// Samples further apart than this, s, tell nothing of what was between them.
const LONGEST_INTERVAL_S: f64 = 0.1;

/// Sums over the second under way, of what exceeds its first sample.
#[derive(Clone, Copy, Debug)]
struct Second {
    length_s: f32,
    count: f32,
    first: [f32; AXES],
    sum: [f32; AXES],
    squares: [f32; AXES],
}

impl Second {
    const EMPTY: Self = Self {
        length_s: 0.0,
        count: 0.0,
        first: [0.0; AXES],
        sum: [0.0; AXES],
        squares: [0.0; AXES],
    };

    fn add(&mut self, values: [f32; AXES]) {
        if self.count == 0.0 {
            self.first = values;
        }
        self.count += 1.0;
        let sums = self.sum.iter_mut().zip(&mut self.squares).zip(self.first);
        for (((sum, square), first), value) in sums.zip(values) {
            let above = value - first;
            *sum += above;
            *square += above * above;
        }
    }

    /// Means, where no axis shook.
    fn still_means(&self) -> Option<[f32; AXES]> {
        let mut means = self.first;
        let still = limits(STILL_RADPS, STILL_MPS2);
        let sums = self.sum.iter().zip(&self.squares).zip(still);
        for (mean, ((&sum, &squares), limit)) in means.iter_mut().zip(sums) {
            let above = sum / self.count;
            // Written so that a NaN is not still.
            let is_still = squares / self.count - above * above < limit * limit;
            if !is_still {
                return None;
            }
            *mean += above;
        }
        Some(means)
    }
}

/// Means over the seconds of late.
#[derive(Clone, Copy, Debug)]
struct Stillness {
    rates: [f32; 3],
    field: Option<[f32; 3]>,
}

impl Stillness {
    /// Whether a still second of these mean rates, and of this field, where one was measured, goes on with it; then
    /// it counts among the seconds of late.
    fn goes_on(&mut self, rates: [f32; 3], field: Option<[f32; 3]>) -> bool {
        let changes =
            self.rates.iter().zip(rates).any(|(old, new)| (new - old).abs() > DRIFT_RADPS);
        let turns = self.field.zip(field).is_some_and(|(old, new)| is_turned(old, new));
        fade_in(&mut self.rates, rates);
        if let Some(new) = field {
            fade_in(self.field.get_or_insert(new), new);
        }
        !(changes || turns)
    }
}

/// Moves a mean over the seconds of late by the newest.
fn fade_in(mean: &mut [f32; 3], newest: [f32; 3]) {
    for (mean, newest) in mean.iter_mut().zip(newest) {
        *mean += (newest - *mean) / STILLNESS_S;
    }
}

/// Whether a field points elsewhere than another.
fn is_turned(old: [f32; 3], new: [f32; 3]) -> bool {
    let ([a, b, c], [x, y, z]) = (old, new);
    let across = [b * z - c * y, c * x - a * z, a * y - b * x];
    squared(across) > FIELD_TURN * FIELD_TURN * squared(old) * squared(new)
}

fn squared(of: [f32; 3]) -> f32 {
    of.iter().map(|value| value * value).sum()
}

/// Whether a velocity, m/s, is faster than that, level or downwards. Without a root, which takes long where there is no
/// instruction for it.
fn is_faster([north, east, down]: [f32; 3], level_mps: f32, down_mps: f32) -> bool {
    north * north + east * east > level_mps * level_mps || down.abs() > down_mps
}

/// A limit for each axis.
fn limits(gyro: f32, accel: f32) -> [f32; AXES] {
    [gyro, gyro, gyro, accel, accel, accel]
}

/// What a second was.
enum Kind {
    /// Of rest, as the one before.
    Rest,
    /// As still as rest, but it may be a smooth turn.
    Doubtful,
    /// Of motion.
    Motion,
}

impl Rest {
    /// Nothing seen yet.
    pub const NONE: Self = Self {
        second: Second::EMPTY,
        before: None,
        stillness: None,
        field: None,
        fixes: (Time::ZERO, None),
        rests: false,
        moves_off: false,
        slow_s: 0.0,
    };

    /// Takes in the velocity of a fix, north, east and down, m/s, zero where it does not say, or that it has none.
    pub fn fix(&mut self, time: Time, velocity_mps: Option<[f64; 3]>) {
        let now = velocity_mps.map(|wide| wide.map(|value| value as f32));
        let slow = now.filter(|now| !is_faster(*now, FIX_MPS, FIX_DOWN_MPS));
        let (then, before) = self.fixes;
        let since_s = (time - then).clamp(0.0, FIX_S) as f32;
        let before = before.filter(|_| self.slow_s > 0.0);
        self.slow_s = if before.is_some() { self.slow_s + since_s } else { f32::MIN_POSITIVE };
        let share = (since_s / self.fix_memory_s()).min(1.0);
        let mean = slow.map(|now| {
            let mut mean = before.unwrap_or(now);
            for (mean, now) in mean.iter_mut().zip(now) {
                *mean += share * (now - *mean);
            }
            mean
        });
        self.fixes = (time, mean);
    }

    /// Over how long the mean of the fixes' velocity is, s.
    fn fix_memory_s(&self) -> f32 {
        self.slow_s.max(*FIX_MEMORY_S.start()).min(*FIX_MEMORY_S.end())
    }

    /// Mean velocity of the fixes of late, north, east and down, m/s; zero where it is not known.
    pub fn fixes_mean_mps(&self) -> [f32; 3] {
        self.fixes.1.unwrap_or([0.0; 3])
    }

    /// Takes in a magnetic field, of any unit.
    pub fn field(&mut self, field: Vector<Body>) {
        self.field = Some(field.to_array().map(|axis| axis as f32));
    }

    /// Takes in a sample, `interval_s` after the one before. Gives the mean angular rate, rad/s, of a
    /// second that ends with it, if the vehicle rested through that second and the one before.
    pub fn push<T: Scalar>(
        &mut self,
        time: Time,
        rates: &MeanRates<T>,
        interval_s: T,
    ) -> Option<Vector<Body, T>> {
        self.moves_off = false;
        if interval_s > T::of(LONGEST_INTERVAL_S) {
            (self.second, self.before) = (Second::EMPTY, None);
            return None;
        }
        let [p, q, r] = rates.angular_rate_radps.to_array();
        let [x, y, z] = rates.specific_force_mps2.to_array();
        self.second.add([p, q, r, x, y, z].map(|value| value.wide() as f32));
        self.second.length_s += interval_s.wide() as f32;
        if self.second.length_s < 1.0 {
            return None;
        }
        let means = core::mem::replace(&mut self.second, Second::EMPTY).still_means();
        let kind = self.kind(time, means);
        self.moves_off = self.rests && matches!(kind, Kind::Motion);
        let is_rest = matches!(kind, Kind::Rest);
        if matches!(kind, Kind::Motion) {
            self.slow_s = 0.0;
        }
        self.rests = is_rest || (self.rests && !self.moves_off);
        let [p, q, r, ..] = means.filter(|_| is_rest)?;
        let rate = |mean: f32| T::of(f64::from(mean));
        Some(Vector::new(rate(p), rate(q), rate(r)))
    }

    /// Whether the last sample ended the first second after a rest in which the vehicle moved.
    pub fn moves_off(&self) -> bool {
        self.moves_off
    }

    /// What the second was whose means these are, where it was still.
    fn kind(&mut self, time: Time, means: Option<[f32; AXES]>) -> Kind {
        let before = core::mem::replace(&mut self.before, means);
        let field = self.field.take();
        let Some(means) = means else {
            self.stillness = None;
            return Kind::Motion;
        };
        let [p, q, r, ..] = means;
        let rates = [p, q, r];
        let stillness = self.stillness.get_or_insert(Stillness { rates, field });
        let goes_on = stillness.goes_on(rates, field);
        let steady = before.is_some_and(|before| {
            (means.iter().zip(before))
                .zip(limits(STEADY_RADPS, STEADY_MPS2))
                .all(|((mean, before), limit)| (mean - before).abs() < limit)
        });
        let (last, mean) = self.fixes;
        let left = libm::sqrtf(FIX_MEMORY_S.start() / self.fix_memory_s());
        let [level_mps, down_mps] = [left * FIX_MEAN_MPS, left * FIX_MEAN_DOWN_MPS];
        let slow =
            time - last < FIX_S && mean.is_some_and(|mean| !is_faster(mean, level_mps, down_mps));
        match steady && slow && squared(rates) < LARGEST_BIAS_RADPS * LARGEST_BIAS_RADPS {
            true if goes_on => Kind::Rest,
            true => Kind::Doubtful,
            false => Kind::Motion,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How many of twenty seconds count as rest: a unit shaken by this much, turning at this rate, at fixes
    /// of this speed.
    fn rests(shake: f64, turn_radps: f64, fix_mps: Option<f64>) -> usize {
        let mut rest = Rest::NONE;
        let mut count = 0;
        for k in 0..1000 {
            let time = Time::from_nanoseconds(k * 20_000_000);
            if k % 50 == 0 {
                rest.fix(time, fix_mps.map(|speed| [speed, 0.0, 0.0]));
            }
            let sign = if k % 2 == 0 { shake } else { -shake };
            let rates = MeanRates {
                angular_rate_radps: Vector::new(0.004, -0.002, turn_radps + 0.02 * sign),
                specific_force_mps2: Vector::new(0.1, sign, -9.8),
            };
            if let Some(rate) = rest.push(time, &rates, 0.02) {
                // A sample of the shake may have no partner.
                assert!((rate - Vector::new(0.004, -0.002, turn_radps)).norm() < 2e-5);
                count += 1;
            }
        }
        count
    }

    #[test]
    fn what_neither_shakes_nor_turns_nor_moves_rests() {
        assert!(rests(0.03, 0.0, Some(0.05)) >= 17);
        assert_eq!(rests(0.3, 0.0, Some(0.05)), 0);
        assert_eq!(rests(0.03, 0.1, Some(0.05)), 0);
        assert_eq!(rests(0.03, 0.0, Some(0.3)), 0);
        assert_eq!(rests(0.03, 0.0, Some(8.0)), 0);
        assert_eq!(rests(0.03, 0.0, None), 0);
        assert_eq!(rests(f64::NAN, 0.0, Some(0.05)), 0);
    }

    /// After how long, s, what glides at this velocity, m/s, after a minute at rest rests no longer.
    fn glides_s(north_mps: f64, down_mps: f64) -> Option<i64> {
        let mut rest = Rest::NONE;
        (0..15_000).find_map(|k| {
            let time = Time::from_nanoseconds(k * 20_000_000);
            let glides = k >= 3_000;
            if k % 50 == 0 {
                let share = if glides { 1.0 } else { 0.0 };
                rest.fix(time, Some([share * north_mps, 0.0, share * down_mps]));
            }
            let rates = MeanRates {
                angular_rate_radps: Vector::new(0.0, 0.0, 0.0),
                specific_force_mps2: Vector::new(0.0, 0.0, -9.8),
            };
            let rested = rest.push(time, &rates, 0.02).is_some();
            // A second that is still ends every fiftieth sample or so.
            let ends = rest.second.count == 0.0;
            (glides && ends && !rested).then_some(k / 50 - 60)
        })
    }

    #[test]
    fn what_glides_as_smoothly_as_rest_is_found_out_by_its_fixes() {
        assert_eq!(glides_s(0.03, 0.05), None);
        for (north_mps, down_mps, within_s) in [(0.0, 0.2, 30), (0.0, 0.15, 45), (0.1, 0.0, 40)] {
            let after_s = glides_s(north_mps, down_mps).unwrap();
            assert!(after_s < within_s, "{north_mps} {down_mps}: {after_s} s");
        }
    }

    #[test]
    fn what_starts_to_turn_rests_no_longer() {
        let mut rest = Rest::NONE;
        for k in 0..1000 {
            let time = Time::from_nanoseconds(k * 20_000_000);
            rest.fix(time, Some([0.0, 0.05, 0.0]));
            let turn = if k < 500 { 0.0 } else { 3e-4 * (k - 500) as f64 };
            let rates = MeanRates {
                angular_rate_radps: Vector::new(turn, 0.0, 0.0),
                specific_force_mps2: Vector::new(0.0, 0.0, -9.8),
            };
            let rested = rest.push(time, &rates, 0.02).is_some();
            assert!(!(rested && k > 600), "{k}");
        }
    }

    /// How many seconds count as rest of a minute at the rate, rad/s, that `rate_radps` gives for a time, s, after a
    /// minute at rest; with a magnetic field where it says how that points then, rad.
    fn rests_while(
        rate_radps: impl Fn(f64) -> f64,
        field_rad: Option<fn(f64) -> f64>,
        down_mps: f64,
    ) -> usize {
        let mut rest = Rest::NONE;
        let mut count = 0;
        for k in 0..12_000 {
            let (time, since_s) =
                (Time::from_nanoseconds(k * 10_000_000), (k - 6000) as f64 * 0.01);
            if k % 20 == 0 {
                let down_mps = if since_s > 0.0 { down_mps } else { 0.0 };
                rest.fix(time, Some([0.0, 0.05, down_mps]));
            }
            if let Some(points) = field_rad {
                let (sine, cosine) = libm::sincos(points(since_s.max(0.0)));
                rest.field(Vector::new(0.2 * cosine, -0.2 * sine, 0.43));
            }
            let rates = MeanRates {
                angular_rate_radps: Vector::new(0.004, 0.0, rate_radps(since_s.max(0.0))),
                specific_force_mps2: Vector::new(0.1, 0.0, -9.8),
            };
            count += usize::from(rest.push(time, &rates, 0.01).is_some() && since_s > 0.0);
        }
        count
    }

    #[test]
    fn a_turn_as_smooth_as_a_bias_is_no_rest_and_a_bias_that_warms_up_is_one() {
        assert!(rests_while(|s| 0.005 + 1.5e-5 * s, None, 0.0) >= 58);
        // A boat at its mooring, a mast that begins to pan, a hoist.
        let swings = rests_while(|s| 0.015 * (0.025 * s).sin(), None, 0.0);
        let pans = rests_while(|s| 0.03 * (0.1 * s).min(1.0), None, 0.0);
        assert!(swings <= 15 && pans <= 2, "{swings} {pans}");
        assert!(rests_while(|_| 0.0, None, -1.0) <= 5);
    }

    #[test]
    fn a_field_that_turns_shows_a_turn_that_began_before() {
        assert!(rests_while(|_| 0.02, Some(|_| 1.0), 0.0) >= 58);
        let pans = rests_while(|_| 0.02, Some(|s| 0.02 * s), 0.0);
        assert!(pans <= 12, "{pans}");
    }
}
