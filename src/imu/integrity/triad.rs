//! What the readings of three gyros, or of three accelerometers, say against themselves.
#![expect(clippy::indexing_slicing, reason = "axes count from 0 to 2, in arrays of three")]

use super::super::held_force::Shaking;
use super::super::repetition::Repetition;
use super::super::{SecondDifference, Vibration, noise_variance};
use super::any;
use crate::frames::{Body, Vector};
use crate::scalar::Scalar;

/// What the readings of one kind of sensor are judged by: rad/s of gyros, m/s² of accelerometers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Readings below this are not taken for a learned full scale.
    least_scale: f64,
    /// The most that vehicles reach, where that bounds what lies beyond full scale; zero where nothing does.
    fastest: f64,
    /// Least usual shaking: below it any touch would be a shock.
    least_shaking: f64,
    /// Shaking of no less than this may be a blow.
    least_blow: f64,
    /// What an axis that is stuck may hide, one-sigma.
    stuck_sigma: f64,
}

impl Limits {
    /// Of gyros, rad/s.
    pub const GYRO: Self = Self {
        least_scale: 1.5,
        fastest: 6.0,
        least_shaking: 0.03,
        least_blow: 3.0,
        stuck_sigma: 0.2,
    };
    /// Of accelerometers, m/s².
    pub const ACCEL: Self = Self {
        least_scale: 17.0,
        fastest: 0.0,
        least_shaking: 0.3,
        least_blow: 20.0,
        stuck_sigma: 2.0,
    };

    /// The usual variance above which an axis moves: one that nothing ever moved is not stuck.
    fn least_moving<T: Scalar>(&self) -> T {
        T::of(0.01 * self.least_shaking * self.least_shaking)
    }
}

/// When a sample came, and what it counts for in means over the time before.
#[derive(Clone, Copy, Debug)]
pub(super) struct Timing<T> {
    /// Since the sample before, s.
    pub interval_s: T,
    /// How long the interval usually is, s.
    pub typical_s: T,
    /// By how much a late sample exceeds that, s; zero of one that is not late.
    pub lost_s: T,
    /// Weight of the sample in the mean of the shaking now.
    pub now: T,
    /// Weight of the sample in the mean of what is usual.
    pub usual: T,
    /// Whether the mean of what is usual has been taken for long enough.
    pub usual_is_known: bool,
}

/// A maximum that came back this often is a full scale.
const REPEATS: u32 = 4;
/// Memory of the shaking now, s.
pub(super) const NOW_S: f64 = 0.15;
/// Shaking now of more than so many times the usual variance is a shock.
const SHOCK: f64 = 8.0;
/// Shaking of more than so many times the usual variance, and of such a size, is a blow: a landing is
/// not, a propeller that breaks is.
const BLOW: f64 = 50.0;
/// A reading at full scale is the top of a tone, and no push, where the shaking now is more than this share of it.
const CUT_OFF_SHARE: f64 = 0.2;
/// An axis that is stuck has one error for at most so long, s.
const LONGEST_STUCK_S: f64 = 5.0;
/// What may lie beyond full scale, as a share of it, one-sigma; of a gyro a quarter of what is left to the rates
/// that vehicles reach, where that is more.
const BEYOND_SCALE: f64 = 0.15;
const BEYOND_GYRO: f64 = 0.25;
/// A burst of clipping is forgotten after this long without, and has one error for at most so long, s.
const BURST_S: f64 = 0.3;
const LONGEST_BURST_S: f64 = 0.5;
/// What is left of a burst when it is shorter than this, s, is nothing: its decay would end in numbers that
/// are too small for a processor to compute with at its usual speed.
const FORGOTTEN_BURST_S: f64 = 1e-6;

/// What is known against the last readings of three axes.
pub(super) struct Found<T> {
    pub clipped: [bool; 3],
    /// How the axes shake where any takes a shock.
    pub shock: Option<Shaking<T>>,
    pub shaken: bool,
    /// What the interval adds to the variance of the integral for what clipping and shocks hide, and for
    /// all else.
    pub hidden: [T; 3],
    pub variance: [T; 3],
    /// Which axes repeat themselves, though the unit vibrates.
    pub stuck: [bool; 3],
}

/// The readings of three axes so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triad<T> {
    pub difference: SecondDifference<T>,
    pub vibration: Vibration<T>,
    now: [T; 3],
    pub usual: [T; 3],
    largest: [T; 3],
    repeats: [u32; 3],
    /// For how long each has been clipped of late, s.
    pub clipped_s: [T; 3],
    /// For how long a shock in which any was clipped goes on without, s.
    goes_on_s: f32,
    repetition: Repetition<T>,
}

impl<T: Scalar> Triad<T> {
    /// Nothing seen yet.
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
    /// Takes in a reading, with the unit's own `marks` of full scale; `full_scale` is zero where it is not known.
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
        let interval_s = timing.interval_s;
        let values = sample.to_array();
        let bend = self.difference.push(sample);
        let mut noise = [T::ZERO; 3];
        if let Some(bend) = bend {
            noise = noise_variance(bend);
            self.vibration.push(noise, interval_s);
        }
        let least_scale = number(limits.least_scale);
        let full_scale = number(if full_scale > 0.0 { 0.998 * full_scale } else { f64::INFINITY });
        let mut clipped = marks;
        let stuck_s = self.repetition.push(values, interval_s);
        for axis in 0..3 {
            let size = values[axis].abs();
            let (largest, repeats) = (&mut self.largest[axis], &mut self.repeats[axis]);
            if size >= *largest && comes_back(size, largest, repeats) {
                // However small: what is stuck at its largest reading is at full scale.
                let stands_still =
                    stuck_s[axis] > T::ZERO && self.usual[axis] > limits.least_moving();
                clipped[axis] |= size >= least_scale || (limits.fastest > 0.0 && stands_still);
            }
            clipped[axis] |= size >= full_scale;
        }
        let least_quiet = square(number(limits.least_shaking));
        let quiet = self.usual.map(|usual| if usual > least_quiet { usual } else { least_quiet });
        for ((now, usual), noise) in self.now.iter_mut().zip(&mut self.usual).zip(noise) {
            *now += timing.now * (noise - *now);
            // A shock enters the usual slowly; what goes on for seconds becomes it.
            *usual += timing.usual * (*now - *usual);
        }
        let now = self.now;
        let shocked: [bool; 3] = core::array::from_fn(|axis| {
            timing.usual_is_known && now[axis] > number(SHOCK) * quiet[axis]
        });
        let (mut shock, mut shaken, mut hidden) = (None, false, [T::ZERO; 3]);
        // What is usual rises with a tone that lasts, and what full scale cuts off of it does not become right by that.
        if self.goes_on_s > 0.0 {
            self.goes_on_s -= interval_s.wide() as f32;
        }
        if any(clipped) && self.is_tone(values, clipped) {
            self.goes_on_s = NOW_S as f32;
        }
        let cut_off = self.goes_on_s > 0.0;
        if any(shocked) || cut_off {
            let (mut struck, least_blow) = (false, square(number(limits.least_blow)));
            for axis in 0..3 {
                let blow = number(BLOW) * quiet[axis];
                struck |= shocked[axis] && noise[axis] > blow;
                shaken |= now[axis] > blow && now[axis] > least_blow;
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
        let stuck = if total(stuck_s) > T::ZERO {
            self.add_stuck(&mut variance, stuck_s, limits, interval_s)
        } else {
            [false; 3]
        };
        Found { clipped, shock, shaken, hidden, variance, stuck }
    }

    /// What lost samples add to the variance of the integral of each axis over an interval; `bend` is the last second
    /// difference.
    fn lost(&self, bend: [T; 3], timing: &Timing<T>) -> [T; 3] {
        let Timing { lost_s, typical_s, .. } = *timing;
        // A trapezoid over lost samples weighs its ends for them: what they would have taken back is missing,
        // and the ends count too much.
        let ends_and_lost = lost_s * (T::of(0.5) * lost_s + typical_s);
        core::array::from_fn(|axis| {
            let moved = bend[axis] * lost_s;
            self.usual[axis].max(self.now[axis]) * ends_and_lost + moved * moved / T::of(36.0)
        })
    }

    /// Adds what axes that have been stuck for `stuck_s` hide to the variance of the integral of each over an interval.
    /// Gives which are.
    fn add_stuck(
        &self,
        variance: &mut [T; 3],
        stuck_s: [T; 3],
        limits: &Limits,
        interval_s: T,
    ) -> [bool; 3] {
        let mut stuck = [false; 3];
        for axis in 0..3 {
            if stuck_s[axis] > T::ZERO && self.usual[axis] > limits.least_moving() {
                let together_s =
                    T::of(2.0) * stuck_s[axis].min(T::of(LONGEST_STUCK_S)) + interval_s;
                variance[axis] += square(T::of(limits.stuck_sigma)) * interval_s * together_s;
                stuck[axis] = true;
            }
        }
        stuck
    }

    /// Whether any reading at full scale is the top of a tone.
    fn is_tone(&self, values: [T; 3], clipped: [bool; 3]) -> bool {
        let least = square(T::of(CUT_OFF_SHARE));
        (0..3).any(|axis| clipped[axis] && self.now[axis] > least * square(values[axis]))
    }

    /// What clipping and shocks hide: the variance that they add to the integral of each axis over an interval.
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
            // What is cut off is cut off on the same side for as long as the burst lasts.
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

fn total<T: Scalar>([x, y, z]: [T; 3]) -> T {
    x + y + z
}

fn square<T: Scalar>(value: T) -> T {
    value * value
}

fn greatest<T: Scalar>(now: [T; 3], usual: [T; 3]) -> T {
    now.into_iter().chain(usual).fold(T::ZERO, T::max)
}
