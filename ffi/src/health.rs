//! Health of the estimate.

use hovernav::health::{Distrust as CoreDistrust, Health as CoreHealth, Trust as CoreTrust};
use hovernav::time::Time;

use crate::access::{object, output};
use crate::object::Hovernav;
use crate::status::Status;

/// Reason why a quantity is not good enough to fly on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Distrust {
    /// The quantity is good enough.
    None = 0,
    /// There is no estimate.
    Missing = 1,
    /// A value is not finite.
    NotFinite = 2,
    /// The estimate is too old, or uses another clock.
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
    /// The sensor repeats the same values: it does not measure.
    Frozen = 9,
    /// The fixes contradict the estimate.
    Disagreement = 10,
    /// A reason unknown to this header.
    Other = 11,
}

/// Trust in a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Trust {
    /// Fully usable.
    Valid = 0,
    /// Good enough to fly on, but degraded: close to its limit, by dead reckoning, or suspect after a sensor fault.
    Degraded = 1,
    /// Not good enough to fly on.
    Lost = 2,
}

/// Health of the estimate: trust in its quantities, with reasons.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Health {
    /// Trust in roll, pitch and heading.
    pub attitude: Trust,
    /// Trust in velocity, all axes.
    pub velocity: Trust,
    /// Trust in position.
    pub position: Trust,
    /// Reason why roll, pitch and angular rates are not good enough.
    pub tilt_reason: Distrust,
    /// Reason why the heading is not good enough.
    pub heading_reason: Distrust,
    /// Reason why horizontal velocity is not good enough.
    pub velocity_reason: Distrust,
    /// Reason why vertical velocity is not good enough.
    pub vertical_velocity_reason: Distrust,
    /// Reason why position is not good enough.
    pub position_reason: Distrust,
    /// 1 if velocity and position are by dead reckoning, because fixes are missing.
    pub dead_reckoning: u32,
    /// Time of the last accepted fix, ns, if dead_reckoning is 1; else 0.
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

/// Gives the health of the estimate at `now_ns`, on the clock of the samples. Call it once a cycle: a quantity that was
/// lost must be well within its limit before it counts as good again.
///
/// # Safety
/// Pointers follow the rules of the crate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_get_health(
    nav: *mut Hovernav,
    now_ns: i64,
    health: *mut Health,
) -> Status {
    // SAFETY: guaranteed by the caller.
    let nav = unsafe { object(nav) };
    // SAFETY: guaranteed by the caller.
    let slot = unsafe { output(health) };
    Status::of(nav.and_then(|nav| {
        let slot = slot?;
        let solution = nav.flight.estimator.solution();
        let assessed = nav.flight.monitor.assess(solution.as_ref(), Time::from_nanoseconds(now_ns));
        slot.write(Health::from(&assessed));
        Ok(())
    }))
}
