//! The pilot's switch and the autopilot: engagement, refusal and release.

/// State of the autopilot's engagement by the pilot's switch.
///
/// If the pilot closes the switch while a check fails, the autopilot does not engage. The pilot must then open and
/// close the switch again. The autopilot therefore takes over only at the moment at which the pilot closes the switch.
///
/// ```
/// use hovernav::autopilot::{Engagement, EngagementChange};
///
/// let mut engagement = Engagement::default();
/// assert_eq!(engagement.update(true, false), Some(EngagementChange::Refused));
/// assert_eq!(engagement.update(true, true), None); // ready, but the switch was not closed now
/// assert_eq!(engagement.update(false, true), None);
/// assert_eq!(engagement.update(true, true), Some(EngagementChange::Engaged));
/// assert!(engagement.is_engaged());
/// assert_eq!(engagement.update(false, true), Some(EngagementChange::Released));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Engagement {
    /// The switch is open.
    #[default]
    Off,
    /// The switch was closed while a check failed: it must be opened before the next attempt.
    Refused,
    /// The autopilot flies.
    Engaged,
}

/// Change of engagement in this cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EngagementChange {
    /// The autopilot takes over.
    Engaged,
    /// The switch was closed while a check failed: the autopilot does not take over.
    Refused,
    /// The switch was opened, or its signal is lost.
    Released,
}

impl Engagement {
    /// Updates the state; call it once a cycle. `ready` is whether every check passes. A check that fails after the
    /// engagement does not release the autopilot: the modes of the autopilot respond to it.
    pub fn update(&mut self, switch_on: bool, ready: bool) -> Option<EngagementChange> {
        let (next, change) = match (*self, switch_on) {
            (Self::Off, true) if ready => (Self::Engaged, Some(EngagementChange::Engaged)),
            (Self::Off, true) => (Self::Refused, Some(EngagementChange::Refused)),
            (Self::Engaged, false) => (Self::Off, Some(EngagementChange::Released)),
            (_, false) => (Self::Off, None),
            (now, true) => (now, None),
        };
        *self = next;
        change
    }

    /// Whether the autopilot flies.
    #[must_use]
    pub const fn is_engaged(self) -> bool {
        matches!(self, Self::Engaged)
    }
}
