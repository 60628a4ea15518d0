//! Checks of inertial samples: full scale, shocks, and late or missing samples.

mod checks;
mod triad;

use core::fmt;

pub use self::checks::Checks;
use self::triad::{Limits, NOW_S, Timing, Triad};
use super::axes::any;
use super::held_force::{HeldForce, Sampling};
use super::{ImuAxes, MeanRates, Motion};
use crate::frames::{Body, Vector};
use crate::scalar::Scalar;

/// Full scale of an inertial unit. Zero if unknown: it is then learned from readings that repeat their own maximum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FullScale {
    /// Full scale of each gyro, rad/s.
    pub gyro_radps: f64,
    /// Full scale of each accelerometer, m/s².
    pub accel_mps2: f64,
}

/// Faults found in the last sample: see [`Integrity::push`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Suspicion<T = f64> {
    /// Sensors at full scale.
    pub clipped: ImuAxes,
    /// Axes that repeat one reading to the last digit although the inertial unit vibrates.
    pub stuck: ImuAxes,
    /// Whether a shock acts on the inertial unit, far above its vibration of the last seconds.
    pub shaken: bool,
    /// Variance that the sample's interval adds to the integral of rate, beyond the usual noise, rad².
    pub angle_variance: [T; 3],
    /// Variance that the sample's interval adds to the integral of specific force, beyond the usual noise, (m/s)².
    pub velocity_variance: [T; 3],
    /// Part of the mean specific force over the interval that is excluded as a shock, m/s².
    pub withheld_mps2: Vector<Body, T>,
}

impl<T: Scalar> Suspicion<T> {
    /// No fault.
    pub const NONE: Self = Self {
        clipped: ImuAxes::NONE,
        stuck: ImuAxes::NONE,
        shaken: false,
        angle_variance: [T::ZERO; 3],
        velocity_variance: [T::ZERO; 3],
        withheld_mps2: Vector::ZERO,
    };

    /// This suspicion in another number type.
    #[must_use]
    pub fn cast<U: Scalar>(&self) -> Suspicion<U> {
        Suspicion {
            clipped: self.clipped,
            stuck: self.stuck,
            shaken: self.shaken,
            angle_variance: self.angle_variance.map(|variance| U::of(variance.wide())),
            velocity_variance: self.velocity_variance.map(|variance| U::of(variance.wide())),
            withheld_mps2: self.withheld_mps2.cast(),
        }
    }

    /// Whether the fault hides part of the motion: a gyro at full scale, or a stuck axis.
    #[must_use]
    pub(crate) fn hides_motion(&self) -> bool {
        self.stuck.any() | any(self.clipped.gyro)
    }

    /// Whether the sample is suspect: a sensor at full scale, a stuck axis, or a vibration far beyond the usual.
    pub(crate) fn is_suspect(&self) -> bool {
        self.clipped.any() | self.stuck.any() | self.shaken
    }
}

/// Axes of a sensor in words: "gyro z", "accelerometers x, y".
struct Axes(&'static str, [bool; 3]);

impl fmt::Display for Axes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(sensor, axes) = *self;
        f.write_str(sensor)?;
        if axes.iter().filter(|&&axis| axis).count() > 1 {
            f.write_str("s")?;
        }
        let mut separator = " ";
        for (name, _) in ["x", "y", "z"].into_iter().zip(axes).filter(|&(_, axis)| axis) {
            f.write_str(separator)?;
            f.write_str(name)?;
            separator = ", ";
        }
        Ok(())
    }
}

impl fmt::Display for Suspicion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [gyro, accel] = ["gyro", "accelerometer"];
        if any(self.clipped.accel) {
            write!(f, "{} at full scale", Axes(accel, self.clipped.accel))
        } else if any(self.clipped.gyro) {
            write!(f, "{} at full scale", Axes(gyro, self.clipped.gyro))
        } else if any(self.stuck.gyro) {
            write!(f, "{} stuck at one reading", Axes(gyro, self.stuck.gyro))
        } else if any(self.stuck.accel) {
            write!(f, "{} stuck at one reading", Axes(accel, self.stuck.accel))
        } else if self.shaken {
            f.write_str("vibration far above the usual level")
        } else {
            f.write_str("no fault found")
        }
    }
}

/// Monitor of the samples of one inertial unit.
///
/// Vibration integrates to a small error only while the samples are complete and evenly spaced. Clipping, a short shock
/// or lost samples leave an error of full size.
#[derive(Clone, Copy, Debug)]
pub struct Integrity<T = f64> {
    gyro: Triad<T>,
    accel: Triad<T>,
    held: HeldForce<T>,
    typical_interval_s: T,
    /// Time over which samples have arrived, s, at most the memory `USUAL_S` of the usual vibration.
    seen_s: T,
    /// The previous readings, as rates or as increments: an inertial unit keeps one form.
    last: Option<[[T; 3]; 2]>,
    repeated: u8,
    /// Number of successive samples on a straight line.
    straight: u8,
    /// Number of successive intervals of usual length.
    even: u8,
}

/// Memory of the usual vibration, s.
const USUAL_S: f64 = 5.0;
/// Time after which the usual vibration counts as known, s.
const MIN_SEEN_S: f64 = 1.0;
/// Number of successive repetitions that indicate an inertial unit that does not measure.
const STUCK: u8 = 2;
/// Number of successive samples on a straight line that indicate interpolation by a logger.
const STRAIGHT: u8 = 5;
/// Minimum duration of the samples on a straight line, s.
const STRAIGHT_S: f64 = 0.1;
/// Largest deviation of such samples from the line, as a fraction of the usual noise.
const STRAIGHT_SHARE: f64 = 0.02;
/// Minimum accelerometer noise, (m/s²)², at which straight lines count: a smaller noise may be that of a simulation.
const MIN_NOISE: f64 = 1e-4;
/// Number of successive intervals of usual length that a shock needs to begin, including the current one. At its
/// beginning, a shock also excludes the previous two readings.
const EVEN: u8 = 3;
/// Minimum vibration, (m/s²)², at which repeated readings are a fault: a smaller vibration may be below the resolution.
const MIN_VIBRATION: f64 = 0.0025;

impl<T: Scalar> Integrity<T> {
    /// State before the first sample.
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

    /// Whether all six readings of a sample repeat those of the two samples before, although the inertial unit
    /// vibrates. Its registers were not written, and the sample contains no information. A single repetition is normal
    /// in a log sampled faster than its sensor.
    pub fn is_stuck(&mut self, motion: &Motion<T>) -> bool {
        let vibrates = || self.accel.usual.iter().any(|&variance| variance > T::of(MIN_VIBRATION));
        let (Motion::Rates { angular_rate_radps: turn, specific_force_mps2: force }
        | Motion::Increments { angle_rad: turn, velocity_mps: force }) = *motion;
        let readings = Some([turn.to_array(), force.to_array()]);
        self.repeated = if self.last == readings { self.repeated.saturating_add(1) } else { 0 };
        self.last = readings;
        self.repeated >= STUCK && vibrates()
    }

    /// Whether a logger has interpolated the sample: `STRAIGHT` samples or more, over `STRAIGHT_S`, lie on a
    /// straight line in all six readings. `interval_s` is the time since the last used sample. The readings must change
    /// along the line. The usual noise of an accelerometer must exceed `MIN_NOISE`.
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
            // Axis by axis: nearly every sample is already off the line on the first axis.
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
            && self.accel.usual.iter().any(|&variance| variance > T::of(MIN_NOISE))
            && self.accel.difference.is_moving()
    }

    /// Feeds the rates of a sample, `interval_s` after the previous one, with the inertial unit's own full-scale flags
    /// `marks`. `momentary` is true for rates at the sample's time, false for means over the interval.
    ///
    /// # Source
    /// Equation (S13) of docs/equations.md.
    pub fn push(
        &mut self,
        (rates, momentary): (&MeanRates<T>, bool),
        marks: &ImuAxes,
        interval_s: T,
        (scale, checks): (&FullScale, Checks),
    ) -> Suspicion<T> {
        if self.typical_interval_s == T::ZERO {
            self.typical_interval_s = interval_s;
        }
        // The typical interval moves by 0.5 % of the difference per sample. A longer interval counts as 1.5 typical
        // intervals.
        let typical = self.typical_interval_s;
        let longest = T::of(1.5) * typical;
        let is_late = interval_s > longest;
        let usual_s = if is_late { longest } else { interval_s };
        self.typical_interval_s += T::of(0.005) * (usual_s - typical);
        let is_even = !is_late && interval_s >= T::of(0.5) * typical;
        self.even = if is_even { self.even.saturating_add(1) } else { 0 };

        // Until the memory `USUAL_S` is full, the usual vibration is the plain mean since the start.
        self.seen_s = T::of(USUAL_S).min(self.seen_s + interval_s);
        let timing = Timing {
            interval_s,
            typical_s: typical,
            lost_s: if is_late { interval_s - typical } else { T::ZERO },
            now: (interval_s / T::of(NOW_S)).min(T::ONE),
            usual: (interval_s / self.seen_s).min(T::ONE),
            usual_is_known: checks.shocks && self.seen_s > T::of(MIN_SEEN_S),
            checks,
        };
        let (turn, force) = (rates.angular_rate_radps, rates.specific_force_mps2);
        let gyro = self.gyro.push(turn, marks.gyro, scale.gyro_radps, &Limits::GYRO, &timing);
        let accel = self.accel.push(force, marks.accel, scale.accel_mps2, &Limits::ACCEL, &timing);
        let sampling = Sampling { interval_s, momentary, even: self.even >= EVEN };
        let held = self.held.push(force, accel.shock, &sampling);
        let hidden_force = held.variance.map_or(accel.hidden, |variance| [variance; 3]);
        Suspicion {
            clipped: ImuAxes { gyro: gyro.clipped, accel: accel.clipped },
            stuck: ImuAxes { gyro: gyro.stuck, accel: accel.stuck },
            shaken: gyro.shaken || accel.shaken,
            angle_variance: sums(gyro.variance, gyro.hidden),
            velocity_variance: sums(accel.variance, hidden_force),
            withheld_mps2: held.withheld_mps2,
        }
    }

    /// Recent vibration of the gyros, variance per axis, (rad/s)².
    #[must_use]
    pub(crate) fn gyro_vibration(&self) -> [T; 3] {
        self.gyro.vibration.variance()
    }

    /// Recent vibration of the accelerometers, variance per axis, (m/s²)².
    #[must_use]
    pub(crate) fn accel_vibration(&self) -> [T; 3] {
        self.accel.vibration.variance()
    }

    /// Forgets the last two samples, and ends a shock, after a gap.
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

#[cfg(test)]
mod tests;
