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
use crate::gps::Fix;
use crate::imu::{ImuSample, Motion};
use crate::time::Time;
use force::MeanForce;
use turning::GravityTurn;
use velocity::FixMotion;

/// Time over which samples are averaged, s: vibration averages out, turns remain.
const PART_S: f64 = 0.5;
/// Longest gap between samples of one average, s.
const GAP_S: f64 = 0.25;
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
        part: Part::EMPTY,
        parts: 0,
        force: MeanForce::NONE,
        turning: GravityTurn::NONE,
        fixes: FixMotion::NONE,
    };

    /// Processes the next event; returns a fault once, when it has become certain. The specific force is judged after
    /// 10 s, the gyros within 10 min, the fixes after at least 80 s of motion. Values that are not finite are skipped.
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
        // Both judge the first part that shows them; a force of the wrong size or direction has no known turn.
        self.force.push(mean.force_mps2).or_else(|| self.turning.push(&mean))
    }

    fn push_fix(&mut self, fix: &Fix) -> Option<SetupFault> {
        if fix.is_finite() { self.fixes.push(fix) } else { None }
    }
}

/// Means over a part, body axes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PartMean {
    rate_radps: [f32; 3],
    force_mps2: [f32; 3],
}

/// Sums of the samples of the current part.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    start: Time,
    last: Time,
    count: u16,
    rate_radps: [f32; 3],
    force_mps2: [f32; 3],
}

impl Part {
    const EMPTY: Self = Self {
        start: Time::ZERO,
        last: Time::ZERO,
        count: 0,
        rate_radps: [0.0; 3],
        force_mps2: [0.0; 3],
    };

    /// Adds a sample; returns the means of the part that it ends.
    fn push(&mut self, sample: &ImuSample) -> Option<PartMean> {
        if !sample.motion.is_finite() {
            return None;
        }
        let interval_s = sample.time - self.last;
        let is_next = self.count > 0 && interval_s > 0.0 && interval_s <= GAP_S;
        if !is_next {
            // Increments of an unknown interval are left out.
            let is_rate = matches!(sample.motion, Motion::Rates { .. });
            *self = Self { start: sample.time, last: sample.time, ..Self::EMPTY };
            self.count = 1;
            if is_rate {
                self.add(sample, 1.0);
            }
            return None;
        }
        let mean = (sample.time - self.start >= PART_S).then(|| self.mean()).flatten();
        if sample.time - self.start >= PART_S {
            *self = Self { start: sample.time, ..Self::EMPTY };
        }
        self.last = sample.time;
        self.count = self.count.saturating_add(1);
        self.add(sample, interval_s);
        mean
    }

    fn add(&mut self, sample: &ImuSample, interval_s: f64) {
        let mean = sample.motion.mean_rates(interval_s);
        let sum =
            |sum: [f32; 3], value: [f64; 3]| plus(sum, value.map(|component| component as f32));
        self.rate_radps = sum(self.rate_radps, mean.angular_rate_radps.to_array());
        self.force_mps2 = sum(self.force_mps2, mean.specific_force_mps2.to_array());
    }

    fn mean(&self) -> Option<PartMean> {
        let share = 1.0 / f32::from(self.count.max(1));
        let mean = |sum: [f32; 3]| sum.map(|component| share * component);
        (self.count >= LEAST_SAMPLES).then(|| PartMean {
            rate_radps: mean(self.rate_radps),
            force_mps2: mean(self.force_mps2),
        })
    }
}

fn plus([a, b, c]: [f32; 3], [x, y, z]: [f32; 3]) -> [f32; 3] {
    [a + x, b + y, c + z]
}

fn norm([x, y, z]: [f32; 3]) -> f32 {
    libm::sqrtf(x * x + y * y + z * z)
}
