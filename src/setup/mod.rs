//! Set-up of the sensors: likely mistakes in units, signs and axes, from the first samples and fixes.
//!
//! The filter cannot detect these mistakes itself: with axes forward, left, up, for example, it estimates an inverted
//! vehicle with a small one-sigma. Four references need no filter: gravity, the turns of gravity in body axes, the change
//! of the receiver's position, and the change of its velocity.

mod dead_axis;
mod fault;
mod force;
mod gyro_signs;
mod turning;
mod velocity;

pub use fault::{ForceScale, SetupFault};

use self::turning::PART_S;
use crate::event::Event;
use crate::frames::{Body, Vector};
use crate::gps::Fix;
use crate::imu::{ImuSample, MeanRates, Motion};
use crate::time::Time;
use dead_axis::DeadAxis;
use force::MeanForce;
use gyro_signs::GyroSigns;
use turning::GravityTurn;
use velocity::FixMotion;

/// Length of an averaging interval, ns.
const PART_NS: i64 = (PART_S * 1e9) as i64;
/// Longest interval between two samples of one average, ns.
const GAP_NS: i64 = 250_000_000;
/// Smallest number of samples of an average.
const MIN_SAMPLES: u16 = 3;
/// Number of averages after which the samples are no longer checked: ten minutes.
const MAX_PARTS: u16 = 1200;

/// Check of units, signs and axes: a bounded amount of work for each event, no growing memory.
///
/// The [`Estimator`](crate::ekf::Estimator) contains one, and reports its faults as
/// [`Notice::SetupSuspect`](crate::ekf::Notice::SetupSuspect). Used alone, it checks sensors before a flight:
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
    dead_axis: DeadAxis,
    signs: GyroSigns,
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
        dead_axis: DeadAxis::NONE,
        signs: GyroSigns::NONE,
        fixes: FixMotion::NONE,
    };

    /// Processes the next event. Returns each fault once, when it is certain. The check of the specific force takes 10
    /// s and that of the gyros up to 10 min. The check of the fixes takes at least 80 s of motion. The signs of the gyros
    /// are checked against fixes with a velocity that has proven right. An averaging interval with a value that is not
    /// finite is skipped.
    pub fn push(&mut self, event: &Event) -> Option<SetupFault> {
        match event {
            Event::Imu(sample) => self.push_sample(sample),
            Event::Gps(fix) => self.push_fix(fix),
            _ => None,
        }
    }

    fn push_sample(&mut self, sample: &ImuSample) -> Option<SetupFault> {
        if self.parts >= MAX_PARTS {
            return None;
        }
        let mean = self.part.push(sample)?;
        self.parts += 1;
        self.signs.push(sample.time, &mean);
        // One fault for each average: the next check waits for the next average, so that no fault is lost.
        let force = self.force.push(mean.specific_force_mps2);
        force.or_else(|| self.turning.push(&mean)).or_else(|| self.dead_axis.push(&mean))
    }

    fn push_fix(&mut self, fix: &Fix) -> Option<SetupFault> {
        if !fix.is_finite() {
            return None;
        }
        let fault = self.fixes.push(fix);
        // A wrong velocity looks like wrong gyros.
        if self.fixes.is_sound() { fault.or_else(|| self.signs.push_fix(fix)) } else { fault }
    }
}

/// Sums of the samples in the current averaging interval. Times are whole nanoseconds, and no sample needs a division.
/// On a processor without double precision, times in seconds and a division would take a tenth of a navigation step.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    start: Time,
    last: Time,
    count: u16,
    /// Number of samples with rates; for increments, the sum of their intervals, s.
    weight: f32,
    rate_radps: Vector<Body, f32>,
    force_mps2: Vector<Body, f32>,
}

impl Part {
    /// An averaging interval without samples that begins at `start`.
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

    /// Adds a sample. Returns the averages of the interval that the sample ends, if any. A sample after a gap only
    /// starts a new averaging interval.
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

    /// The averages of the interval; `None` for too few samples, or if a sum is not finite.
    fn mean(&self) -> Option<MeanRates<f32>> {
        let share = 1.0 / self.weight;
        let mean = MeanRates {
            angular_rate_radps: self.rate_radps * share,
            specific_force_mps2: self.force_mps2 * share,
        };
        (self.count >= MIN_SAMPLES
            && mean.angular_rate_radps.is_finite()
            && mean.specific_force_mps2.is_finite())
        .then_some(mean)
    }
}
