//! What of the estimate is good enough to fly by.

use hovernav::autopilot::{Distrust as CoreDistrust, Health as CoreHealth, Trust as CoreTrust};
use hovernav::time::Time;

use crate::access::{object, output};
use crate::object::Hovernav;
use crate::status::Status;

/// Why a quantity is not good enough to fly by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Distrust {
    /// It is good enough.
    None = 0,
    /// There is no estimate.
    Missing = 1,
    /// A value of it is not finite.
    NotFinite = 2,
    /// It is too old, or of another clock.
    Stale = 3,
    /// Roll and pitch are too uncertain.
    Tilt = 4,
    /// Heading is too uncertain.
    Heading = 5,
    /// Horizontal velocity is too uncertain.
    Velocity = 6,
    /// Vertical velocity is too uncertain.
    VerticalVelocity = 7,
    /// Position is too uncertain.
    Position = 8,
    /// The sensor repeats itself: it does not measure.
    Frozen = 9,
    /// The fixes deny the estimate.
    Disagreement = 10,
    /// A reason that this header does not know.
    Other = 11,
}

/// How far a quantity can be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Trust {
    /// As it should be.
    Valid = 0,
    /// Good enough to fly by, but near its limits, by dead reckoning, or doubted by a sensor.
    Degraded = 1,
    /// Not good enough.
    Lost = 2,
}

/// What of the estimate is good enough to fly by, and why not.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Health {
    /// Roll, pitch and heading.
    pub attitude: Trust,
    /// Velocity, all axes.
    pub velocity: Trust,
    /// Position.
    pub position: Trust,
    /// What is wrong with roll, pitch and angular rates.
    pub tilt_reason: Distrust,
    /// What is wrong with the heading.
    pub heading_reason: Distrust,
    /// What is wrong with horizontal velocity.
    pub velocity_reason: Distrust,
    /// What is wrong with vertical velocity.
    pub vertical_velocity_reason: Distrust,
    /// What is wrong with position.
    pub position_reason: Distrust,
    /// 1 if velocity and position are by dead reckoning, for want of fixes.
    pub dead_reckoning: u32,
    /// The last accepted fix then, ns.
    pub dead_reckoning_since_ns: i64,
}

pub(crate) const fn distrust(why: CoreDistrust) -> Distrust {
    match why {
        CoreDistrust::Missing => Distrust::Missing,
        CoreDistrust::NotFinite => Distrust::NotFinite,
        CoreDistrust::Stale => Distrust::Stale,
        CoreDistrust::Tilt => Distrust::Tilt,
        CoreDistrust::Heading => Distrust::Heading,
        CoreDistrust::Velocity => Distrust::Velocity,
        CoreDistrust::VerticalVelocity => Distrust::VerticalVelocity,
        CoreDistrust::Position => Distrust::Position,
        CoreDistrust::Frozen => Distrust::Frozen,
        CoreDistrust::Disagreement => Distrust::Disagreement,
        _ => Distrust::Other,
    }
}

const fn trust(trust: CoreTrust) -> Trust {
    match trust {
        CoreTrust::Valid => Trust::Valid,
        CoreTrust::Degraded => Trust::Degraded,
        CoreTrust::Lost => Trust::Lost,
    }
}

impl From<&CoreHealth> for Health {
    fn from(core: &CoreHealth) -> Self {
        let reason = |quantity: Result<(), CoreDistrust>| {
            quantity.map_or_else(distrust, |()| Distrust::None)
        };
        Self {
            attitude: trust(core.attitude_trust()),
            velocity: trust(core.velocity_trust()),
            position: trust(core.position_trust()),
            tilt_reason: reason(core.tilt),
            heading_reason: reason(core.heading),
            velocity_reason: reason(core.velocity),
            vertical_velocity_reason: reason(core.vertical_velocity),
            position_reason: reason(core.position),
            dead_reckoning: u32::from(core.dead_reckoning_since.is_some()),
            dead_reckoning_since_ns: core.dead_reckoning_since.map_or(0, Time::nanoseconds),
        }
    }
}

/// Gives what of the estimate is good enough to fly by at `now_ns`, on the clock of the samples. Call
/// it once a cycle: what comes back has to hold for a while before it counts.
///
/// # Safety
/// Pointers as the crate's rules say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_get_health(
    nav: *mut Hovernav,
    now_ns: i64,
    health: *mut Health,
) -> Status {
    // SAFETY: the caller's promise.
    let nav = unsafe { object(nav) };
    // SAFETY: the caller's promise.
    let place = unsafe { output(health) };
    Status::of(nav.and_then(|nav| {
        let place = place?;
        let solution = nav.flight.estimator.solution();
        let assessed = nav.flight.monitor.assess(solution.as_ref(), Time::from_nanoseconds(now_ns));
        place.write(Health::from(&assessed));
        Ok(())
    }))
}
