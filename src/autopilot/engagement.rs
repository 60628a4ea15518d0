//! From the pilot's switch to the autopilot: taken over, refused, given back.

/// Whether the autopilot has been asked to fly, and may.
///
/// A switch that is closed while a check fails is refused, and stays so until it is opened: the
/// autopilot never takes over at a moment that the pilot did not choose.
///
/// ```
/// use hovernav::autopilot::{Engagement, EngagementChange};
///
/// let mut engagement = Engagement::default();
/// assert_eq!(engagement.update(true, false), Some(EngagementChange::Refused));
/// assert_eq!(engagement.update(true, true), None); // ready now, but nobody asked now
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
    /// The switch was closed while a check failed.
    Refused,
    /// The autopilot flies.
    Engaged,
}

/// What became of the switch in this cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EngagementChange {
    /// The autopilot takes over.
    Engaged,
    /// It was asked to, and does not.
    Refused,
    /// The switch was opened, or is lost.
    Released,
}

impl Engagement {
    /// Takes in the switch and whether every check passes; once a cycle. Checks that fail later do not
    /// release: what the autopilot does then is the choice of its modes.
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
