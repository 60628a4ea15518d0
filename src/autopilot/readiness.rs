//! Readiness of the autopilot to take over: every check with its name and value.

use super::check::{ConfigError, within};
use super::trim::Trim;
use crate::controls::Sticks;
use crate::ekf::Solution;
use crate::frames::{Ned, Vector};
use crate::scalar::Scalar;
use crate::time::Time;

/// One condition that must be met before the autopilot takes over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Check {
    /// Age of the estimate, s.
    Estimate,
    /// Greater one-sigma of roll and pitch, rad.
    Tilt,
    /// One-sigma of heading, rad.
    Heading,
    /// Greater one-sigma of north and east velocity, m/s.
    Velocity,
    /// One-sigma of vertical velocity, m/s.
    VerticalVelocity,
    /// Greatest one-sigma of position on any axis, m.
    Position,
    /// Age of the last good fix, s.
    Fix,
    /// Speed in three dimensions, m/s: the autopilot takes over in a hover.
    Speed,
    /// Angular rate, rad/s.
    Rate,
    /// Greater angle of roll and pitch, rad.
    Level,
    /// Largest deflection of a pilot's stick from hover trim.
    Sticks,
    /// Difference of the loop's period from the design period of the gains, s.
    Period,
    /// Whether the pilot's pulses are fresh: 1 or 0.
    Pilot,
    /// Whether the servos receive their commands: 1 or 0.
    Servos,
    /// Distance from the centre of the geofence, as a fraction of the distance to its side or top; 0 without a
    /// geofence.
    Geofence,
    /// Greater one-sigma of the gyro bias about the roll and pitch axes, rad/s.
    GyroBias,
}

impl Check {
    /// All checks, in the order of [`Readiness::results`].
    pub const ALL: [Self; 16] = [
        Self::Estimate,
        Self::Tilt,
        Self::Heading,
        Self::Velocity,
        Self::VerticalVelocity,
        Self::Position,
        Self::Fix,
        Self::Speed,
        Self::Rate,
        Self::Level,
        Self::Sticks,
        Self::Period,
        Self::Pilot,
        Self::Servos,
        Self::Geofence,
        Self::GyroBias,
    ];

    /// Name of the check, with the unit of its value.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Estimate => "age of the estimate, s",
            Self::Tilt => "one-sigma of roll and pitch, rad",
            Self::Heading => "one-sigma of heading, rad",
            Self::Velocity => "one-sigma of horizontal velocity, m/s",
            Self::VerticalVelocity => "one-sigma of vertical velocity, m/s",
            Self::Position => "one-sigma of position, m",
            Self::Fix => "age of the last fix, s",
            Self::Speed => "speed, m/s",
            Self::Rate => "angular rate, rad/s",
            Self::Level => "roll or pitch, rad",
            Self::Sticks => "stick from hover trim",
            Self::Period => "error of the loop's period, s",
            Self::Pilot => "pilot's signal",
            Self::Servos => "servos",
            Self::Geofence => "share of the way to the geofence",
            Self::GyroBias => "one-sigma of gyro bias, rad/s",
        }
    }
}

/// Largest value with which each check passes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct ReadinessLimits {
    /// Age of the estimate, s.
    pub estimate_age_s: f64,
    /// One-sigma of roll and pitch, rad.
    pub tilt_sigma_rad: f64,
    /// One-sigma of heading, rad.
    pub heading_sigma_rad: f64,
    /// One-sigma of horizontal velocity, m/s.
    pub velocity_sigma_mps: f64,
    /// One-sigma of vertical velocity, m/s.
    pub vertical_velocity_sigma_mps: f64,
    /// One-sigma of position, m.
    pub position_sigma_m: f64,
    /// Age of the last good fix, s.
    pub fix_age_s: f64,
    /// Speed in three dimensions, m/s.
    pub speed_mps: f64,
    /// Angular rate, rad/s.
    pub rate_radps: f64,
    /// Angle of roll and of pitch, rad.
    pub level_rad: f64,
    /// Deflection of a stick from trim; the trim is the configured trim or the trim learned in hover.
    pub stick: f64,
    /// Difference of the loop's period from the design period of the gains, as a fraction of the design period.
    pub period: f64,
    /// One-sigma of the gyro bias about the roll and pitch axes, rad/s. A bias b tilts the vertical. Without GPS the
    /// position error after a time t is g b t³ / 6: 3.3 m after 15 s (Titterton and Weston 2004, section 12.3).
    pub gyro_bias_sigma_radps: f64,
}

impl Default for ReadinessLimits {
    /// Limits in a hover. The limits of one-sigmas are half of those for continued flight, except position: 5 m of 8 m.
    fn default() -> Self {
        Self {
            estimate_age_s: 0.1,
            tilt_sigma_rad: 0.06,
            heading_sigma_rad: 0.17,
            velocity_sigma_mps: 0.4,
            vertical_velocity_sigma_mps: 0.5,
            position_sigma_m: 5.0,
            fix_age_s: 2.5,
            speed_mps: 3.0,
            rate_radps: 0.5,
            level_rad: 0.35,
            stick: 0.5,
            period: 0.05,
            gyro_bias_sigma_radps: 6e-4,
        }
    }
}

impl ReadinessLimits {
    /// Checks that every limit is above 0 and at most 1000.
    ///
    /// # Errors
    /// [`ConfigError`] with the first limit that is out of range.
    pub fn check(&self) -> Result<(), ConfigError> {
        let limit = |what, found| within(what, found, 1e-6, 1e3, "above 0, at most 1000");
        limit("ready.estimate_age_s", self.estimate_age_s)?;
        limit("ready.tilt_sigma_rad", self.tilt_sigma_rad)?;
        limit("ready.heading_sigma_rad", self.heading_sigma_rad)?;
        limit("ready.velocity_sigma_mps", self.velocity_sigma_mps)?;
        limit("ready.vertical_velocity_sigma_mps", self.vertical_velocity_sigma_mps)?;
        limit("ready.position_sigma_m", self.position_sigma_m)?;
        limit("ready.fix_age_s", self.fix_age_s)?;
        limit("ready.speed_mps", self.speed_mps)?;
        limit("ready.rate_radps", self.rate_radps)?;
        limit("ready.level_rad", self.level_rad)?;
        limit("ready.stick", self.stick)?;
        limit("ready.period", self.period)?;
        limit("ready.gyro_bias_sigma_radps", self.gyro_bias_sigma_radps)
    }
}

/// Observed quantities for the readiness checks. `None` means unknown and fails the check, except for `geofence_share`.
#[derive(Clone, Copy, Debug)]
pub struct Observed<'a, T = f64> {
    /// Time of the check, on the estimator's clock.
    pub now: Time,
    /// The estimator's latest solution.
    pub solution: Option<&'a Solution<T>>,
    /// Age of the last good fix, s.
    pub fix_age_s: Option<f64>,
    /// The pilot's sticks.
    pub pilot: Option<Sticks>,
    /// Trim with which the sticks are compared.
    pub trim: &'a Trim,
    /// The loop's own period, s.
    pub loop_period_s: Option<f64>,
    /// The design period of the gains, s.
    pub design_period_s: f64,
    /// Whether the pilot's pulses are fresh on every channel.
    pub pilot_signal: bool,
    /// Whether the servos receive their commands.
    pub servos: bool,
    /// Distance from the centre of the geofence as a fraction of the distance to the geofence, 1 at the geofence.
    /// `None` without a geofence or a position.
    pub geofence_share: Option<f64>,
}

/// One check with its value and its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checked {
    /// The check.
    pub check: Check,
    /// The value; NaN if it is unknown.
    pub value: f64,
    /// The largest value that passes; for [`Check::Pilot`] and [`Check::Servos`] the smallest value that passes.
    pub limit: f64,
    /// Whether the check passes.
    pub passes: bool,
}

impl core::fmt::Display for Checked {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { check, value, limit, .. } = self;
        // Four decimals: the limit of the loop's period is a share of that period.
        let limit = libm::round(limit * 1e4) / 1e4;
        match check {
            Check::Pilot | Check::Servos => {
                write!(f, "{}: {}", check.name(), if self.passes { "good" } else { "not good" })
            }
            _ if value.is_nan() => write!(f, "{}: unknown, expected at most {limit}", check.name()),
            _ => write!(f, "{}: {value:.3}, at most {limit}", check.name()),
        }
    }
}

/// Every check's outcome at one moment.
///
/// ```
/// use hovernav::autopilot::{Check, Observed, Readiness, ReadinessLimits, Trim};
/// use hovernav::time::Time;
///
/// let nothing: Observed<'_> = Observed {
///     now: Time::ZERO,
///     solution: None,
///     fix_age_s: Some(0.4),
///     pilot: None,
///     trim: &Trim::default(),
///     loop_period_s: Some(0.0303),
///     design_period_s: 0.0303,
///     pilot_signal: true,
///     servos: true,
///     geofence_share: None,
/// };
/// let readiness = Readiness::assess(&nothing, &ReadinessLimits::default());
/// assert!(!readiness.is_ready());
/// let first = readiness.failed().next().expect("no estimate");
/// assert_eq!(first.check, Check::Estimate);
/// assert_eq!(first.to_string(), "age of the estimate, s: unknown, expected at most 0.1");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Readiness {
    results: [Checked; Check::ALL.len()],
}

impl Readiness {
    /// Compares every value of `observed` with `limits`.
    #[must_use]
    pub fn assess<T: Scalar>(observed: &Observed<'_, T>, limits: &ReadinessLimits) -> Self {
        let solution = observed.solution;
        let of =
            |number: fn(&Solution<T>) -> T| solution.map_or(f64::NAN, |one| number(one).wide());
        let results = Check::ALL.map(|check| {
            let (value, limit) = match check {
                Check::Estimate => {
                    let age_s = solution.map_or(f64::NAN, |solution| observed.now - solution.time);
                    (libm::fabs(age_s), limits.estimate_age_s)
                }
                Check::Tilt => {
                    let tilt = of(|s| larger(s.attitude_sigma_rad[0], s.attitude_sigma_rad[1]));
                    (tilt, limits.tilt_sigma_rad)
                }
                Check::Heading => (of(|s| s.attitude_sigma_rad[2]), limits.heading_sigma_rad),
                Check::Velocity => {
                    let sigma = of(|s| larger(s.velocity_sigma_mps.x(), s.velocity_sigma_mps.y()));
                    (sigma, limits.velocity_sigma_mps)
                }
                Check::VerticalVelocity => {
                    (of(|s| s.velocity_sigma_mps.z()), limits.vertical_velocity_sigma_mps)
                }
                Check::Position => (of(|s| largest(s.position_sigma_m)), limits.position_sigma_m),
                Check::Fix => (observed.fix_age_s.unwrap_or(f64::NAN), limits.fix_age_s),
                Check::Speed => (of(|s| s.velocity_mps.norm()), limits.speed_mps),
                Check::Rate => (of(|s| s.angular_rate_radps.norm()), limits.rate_radps),
                Check::Level => {
                    let leans = of(|s| {
                        let [roll_rad, pitch_rad, _] = s.body_to_ned.angles();
                        larger(roll_rad.abs(), pitch_rad.abs())
                    });
                    (leans, limits.level_rad)
                }
                Check::Sticks => {
                    let apart = |sticks: Sticks| sticks.farthest_from(observed.trim.sticks);
                    let pilot = observed.pilot.filter(|sticks| sticks.is_finite());
                    (pilot.map_or(f64::NAN, apart), limits.stick)
                }
                Check::Period => {
                    let off = |period_s: f64| libm::fabs(period_s - observed.design_period_s);
                    let limit = limits.period * observed.design_period_s;
                    (observed.loop_period_s.map_or(f64::NAN, off), limit)
                }
                Check::Pilot => (f64::from(u8::from(observed.pilot_signal)), 1.0),
                Check::Servos => (f64::from(u8::from(observed.servos)), 1.0),
                Check::Geofence => (observed.geofence_share.unwrap_or(0.0), AT_GEOFENCE),
                Check::GyroBias => {
                    let bias =
                        of(|s| larger(s.gyro_bias_sigma_radps.x(), s.gyro_bias_sigma_radps.y()));
                    (bias, limits.gyro_bias_sigma_radps)
                }
            };
            // Written so that a NaN fails.
            let passes = match check {
                Check::Pilot | Check::Servos => value >= limit,
                _ => value <= limit,
            };
            Checked { check, value, limit, passes }
        });
        Self { results }
    }

    /// Whether every check passes.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.results.iter().all(|result| result.passes)
    }

    /// Every check, in the order of [`Check::ALL`].
    #[must_use]
    pub const fn results(&self) -> &[Checked; Check::ALL.len()] {
        &self.results
    }

    /// The checks that do not pass.
    pub fn failed(&self) -> impl Iterator<Item = &Checked> {
        self.results.iter().filter(|result| !result.passes)
    }

    /// One bit for each check that does not pass, in the order of [`Check::ALL`]; the first check is the lowest bit.
    #[must_use]
    pub fn failed_bits(&self) -> u16 {
        self.results.iter().rev().fold(0, |bits, result| bits << 1 | u16::from(!result.passes))
    }
}

/// Largest distance from the centre of the geofence at which the autopilot may take over, as a fraction of the distance
/// to the geofence. Outside the geofence the autopilot would turn back at once, to a position that may be wrong.
const AT_GEOFENCE: f64 = 1.0;

/// The larger of two numbers; NaN if one of them is NaN.
fn larger<T: Scalar>(a: T, b: T) -> T {
    if a > b || a.partial_cmp(&a).is_none() { a } else { b }
}

fn largest<T: Scalar>(sigma: Vector<Ned, T>) -> T {
    larger(larger(sigma.x(), sigma.y()), sigma.z())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::earth::Geodetic;
    use crate::frames::{EulerAngles, Rotation};

    #[test]
    fn a_limit_that_is_a_share_has_four_decimals() {
        let check = Check::Period;
        let checked = Checked { check, value: 0.016, limit: 0.05 / 33.0, passes: false };
        let text = checked.to_string();
        assert!(text.ends_with(": 0.016, at most 0.0015"), "{text}");
    }

    fn hovering() -> Solution {
        Solution {
            velocity_mps: Vector::new(0.3, -0.2, 0.1),
            body_to_ned: Rotation::from_euler(EulerAngles::from_degrees(3.0, -1.0, 40.0)),
            angular_rate_radps: Vector::new(0.05, 0.02, -0.1),
            position_sigma_m: Vector::new(1.0, 1.0, 1.5),
            velocity_sigma_mps: Vector::new(0.1, 0.1, 0.1),
            attitude_sigma_rad: [0.01, 0.01, 0.03],
            gyro_bias_sigma_radps: Vector::new(4e-4, 4e-4, 1e-3),
            ..Solution::at_rest(Time::ZERO, Geodetic::from_degrees(1.35, 103.82, 50.0).unwrap())
        }
    }

    fn observed<'a>(solution: &'a Solution, trim: &'a Trim) -> Observed<'a> {
        Observed {
            now: Time::ZERO + 0.02,
            solution: Some(solution),
            fix_age_s: Some(0.7),
            pilot: Some(Sticks { collective: 0.1, ..Sticks::NEUTRAL }),
            trim,
            loop_period_s: Some(0.0304),
            design_period_s: 0.0303,
            pilot_signal: true,
            servos: true,
            geofence_share: Some(0.9),
        }
    }

    #[test]
    fn a_good_hover_is_ready_and_each_fault_fails_its_own_check_alone() {
        let (good, trim) = (hovering(), Trim::default());
        let limits = ReadinessLimits::default();
        let ready = observed(&good, &trim);
        let assessed = Readiness::assess(&ready, &limits);
        assert!(assessed.is_ready() && assessed.failed_bits() == 0, "{assessed:?}");

        let spoilt = |spoil: fn(&mut Solution)| {
            let mut solution = hovering();
            spoil(&mut solution);
            solution
        };
        let solutions = [
            (Check::Tilt, spoilt(|s| s.attitude_sigma_rad[1] = 0.1)),
            (Check::Heading, spoilt(|s| s.attitude_sigma_rad[2] = f64::NAN)),
            (Check::Velocity, spoilt(|s| s.velocity_sigma_mps = Vector::new(f64::NAN, 0.1, 0.1))),
            (
                Check::VerticalVelocity,
                spoilt(|s| s.velocity_sigma_mps = Vector::new(0.1, 0.1, 2.0)),
            ),
            (Check::Position, spoilt(|s| s.position_sigma_m = Vector::new(1.0, 9.0, 1.0))),
            (Check::Speed, spoilt(|s| s.velocity_mps = Vector::new(5.0, 0.0, 0.0))),
            (Check::Rate, spoilt(|s| s.angular_rate_radps = Vector::new(0.0, 0.0, -2.0))),
            (
                Check::Level,
                spoilt(|s| {
                    s.body_to_ned = Rotation::from_euler(EulerAngles::from_degrees(30.0, 0.0, 0.0));
                }),
            ),
            (Check::GyroBias, spoilt(|s| s.gyro_bias_sigma_radps = Vector::new(4e-4, 2e-3, 1e-3))),
        ];
        let mut cases: Vec<(Check, Observed<'_>)> =
            solutions.iter().map(|(check, solution)| (*check, observed(solution, &trim))).collect();
        cases.extend([
            (Check::Estimate, Observed { now: Time::ZERO + 0.5, ..ready }),
            (Check::Fix, Observed { fix_age_s: None, ..ready }),
            (
                Check::Sticks,
                Observed { pilot: Some(Sticks { pedal: -0.8, ..Sticks::NEUTRAL }), ..ready },
            ),
            (Check::Period, Observed { loop_period_s: Some(0.02), ..ready }),
            (Check::Pilot, Observed { pilot_signal: false, ..ready }),
            (Check::Servos, Observed { servos: false, ..ready }),
            (Check::Geofence, Observed { geofence_share: Some(1.2), ..ready }),
        ]);
        assert_eq!(cases.len(), Check::ALL.len());
        for (check, observed) in cases {
            let assessed = Readiness::assess(&observed, &limits);
            let failed: Vec<Check> = assessed.failed().map(|failed| failed.check).collect();
            assert_eq!(failed, [check]);
            assert_eq!(assessed.failed_bits().count_ones(), 1);
            let bit = assessed.failed_bits().trailing_zeros() as usize;
            assert_eq!(Check::ALL[bit], check);
        }
    }

    #[test]
    fn limits_that_cannot_be_are_named() {
        let limits = ReadinessLimits { fix_age_s: f64::NAN, ..ReadinessLimits::default() };
        assert_eq!(limits.check().unwrap_err().what, "ready.fix_age_s");
    }
}
