//! The specific force through a shock: how far the readings are believed against what was felt before.

use crate::frames::{Body, Vector};
use crate::scalar::Scalar;

/// By how much a vehicle's own specific force usually changes in a second, and at most, one-sigma, m/s².
const AGILITY_MPS2: f64 = 1.0;
const MOST_AGILITY_MPS2: f64 = 3.0;
/// Memory of the force before a shock, s.
const BEFORE_S: f64 = 0.3;
/// A shock begins with a blow where the shaking, as noise without memory over such a time, s, would cost the
/// integral more than a force that is held.
const WEIGHED_S: f64 = 0.3;
const HELD_COST: f64 =
    MOST_AGILITY_MPS2 * MOST_AGILITY_MPS2 * (BEFORE_S * WEIGHED_S + WEIGHED_S * WEIGHED_S / 3.0);
/// Share of shocks in which the readings were right, as of a catapult.
const PUSHES: f64 = 0.2;
/// Memory of the strongest shaking, s, and the least of it that a sample leaves: a tone between its peaks
/// goes on.
const SHAKING_S: f64 = 0.05;
const LEAST_LEFT: f64 = 0.3;

/// Follows the specific force of one unit: at ease by a short mean, in a shock by a Kalman filter that
/// weighs what shakes against what a vehicle can do.
///
/// A tone of tens of m/s² sampled at a few points of its periods, its tops cut off, adds up to metres a
/// second that were never flown. The vehicle's own force hardly changes while it lasts.
#[derive(Clone, Copy, Debug)]
pub(super) struct HeldForce<T> {
    /// Force that is believed.
    force_mps2: Vector<Body, T>,
    /// The last two readings, the earlier first.
    readings_mps2: [Vector<Body, T>; 2],
    shock: Shock<T>,
}

#[derive(Clone, Copy, Debug)]
struct Shock<T> {
    /// For how long it has lasted, s; zero while there is none.
    lasted_s: T,
    /// Variance of the force that is believed, each axis, (m/s²)².
    variance: T,
    /// Variance of the shaking of late, on the axis that shakes most, (m/s²)².
    shaking: T,
    /// Integral of what was not believed, and the greatest square of its length, (m/s)².
    withheld_mps: Vector<Body, T>,
    greatest_withheld: T,
}

/// How a unit shakes in a shock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shaking<T> {
    /// Variance on the axis that shakes most, by the last reading, (m/s²)².
    pub variance: T,
    /// Whether the last reading is a blow, and may begin a shock.
    pub struck: bool,
}

/// When a reading came, and what it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sampling<T> {
    /// Since the one before, s.
    pub interval_s: T,
    /// Whether the integral is a trapezoid over this reading and the one before.
    pub momentary: bool,
    /// Whether this interval and the two before are of usual length.
    pub even: bool,
}

/// What was made of one reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Held<T> {
    /// Part of the mean force over the interval that is not believed.
    pub withheld_mps2: Vector<Body, T>,
    /// Variance that the interval leaves in the integral of each axis, (m/s)²; none where the reading was
    /// believed.
    pub variance: Option<T>,
}

impl<T: Scalar> HeldForce<T> {
    /// Nothing felt yet.
    pub(super) const NONE: Self =
        Self { force_mps2: Vector::ZERO, readings_mps2: [Vector::ZERO; 2], shock: Shock::NONE };

    /// Takes in the mean or momentary force of a sample, and how the unit shakes, if more than usual.
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
        // What was not believed of the reading before.
        let before = if lasts { first - self.force_mps2 } else { Vector::ZERO };
        let Some(shaking) = shaking.filter(|shaking| lasts || begins(shaking)) else {
            if lasts {
                self.shock = Shock::NONE;
            }
            self.force_mps2 += (reading_mps2 - self.force_mps2) * share;
            let left = if momentary { before * T::of(0.5) } else { Vector::ZERO };
            return Held { withheld_mps2: left, variance: None };
        };
        let mut taken_back = Vector::ZERO;
        if !lasts {
            // A blow shows by its second or third reading: the two before are taken out of the mean, and
            // back whole, though they were in the intervals before.
            for reading in [first, second] {
                let without = self.force_mps2 - reading * share;
                self.force_mps2 = without * (T::ONE / (T::ONE - share));
            }
            taken_back = (first - self.force_mps2) + (second - self.force_mps2);
            self.shock.begin(shaking.variance);
        }
        let weight = self.shock.weigh(shaking.variance, interval_s);
        let off = reading_mps2 - self.force_mps2;
        self.force_mps2 += off * weight;
        let now = off * (T::ONE - weight);
        let in_interval = if momentary { (before + now) * T::of(0.5) } else { now };
        let withheld_mps2 = taken_back + in_interval;
        Held { withheld_mps2, variance: Some(self.shock.leaves(withheld_mps2, interval_s)) }
    }

    /// Ends a shock, after a gap.
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

    fn begin(&mut self, shaking: T) {
        self.variance = T::of(AGILITY_MPS2 * AGILITY_MPS2 * BEFORE_S);
        self.shaking = shaking;
    }

    /// The weight of a reading against the force that is believed.
    fn weigh(&mut self, shaking: T, interval_s: T) -> T {
        let left = (T::ONE - interval_s * T::of(1.0 / SHAKING_S)).max(T::of(LEAST_LEFT));
        self.shaking = shaking.max(left * self.shaking);
        self.variance += T::of(AGILITY_MPS2 * AGILITY_MPS2) * interval_s;
        let weight = self.variance / (self.variance + self.shaking);
        self.variance = self.variance * (T::ONE - weight);
        weight
    }

    /// What an interval leaves in the integral of each axis, (m/s)²: the force wrong by the same all through
    /// the shock, or the readings right where they were not believed.
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

    /// A unit at rest that feels `felt` for so many samples, the shaking as its second differences have it:
    /// by how much the integral of what is believed is off that of what was `moved`, m/s, and the
    /// one-sigma of it.
    fn error(
        interval_s: f64,
        momentary: bool,
        felt: &[f64],
        moved: impl Fn(usize) -> f64,
    ) -> (f64, f64) {
        let (mut held, mut error_mps, mut variance) = (HeldForce::<f64>::NONE, 0.0, 0.0);
        let (mut last, mut strengths) = ([0.0; 2], Vec::new());
        for step in 0..300 + felt.len() {
            let place = step.checked_sub(200).filter(|place| *place < felt.len());
            let reading = place.map_or(0.0, |place| felt[place]);
            let [before_that, before] = last;
            let bend: f64 = reading - 2.0 * before + before_that;
            last = [before, reading];
            strengths.push(bend * bend / 6.0);
            let recent = strengths.iter().rev().take(5).sum::<f64>() / 5.0;
            let (strength, struck) = (bend * bend / 6.0, bend * bend / 6.0 > 50.0 * QUIET);
            let shaking = Shaking { variance: strength.max(QUIET), struck };
            let shaking = (recent > 8.0 * QUIET).then_some(shaking);
            let force = Vector::new(reading, 0.0, -9.8);
            let sampling = Sampling { interval_s, momentary, even: true };
            let found = held.push(force, shaking, &sampling);
            let mean = if momentary { 0.5 * (before + reading) } else { reading };
            let [withheld, _, _] = found.withheld_mps2.to_array();
            error_mps += (mean - withheld - place.map_or(0.0, &moved)) * interval_s;
            variance += found.variance.unwrap_or_default();
        }
        (error_mps, variance.sqrt())
    }

    #[test]
    fn a_tone_that_ends_at_full_scale_moves_little_and_within_three_sigmas() {
        let mut squares = Vec::new();
        for (momentary, turn_rad) in
            [true, false].into_iter().flat_map(|m| [(m, 1.3), (m, 2.0), (m, 2.8)])
        {
            for phase in 0..20 {
                let tone =
                    |k: u32| 35.0 * (0.314 * f64::from(phase) + turn_rad * f64::from(k)).sin();
                let felt: Vec<f64> = (0..10).map(|k| tone(k).clamp(-29.4, 29.4)).collect();
                let (error_mps, sigma_mps) = error(0.03, momentary, &felt, |_| 0.0);
                assert!(
                    error_mps.abs() < 3.0 * sigma_mps,
                    "{phase} {turn_rad}: {error_mps} of {sigma_mps} m/s"
                );
                squares.push(error_mps * error_mps);
            }
        }
        let rms_mps = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        assert!(rms_mps < 0.2, "{rms_mps} m/s");
    }

    #[test]
    fn a_push_that_is_taken_for_a_shock_is_within_three_sigmas() {
        for momentary in [true, false] {
            for lasts in [1, 2, 4, 10, 30] {
                let felt = vec![40.0; lasts];
                let (error_mps, sigma_mps) = error(0.03, momentary, &felt, |_| 40.0);
                assert!(
                    error_mps.abs() < 3.0 * sigma_mps,
                    "{lasts}: {error_mps} of {sigma_mps} m/s"
                );
                assert!(error_mps.abs() < 7.0, "{lasts}: {error_mps} m/s");
            }
        }
    }

    #[test]
    fn bumps_of_a_unit_that_is_sampled_fast_are_believed() {
        let felt = [3.0, 9.0, 4.0, -6.0, 2.0];
        assert_eq!(error(0.01, true, &felt, |place| felt[place]).1, 0.0);
    }
}
