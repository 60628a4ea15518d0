//! Specific force during a shock: weighs the readings against the estimated force from before the shock.

use crate::frames::{Body, Vector};
use crate::scalar::Scalar;

/// Usual change of a vehicle's own specific force within a second, one-sigma, m/s².
const AGILITY_MPS2: f64 = 1.0;
/// Largest change of a vehicle's own specific force within a second, one-sigma, m/s².
const MAX_AGILITY_MPS2: f64 = 3.0;
/// Memory of the force before a shock, s.
const BEFORE_S: f64 = 0.3;
/// Growth per second of the variance of the force estimated during a shock, (m/s²)²/s.
const DRIFT: f64 = AGILITY_MPS2 * AGILITY_MPS2;
/// Variance of the estimated force before a shock, (m/s²)².
const AT_EASE: f64 = DRIFT * BEFORE_S;
/// Integration time, s, for detecting the start of a shock. The vibration counts as white noise. Its variance in the
/// integral over this time is compared with [`HELD_COST`].
const WEIGHED_S: f64 = 0.3;
/// Variance of the integral of a held force over that time, (m/s)². A shock begins when the vibration adds more than
/// this.
const HELD_COST: f64 =
    MAX_AGILITY_MPS2 * MAX_AGILITY_MPS2 * (BEFORE_S * WEIGHED_S + WEIGHED_S * WEIGHED_S / 3.0);
/// Limit of the difference between a reading and the estimated force while a tone is clipped, in one-sigmas of the
/// vibration. Larger differences are clamped. The estimate is then nearly a median; one-sided clipping hardly shifts
/// it.
const FURTHEST_SIGMAS: f64 = 0.5;
/// Fraction of shocks whose readings are true motion, as in a catapult launch.
const PUSHES: f64 = 0.2;
/// Memory of the strongest vibration, s.
const SHAKING_S: f64 = 0.05;
/// Smallest decay factor of the strongest vibration per sample: a tone continues between its peaks.
const MIN_LEFT: f64 = 0.3;

/// Estimates the specific force of one inertial unit by a short mean. In a shock, a Kalman filter replaces the mean.
/// Its measurement noise is the vibration, its process noise the agility of a vehicle.
///
/// A tone of tens of m/s², sampled a few times per period and clipped, integrates to a velocity error of metres per
/// second. The vehicle's own force hardly changes during that time.
#[derive(Clone, Copy, Debug)]
pub(super) struct HeldForce<T> {
    /// Estimated force, m/s².
    force_mps2: Vector<Body, T>,
    /// The last two readings, the earlier first.
    readings_mps2: [Vector<Body, T>; 2],
    shock: Shock<T>,
}

#[derive(Clone, Copy, Debug)]
struct Shock<T> {
    /// Duration of the shock, s; zero without one.
    lasted_s: T,
    /// Variance of the estimated force per axis, (m/s²)². Without a shock it grows with each reading excluded from the
    /// mean.
    variance: T,
    /// Recent vibration variance on the strongest axis, (m/s²)².
    shaking: T,
    /// Integral of the excluded force over the shock, m/s.
    withheld_mps: Vector<Body, T>,
    /// Greatest square of the length of that integral, (m/s)².
    greatest_withheld: T,
}

/// Vibration of an inertial unit in a shock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shaking<T> {
    /// Variance on the axis with the strongest vibration, from the last reading, (m/s²)².
    pub variance: T,
    /// Whether the last reading is strong enough to begin a shock.
    pub struck: bool,
    /// Whether recent readings were at full scale.
    pub cut_off: bool,
}

/// Timing and form of a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sampling<T> {
    /// Time since the previous reading, s.
    pub interval_s: T,
    /// Whether readings are momentary. The integral is then a trapezoid over this reading and the previous one.
    pub momentary: bool,
    /// Whether this interval and the two before it have the usual length.
    pub even: bool,
}

/// Result for one reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Held<T> {
    /// Part of the mean force over the interval that is excluded as a shock, m/s².
    pub withheld_mps2: Vector<Body, T>,
    /// Variance that the interval adds to the integral of each axis, (m/s)²; `None` if the whole reading was used.
    pub variance: Option<T>,
}

impl<T: Scalar> HeldForce<T> {
    /// State before the first reading.
    pub(super) const NONE: Self =
        Self { force_mps2: Vector::ZERO, readings_mps2: [Vector::ZERO; 2], shock: Shock::NONE };

    /// Feeds the mean or momentary force of a sample, and the vibration if it is above usual.
    ///
    /// # Source
    /// Equation (S16) of docs/equations.md.
    pub(super) fn push(
        &mut self,
        reading_mps2: Vector<Body, T>,
        shaking: Option<Shaking<T>>,
        sampling: &Sampling<T>,
    ) -> Held<T> {
        let Sampling { interval_s, momentary, even } = *sampling;
        let [second, first] = self.readings_mps2;
        self.readings_mps2 = [first, reading_mps2];
        let share = (interval_s * T::of(1.0 / BEFORE_S)).min(T::ONE);
        let lasts = self.shock.lasted_s > T::ZERO;
        let begins = |shaking: &Shaking<T>| {
            let costs = shaking.variance * interval_s > T::of(HELD_COST / WEIGHED_S);
            shaking.struck && costs && even && share < T::of(0.5)
        };
        // Excluded part of the previous reading.
        let before = if lasts { first - self.force_mps2 } else { Vector::ZERO };
        let shakes = shaking.is_some();
        let Some(shaking) = shaking.filter(|shaking| lasts || begins(shaking)) else {
            if lasts {
                self.shock = Shock::NONE;
            }
            if shakes && self.shock.variance < T::of(2.0 * AT_EASE) {
                // The reading may be the first of a shock.
                self.shock.variance += T::of(DRIFT) * interval_s;
            } else {
                self.force_mps2 += (reading_mps2 - self.force_mps2) * share;
                if !shakes {
                    self.shock.variance = T::of(AT_EASE);
                }
            }
            let left = if momentary { before * T::of(0.5) } else { Vector::ZERO };
            return Held { withheld_mps2: left, variance: None };
        };
        let mut taken_back = Vector::ZERO;
        if !lasts {
            // A shock is detected only at its second or third reading. The two readings before are therefore removed
            // from the mean. Their excluded parts count fully in this interval, although the readings are from earlier
            // intervals.
            let omitted = self.shock.omitted(interval_s);
            for reading in [first, second].into_iter().skip(omitted) {
                let without = self.force_mps2 - reading * share;
                self.force_mps2 = without * (T::ONE / (T::ONE - share));
            }
            taken_back = (first - self.force_mps2) + (second - self.force_mps2);
            self.shock.shaking = shaking.variance;
        }
        let weight = self.shock.weigh(shaking.variance, interval_s);
        let off = reading_mps2 - self.force_mps2;
        let accepted = if shaking.cut_off { self.shock.limited(off) } else { off } * weight;
        self.force_mps2 += accepted;
        let now = off - accepted;
        let in_interval = if momentary { (before + now) * T::of(0.5) } else { now };
        let withheld_mps2 = taken_back + in_interval;
        Held { withheld_mps2, variance: Some(self.shock.leaves(withheld_mps2, interval_s)) }
    }

    /// Ends a shock after a gap.
    pub(super) fn interrupt(&mut self) {
        self.shock = Shock::NONE;
    }
}

impl<T: Scalar> Shock<T> {
    const NONE: Self = Self {
        lasted_s: T::ZERO,
        variance: T::ZERO,
        shaking: T::ZERO,
        withheld_mps: Vector::ZERO,
        greatest_withheld: T::ZERO,
    };

    /// Number of the last two readings excluded from the mean.
    fn omitted(&self, interval_s: T) -> usize {
        let [omitted, one] = [self.variance - T::of(AT_EASE), T::of(DRIFT) * interval_s];
        usize::from(omitted > T::of(0.5) * one) + usize::from(omitted > T::of(1.5) * one)
    }

    /// Weight, 0 to 1, of a reading against the estimated force.
    fn weigh(&mut self, shaking: T, interval_s: T) -> T {
        let left = (T::ONE - interval_s * T::of(1.0 / SHAKING_S)).max(T::of(MIN_LEFT));
        self.shaking = shaking.max(left * self.shaking);
        self.variance += T::of(DRIFT) * interval_s;
        let weight = self.variance / (self.variance + self.shaking);
        self.variance = self.variance * (T::ONE - weight);
        weight
    }

    /// Limits the distance of a clipped reading from the estimated force.
    fn limited(&self, off_mps2: Vector<Body, T>) -> Vector<Body, T> {
        let furthest = T::of(FURTHEST_SIGMAS) * self.shaking.sqrt();
        off_mps2.to_array().map(|off| off.max(-furthest).min(furthest)).into()
    }

    /// Variance that an interval adds to the integral of each axis, (m/s)². It covers a constant error of the estimated
    /// force throughout the shock, and excluded readings that were true motion.
    fn leaves(&mut self, withheld_mps2: Vector<Body, T>, interval_s: T) -> T {
        let held = self.variance * interval_s * (T::of(2.0) * self.lasted_s + interval_s);
        self.lasted_s += interval_s;
        self.withheld_mps += withheld_mps2 * interval_s;
        let withheld = self.withheld_mps.dot(self.withheld_mps);
        let grown = (withheld - self.greatest_withheld).max(T::ZERO);
        self.greatest_withheld = self.greatest_withheld.max(withheld);
        held + T::of(PUSHES) * grown
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUIET: f64 = 0.25;
    const FULL_SCALE: f64 = 29.4;

    /// An inertial unit: its sampling interval, s, and its force outside shocks, m/s².
    struct Unit {
        interval_s: f64,
        momentary: bool,
        steady: f64,
        full_scale: f64,
    }

    impl Unit {
        /// Feeds the force `felt`, clipped at full scale, one value a sample, with the vibration from its second
        /// differences. Returns the error of the integrated estimate against `moved`, m/s, and its one-sigma.
        fn error(&self, felt: &[f64], moved: impl Fn(usize) -> f64) -> (f64, f64) {
            let Self { interval_s, momentary, steady, full_scale } = *self;
            let (mut held, mut error_mps, mut variance) = (HeldForce::<f64>::NONE, 0.0, 0.0);
            let (mut last, mut strengths, mut clipped) = ([steady; 2], Vec::new(), Vec::new());
            for step in 0..300 + felt.len() {
                let place = step.checked_sub(200).filter(|place| *place < felt.len());
                let true_reading = place.map_or(steady, |place| felt[place]);
                let reading = true_reading.clamp(-full_scale, full_scale);
                let [before_that, before] = last;
                let bend: f64 = reading - 2.0 * before + before_that;
                last = [before, reading];
                strengths.push(bend * bend / 6.0);
                let recent = strengths.iter().rev().take(5).sum::<f64>() / 5.0;
                let is_tone = recent > 0.04 * full_scale * full_scale;
                clipped.push(reading.abs() == full_scale && is_tone);
                // As in equation (S13).
                let cut_off = clipped.iter().rev().take(5).any(|clipped| *clipped);
                let (strength, struck) = (bend * bend / 6.0, bend * bend / 6.0 > 50.0 * QUIET);
                let shaking = Shaking { variance: strength.max(QUIET), struck, cut_off };
                let shaking = (cut_off || recent > 8.0 * QUIET).then_some(shaking);
                let force = Vector::new(reading, 0.0, -9.8);
                let sampling = Sampling { interval_s, momentary, even: true };
                let found = held.push(force, shaking, &sampling);
                let mean = if momentary { 0.5 * (before + reading) } else { reading };
                let [withheld, _, _] = found.withheld_mps2.to_array();
                error_mps += (mean - withheld - place.map_or(steady, &moved)) * interval_s;
                variance += found.variance.unwrap_or_default();
            }
            (error_mps, variance.sqrt())
        }
    }

    /// RMS error, m/s, left by tones of 35 m/s² about this force over `samples` samples. Asserts that each error is
    /// within three one-sigmas.
    fn left_by_tones(steady: f64, samples: u32) -> f64 {
        let mut squares = Vec::new();
        for (momentary, turn_rad) in
            [true, false].into_iter().flat_map(|m| [(m, 1.3), (m, 2.0), (m, 2.8)])
        {
            let unit = Unit { interval_s: 0.03, momentary, steady, full_scale: FULL_SCALE };
            for phase in 0..20 {
                let tone = |k: u32| (0.314 * f64::from(phase) + turn_rad * f64::from(k)).sin();
                let felt: Vec<f64> = (0..samples).map(|k| steady + 35.0 * tone(k)).collect();
                let (error_mps, sigma_mps) = unit.error(&felt, |_| steady);
                assert!(
                    error_mps.abs() < 3.0 * sigma_mps,
                    "{phase} {turn_rad}: {error_mps} of {sigma_mps} m/s"
                );
                squares.push(error_mps * error_mps);
            }
        }
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    }

    #[test]
    fn a_tone_that_ends_at_full_scale_moves_little_and_within_three_sigmas() {
        let rms_mps = left_by_tones(0.0, 10);
        assert!(rms_mps < 0.1, "{rms_mps} m/s");
    }

    #[test]
    fn a_tone_that_is_cut_off_on_one_side_for_seconds_moves_little() {
        // The mean of the clipped readings is 3.5 m/s² too low.
        let rms_mps = left_by_tones(9.8, 100);
        assert!(rms_mps < 0.4, "{rms_mps} m/s");
    }

    #[test]
    fn a_push_that_is_taken_for_a_shock_is_within_three_sigmas() {
        for (momentary, full_scale) in
            [true, false].into_iter().flat_map(|m| [(m, FULL_SCALE), (m, f64::INFINITY)])
        {
            let unit = Unit { interval_s: 0.03, momentary, steady: 0.0, full_scale };
            for lasts in [1, 2, 4, 10, 30] {
                let felt = vec![40.0; lasts];
                let (error_mps, sigma_mps) = unit.error(&felt, |_| full_scale.min(40.0));
                assert!(
                    error_mps.abs() < 3.0 * sigma_mps,
                    "{lasts}: {error_mps} of {sigma_mps} m/s"
                );
                let max_mps = if full_scale < 40.0 { 11.0 } else { 7.0 };
                assert!(error_mps.abs() < max_mps, "{lasts}: {error_mps} m/s");
            }
        }
    }

    #[test]
    fn bumps_of_a_unit_that_is_sampled_fast_are_accepted() {
        let felt = [3.0, 9.0, 4.0, -6.0, 2.0];
        let unit = Unit { interval_s: 0.01, momentary: true, steady: 0.0, full_scale: FULL_SCALE };
        assert_eq!(unit.error(&felt, |place| felt[place]).1, 0.0);
    }
}
