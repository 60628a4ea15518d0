//! Test inputs that the autopilot flies, with their limits and reasons for an early end.

use super::check::{self, ConfigError};
use super::maneuver::Maneuver;
use crate::controls::Sticks;
use crate::ekf::Solution;
use crate::frames::{Ned, Vector};
use crate::scalar::{Readable, Scalar};

/// A test input added to the autopilot's commands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Excitation {
    /// Direction of the test input: 1 on the excited stick, 0 on the others.
    pub direction: Sticks,
    /// The manoeuvre added to the stick, as a fraction of full stick.
    pub maneuver: Maneuver,
    /// Limits that end the test input early.
    pub limits: ExcitationLimits,
}

/// Limits beyond which a test input ends at once and the autopilot flies alone, and the largest rate of the stick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExcitationLimits {
    /// Largest roll and pitch, rad.
    pub tilt_rad: f64,
    /// Largest angular rate about any axis, rad/s.
    pub rate_radps: f64,
    /// Largest deviation from the velocity that guidance commands, m/s.
    pub speed_mps: f64,
    /// Largest rate of the stick, 1/s; the travel from neutral to a stop is 1. The input rises and falls at most at
    /// this rate, and ends when the stick has returned.
    pub stick_rate_per_s: f64,
}

impl Default for ExcitationLimits {
    /// Limits of 20°, 115 °/s and 2.5 m/s, the range of validity of a hover model. The rate of the stick is not
    /// limited.
    fn default() -> Self {
        Self { tilt_rad: 0.35, rate_radps: 2.0, speed_mps: 2.5, stick_rate_per_s: f64::INFINITY }
    }
}

/// Reason of the early end of a test input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ExcitationAbort {
    /// The pilot moved a stick.
    Stick,
    /// The autopilot no longer holds velocity: the pilot took over, or the estimate is not good enough.
    Mode,
    /// Roll or pitch beyond the limit.
    Tilt,
    /// An angular rate beyond the limit.
    Rate,
    /// The difference between velocity and commanded velocity is beyond the limit.
    Speed,
}

impl core::fmt::Display for ExcitationAbort {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Stick => "the pilot moved a stick",
            Self::Mode => "velocity is no longer held",
            Self::Tilt => "roll or pitch went beyond its limit",
            Self::Rate => "an angular rate went beyond its limit",
            Self::Speed => "the deviation from the commanded velocity went beyond its limit",
        })
    }
}

/// Reason for the rejection of a test input.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ExcitationError {
    /// The autopilot does not hold velocity.
    NotFlying,
    /// Another test input is active.
    Busy,
    /// A number is out of range.
    Value {
        /// Name of the number.
        what: &'static str,
        /// The number found.
        found: f64,
        /// The expected range.
        expected: &'static str,
    },
}

impl core::fmt::Display for ExcitationError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NotFlying => f.write_str("test input: the autopilot does not hold velocity"),
            Self::Busy => f.write_str("test input: another one is under way"),
            Self::Value { what, found, expected } => {
                write!(f, "test input: {what}: found {}, expected {expected}", Readable(*found))
            }
        }
    }
}

impl core::error::Error for ExcitationError {}

impl Excitation {
    /// Rejects a test input that cannot be flown.
    ///
    /// # Errors
    /// [`ExcitationError::Value`] with the first number that is out of range.
    pub fn check(&self) -> Result<(), ExcitationError> {
        for stick in self.direction.to_array() {
            within("direction", stick, -1.0, 1.0, "-1 to 1 on each stick")?;
        }
        within("amplitude", self.maneuver.amplitude().abs(), 0.0, 0.5, "up to half of full stick")?;
        within("duration", self.maneuver.duration_s(), 0.05, 300.0, "0.05 to 300 s")?;
        if let Maneuver::Sweep { first_hz, last_hz, fade_s, .. } = self.maneuver {
            within("first frequency", first_hz, 0.01, 20.0, "0.01 to 20 Hz")?;
            within("last frequency", last_hz, first_hz, 20.0, "the first to 20 Hz")?;
            within("fade", fade_s, 0.0, 300.0, "0 to 300 s")?;
        }
        self.limits.check()
    }
}

impl ExcitationLimits {
    /// Rejects limits out of range.
    ///
    /// # Errors
    /// [`ExcitationError::Value`] with the first number that is out of range.
    pub fn check(&self) -> Result<(), ExcitationError> {
        let Self { tilt_rad, rate_radps, speed_mps, stick_rate_per_s } = *self;
        within("limit of tilt", tilt_rad, 0.0, 0.8, "0 to 0.8 rad")?;
        within("limit of rate", rate_radps, 0.0, 10.0, "0 to 10 rad/s")?;
        within("limit of speed", speed_mps, 0.0, 20.0, "0 to 20 m/s")?;
        let expected = "at least 0.1 a second";
        within("rate of the stick", stick_rate_per_s, 0.1, f64::INFINITY, expected)
    }
}

/// Rejects NaN and numbers outside `lowest` to `highest`.
pub(super) fn within(
    what: &'static str,
    found: f64,
    lowest: f64,
    highest: f64,
    expected: &'static str,
) -> Result<(), ExcitationError> {
    check::within(what, found, lowest, highest, expected).map_err(
        |ConfigError { what, found, expected }| ExcitationError::Value { what, found, expected },
    )
}

/// An active test input.
#[derive(Clone, Copy, Debug)]
struct Running {
    excitation: Excitation,
    elapsed_s: f64,
    /// Value of the last addition to the stick, along the direction.
    level: f64,
}

/// The active test input, if any. It is computed in `f64` for every number type of the autopilot.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Exciter {
    running: Option<Running>,
}

impl Exciter {
    pub fn start(&mut self, excitation: Excitation) -> Result<(), ExcitationError> {
        if self.running.is_some() {
            return Err(ExcitationError::Busy);
        }
        excitation.check()?;
        self.running = Some(Running { excitation, elapsed_s: 0.0, level: 0.0 });
        Ok(())
    }

    pub const fn is_running(&self) -> bool {
        self.running.is_some()
    }

    pub const fn stop(&mut self) {
        self.running = None;
    }

    /// Returns the value to add to the sticks over the next `period_s`, and the reason if the test input ended early.
    /// `flown` is the estimate and the commanded velocity; `None` while the autopilot does not hold velocity.
    pub fn step<T: Scalar>(
        &mut self,
        flown: Option<(&Solution<T>, Vector<Ned, T>)>,
        period_s: f64,
    ) -> (Sticks, Option<ExcitationAbort>) {
        let Some(running) = self.running else { return (Sticks::NEUTRAL, None) };
        let Running { excitation: Excitation { direction, maneuver, limits }, elapsed_s, level } =
            running;
        if let Some(abort) = limits.crossed(flown) {
            self.running = None;
            return (Sticks::NEUTRAL, Some(abort));
        }
        let wanted = maneuver.at(elapsed_s);
        let travel = limits.stick_rate_per_s * period_s;
        let next = if (wanted - level).abs() <= travel {
            wanted
        } else {
            level + libm::copysign(travel, wanted - level)
        };
        let lasts = elapsed_s < maneuver.duration_s() || next != 0.0;
        let elapsed_s = elapsed_s + period_s;
        self.running = lasts.then_some(Running { elapsed_s, level: next, ..running });
        (direction.scaled(next), None)
    }
}

impl ExcitationLimits {
    /// The limit that the estimate exceeds, if any. Without an estimate the reason is that the autopilot does not hold
    /// velocity.
    fn crossed<T: Scalar>(
        &self,
        flown: Option<(&Solution<T>, Vector<Ned, T>)>,
    ) -> Option<ExcitationAbort> {
        let Some((solution, commanded_mps)) = flown else { return Some(ExcitationAbort::Mode) };
        let [roll_rad, pitch_rad, _] = solution.body_to_ned.angles();
        let rates = solution.angular_rate_radps.to_array();
        // Written so that NaN exceeds every limit.
        let within = |value: T, limit: f64| value.abs() <= T::of(limit);
        if !(within(roll_rad, self.tilt_rad) && within(pitch_rad, self.tilt_rad)) {
            Some(ExcitationAbort::Tilt)
        } else if !rates.iter().all(|rate| within(*rate, self.rate_radps)) {
            Some(ExcitationAbort::Rate)
        } else if !within((solution.velocity_mps - commanded_mps).norm(), self.speed_mps) {
            Some(ExcitationAbort::Speed)
        } else {
            None
        }
    }
}
