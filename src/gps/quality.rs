//! Checks of the quality of a fix, which report the failed checks.

use core::fmt;

use super::{Dimension, ReceiverFix};
use crate::earth::Geodetic;
use crate::scalar::Scalar;

/// Limits of a fix. A value that the receiver does not send passes the check.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize), serde(default))]
pub struct Limits {
    /// Whether a 2-D fix, whose height is held or assumed, is rejected.
    pub need_three_dimensions: bool,
    /// Smallest number of satellites used.
    pub min_satellites: u8,
    /// Largest dilution of precision of position.
    pub max_position_dilution: f64,
    /// Largest horizontal dilution of precision.
    pub max_horizontal_dilution: f64,
    /// Largest one-sigma of horizontal position, m.
    pub max_horizontal_sigma_m: f64,
    /// Largest one-sigma of height, m.
    pub max_vertical_sigma_m: f64,
    /// Largest one-sigma of velocity on any axis, m/s.
    pub max_velocity_sigma_mps: f64,
    /// Largest ground speed of the vehicle, m/s.
    pub max_ground_speed_mps: f64,
    /// Largest climb or sink rate of the vehicle, m/s.
    pub max_vertical_speed_mps: f64,
    /// Largest jump of a position, m: distance from the last good fix minus the distance that the vehicle can travel.
    pub max_jump_m: f64,
    /// Largest delay of a fix, s, relative to the most prompt recent fix.
    pub max_delay_s: f64,
}

impl Default for Limits {
    /// Limits for a small helicopter: up to 60 m/s, with a receiver that is accurate to a few metres.
    fn default() -> Self {
        Self {
            need_three_dimensions: true,
            min_satellites: 4,
            max_position_dilution: 6.0,
            max_horizontal_dilution: 4.0,
            max_horizontal_sigma_m: 20.0,
            max_vertical_sigma_m: 30.0,
            max_velocity_sigma_mps: 3.0,
            max_ground_speed_mps: 60.0,
            max_vertical_speed_mps: 20.0,
            max_jump_m: 30.0,
            max_delay_s: 0.5,
        }
    }
}

/// A failed check of a fix, with the value found and its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "each variant's text says it, and the fields are its numbers")]
pub enum Failure {
    /// The height was not solved for.
    TwoDimensional,
    Satellites {
        found: u8,
        min: u8,
    },
    PositionDilution {
        found: f64,
        max: f64,
    },
    HorizontalDilution {
        found: f64,
        max: f64,
    },
    HorizontalSigma {
        found_m: f64,
        max_m: f64,
    },
    VerticalSigma {
        found_m: f64,
        max_m: f64,
    },
    VelocitySigma {
        found_mps: f64,
        max_mps: f64,
    },
    GroundSpeed {
        found_mps: f64,
        max_mps: f64,
    },
    VerticalSpeed {
        found_mps: f64,
        max_mps: f64,
    },
    /// The distance from both the last good fix and the last fix exceeds what the vehicle can have travelled, by more
    /// than the limit.
    Jump {
        found_m: f64,
        max_m: f64,
    },
    /// The receiver's time did not advance: an epoch is repeated or out of order.
    TimeNotAdvancing {
        step_s: f64,
    },
    /// The fix arrived later than usual.
    Delay {
        found_s: f64,
        max_s: f64,
    },
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::TwoDimensional => write!(f, "2-D fix: the height was not solved for"),
            Self::Satellites { found, min } => write!(f, "{found} satellites, need {min}"),
            Self::PositionDilution { found, max } => write!(f, "PDOP {found:.1}, limit {max:.1}"),
            Self::HorizontalDilution { found, max } => {
                write!(f, "HDOP {found:.1}, limit {max:.1}")
            }
            Self::HorizontalSigma { found_m, max_m } => {
                write!(f, "horizontal sigma {found_m:.1} m, limit {max_m:.1} m")
            }
            Self::VerticalSigma { found_m, max_m } => {
                write!(f, "vertical sigma {found_m:.1} m, limit {max_m:.1} m")
            }
            Self::VelocitySigma { found_mps, max_mps } => {
                write!(f, "velocity sigma {found_mps:.2} m/s, limit {max_mps:.2} m/s")
            }
            Self::GroundSpeed { found_mps, max_mps } => {
                write!(f, "ground speed {found_mps:.1} m/s, limit {max_mps:.1} m/s")
            }
            Self::VerticalSpeed { found_mps, max_mps } => {
                write!(f, "vertical speed {found_mps:.1} m/s, limit {max_mps:.1} m/s")
            }
            Self::Jump { found_m, max_m } => {
                write!(f, "position jumped {found_m:.0} m, possible {max_m:.0} m")
            }
            Self::TimeNotAdvancing { step_s } => {
                write!(f, "the receiver's time stepped by {step_s:.3} s")
            }
            Self::Delay { found_s, max_s } => {
                write!(f, "{found_s:.2} s later than usual, limit {max_s:.2} s")
            }
        }
    }
}

/// All failed checks of one fix.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Failures([Option<Failure>; 12]);

impl Failures {
    /// Whether the fix is good.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.iter().next().is_none()
    }

    /// The failed checks, in the order of [`Limits`].
    pub fn iter(&self) -> impl Iterator<Item = &Failure> {
        self.0.iter().flatten()
    }
}

/// Checks the fixes of one receiver, each fix by itself and against previous fixes.
#[derive(Clone, Copy, Debug)]
pub struct QualityCheck {
    limits: Limits,
    /// The last good fix.
    good: Option<ReceiverFix>,
    /// The last fix, good or not.
    last: Option<ReceiverFix>,
    /// The most prompt recent fix: the reference for the usual delay.
    prompt: Option<ReceiverFix>,
}

/// Largest relative drift between the clocks: the receiver's clock is exact, the host's clock is a plain crystal.
const CLOCK_DRIFT: f64 = 1e-4;

impl QualityCheck {
    /// A check without previous fixes.
    #[must_use]
    pub const fn new(limits: Limits) -> Self {
        Self { limits, good: None, last: None, prompt: None }
    }

    /// All failed checks of `fix`. Call it for every fix, in the order of arrival.
    ///
    /// A jump fails only if it exceeds its limit relative to both the last good fix and the last fix of any kind. Two
    /// consecutive fixes that agree are therefore accepted. A wrong first fix thus does not cause the rejection of all
    /// later fixes.
    pub fn check(&mut self, fix: &ReceiverFix) -> Failures {
        let limits = &self.limits;
        let sigma = fix.position_sigma_m.map(|sigma| sigma.to_array());
        let horizontal_sigma = sigma.map(|[north, east, _]| libm::fmax(north, east));
        let velocity_sigma =
            fix.velocity_sigma_mps.map(|sigma| sigma.to_array().into_iter().fold(0.0, libm::fmax));
        let vertical_speed = fix.down_velocity_mps.map(libm::fabs);
        let failures = Failures([
            (limits.need_three_dimensions && fix.dimension == Some(Dimension::TwoD))
                .then_some(Failure::TwoDimensional),
            fix.satellites
                .filter(|found| *found < limits.min_satellites)
                .map(|found| Failure::Satellites { found, min: limits.min_satellites }),
            above(fix.dilution.position, limits.max_position_dilution)
                .map(|(found, max)| Failure::PositionDilution { found, max }),
            above(fix.dilution.horizontal, limits.max_horizontal_dilution)
                .map(|(found, max)| Failure::HorizontalDilution { found, max }),
            above(horizontal_sigma, limits.max_horizontal_sigma_m)
                .map(|(found_m, max_m)| Failure::HorizontalSigma { found_m, max_m }),
            above(sigma.map(|[_, _, down]| down), limits.max_vertical_sigma_m)
                .map(|(found_m, max_m)| Failure::VerticalSigma { found_m, max_m }),
            above(velocity_sigma, limits.max_velocity_sigma_mps)
                .map(|(found_mps, max_mps)| Failure::VelocitySigma { found_mps, max_mps }),
            above(fix.ground_speed_mps, limits.max_ground_speed_mps)
                .map(|(found_mps, max_mps)| Failure::GroundSpeed { found_mps, max_mps }),
            above(vertical_speed, limits.max_vertical_speed_mps)
                .map(|(found_mps, max_mps)| Failure::VerticalSpeed { found_mps, max_mps }),
            self.jump(fix),
            self.last
                .and_then(|last| fix.time?.since(&last.time?))
                .filter(|step_s| *step_s <= 0.0)
                .map(|step_s| Failure::TimeNotAdvancing { step_s }),
            self.delay(fix),
        ]);
        if failures.is_empty() {
            self.good = Some(*fix);
        }
        self.last = Some(*fix);
        failures
    }

    fn jump(&self, fix: &ReceiverFix) -> Option<Failure> {
        let beyond = |before: &ReceiverFix| {
            let seconds = fix
                .time
                .zip(before.time)
                .and_then(|(now, then)| now.since(&then))
                .unwrap_or(fix.arrival - before.arrival);
            let reach =
                Scalar::hypot(self.limits.max_ground_speed_mps, self.limits.max_vertical_speed_mps);
            let max_m = self.limits.max_jump_m + reach * libm::fmax(seconds, 0.0);
            let found_m = distance_m(before, fix);
            (found_m > max_m).then_some(Failure::Jump { found_m, max_m })
        };
        let failure = beyond(self.good.as_ref()?)?;
        self.last.as_ref().and_then(beyond)?;
        Some(failure)
    }

    fn delay(&mut self, fix: &ReceiverFix) -> Option<Failure> {
        let max_s = self.limits.max_delay_s;
        let behind = |prompt: &ReceiverFix| {
            let by_receiver_s = fix.time?.since(&prompt.time?)?;
            let by_arrival_s = fix.arrival - prompt.arrival;
            Some(by_arrival_s - by_receiver_s - CLOCK_DRIFT * libm::fabs(by_arrival_s))
        };
        let found_s = self.prompt.as_ref().and_then(behind);
        if found_s.is_none_or(|found_s| found_s <= 0.0) {
            self.prompt = Some(*fix);
        }
        above(found_s, max_s).map(|(found_s, max_s)| Failure::Delay { found_s, max_s })
    }
}

fn above(found: Option<f64>, max: f64) -> Option<(f64, f64)> {
    found.filter(|found| *found > max).map(|found| (found, max))
}

/// Straight-line distance; horizontal distance alone where a height is unknown.
fn distance_m(from: &ReceiverFix, to: &ReceiverFix) -> f64 {
    let heights = from.height_m.zip(to.height_m);
    let heights = heights.or(from.altitude_msl_m.zip(to.altitude_msl_m));
    let (from_height_m, to_height_m) = heights.unwrap_or((0.0, 0.0));
    let ecef = |fix: &ReceiverFix, height_m| {
        let ReceiverFix { latitude_rad, longitude_rad, .. } = *fix;
        Geodetic { latitude_rad, longitude_rad, height_m }.to_ecef()
    };
    (ecef(to, to_height_m) - ecef(from, from_height_m)).norm()
}
