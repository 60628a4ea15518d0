//! Set-up of the sensors: likely mistakes in units, signs and axes, from the first samples and fixes.
//!
//! A filter cannot report them itself: fed with axes forward, left, up, it finds a vehicle on its back and is certain of
//! it. Three references need no filter: gravity, the turns of gravity, and the change of the receiver's position.

mod fault;
mod force;
mod turning;
mod velocity;

pub use fault::{ForceScale, SetupFault};

use crate::event::Event;
use crate::frames::{Body, Vector};
use crate::gps::Fix;
use crate::imu::{ImuSample, MeanRates, Motion};
use crate::time::Time;
use force::MeanForce;
use turning::GravityTurn;
use velocity::FixMotion;

/// Time over which samples are averaged, s: vibration averages out, turns remain.
const PART_S: f64 = 0.5;
const PART_NS: i64 = (PART_S * 1e9) as i64;
/// Longest gap between samples of one average, ns.
const GAP_NS: i64 = 250_000_000;
/// Least number of samples of an average.
const LEAST_SAMPLES: u16 = 3;
/// Number of averages after which the samples are no longer checked: ten minutes.
const MOST_PARTS: u16 = 1200;

/// Check of units, signs and axes: a bounded amount of work for each event, no growing memory.
///
/// The [`Estimator`](crate::ekf::Estimator) contains one and reports as
/// [`Notice::SetupSuspect`](crate::ekf::Notice::SetupSuspect). On its own it checks sensors before a flight:
///
/// ```
/// use hovernav::event::Event;
/// use hovernav::frames::Vector;
/// use hovernav::imu::{ImuSample, Motion};
/// use hovernav::setup::{ForceScale, SetupCheck, SetupFault};
/// use hovernav::time::Time;
///
/// let mut check = SetupCheck::default();
/// let mut faults = Vec::new();
/// for k in 0..600 {
///     let in_g = Motion::Rates {
///         angular_rate_radps: Vector::ZERO,
///         specific_force_mps2: Vector::new(0.0, 0.0, -1.0),
///     };
///     let sample = ImuSample::new(Time::from_nanoseconds(k * 20_000_000), in_g);
///     faults.extend(check.push(&Event::Imu(sample)));
/// }
/// assert_eq!(faults, [SetupFault::ForceSize { mean_mps2: 1.0, scale: ForceScale::InG }]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SetupCheck {
    part: Part,
    parts: u16,
    force: MeanForce,
    turning: GravityTurn,
    fixes: FixMotion,
}

impl Default for SetupCheck {
    fn default() -> Self {
        Self::NEW
    }
}

impl SetupCheck {
    /// A check before its first event.
    pub const NEW: Self = Self {
        part: Part::from(Time::ZERO),
        parts: 0,
        force: MeanForce::NONE,
        turning: GravityTurn::NONE,
        fixes: FixMotion::NONE,
    };

    /// Processes the next event; returns a fault once, when it has become certain. The specific force is judged after
    /// 10 s, the gyros within 10 min, the fixes after at least 80 s of motion. Half a second with a value that is not finite
    /// is skipped.
    pub fn push(&mut self, event: &Event) -> Option<SetupFault> {
        match event {
            Event::Imu(sample) => self.push_sample(sample),
            Event::Gps(fix) => self.push_fix(fix),
            _ => None,
        }
    }

    fn push_sample(&mut self, sample: &ImuSample) -> Option<SetupFault> {
        if self.parts >= MOST_PARTS {
            return None;
        }
        let mean = self.part.push(sample)?;
        self.parts += 1;
        self.force.push(mean.specific_force_mps2).or_else(|| self.turning.push(&mean))
    }

    fn push_fix(&mut self, fix: &Fix) -> Option<SetupFault> {
        if fix.is_finite() { self.fixes.push(fix) } else { None }
    }
}

/// Sums of the samples of the current part. Whole nanoseconds and no division for a sample: a processor without double
/// precision needs a tenth of a navigation step for both.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    start: Time,
    last: Time,
    count: u16,
    /// Number of rates, or sum of the intervals of increments, s.
    weight: f32,
    rate_radps: Vector<Body, f32>,
    force_mps2: Vector<Body, f32>,
}

impl Part {
    /// A part without samples, from `start` on.
    const fn from(start: Time) -> Self {
        Self {
            start,
            last: start,
            count: 0,
            weight: 0.0,
            rate_radps: Vector::ZERO,
            force_mps2: Vector::ZERO,
        }
    }

    /// Adds a sample; returns the means of the part that it ends. A sample after a gap, of unknown interval, only starts
    /// a part.
    fn push(&mut self, sample: &ImuSample) -> Option<MeanRates<f32>> {
        let now = sample.time.nanoseconds();
        let interval = now.saturating_sub(self.last.nanoseconds());
        if !(1..=GAP_NS).contains(&interval) {
            *self = Self::from(sample.time);
            return None;
        }
        let mut mean = None;
        if now.saturating_sub(self.start.nanoseconds()) >= PART_NS {
            mean = self.mean();
            *self = Self::from(sample.time);
        }
        let (rate_radps, force_mps2, weight) = match sample.motion.cast() {
            Motion::Rates { angular_rate_radps, specific_force_mps2 } => {
                (angular_rate_radps, specific_force_mps2, 1.0)
            }
            Motion::Increments { angle_rad, velocity_mps } => {
                (angle_rad, velocity_mps, 1e-9 * interval as f32)
            }
        };
        self.last = sample.time;
        self.count = self.count.saturating_add(1);
        self.weight += weight;
        self.rate_radps += rate_radps;
        self.force_mps2 += force_mps2;
        mean
    }

    /// `None` for too few samples, or with one that is not finite.
    fn mean(&self) -> Option<MeanRates<f32>> {
        let share = 1.0 / self.weight;
        let mean = MeanRates {
            angular_rate_radps: self.rate_radps * share,
            specific_force_mps2: self.force_mps2 * share,
        };
        (self.count >= LEAST_SAMPLES
            && mean.angular_rate_radps.is_finite()
            && mean.specific_force_mps2.is_finite())
        .then_some(mean)
    }
}
