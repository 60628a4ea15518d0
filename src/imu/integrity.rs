//! What a sample cannot tell: full scale, shocks, samples that came late or not at all.
#![expect(clippy::indexing_slicing, reason = "axes count from 0 to 2, in arrays of three")]

use core::fmt;

use super::held_force::{HeldForce, Sampling, Shaking};
use super::repetition::Repetition;
use super::{ClippedAxes, MeanRates, Motion, SecondDifference, Vibration, noise_variance};
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
        self.stuck || any(self.gyro_clipped)
    }

    /// Whether any sensor stands at its full scale.
    #[must_use]
    pub fn is_clipped(&self) -> bool {
        any(self.gyro_clipped) || any(self.accel_clipped)
    }
}

impl fmt::Display for Suspicion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if any(self.accel_clipped) {
            "an accelerometer at full scale"
        } else if any(self.gyro_clipped) {
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
    /// For how long samples have come, to the memory of what is usual, s.
    seen_s: T,
    /// The readings before, of either form: a unit keeps to one.
    last: Option<[[T; 3]; 2]>,
    repeated: u8,
    /// Samples in a row on a straight line.
    straight: u8,
    /// Intervals of usual length in a row.
    even: u8,
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
/// A reading at full scale is the top of a tone, and no push, where the shaking now is more than this share of it.
const CUT_OFF_SHARE: f64 = 0.2;
/// Least usual shaking: below it any touch would be a shock, rad/s and m/s².
const LEAST_GYRO_SHAKING: f64 = 0.03;
const LEAST_ACCEL_SHAKING: f64 = 0.3;
/// So many repetitions in a row are a unit that does not measure.
const STUCK: u8 = 2;
/// So many in a row on a straight line, over no less than this, s, were made up by a logger: they are off it by less than
/// this share of the usual noise.
const STRAIGHT: u8 = 5;
const STRAIGHT_S: f64 = 0.1;
const STRAIGHT_SHARE: f64 = 0.02;
/// Accelerometers whose noise is less than this, (m/s²)², may be those of a simulation.
const LEAST_NOISE: f64 = 1e-4;
/// A shock begins after so many intervals of usual length: what it takes back is known by them.
const EVEN: u8 = 3;
/// Vibration of less than this, (m/s²)², may leave readings as they were.
const LEAST_VIBRATION: f64 = 0.0025;
/// What an axis that is stuck may hide, one-sigma, rad/s and m/s²; it has one error for at most so long, s.
const STUCK_GYRO_RADPS: f64 = 0.2;
const STUCK_ACCEL_MPS2: f64 = 2.0;
const LONGEST_STUCK_S: f64 = 5.0;
/// What may lie beyond full scale, as a share of it, one-sigma; of a gyro a quarter of what is left to the rates
/// that vehicles reach, rad/s, where that is more.
const BEYOND_SCALE: f64 = 0.15;
const BEYOND_GYRO: f64 = 0.25;
const MOST_RADPS: f64 = 6.0;
/// A burst of clipping is forgotten after this long without, and has one error for at most so long, s.
const BURST_S: f64 = 0.3;
const LONGEST_BURST_S: f64 = 0.5;
/// What is left of a burst when it is shorter than this, s, is nothing: its decay would end in numbers that
/// are too small for a processor to compute with at its usual speed.
const FORGOTTEN_BURST_S: f64 = 1e-6;

/// What is known against the last readings of three axes.
struct Found<T> {
    clipped: [bool; 3],
    /// How the axes shake where any takes a shock.
    shock: Option<Shaking<T>>,
    shaken: bool,
    /// What the interval adds to the variance of the integral for what clipping and shocks hide, and for
    /// all else.
    hidden: [T; 3],
    variance: [T; 3],
    stuck: bool,
}

#[derive(Clone, Copy, Debug)]
struct Triad<T> {
    difference: SecondDifference<T>,
    vibration: Vibration<T>,
    now: [T; 3],
    usual: [T; 3],
    largest: [T; 3],
    repeats: [u32; 3],
    /// For how long each has been clipped of late, s.
    clipped_s: [T; 3],
    /// For how long a shock in which any was clipped goes on without, s.
    goes_on_s: T,
    repetition: Repetition<T>,
}

/// What the latest reading counts for, in means over the time before.
#[derive(Clone, Copy, Debug)]
struct Weights<T> {
    now: T,
    usual: T,
    /// Whether the mean of what is usual has been taken for long enough.
    usual_is_known: bool,
}

impl<T: Scalar> Triad<T> {
    const NONE: Self = Self {
        difference: SecondDifference::NONE,
        vibration: Vibration::NONE,
        now: [T::ZERO; 3],
        usual: [T::ZERO; 3],
        largest: [T::ZERO; 3],
        repeats: [0; 3],
        clipped_s: [T::ZERO; 3],
        goes_on_s: T::ZERO,
        repetition: Repetition::NONE,
    };
}

impl<T: Scalar> Integrity<T> {
    /// Nothing seen yet.
    pub const NONE: Self = Self {
        gyro: Triad::NONE,
        accel: Triad::NONE,
        held: HeldForce::NONE,
        typical_interval_s: T::ZERO,
        seen_s: T::ZERO,
        last: None,
        repeated: 0,
        straight: 0,
        even: 0,
    };

    /// Whether a sample repeats the two before in all six readings although the unit vibrates: its
    /// registers were not written, and it tells nothing. One repetition is how a log that was sampled
    /// faster than its unit looks.
    pub fn is_stuck(&mut self, motion: &Motion<T>) -> bool {
        let vibrates =
            || self.accel.usual.iter().any(|&variance| variance > T::of(LEAST_VIBRATION));
        let (Motion::Rates { angular_rate_radps: turn, specific_force_mps2: force }
        | Motion::Increments { angle_rad: turn, velocity_mps: force }) = *motion;
        let readings = Some([turn.to_array(), force.to_array()]);
        self.repeated = if self.last == readings { self.repeated.saturating_add(1) } else { 0 };
        self.last = readings;
        self.repeated >= STUCK && vibrates()
    }

    /// Whether a sample goes on, `interval_s` after the last one taken in, along the straight line of the ones before in all
    /// six readings, a line that leads somewhere, although they are not without noise: a logger has put it where it had
    /// none.
    ///
    /// # Source
    /// Equation (S17) of docs/equations.md.
    pub fn is_interpolated(&mut self, motion: &Motion<T>, interval_s: T) -> bool {
        let typical_s = self.typical_interval_s;
        let (turn, force, scale) = match motion {
            Motion::Rates { angular_rate_radps, specific_force_mps2 } => {
                (angular_rate_radps, specific_force_mps2, T::ONE)
            }
            Motion::Increments { angle_rad, velocity_mps } => (angle_rad, velocity_mps, typical_s),
        };
        let off_by = T::of(STRAIGHT_SHARE) * scale * typical_s;
        let on_line = |triad: &Triad<T>, reading: &Vector<Body, T>| {
            let lines = triad.difference.lines().zip(triad.usual);
            // One after the other: all but a few samples are off the first.
            reading.to_array().into_iter().zip(lines).all(|(reading, ((newer, slope), usual))| {
                let off = (reading - scale * newer) * typical_s - scale * slope * interval_s;
                off * off <= off_by * off_by * usual
            })
        };
        let is_straight = self.gyro.difference.is_full()
            && on_line(&self.gyro, turn)
            && on_line(&self.accel, force);
        self.straight = if is_straight { self.straight.saturating_add(1) } else { 0 };
        self.straight >= STRAIGHT
            && T::of(f64::from(self.straight)) * typical_s >= T::of(STRAIGHT_S)
            && self.accel.usual.iter().any(|&variance| variance > T::of(LEAST_NOISE))
            && self.accel.difference.is_moving()
    }

    /// Takes in the rates of a sample, `interval_s` after the one before, with the unit's own marks of full
    /// scale. `momentary` says whether the rates are those of the sample's moment, and not means of the interval.
    ///
    /// # Source
    /// Equation (S13) of docs/equations.md.
    pub fn push(
        &mut self,
        (rates, momentary): (&MeanRates<T>, bool),
        marks: &ClippedAxes,
        interval_s: T,
        scale: &FullScale,
    ) -> Suspicion<T> {
        if self.typical_interval_s == T::ZERO {
            self.typical_interval_s = interval_s;
        }
        // Half a percent a sample, and no more for an interval that is itself unusual.
        let typical = self.typical_interval_s;
        let longest = T::of(1.5) * typical;
        let is_late = interval_s > longest;
        let usual_s = if is_late { longest } else { interval_s };
        self.typical_interval_s += T::of(0.005) * (usual_s - typical);
        let lost_s = if is_late { interval_s - typical } else { T::ZERO };
        let is_even = !is_late && interval_s >= T::of(0.5) * typical;
        self.even = if is_even { self.even.saturating_add(1) } else { 0 };

        // A plain mean until the memory is filled.
        self.seen_s = T::of(USUAL_S).min(self.seen_s + interval_s);
        let weights = Weights {
            now: (interval_s / T::of(NOW_S)).min(T::ONE),
            usual: (interval_s / self.seen_s).min(T::ONE),
            usual_is_known: self.seen_s > T::of(LEAST_SEEN_S),
        };
        let gyro = self.gyro.push(
            (rates.angular_rate_radps, marks.gyro),
            (interval_s, &weights),
            (scale.gyro_radps, LEAST_GYRO_SCALE, MOST_RADPS, LEAST_GYRO_SHAKING, LEAST_GYRO_BLOW),
            ((lost_s, typical), STUCK_GYRO_RADPS),
        );
        let accel = self.accel.push(
            (rates.specific_force_mps2, marks.accel),
            (interval_s, &weights),
            (scale.accel_mps2, LEAST_ACCEL_SCALE, 0.0, LEAST_ACCEL_SHAKING, LEAST_ACCEL_BLOW),
            ((lost_s, typical), STUCK_ACCEL_MPS2),
        );
        let sampling = Sampling { interval_s, momentary, even: self.even >= EVEN };
        let held = self.held.push(rates.specific_force_mps2, accel.shock, &sampling);
        let hidden_force = held.variance.map_or(accel.hidden, |variance| [variance; 3]);
        Suspicion {
            gyro_clipped: gyro.clipped,
            accel_clipped: accel.clipped,
            stuck: gyro.stuck || accel.stuck,
            shaken: gyro.shaken || accel.shaken,
            angle_variance: sums(gyro.variance, gyro.hidden),
            velocity_variance: sums(accel.variance, hidden_force),
            withheld_mps2: held.withheld_mps2,
        }
    }

    /// Vibration of the gyros of late, variance per axis, (rad/s)².
    #[must_use]
    pub(crate) fn gyro_vibration(&self) -> [T; 3] {
        self.gyro.vibration.variance()
    }

    /// Vibration of the accelerometers of late, variance per axis, (m/s²)².
    #[must_use]
    pub(crate) fn accel_vibration(&self) -> [T; 3] {
        self.accel.vibration.variance()
    }

    /// Forgets the last two samples, after a gap, and with them a shock.
    pub fn interrupt(&mut self) {
        self.gyro.difference.interrupt();
        self.accel.difference.interrupt();
        self.held.interrupt();
        self.even = 0;
    }
}

fn sums<T: Scalar>([a, b, c]: [T; 3], [d, e, f]: [T; 3]) -> [T; 3] {
    [a + d, b + e, c + f]
}

impl<T: Scalar> Triad<T> {
    fn push(
        &mut self,
        (sample, marks): (Vector<Body, T>, [bool; 3]),
        (interval_s, weights): (T, &Weights<T>),
        (scale, least_scale, limit, least_shaking, least_blow): (f64, f64, f64, f64, f64),
        ((lost_s, typical_s), stuck_sigma): ((T, T), f64),
    ) -> Found<T> {
        let number = T::of;
        let values = sample.to_array();
        let bend = self.difference.push(sample);
        let mut noise = [T::ZERO; 3];
        if let Some(bend) = bend {
            noise = noise_variance(bend);
            self.vibration.push(noise, interval_s);
        }
        let least_scale = number(least_scale);
        let full_scale = number(if scale > 0.0 { 0.998 * scale } else { f64::INFINITY });
        let mut clipped = marks;
        let stuck_s = self.repetition.push(values, interval_s);
        // An axis that nothing ever moved is none that is stuck.
        let least_moving = number(0.01 * least_shaking * least_shaking);
        for axis in 0..3 {
            let size = values[axis].abs();
            let (largest, repeats) = (&mut self.largest[axis], &mut self.repeats[axis]);
            if size >= *largest && comes_back(size, largest, repeats) {
                // However small: what is stuck at its largest reading is at full scale.
                let stands_still = stuck_s[axis] > T::ZERO && self.usual[axis] > least_moving;
                clipped[axis] |= size >= least_scale || (limit > 0.0 && stands_still);
            }
            clipped[axis] |= size >= full_scale;
        }
        let least_quiet = square(number(least_shaking));
        let quiet = self.usual.map(|usual| if usual > least_quiet { usual } else { least_quiet });
        for ((now, usual), noise) in self.now.iter_mut().zip(&mut self.usual).zip(noise) {
            *now += weights.now * (noise - *now);
            // A shock enters the usual slowly; what goes on for seconds becomes it.
            *usual += weights.usual * (*now - *usual);
        }
        let now = self.now;
        let shocked: [bool; 3] = core::array::from_fn(|axis| {
            weights.usual_is_known && now[axis] > number(SHOCK) * quiet[axis]
        });
        let (mut shock, mut shaken, mut hidden) = (None, false, [T::ZERO; 3]);
        // What is usual rises with a tone that lasts, and what full scale cuts off of it does not become right by that.
        let least_tone = square(number(CUT_OFF_SHARE));
        let tone: [bool; 3] = core::array::from_fn(|axis| {
            clipped[axis] && now[axis] > least_tone * square(values[axis])
        });
        self.goes_on_s =
            if any(tone) { number(NOW_S) } else { (self.goes_on_s - interval_s).max(T::ZERO) };
        if any(shocked) || self.goes_on_s > T::ZERO {
            let (mut struck, least_blow) = (false, square(number(least_blow)));
            for axis in 0..3 {
                let blow = number(BLOW) * quiet[axis];
                struck |= shocked[axis] && noise[axis] > blow;
                shaken |= now[axis] > blow && now[axis] > least_blow;
            }
            let cut_off = self.goes_on_s > T::ZERO;
            shock = Some(Shaking { variance: greatest(noise, self.usual), struck, cut_off });
        }
        if shock.is_some() || any(clipped) {
            hidden = self.hidden(values, limit, clipped, shocked, interval_s);
        }
        if any(clipped) || total(self.clipped_s) > T::ZERO {
            self.count_clipping(clipped, interval_s);
        }
        let mut variance = [T::ZERO; 3];
        // A trapezoid over lost samples weighs its ends for them: what they would have taken back is missing,
        // and the ends count too much.
        if lost_s > T::ZERO {
            let bend = bend.unwrap_or_default();
            let ends_and_lost = lost_s * (number(0.5) * lost_s + typical_s);
            for axis in 0..3 {
                let moved = bend[axis] * lost_s;
                variance[axis] = self.usual[axis].max(self.now[axis]) * ends_and_lost
                    + moved * moved / number(36.0);
            }
        }
        let mut stuck = false;
        if total(stuck_s) > T::ZERO {
            for axis in 0..3 {
                if stuck_s[axis] > T::ZERO && self.usual[axis] > least_moving {
                    let together_s =
                        number(2.0) * stuck_s[axis].min(number(LONGEST_STUCK_S)) + interval_s;
                    variance[axis] += square(number(stuck_sigma)) * interval_s * together_s;
                    stuck = true;
                }
            }
        }
        Found { clipped, shock, shaken, hidden, variance, stuck }
    }

    /// What clipping and shocks hide: the variance that they add to the integral of each axis over an interval.
    fn hidden(
        &self,
        values: [T; 3],
        limit: f64,
        clipped: [bool; 3],
        shocked: [bool; 3],
        interval_s: T,
    ) -> [T; 3] {
        let mut hidden = [T::ZERO; 3];
        for axis in 0..3 {
            let now = self.now[axis];
            // What is cut off is cut off on the same side for as long as the burst lasts.
            if clipped[axis] {
                let size = values[axis].abs();
                let within_limit = T::of(BEYOND_GYRO) * (T::of(limit) - size);
                let beyond = (T::of(BEYOND_SCALE) * size).max(within_limit);
                let together_s = T::of(2.0) * self.clipped_s[axis] + interval_s;
                hidden[axis] = now.max(beyond * beyond) * interval_s * together_s;
            }
            if shocked[axis] {
                hidden[axis] += now * interval_s * interval_s;
            }
        }
        hidden
    }

    /// Counts for how long each axis has been clipped of late.
    fn count_clipping(&mut self, clipped: [bool; 3], interval_s: T) {
        let left = (T::ONE - interval_s / T::of(BURST_S)).max(T::ZERO);
        for (clipped_s, clipped) in self.clipped_s.iter_mut().zip(clipped) {
            let before_s = *clipped_s * left;
            *clipped_s = if clipped {
                (*clipped_s + interval_s).min(T::of(LONGEST_BURST_S))
            } else if before_s > T::of(FORGOTTEN_BURST_S) {
                before_s
            } else {
                T::ZERO
            };
        }
    }
}

/// Whether a reading that is not below the largest of its axis has come back so often that it is the full scale.
fn comes_back<T: Scalar>(size: T, largest: &mut T, repeats: &mut u32) -> bool {
    if size > *largest {
        (*largest, *repeats) = (size, 1);
    } else {
        *repeats = repeats.saturating_add(1);
    }
    *repeats >= REPEATS
}

/// Whether any axis is; without a branch for each.
const fn any([x, y, z]: [bool; 3]) -> bool {
    x | y | z
}

fn total<T: Scalar>([x, y, z]: [T; 3]) -> T {
    x + y + z
}

fn square<T: Scalar>(value: T) -> T {
    value * value
}

fn greatest<T: Scalar>(now: [T; 3], usual: [T; 3]) -> T {
    now.into_iter().chain(usual).fold(T::ZERO, T::max)
}

#[cfg(test)]
mod tests;
