//! Checks on the readings of three gyros or three accelerometers.
#![expect(clippy::indexing_slicing, reason = "axes count from 0 to 2, in arrays of three")]

use super::super::axes::any;
use super::super::held_force::Shaking;
use super::super::repetition::Repetition;
use super::super::{SecondDifference, Vibration, noise_variance};
use super::checks::Checks;
use crate::frames::{Body, Vector};
use crate::matrix::square;
use crate::scalar::Scalar;

/// Limits for the readings of one kind of sensor: rad/s for gyros, m/s² for accelerometers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Smallest reading that counts as a learned full scale, in the sensor's unit.
    min_scale: f64,
    /// Largest value that vehicles reach, in the sensor's unit. It bounds readings beyond full scale; zero without a
    /// bound.
    fastest: f64,
    /// Minimum usual vibration, one-sigma, in the sensor's unit: with a smaller one any touch would count as a shock.
    min_shaking: f64,
    /// Minimum vibration of a strong shock, one-sigma, in the sensor's unit.
    min_shock: f64,
    /// One-sigma, in the sensor's unit, of the motion hidden by a stuck axis.
    stuck_sigma: f64,
}

impl Limits {
    /// Limits of gyros, rad/s.
    pub const GYRO: Self =
        Self { min_scale: 1.5, fastest: 6.0, min_shaking: 0.03, min_shock: 3.0, stuck_sigma: 0.2 };
    /// Limits of accelerometers, m/s².
    pub const ACCEL: Self =
        Self { min_scale: 17.0, fastest: 0.0, min_shaking: 0.3, min_shock: 20.0, stuck_sigma: 2.0 };

    /// Usual variance above which an axis counts as moving: an axis that never moved is not stuck.
    fn min_moving<T: Scalar>(&self) -> T {
        T::of(0.01 * self.min_shaking * self.min_shaking)
    }
}

/// Timing of a sample, and its weights in the running means.
#[derive(Clone, Copy, Debug)]
pub(super) struct Timing<T> {
    /// Time since the previous sample, s.
    pub interval_s: T,
    /// Usual length of the interval, s.
    pub typical_s: T,
    /// Excess of a late sample's interval over the usual length, s; zero if not late.
    pub lost_s: T,
    /// Weight of the sample in the mean of the present vibration.
    pub now: T,
    /// Weight of the sample in the mean of the usual vibration.
    pub usual: T,
    /// Whether shocks are looked for, and the usual vibration has been averaged long enough.
    pub usual_is_known: bool,
    /// Faults to look for.
    pub checks: Checks,
}

/// Number of occurrences of a maximum after which it counts as the full scale.
const REPEATS: u32 = 4;
/// Memory of the present vibration, s.
pub(super) const NOW_S: f64 = 0.15;
/// Minimum present vibration of a shock, in multiples of the usual variance.
const SHOCK: f64 = 8.0;
/// Minimum vibration of a strong shock, in multiples of the usual variance; it must also exceed `min_shock`. A
/// landing stays below this limit, a breaking propeller exceeds it.
const STRONG_SHOCK: f64 = 50.0;
/// Minimum present vibration, as a fraction of full scale, at which a reading at full scale belongs to a tone. At a
/// smaller vibration it belongs to a push.
const CUT_OFF_SHARE: f64 = 0.2;
/// Longest time, s, for which a stuck axis has one constant error.
const LONGEST_STUCK_S: f64 = 5.0;
/// One-sigma of the motion beyond full scale, as a fraction of the full scale.
const BEYOND_SCALE: f64 = 0.15;
/// One-sigma of a turn beyond full scale, as a fraction of the range from full scale to the fastest vehicles. The
/// larger of the two one-sigmas counts.
const BEYOND_GYRO: f64 = 0.25;
/// Decay time of a clipping burst, s.
const BURST_S: f64 = 0.3;
/// Longest time, s, for which a clipping burst has one constant error.
const LONGEST_BURST_S: f64 = 0.5;
/// Shortest burst, s; a shorter one is set to zero, because its decay would end in denormal numbers, which slow the
/// processor.
const FORGOTTEN_BURST_S: f64 = 1e-6;

/// Faults found in the last readings of three axes.
pub(super) struct Found<T> {
    pub clipped: [bool; 3],
    /// Vibration of the axes, if any has a shock or a clipped tone.
    pub shock: Option<Shaking<T>>,
    pub shaken: bool,
    /// Variance that clipping and shocks add to the integral over the interval, rad² or (m/s)².
    pub hidden: [T; 3],
    /// Variance that lost samples and stuck axes add to the integral over the interval, rad² or (m/s)².
    pub variance: [T; 3],
    /// Axes that repeat one reading although the inertial unit vibrates.
    pub stuck: [bool; 3],
}

/// State of the checks on three axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triad<T> {
    pub difference: SecondDifference<T>,
    pub vibration: Vibration<T>,
    now: [T; 3],
    pub usual: [T; 3],
    largest: [T; 3],
    repeats: [u32; 3],
    /// Recent clipping time of each axis, s.
    pub clipped_s: [T; 3],
    /// Remaining time, s, for which a clipped tone counts as a shock.
    goes_on_s: f32,
    repetition: Repetition<T>,
}

impl<T: Scalar> Triad<T> {
    /// State before the first sample.
    pub const NONE: Self = Self {
        difference: SecondDifference::NONE,
        vibration: Vibration::NONE,
        now: [T::ZERO; 3],
        usual: [T::ZERO; 3],
        largest: [T::ZERO; 3],
        repeats: [0; 3],
        clipped_s: [T::ZERO; 3],
        goes_on_s: 0.0,
        repetition: Repetition::NONE,
    };
}

impl<T: Scalar> Triad<T> {
    /// Feeds a reading, with the inertial unit's own full-scale flags `marks`; `full_scale` is zero if unknown.
    ///
    /// # Source
    /// Equation (S13) of docs/equations.md.
    pub fn push(
        &mut self,
        sample: Vector<Body, T>,
        marks: [bool; 3],
        full_scale: f64,
        limits: &Limits,
        timing: &Timing<T>,
    ) -> Found<T> {
        let number = T::of;
        let (interval_s, checks) = (timing.interval_s, timing.checks);
        let values = sample.to_array();
        let bend = self.difference.push(sample);
        let mut noise = [T::ZERO; 3];
        if let Some(bend) = bend {
            noise = noise_variance(bend);
            self.vibration.push(noise, interval_s);
        }
        let min_scale = number(limits.min_scale);
        let full_scale = number(if full_scale > 0.0 { 0.998 * full_scale } else { f64::INFINITY });
        let mut clipped = marks;
        let stuck_s = self.repetition.push(values, interval_s);
        for axis in 0..3 {
            let size = values[axis].abs();
            let (largest, repeats) = (&mut self.largest[axis], &mut self.repeats[axis]);
            if size >= *largest && comes_back(size, largest, repeats) {
                // An axis stuck at its largest reading counts as at full scale, at any size of that reading.
                let stands_still =
                    stuck_s[axis] > T::ZERO && self.usual[axis] > limits.min_moving();
                clipped[axis] |= size >= min_scale || (limits.fastest > 0.0 && stands_still);
            }
            clipped[axis] |= size >= full_scale;
        }
        if !checks.clipping {
            clipped = [false; 3];
        }
        let min_quiet = square(number(limits.min_shaking));
        let quiet = self.usual.map(|usual| if usual > min_quiet { usual } else { min_quiet });
        for ((now, usual), noise) in self.now.iter_mut().zip(&mut self.usual).zip(noise) {
            *now += timing.now * (noise - *now);
            // A shock enters the usual vibration slowly; vibration that lasts seconds becomes usual.
            *usual += timing.usual * (*now - *usual);
        }
        let now = self.now;
        let shocked: [bool; 3] = core::array::from_fn(|axis| {
            timing.usual_is_known && now[axis] > number(SHOCK) * quiet[axis]
        });
        let (mut shock, mut shaken, mut hidden) = (None, false, [T::ZERO; 3]);
        // A lasting tone raises the usual vibration, but its clipped readings stay wrong.
        if self.goes_on_s > 0.0 {
            self.goes_on_s -= interval_s.wide() as f32;
        }
        if any(clipped) && checks.shocks && self.is_tone(values, clipped) {
            self.goes_on_s = NOW_S as f32;
        }
        let cut_off = self.goes_on_s > 0.0;
        if any(shocked) || cut_off {
            let (mut struck, min_shock) = (false, square(number(limits.min_shock)));
            for axis in 0..3 {
                let blow = number(STRONG_SHOCK) * quiet[axis];
                struck |= shocked[axis] && noise[axis] > blow;
                shaken |= now[axis] > blow && now[axis] > min_shock;
            }
            shock = Some(Shaking { variance: greatest(noise, self.usual), struck, cut_off });
        }
        if shock.is_some() || any(clipped) {
            hidden = self.hidden(values, limits, clipped, shocked, interval_s);
        }
        if any(clipped) || total(self.clipped_s) > T::ZERO {
            self.count_clipping(clipped, interval_s);
        }
        let mut variance = [T::ZERO; 3];
        if timing.lost_s > T::ZERO {
            variance = self.lost(bend.unwrap_or_default(), timing);
        }
        let stuck = if total(stuck_s) > T::ZERO && checks.stuck_axes {
            self.add_stuck(&mut variance, stuck_s, limits, interval_s)
        } else {
            [false; 3]
        };
        Found { clipped, shock, shaken, hidden, variance, stuck }
    }

    /// Variance that lost samples add to the integral of each axis over an interval; `bend` is the last second
    /// difference.
    fn lost(&self, bend: [T; 3], timing: &Timing<T>) -> [T; 3] {
        let Timing { lost_s, typical_s, .. } = *timing;
        // A trapezoid over lost samples replaces them by the samples at its ends. The lost samples no longer cancel
        // each other's vibration, and the samples at the ends get too much weight.
        let ends_and_lost = lost_s * (T::of(0.5) * lost_s + typical_s);
        core::array::from_fn(|axis| {
            let moved = bend[axis] * lost_s;
            self.usual[axis].max(self.now[axis]) * ends_and_lost + moved * moved / T::of(36.0)
        })
    }

    /// Adds to `variance` the variance that stuck axes hide in the integral over an interval. `stuck_s` is the time, s,
    /// for which each axis has been stuck. Returns the stuck axes.
    fn add_stuck(
        &self,
        variance: &mut [T; 3],
        stuck_s: [T; 3],
        limits: &Limits,
        interval_s: T,
    ) -> [bool; 3] {
        let mut stuck = [false; 3];
        for axis in 0..3 {
            if stuck_s[axis] > T::ZERO && self.usual[axis] > limits.min_moving() {
                let together_s =
                    T::of(2.0) * stuck_s[axis].min(T::of(LONGEST_STUCK_S)) + interval_s;
                variance[axis] += square(T::of(limits.stuck_sigma)) * interval_s * together_s;
                stuck[axis] = true;
            }
        }
        stuck
    }

    /// Whether any reading at full scale belongs to a tone.
    fn is_tone(&self, values: [T; 3], clipped: [bool; 3]) -> bool {
        let least = square(T::of(CUT_OFF_SHARE));
        (0..3).any(|axis| clipped[axis] && self.now[axis] > least * square(values[axis]))
    }

    /// Variance hidden by clipping and shocks in the integral of each axis over an interval.
    fn hidden(
        &self,
        values: [T; 3],
        limits: &Limits,
        clipped: [bool; 3],
        shocked: [bool; 3],
        interval_s: T,
    ) -> [T; 3] {
        let mut hidden = [T::ZERO; 3];
        for axis in 0..3 {
            let now = self.now[axis];
            // Clipping hides motion on the same side throughout the burst.
            if clipped[axis] {
                let size = values[axis].abs();
                let within_limit = T::of(BEYOND_GYRO) * (T::of(limits.fastest) - size);
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

    /// Updates the recent clipping time of each axis.
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

/// Whether a reading is the full scale of its axis. The reading must be at or above the axis's `largest` reading, and
/// must have been repeated often enough.
fn comes_back<T: Scalar>(size: T, largest: &mut T, repeats: &mut u32) -> bool {
    if size > *largest {
        (*largest, *repeats) = (size, 1);
    } else {
        *repeats = repeats.saturating_add(1);
    }
    *repeats >= REPEATS
}

fn total<T: Scalar>([x, y, z]: [T; 3]) -> T {
    x + y + z
}

fn greatest<T: Scalar>(now: [T; 3], usual: [T; 3]) -> T {
    now.into_iter().chain(usual).fold(T::ZERO, T::max)
}
