//! What of an estimate can be flown on.

use super::config::{ConfigError, within};
use crate::ekf::Solution;
use crate::time::Time;

/// One-sigmas up to which an estimate is flown on, and its greatest age.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
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

/// Why an estimate, or a part of it, is not flown on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distrust {
    /// There is none.
    Missing,
    /// A value of it is NaN or infinite.
    NotFinite,
    /// It is too old, or of another clock.
    Stale,
    /// Roll and pitch are too uncertain.
    Tilt,
    /// Velocity is too uncertain.
    Velocity,
    /// Position is too uncertain.
    Position,
}

/// What of an estimate can be flown on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Health {
    /// Roll, pitch and rates, or why not.
    pub tilt: Result<(), Distrust>,
    /// Heading.
    pub heading: bool,
    /// Horizontal velocity, or why not.
    pub velocity: Result<(), Distrust>,
    /// Vertical velocity.
    pub vertical_velocity: bool,
    /// Position, or why not.
    pub position: Result<(), Distrust>,
}

impl Health {
    const fn none(why: Distrust) -> Self {
        Self {
            tilt: Err(why),
            heading: false,
            velocity: Err(why),
            vertical_velocity: false,
            position: Err(why),
        }
    }

    /// What of `solution` can be flown on at `now`.
    #[must_use]
    pub fn of(solution: Option<&Solution>, now: Time, limits: &HealthLimits) -> Self {
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
        let speed = solution.velocity_sigma_mps;
        let place = solution.position_sigma_m.to_array();
        let velocity = if speed.x().max(speed.y()) > limits.velocity_sigma_mps {
            Err(Distrust::Velocity)
        } else {
            Ok(())
        };
        let near = place.into_iter().all(|sigma| sigma <= limits.position_sigma_m);
        Self {
            tilt: Ok(()),
            heading: yaw <= limits.heading_sigma_rad,
            velocity,
            vertical_velocity: speed.z() <= limits.vertical_velocity_sigma_mps,
            position: velocity.and(if near { Ok(()) } else { Err(Distrust::Position) }),
        }
    }
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
