//! Health of an estimate: the quantities of the estimate that are good enough to fly on.
//!
//! [`Solution::health`] evaluates one moment: one-sigmas and age. A [`HealthMonitor`] also observes all sensor events
//! and estimator notices. It detects faults that a one-sigma does not show: a frozen sensor, or fixes that contradict
//! the estimate. The autopilot chooses its mode by the monitor's result, and returns to a better mode after
//! [`HealthLimits::recovery_s`].
//!
//! ```
//! use hovernav::prelude::*;
//!
//! let home = Geodetic::from_degrees(48.1, 11.6, 520.0).ok_or("invalid position")?;
//! let solution = Solution::at_rest(Time::ZERO, home);
//! let health = solution.health(Time::from_seconds(0.1));
//! assert!(health.velocity.is_ok() && health.position.is_ok());
//! assert!(solution.health(Time::from_seconds(1.0)).tilt.is_err());     // too old
//! # Ok::<(), &str>(())
//! ```

mod monitor;

pub use monitor::HealthMonitor;

use core::fmt;

use crate::ekf::Solution;
use crate::scalar::Scalar;
use crate::time::Time;

/// Largest one-sigmas and age of an estimate that is good enough to fly on. It is the section `[health]` of
/// `autopilot.toml`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct HealthLimits<T = f64> {
    /// Largest one-sigma of roll and pitch, rad.
    pub tilt_sigma_rad: T,
    /// Largest one-sigma of heading, rad.
    pub heading_sigma_rad: T,
    /// Largest one-sigma of horizontal velocity, m/s.
    pub velocity_sigma_mps: T,
    /// Largest one-sigma of vertical velocity, m/s.
    pub vertical_velocity_sigma_mps: T,
    /// Largest one-sigma of position on each axis, m.
    pub position_sigma_m: T,
    /// Largest age of the estimate, s.
    pub age_s: T,
    /// Time without an accepted fix, s, after which the estimate counts as dead reckoning.
    pub dead_reckoning_s: T,
    /// Time, s, after which continually rejected fixes count as a contradiction to the estimate.
    pub disagreement_s: T,
    /// Time, s, for which a quantity must be good before the autopilot returns to a better mode that uses it.
    pub recovery_s: T,
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
            dead_reckoning_s: 2.5,
            disagreement_s: 3.0,
            recovery_s: 1.0,
        }
    }
}

impl<T: Scalar> HealthLimits<T> {
    /// The same limits in another number type.
    #[must_use]
    pub fn cast<U: Scalar>(&self) -> HealthLimits<U> {
        let number = |value: T| U::of(value.wide());
        HealthLimits {
            tilt_sigma_rad: number(self.tilt_sigma_rad),
            heading_sigma_rad: number(self.heading_sigma_rad),
            velocity_sigma_mps: number(self.velocity_sigma_mps),
            vertical_velocity_sigma_mps: number(self.vertical_velocity_sigma_mps),
            position_sigma_m: number(self.position_sigma_m),
            age_s: number(self.age_s),
            dead_reckoning_s: number(self.dead_reckoning_s),
            disagreement_s: number(self.disagreement_s),
            recovery_s: number(self.recovery_s),
        }
    }
}

/// Reason why an estimate, or a quantity of it, is not good enough to fly on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Distrust {
    /// There is no estimate.
    Missing,
    /// A value of the estimate is NaN or infinite.
    NotFinite,
    /// The estimate is too old, or uses another clock.
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
    /// The sensor repeats the same values: it does not measure.
    Frozen,
    /// The fixes contradict the estimate; it is unknown which of the two is right.
    Disagreement,
}

impl fmt::Display for Distrust {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Missing => "there is no estimate",
            Self::NotFinite => "the estimate is not finite",
            Self::Stale => "the estimate is too old",
            Self::Tilt => "roll and pitch are too uncertain",
            Self::Heading => "the heading is too uncertain",
            Self::Velocity => "horizontal velocity is too uncertain",
            Self::VerticalVelocity => "vertical velocity is too uncertain",
            Self::Position => "position is too uncertain",
            Self::Frozen => "the sensor repeats the same values",
            Self::Disagreement => "the fixes contradict the estimate",
        })
    }
}

/// Trust in a quantity of an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Trust {
    /// Fully usable.
    Valid,
    /// Good enough to fly on, but degraded: close to its limit, by dead reckoning, or suspect after a sensor fault.
    Degraded,
    /// Not good enough to fly on.
    Lost,
}

/// Quantities that are good enough, but degraded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DegradedQuantities {
    /// Roll, pitch and heading.
    pub attitude: bool,
    /// Velocity.
    pub velocity: bool,
    /// Position.
    pub position: bool,
}

/// Fraction of its limit above which a one-sigma counts as degraded.
const DEGRADED: f64 = 0.6;
/// Fraction of its limit below which a one-sigma that exceeded the limit is good again.
const GOOD_AGAIN: f64 = 0.8;

impl DegradedQuantities {
    /// The value for which no quantity is degraded.
    pub const NONE: Self = Self { attitude: false, velocity: false, position: false };

    /// The quantities of a solution that are close to their limits.
    fn near<T: Scalar>(solution: Option<&Solution<T>>, limits: &HealthLimits<T>) -> Self {
        let Some(solution) = solution else { return Self::NONE };
        let [roll, pitch, yaw] = solution.attitude_sigma_rad;
        let [north, east, down] = solution.velocity_sigma_mps.to_array();
        let [x, y, z] = solution.position_sigma_m.to_array();
        let near = |sigma: T, limit: T| sigma > T::of(DEGRADED) * limit;
        Self {
            attitude: near(roll.max(pitch), limits.tilt_sigma_rad)
                || near(yaw, limits.heading_sigma_rad),
            velocity: near(north.max(east), limits.velocity_sigma_mps)
                || near(down, limits.vertical_velocity_sigma_mps),
            position: near(x.max(y).max(z), limits.position_sigma_m),
        }
    }
}

/// State of each quantity of an estimate: `Ok` if it is good enough to fly on, otherwise the reason why it is not.
///
/// If tilt is not good enough, no quantity is. If horizontal velocity is not good enough, position is not either.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Health {
    /// State of roll, pitch and angular rates.
    pub tilt: Result<(), Distrust>,
    /// Heading.
    pub heading: Result<(), Distrust>,
    /// Horizontal velocity.
    pub velocity: Result<(), Distrust>,
    /// Vertical velocity.
    pub vertical_velocity: Result<(), Distrust>,
    /// State of position, all three axes.
    pub position: Result<(), Distrust>,
    /// Quantities that are degraded.
    pub degraded: DegradedQuantities,
    /// Time of the last accepted fix, if it is too long ago. Velocity and position are dead-reckoned since this time.
    pub dead_reckoning_since: Option<Time>,
}

impl<T: Scalar> Solution<T> {
    /// Health of the solution at `now`, on the solution's clock, by the default [`HealthLimits`]. It evaluates one
    /// moment only; a [`HealthMonitor`] also detects frozen sensors and rejected fixes.
    #[must_use]
    pub fn health(&self, now: Time) -> Health {
        Health::assess(Some(self), now, &HealthLimits::default().cast())
    }
}

impl Health {
    /// Health without any good quantity; `why` is the reason.
    #[must_use]
    pub const fn none(why: Distrust) -> Self {
        Self {
            tilt: Err(why),
            heading: Err(why),
            velocity: Err(why),
            vertical_velocity: Err(why),
            position: Err(why),
            degraded: DegradedQuantities::NONE,
            dead_reckoning_since: None,
        }
    }

    /// Roll, pitch and heading.
    #[must_use]
    pub fn attitude_trust(&self) -> Trust {
        trust(self.tilt.and(self.heading).is_ok(), self.degraded.attitude)
    }

    /// Trust in the velocity, all three axes.
    #[must_use]
    pub fn velocity_trust(&self) -> Trust {
        trust(self.velocity.and(self.vertical_velocity).is_ok(), self.degraded.velocity)
    }

    /// Position.
    #[must_use]
    pub fn position_trust(&self) -> Trust {
        trust(self.position.is_ok(), self.degraded.position)
    }

    /// Whether tilt, heading, velocity, vertical velocity and position are good enough, in this order.
    fn are_good(&self) -> [bool; 5] {
        [self.tilt, self.heading, self.velocity, self.vertical_velocity, self.position]
            .map(|quantity| quantity.is_ok())
    }

    /// This health with velocity marked as not good, and therefore position too; `why` is the reason.
    fn without_velocity(self, why: Distrust) -> Self {
        Self { velocity: Err(why), vertical_velocity: Err(why), position: Err(why), ..self }
    }

    /// Health of `solution` at `now`, on the solution's clock.
    #[must_use]
    pub fn assess<T: Scalar>(
        solution: Option<&Solution<T>>,
        now: Time,
        limits: &HealthLimits<T>,
    ) -> Self {
        let health = Self::within(solution, now, limits, &[true; 5]);
        let near = health.tilt.is_ok().then(|| DegradedQuantities::near(solution, limits));
        Self { degraded: near.unwrap_or(DegradedQuantities::NONE), ..health }
    }

    /// Health of `solution` at `now` without [`DegradedQuantities`]. A quantity that was not good enough before must be
    /// well within its limit. `was_good` has the order of [`are_good`](Self::are_good).
    fn within<T: Scalar>(
        solution: Option<&Solution<T>>,
        now: Time,
        limits: &HealthLimits<T>,
        was_good: &[bool; 5],
    ) -> Self {
        let Some(solution) = solution else { return Self::none(Distrust::Missing) };
        if !is_finite(solution) {
            return Self::none(Distrust::NotFinite);
        }
        if now.seconds_since::<T>(solution.time).abs() > limits.age_s {
            return Self::none(Distrust::Stale);
        }
        let [tilt, heading, velocity, vertical, position] =
            was_good.map(|was_good| if was_good { T::ONE } else { T::of(GOOD_AGAIN) });
        let [roll, pitch, yaw] = solution.attitude_sigma_rad;
        if roll.max(pitch) > tilt * limits.tilt_sigma_rad {
            return Self::none(Distrust::Tilt);
        }
        let [north, east, down] = solution.velocity_sigma_mps.to_array();
        let velocity =
            below(north.max(east), velocity * limits.velocity_sigma_mps, Distrust::Velocity);
        let [x, y, z] = solution.position_sigma_m.to_array();
        let place = below(x.max(y).max(z), position * limits.position_sigma_m, Distrust::Position);
        Self {
            tilt: Ok(()),
            heading: below(yaw, heading * limits.heading_sigma_rad, Distrust::Heading),
            velocity,
            vertical_velocity: below(
                down,
                vertical * limits.vertical_velocity_sigma_mps,
                Distrust::VerticalVelocity,
            ),
            position: velocity.and(place),
            degraded: DegradedQuantities::NONE,
            dead_reckoning_since: None,
        }
    }
}

const fn trust(is_good: bool, is_doubtful: bool) -> Trust {
    match (is_good, is_doubtful) {
        (false, _) => Trust::Lost,
        (true, true) => Trust::Degraded,
        (true, false) => Trust::Valid,
    }
}

fn below<T: Scalar>(sigma: T, limit: T, why: Distrust) -> Result<(), Distrust> {
    if sigma <= limit { Ok(()) } else { Err(why) }
}

fn is_finite<T: Scalar>(solution: &Solution<T>) -> bool {
    solution.position.is_navigable()
        && solution.velocity_mps.is_finite()
        && solution.body_to_ned.is_finite()
        && solution.angular_rate_radps.is_finite()
        && solution.heading_revision_rad.is_finite()
        && solution.position_sigma_m.is_finite()
        && solution.velocity_sigma_mps.is_finite()
        && solution.attitude_sigma_rad.iter().all(|sigma| sigma.is_finite())
}
