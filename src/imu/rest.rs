//! Detection of rest from samples, fixes and magnetic field.

use super::MeanRates;
use crate::frames::{Body, Vector};
use crate::scalar::Scalar;
use crate::time::Time;

/// Detects rest: seconds without vibration, without change, and with stationary fixes.
///
/// An engine, a rotor or a road causes vibration above 0.1 m/s². A panning mast or a swinging boat may turn as smoothly
/// as a gyro bias. No bias changes by 0.1 °/s within a minute, though, and a bias does not turn the magnetic field.
/// Without fix velocities, rest is not detected.
#[derive(Clone, Copy, Debug)]
pub struct Rest {
    second: Second,
    /// Means of the previous second, if still.
    before: Option<[f32; AXES]>,
    /// Means over the recent seconds, if all were still.
    stillness: Option<Stillness>,
    /// Latest magnetic field of the current second.
    field: Option<[f32; 3]>,
    /// Time of the last fix, and the recent mean velocity of the fixes, north, east and down, m/s.
    fixes: (Time, Option<[f32; 3]>),
    /// Whether the vehicle is at rest: set by a second of rest, cleared by a second with motion.
    rests: bool,
    /// Whether the last sample ended a second with motion, and that second was the first after rest.
    moves_off: bool,
    /// Time, s, for which the fixes have been slow and no second had motion.
    slow_s: f32,
}

/// Number of axes: three rates, then three forces.
const AXES: usize = 6;

/// Largest standard deviation of the gyros at rest, rad/s.
const STILL_RADPS: f32 = 0.012;
/// Largest standard deviation of the accelerometers at rest, m/s².
const STILL_MPS2: f32 = 0.1;
/// Largest change of a mean rate from one second to the next at rest, rad/s.
const STEADY_RADPS: f32 = 0.005;
/// Largest change of a mean force from one second to the next at rest, m/s².
const STEADY_MPS2: f32 = 0.05;
/// Largest change of a mean rate from its recent mean at rest, rad/s, by noise and warming up.
const DRIFT_RADPS: f32 = 0.002;
/// Sine of the largest turn of the magnetic field from its recent mean.
const FIELD_TURN: f32 = 0.07;
/// Time constant of the recent means, s.
const STILLNESS_S: f32 = 60.0;
/// Largest gyro bias, rad/s; a faster turn is not rest.
const LARGEST_BIAS_RADPS: f32 = 0.05;
/// Largest horizontal velocity of one fix at rest, m/s.
const FIX_MPS: f32 = 0.5;
/// Largest horizontal velocity of the mean of the fixes at rest, m/s, for the shortest averaging time. It decreases
/// with the square root of the averaging time.
const FIX_MEAN_MPS: f32 = 0.15;
/// Largest vertical velocity of one fix at rest, m/s.
const FIX_DOWN_MPS: f32 = 1.0;
/// Largest vertical velocity of the mean of the fixes at rest, m/s, for the shortest averaging time. It decreases with
/// the square root of the averaging time.
const FIX_MEAN_DOWN_MPS: f32 = 0.25;
/// Averaging time of the mean of the fixes, s: the time for which the fixes have been slow, within this range. The
/// receiver's error of the mean decreases with the square root of the averaging time.
const FIX_MEMORY_S: core::ops::RangeInclusive<f32> = 5.0..=30.0;
/// Largest age of a fix, s, that is evidence of rest.
const FIX_S: f64 = 3.0;
/// Longest interval, s, between two samples: a longer one may hide motion, so the second starts again.
const LONGEST_INTERVAL_S: f64 = 0.1;

/// Sums over the current second, relative to its first sample.
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

    /// Means, if no axis vibrates.
    fn still_means(&self) -> Option<[f32; AXES]> {
        let mut means = self.first;
        let still = limits(STILL_RADPS, STILL_MPS2);
        let sums = self.sum.iter().zip(&self.squares).zip(still);
        for (mean, ((&sum, &squares), limit)) in means.iter_mut().zip(sums) {
            let above = sum / self.count;
            // The comparison also rejects NaN.
            let is_still = squares / self.count - above * above < limit * limit;
            if !is_still {
                return None;
            }
            *mean += above;
        }
        Some(means)
    }
}

/// Means over the recent seconds.
#[derive(Clone, Copy, Debug)]
struct Stillness {
    rates: [f32; 3],
    field: Option<[f32; 3]>,
}

impl Stillness {
    /// Adds a still second with mean rates `rates`, rad/s, and its field if measured. Returns whether the second
    /// continues the stillness.
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

/// Updates a mean over the recent seconds with the newest value.
fn fade_in(mean: &mut [f32; 3], newest: [f32; 3]) {
    for (mean, newest) in mean.iter_mut().zip(newest) {
        *mean += (newest - *mean) / STILLNESS_S;
    }
}

/// Whether two fields differ in direction.
fn is_turned(old: [f32; 3], new: [f32; 3]) -> bool {
    let ([a, b, c], [x, y, z]) = (old, new);
    let across = [b * z - c * y, c * x - a * z, a * y - b * x];
    squared(across) > FIELD_TURN * FIELD_TURN * squared(old) * squared(new)
}

fn squared(of: [f32; 3]) -> f32 {
    of.iter().map(|value| value * value).sum()
}

/// Whether a velocity, m/s, exceeds the horizontal or the vertical limit. Uses squares, because a root is slow without
/// a hardware instruction.
fn is_faster([north, east, down]: [f32; 3], level_mps: f32, down_mps: f32) -> bool {
    north * north + east * east > level_mps * level_mps || down.abs() > down_mps
}

/// A limit for each axis.
fn limits(gyro: f32, accel: f32) -> [f32; AXES] {
    [gyro, gyro, gyro, accel, accel, accel]
}

/// Classification of a second.
enum Kind {
    /// Rest, like the second before.
    Rest,
    /// As still as rest, but possibly a smooth turn.
    Doubtful,
    /// Motion.
    Motion,
}

impl Rest {
    /// State before the first sample.
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

    /// Feeds the velocity of a fix, north, east and down, m/s. An axis without velocity is zero; a fix without velocity
    /// is `None`.
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

    /// Averaging time of the fixes' mean velocity, s.
    fn fix_memory_s(&self) -> f32 {
        self.slow_s.max(*FIX_MEMORY_S.start()).min(*FIX_MEMORY_S.end())
    }

    /// Recent mean velocity of the fixes, north, east and down, m/s; zero if unknown.
    pub fn fixes_mean_mps(&self) -> [f32; 3] {
        self.fixes.1.unwrap_or([0.0; 3])
    }

    /// Feeds a magnetic field, in any unit.
    pub fn field(&mut self, field: Vector<Body>) {
        self.field = Some(field.to_array().map(|axis| axis as f32));
    }

    /// Feeds a sample, `interval_s` after the previous one. Returns the mean angular rate, rad/s, of a second that ends
    /// with this sample. `None` unless the vehicle rested through that second and the one before.
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

    /// Whether the last sample ended a second with motion, and that second was the first after rest.
    pub fn moves_off(&self) -> bool {
        self.moves_off
    }

    /// Classifies a second by its means; `means` is `None` for a second that was not still.
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

    /// Number of seconds, of 20, that count as rest with this vibration, this turn rate and this speed of the fixes.
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
                // The vibration alternates in sign. In a second with an odd number of samples one of them is not
                // cancelled.
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

    /// Time, s, until rest ends for a vehicle that glides at this velocity, m/s, after a minute at rest.
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
            // A still second ends about every fiftieth sample.
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

    /// Number of seconds of a minute that count as rest after a minute at rest. `rate_radps` gives the rate, rad/s, at
    /// a time, s; `field_rad` the direction of the magnetic field, rad, if any.
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
        // Motions that are not rest: a boat at its mooring, a mast that begins to pan, and a hoist.
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
