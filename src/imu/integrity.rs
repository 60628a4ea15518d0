//! What a sample cannot tell: full scale, shocks, samples that came late or not at all.

use core::fmt;

use super::held_force::{HeldForce, Shaking};
use super::repetition::Repetition;
use super::second_difference::SecondDifference;
use super::{ClippedAxes, Motion};
use crate::frames::{Body, Vector};
use crate::scalar::Scalar;

/// The greatest readings a unit can give; zero where it is not known, and then learned from readings
/// that repeat their own maximum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FullScale {
    /// Of each gyro, rad/s.
    pub gyro_radps: f64,
    /// Of each accelerometer, m/s².
    pub accel_mps2: f64,
}

/// What is known against the last sample: see [`Integrity::push`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Suspicion<T = f64> {
    /// Which gyros stand at their full scale.
    pub gyro_clipped: [bool; 3],
    /// Which accelerometers stand at their full scale.
    pub accel_clipped: [bool; 3],
    /// Whether an axis repeats itself to the last digit, though the unit vibrates.
    pub stuck: bool,
    /// Whether the unit takes blows, far beyond its vibration of the last seconds.
    pub shaken: bool,
    /// Variance that the sample's interval adds to the integral of rate beside the usual noise, rad².
    pub angle_variance: [T; 3],
    /// Variance that it adds to the integral of specific force, (m/s)².
    pub velocity_variance: [T; 3],
    /// Part of the mean specific force over the interval that is a shock and not believed, m/s².
    pub withheld_mps2: Vector<Body, T>,
}

impl<T: Scalar> Suspicion<T> {
    /// Nothing known against a sample.
    pub const NONE: Self = Self {
        gyro_clipped: [false; 3],
        accel_clipped: [false; 3],
        stuck: false,
        shaken: false,
        angle_variance: [T::ZERO; 3],
        velocity_variance: [T::ZERO; 3],
        withheld_mps2: Vector::ZERO,
    };

    /// The same in numbers of another type.
    #[must_use]
    pub fn cast<U: Scalar>(&self) -> Suspicion<U> {
        Suspicion {
            gyro_clipped: self.gyro_clipped,
            accel_clipped: self.accel_clipped,
            stuck: self.stuck,
            shaken: self.shaken,
            angle_variance: self.angle_variance.map(|variance| U::of(variance.wide())),
            velocity_variance: self.velocity_variance.map(|variance| U::of(variance.wide())),
            withheld_mps2: self.withheld_mps2.cast(),
        }
    }

    /// Whether it hides how the vehicle turned or what was felt: a gyro at full scale, an axis that is stuck.
    #[must_use]
    pub(crate) fn hides_motion(&self) -> bool {
        self.stuck || self.gyro_clipped.contains(&true)
    }

    /// Whether any sensor stands at its full scale.
    #[must_use]
    pub fn is_clipped(&self) -> bool {
        self.gyro_clipped.iter().chain(&self.accel_clipped).any(|&clipped| clipped)
    }
}

impl fmt::Display for Suspicion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.accel_clipped.contains(&true) {
            "an accelerometer at full scale"
        } else if self.gyro_clipped.contains(&true) {
            "a gyro at full scale"
        } else if self.stuck {
            "an axis that repeats itself"
        } else if self.shaken {
            "shaken far beyond the usual"
        } else {
            "nothing known against it"
        })
    }
}

/// Watches the samples of one unit.
///
/// A vibrating unit's trapezoids add up to a small error only while the samples are whole and evenly
/// spaced: what exceeds full scale, what shakes for a moment, and what was lost on the line leaves an
/// error of full size.
#[derive(Clone, Copy, Debug)]
pub struct Integrity<T = f64> {
    gyro: Triad<T>,
    accel: Triad<T>,
    held: HeldForce<T>,
    typical_interval_s: T,
    last: Option<Motion<T>>,
    repeated: u8,
}

/// Readings below these are not taken for a learned full scale, rad/s and m/s².
const LEAST_GYRO_SCALE: f64 = 1.5;
const LEAST_ACCEL_SCALE: f64 = 17.0;
/// A maximum that came back this often is a full scale.
const REPEATS: u32 = 4;
/// Memory of the shaking now, and of the usual, s.
const NOW_S: f64 = 0.15;
const USUAL_S: f64 = 5.0;
/// What is usual is known after this long, s.
const LEAST_SEEN_S: f64 = 1.0;
/// Shaking now of more than so many times the usual variance is a shock.
const SHOCK: f64 = 8.0;
/// Shaking of more than so many times the usual variance, and of such a size, is a blow: a landing is
/// not, a propeller that breaks is.
const BLOW: f64 = 50.0;
const LEAST_GYRO_BLOW: f64 = 3.0;
const LEAST_ACCEL_BLOW: f64 = 20.0;
/// Least usual shaking: below it any touch would be a shock, rad/s and m/s².
const LEAST_GYRO_SHAKING: f64 = 0.03;
const LEAST_ACCEL_SHAKING: f64 = 0.3;
/// So many repetitions in a row are a unit that does not measure.
const STUCK: u8 = 2;
/// Vibration of less than this, (m/s²)², may leave readings as they were.
const LEAST_VIBRATION: f64 = 0.0025;
/// What an axis that is stuck may hide, one-sigma, rad/s and m/s²; it has one error for at most so long, s.
const STUCK_GYRO_RADPS: f64 = 0.2;
const STUCK_ACCEL_MPS2: f64 = 2.0;
const LONGEST_STUCK_S: f64 = 5.0;
/// What may lie beyond full scale, as a share of it, one-sigma.
const BEYOND_SCALE: f64 = 0.15;
/// A burst of clipping is forgotten after this long without, and has one error for at most so long, s.
const BURST_S: f64 = 0.3;
const LONGEST_BURST_S: f64 = 0.5;

/// What is known against the last readings of three axes.
struct Found<T> {
    clipped: [bool; 3],
    /// How the axes shake where any takes a shock.
    shock: Option<Shaking<T>>,
    shaken: bool,
    /// What the interval adds to the variance of the integral.
    variance: [T; 3],
    stuck: bool,
}

#[derive(Clone, Copy, Debug)]
struct Triad<T> {
    difference: SecondDifference<T>,
    now: [T; 3],
    usual: [T; 3],
    largest: [T; 3],
    repeats: [u32; 3],
    /// For how long each has been clipped of late, s.
    clipped_s: [T; 3],
    repetition: Repetition<T>,
    seen_s: T,
}

impl<T: Scalar> Triad<T> {
    const NONE: Self = Self {
        difference: SecondDifference::NONE,
        now: [T::ZERO; 3],
        usual: [T::ZERO; 3],
        largest: [T::ZERO; 3],
        repeats: [0; 3],
        clipped_s: [T::ZERO; 3],
        repetition: Repetition::NONE,
        seen_s: T::ZERO,
    };
}

impl<T: Scalar> Integrity<T> {
    /// Nothing seen yet.
    pub const NONE: Self = Self {
        gyro: Triad::NONE,
        accel: Triad::NONE,
        held: HeldForce::NONE,
        typical_interval_s: T::ZERO,
        last: None,
        repeated: 0,
    };

    /// Whether a sample repeats the two before in all six readings although the unit vibrates: its
    /// registers were not written, and it tells nothing. One repetition is how a log that was sampled
    /// faster than its unit looks.
    pub fn is_stuck(&mut self, motion: &Motion<T>) -> bool {
        let vibrates = self.accel.usual.iter().any(|&variance| variance > T::of(LEAST_VIBRATION));
        self.repeated =
            if self.last == Some(*motion) { self.repeated.saturating_add(1) } else { 0 };
        self.last = Some(*motion);
        vibrates && self.repeated >= STUCK
    }

    /// Takes in the motion of a sample, `interval_s` after the one before, with the unit's own marks of full
    /// scale.
    ///
    /// # Source
    /// Equation (S13) of docs/equations.md.
    pub fn push(
        &mut self,
        motion: &Motion<T>,
        marks: &ClippedAxes,
        interval_s: T,
        scale: &FullScale,
    ) -> Suspicion<T> {
        let rates = motion.mean_rates(interval_s);
        if self.typical_interval_s == T::ZERO {
            self.typical_interval_s = interval_s;
        }
        // Half a percent a sample, and no more for an interval that is itself unusual.
        let typical = self.typical_interval_s;
        let longest = T::of(1.5) * typical;
        self.typical_interval_s += T::of(0.005) * (interval_s.min(longest) - typical);
        let late_s = (interval_s - longest).max(T::ZERO);

        let gyro = self.gyro.push(
            (rates.angular_rate_radps, marks.gyro),
            interval_s,
            (scale.gyro_radps, LEAST_GYRO_SCALE, LEAST_GYRO_SHAKING, LEAST_GYRO_BLOW),
            (late_s, STUCK_GYRO_RADPS),
        );
        let accel = self.accel.push(
            (rates.specific_force_mps2, marks.accel),
            interval_s,
            (scale.accel_mps2, LEAST_ACCEL_SCALE, LEAST_ACCEL_SHAKING, LEAST_ACCEL_BLOW),
            (late_s, STUCK_ACCEL_MPS2),
        );
        let momentary = matches!(motion, Motion::Rates { .. });
        let held = self.held.push(rates.specific_force_mps2, accel.shock, interval_s, momentary);
        Suspicion {
            gyro_clipped: gyro.clipped,
            accel_clipped: accel.clipped,
            stuck: gyro.stuck || accel.stuck,
            shaken: gyro.shaken || accel.shaken,
            angle_variance: gyro.variance,
            velocity_variance: held.variance.unwrap_or(accel.variance),
            withheld_mps2: held.withheld_mps2,
        }
    }

    /// Forgets the last two samples, after a gap.
    pub fn interrupt(&mut self) {
        self.gyro.difference.interrupt();
        self.accel.difference.interrupt();
    }
}

impl<T: Scalar> Triad<T> {
    fn push(
        &mut self,
        (sample, marks): (Vector<Body, T>, [bool; 3]),
        interval_s: T,
        (scale, least_scale, least_shaking, least_blow): (f64, f64, f64, f64),
        (late_s, stuck_sigma): (T, f64),
    ) -> Found<T> {
        let number = T::of;
        let square = |value: T| value * value;
        let values = sample.to_array();
        let bend = self.difference.push(sample).unwrap_or_default();
        // A plain mean until the memory is filled.
        self.seen_s = number(USUAL_S).min(self.seen_s + interval_s);
        let (known, usual_weight) = (self.seen_s > number(LEAST_SEEN_S), interval_s / self.seen_s);
        let (mut clipped, mut shaken, mut variance) = ([false; 3], false, [T::ZERO; 3]);
        let (mut shock, mut struck, mut strongest) = (false, false, T::ZERO);
        let axes = self.now.iter_mut().zip(&mut self.usual).zip(&mut self.largest);
        let axes = axes.zip(&mut self.repeats).zip(&mut self.clipped_s);
        let values = values.into_iter().zip(bend).zip(marks);
        let results = clipped.iter_mut().zip(&mut variance);
        for (
            ((((now, usual), largest), repeats), clipped_s),
            (((value, bend), marked), (clipped, variance)),
        ) in axes.zip(values.zip(results))
        {
            let size = value.abs();
            if size > *largest {
                (*largest, *repeats) = (size, 1);
            } else if size == *largest {
                *repeats = repeats.saturating_add(1);
            }
            let learned =
                *repeats >= REPEATS && *largest >= number(least_scale) && size == *largest;
            *clipped = marked || learned || (scale > 0.0 && size >= number(0.998 * scale));

            let strength = bend * bend / number(6.0);
            *now += (interval_s / number(NOW_S)).min(T::ONE) * (strength - *now);
            let quiet = usual.max(square(number(least_shaking)));
            let shocked = known && *now > number(SHOCK) * quiet;
            shaken |= known && *now > number(BLOW) * quiet && *now > square(number(least_blow));
            // A shock enters the usual slowly; what goes on for seconds becomes it.
            *usual += usual_weight.min(T::ONE) * (*now - *usual);

            // What is cut off is cut off on the same side for as long as the burst lasts.
            let mut hidden = T::ZERO;
            if *clipped {
                let beyond = number(BEYOND_SCALE) * size;
                let together_s = number(2.0) * *clipped_s + interval_s;
                hidden = now.max(beyond * beyond) * interval_s * together_s;
                *clipped_s = (*clipped_s + interval_s).min(number(LONGEST_BURST_S));
            } else {
                *clipped_s = *clipped_s * (T::ONE - interval_s / number(BURST_S)).max(T::ZERO);
            }
            shock |= shocked;
            struck |= shocked && strength > number(BLOW) * quiet;
            strongest = strongest.max(strength.max(*usual));
            if shocked {
                hidden += *now * interval_s * interval_s;
            }
            // A trapezoid over a lost sample weighs its ends twice: their vibration no longer cancels.
            if late_s > T::ZERO {
                let shaken = number(0.5) * usual.max(*now) + bend * bend / number(36.0);
                hidden += shaken * late_s * late_s;
            }
            *variance = hidden;
        }
        // An axis that nothing ever moved is none.
        let mut stuck_s = self.repetition.push(sample.to_array(), interval_s);
        for (stuck_s, usual) in stuck_s.iter_mut().zip(&self.usual) {
            if *usual <= number(0.01 * least_shaking * least_shaking) {
                *stuck_s = T::ZERO;
            }
        }
        for (variance, stuck_s) in variance.iter_mut().zip(stuck_s).filter(|(_, s)| *s > T::ZERO) {
            let together_s = number(2.0) * stuck_s.min(number(LONGEST_STUCK_S)) + interval_s;
            *variance += square(number(stuck_sigma)) * interval_s * together_s;
        }
        Found {
            clipped,
            shock: shock.then_some(Shaking { variance: strongest, struck }),
            shaken,
            variance,
            stuck: stuck_s.iter().any(|&s| s > T::ZERO),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rates(x: f64, turn: f64) -> Motion {
        Motion::Rates {
            angular_rate_radps: Vector::new(0.0, 0.0, turn),
            specific_force_mps2: Vector::new(x, 0.0, -9.8),
        }
    }

    /// Even numbers between −1 and 1 of a 64-bit congruential generator.
    fn noise() -> impl FnMut() -> f64 {
        let mut state = 1u64;
        move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }
    }

    #[test]
    fn steady_vibration_is_no_suspicion() {
        let (mut integrity, mut next) = (Integrity::<f64>::NONE, noise());
        for k in 0..3000 {
            let found = integrity.push(
                &rates(3.0 * next(), 0.1 * next()),
                &ClippedAxes::NONE,
                0.01,
                &FullScale::default(),
            );
            assert!(k < 100 || (!found.shaken && !found.is_clipped()), "{k}");
            assert!(k < 100 || found.velocity_variance == [0.0; 3]);
        }
    }

    #[test]
    fn readings_at_a_known_or_learned_full_scale_are_clipped() {
        let known = FullScale { accel_mps2: 20.0, gyro_radps: 0.0 };
        for (scale, from) in [(known, 0), (FullScale::default(), 40)] {
            let (mut integrity, mut next) = (Integrity::<f64>::NONE, noise());
            for k in 0..400 {
                let force = (40.0 * next()).clamp(-20.0, 20.0);
                let found = integrity.push(&rates(force, 0.0), &ClippedAxes::NONE, 0.01, &scale);
                assert!(k < from || force.abs() != 20.0 || found.accel_clipped[0]);
                assert!(force.abs() > 19.9 || !found.accel_clipped[0]);
                assert!(!found.accel_clipped[2] && found.gyro_clipped == [false; 3]);
                assert!(!found.accel_clipped[0] || found.velocity_variance[0] > 0.0);
            }
        }
    }

    #[test]
    fn a_burst_that_the_unit_marks_hides_one_error_and_not_many() {
        let (mut integrity, mut next) = (Integrity::<f64>::NONE, noise());
        let mut hidden = |marked: bool| {
            let marks = ClippedAxes { accel: [marked, false, false], ..ClippedAxes::NONE };
            let force = 3.0 * next();
            integrity.push(&rates(force, 0.0), &marks, 0.01, &FullScale::default())
        };
        for _ in 0..500 {
            assert!(!hidden(false).is_clipped());
        }
        let burst: Vec<Suspicion> = (0..20).map(|_| hidden(true)).collect();
        assert!(burst.iter().all(|found| found.accel_clipped == [true, false, false]));
        let total: f64 = burst.iter().map(|found| found.velocity_variance[0]).sum();
        let one_by_one = 20.0 * burst[0].velocity_variance[0];
        assert!(total > 5.0 * one_by_one, "{total} {one_by_one}");
        assert_eq!(hidden(false).velocity_variance, [0.0; 3]);
    }

    #[test]
    fn a_unit_that_repeats_itself_twice_is_stuck_unless_it_rests() {
        for (strength, expected) in [(3.0, true), (0.0, false)] {
            let (mut integrity, mut next) = (Integrity::<f64>::NONE, noise());
            let mut stuck = |force: f64| {
                let motion = rates(strength * force, 0.0);
                let stuck = integrity.is_stuck(&motion);
                integrity.push(&motion, &ClippedAxes::NONE, 0.01, &FullScale::default());
                stuck
            };
            for _ in 0..500 {
                assert!(strength == 0.0 || !stuck(next()));
            }
            assert_eq!([1.0, 1.0, 1.0, 1.0, 0.5].map(&mut stuck)[..2], [false, false]);
            assert_eq!(
                [0.7, 0.7, 0.7, 0.7, 0.5].map(stuck),
                [false, false, expected, expected, false]
            );
        }
    }

    #[test]
    fn a_shock_and_a_lost_sample_leave_an_error_of_full_size() {
        let (mut integrity, mut next) = (Integrity::<f64>::NONE, noise());
        let mut push = |force: f64, interval_s: f64| {
            integrity.push(
                &rates(force, 0.0),
                &ClippedAxes::NONE,
                interval_s,
                &FullScale::default(),
            )
        };
        for _ in 0..1000 {
            push(1.7 * next(), 0.03);
        }
        let lost = push(1.0, 0.09).velocity_variance[0];
        assert!(lost > 0.3 * 0.045f64.powi(2), "{lost}");
        let shock = [30.0, -30.0, 30.0, -30.0, 30.0].map(|force| push(force, 0.03));
        assert!(shock[4].shaken);
        let variance: f64 = shock.iter().map(|found| found.velocity_variance[0]).sum();
        assert!(variance > (5.0f64 * 0.03).powi(2), "{variance}");
        let missed: f64 = shock.iter().map(|found| found.withheld_mps2.to_array()[0] * 0.03).sum();
        assert!(missed.abs() < 3.0 * variance.sqrt(), "{missed} m/s with a variance of {variance}");
    }
}
