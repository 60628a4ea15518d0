//! What of an estimate is good enough to fly by: one set of limits, one answer.
//!
//! [`Health::assess`] is the only place that decides. The autopilot picks its mode by it, the flight
//! loop reports it to the ground; both assess once a cycle.
//!
//! It looks at one moment. Hysteresis belongs to whoever acts on the answer: the autopilot returns to
//! a better mode after [`HealthLimits::recovery_s`].

use super::check::{ConfigError, within};
use crate::ekf::Solution;
use crate::time::Time;

/// One-sigmas up to which an estimate is good enough to fly by, and its greatest age. In
/// `autopilot.toml` the section `[health]`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
#[non_exhaustive]
pub struct HealthLimits {
    /// Roll and pitch, rad.
    pub tilt_sigma_rad: f64,
    /// Heading, rad.
    pub heading_sigma_rad: f64,
    /// Horizontal velocity, m/s.
    pub velocity_sigma_mps: f64,
    /// Vertical velocity, m/s.
    pub vertical_velocity_sigma_mps: f64,
    /// Position, each axis, m.
    pub position_sigma_m: f64,
    /// Age of the estimate, s.
    pub age_s: f64,
    /// A value must be trusted this long, s, before a better mode is flown on it again.
    pub recovery_s: f64,
}

impl Default for HealthLimits {
    fn default() -> Self {
        Self {
            tilt_sigma_rad: 0.12,
            heading_sigma_rad: 0.35,
            velocity_sigma_mps: 0.8,
            vertical_velocity_sigma_mps: 1.0,
            position_sigma_m: 8.0,
            age_s: 0.2,
            recovery_s: 1.0,
        }
    }
}

impl HealthLimits {
    pub(super) fn check(&self) -> Result<(), ConfigError> {
        const EXPECTED: &str = "above 0, at most 1000";
        within("health.tilt_sigma_rad", self.tilt_sigma_rad, 1e-6, 1e3, EXPECTED)?;
        within("health.heading_sigma_rad", self.heading_sigma_rad, 1e-6, 1e3, EXPECTED)?;
        within("health.velocity_sigma_mps", self.velocity_sigma_mps, 1e-6, 1e3, EXPECTED)?;
        let vertical = self.vertical_velocity_sigma_mps;
        within("health.vertical_velocity_sigma_mps", vertical, 1e-6, 1e3, EXPECTED)?;
        within("health.position_sigma_m", self.position_sigma_m, 1e-6, 1e3, EXPECTED)?;
        within("health.age_s", self.age_s, 1e-3, 1e3, EXPECTED)?;
        within("health.recovery_s", self.recovery_s, 0.0, 1e3, "0 to 1000")
    }
}

/// Why an estimate, or a part of it, is not good enough to fly by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Distrust {
    /// There is none.
    Missing,
    /// A value of it is NaN or infinite.
    NotFinite,
    /// It is too old, or of another clock.
    Stale,
    /// Roll and pitch are too uncertain.
    Tilt,
    /// Heading is too uncertain.
    Heading,
    /// Horizontal velocity is too uncertain.
    Velocity,
    /// Vertical velocity is too uncertain.
    VerticalVelocity,
    /// Position is too uncertain.
    Position,
}

/// What of an estimate is good enough to fly by: each quantity `Ok`, or why it is not.
///
/// Without tilt nothing is good enough, and without horizontal velocity no position is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Health {
    /// Roll, pitch and angular rates.
    pub tilt: Result<(), Distrust>,
    /// Heading.
    pub heading: Result<(), Distrust>,
    /// Horizontal velocity.
    pub velocity: Result<(), Distrust>,
    /// Vertical velocity.
    pub vertical_velocity: Result<(), Distrust>,
    /// Position, all three axes.
    pub position: Result<(), Distrust>,
}

impl Health {
    /// Nothing is good enough, for one reason.
    #[must_use]
    pub const fn none(why: Distrust) -> Self {
        Self {
            tilt: Err(why),
            heading: Err(why),
            velocity: Err(why),
            vertical_velocity: Err(why),
            position: Err(why),
        }
    }

    /// What of `solution` is good enough to fly by at `now`, on the solution's clock.
    #[must_use]
    pub fn assess(solution: Option<&Solution>, now: Time, limits: &HealthLimits) -> Self {
        let Some(solution) = solution else { return Self::none(Distrust::Missing) };
        if !is_finite(solution) {
            return Self::none(Distrust::NotFinite);
        }
        if libm::fabs(now - solution.time) > limits.age_s {
            return Self::none(Distrust::Stale);
        }
        let [roll, pitch, yaw] = solution.attitude_sigma_rad;
        if roll.max(pitch) > limits.tilt_sigma_rad {
            return Self::none(Distrust::Tilt);
        }
        let [north, east, down] = solution.velocity_sigma_mps.to_array();
        let velocity = below(north.max(east), limits.velocity_sigma_mps, Distrust::Velocity);
        let [x, y, z] = solution.position_sigma_m.to_array();
        let place = below(x.max(y).max(z), limits.position_sigma_m, Distrust::Position);
        Self {
            tilt: Ok(()),
            heading: below(yaw, limits.heading_sigma_rad, Distrust::Heading),
            velocity,
            vertical_velocity: below(
                down,
                limits.vertical_velocity_sigma_mps,
                Distrust::VerticalVelocity,
            ),
            position: velocity.and(place),
        }
    }
}

fn below(sigma: f64, limit: f64, why: Distrust) -> Result<(), Distrust> {
    if sigma <= limit { Ok(()) } else { Err(why) }
}

fn is_finite(solution: &Solution) -> bool {
    solution.position.is_navigable()
        && solution.velocity_mps.is_finite()
        && solution.body_to_ned.quaternion().is_finite()
        && solution.angular_rate_radps.is_finite()
        && solution.position_sigma_m.is_finite()
        && solution.velocity_sigma_mps.is_finite()
        && solution.attitude_sigma_rad.iter().all(|sigma| sigma.is_finite())
}
