//! What flight control tells.

use core::fmt;

use crate::autopilot::{ProgrammeChange, Readiness, Transition};

/// Why the autopilot gave the sticks back though the switch is closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HandedBack {
    /// The pilot moved a stick far.
    Override,
    /// Not even attitude is known, and there is a pilot.
    NoAttitude,
    /// The loop was late several times in a row.
    Late,
}

/// Something worth telling that came of a cycle.
// A box would be an allocation in the loop.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ControlNotice {
    /// The autopilot takes over.
    Engaged,
    /// It was asked to, and does not: see [`Readiness::failed`].
    Refused(Readiness),
    /// The switch was opened, or the aux channel alone is lost: the pilot flies.
    Released,
    /// The pilot flies, whatever the switch says, until it has been opened.
    HandedBack(HandedBack),
    /// The autopilot changed its mode.
    Mode(Transition),
    /// The pilot's signal is lost while the autopilot flies: it holds.
    PilotLost,
    /// The pilot's signal is back.
    PilotBack,
    /// The pilot did not come back: it descends.
    Descends,
    /// The fence is reached: it goes back to the middle, at the height it has or the fence's.
    FenceReached,
    /// It is well inside the fence again.
    FenceLeft,
    /// A stick has been at its end for too long; attitude comes first there.
    Saturated,
    /// A test input begins, or there are no more.
    TestInputs(ProgrammeChange),
}

impl fmt::Display for ControlNotice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Engaged => f.write_str("the autopilot flies"),
            Self::Refused(readiness) => {
                let failed = readiness.failed().count();
                write!(f, "the autopilot does not take over: {failed} of its checks fail")
            }
            Self::Released => f.write_str("the pilot flies: the switch is open"),
            Self::HandedBack(HandedBack::Override) => {
                f.write_str("the pilot flies: a stick was moved")
            }
            Self::HandedBack(HandedBack::NoAttitude) => {
                f.write_str("the pilot flies: the attitude is not known")
            }
            Self::HandedBack(HandedBack::Late) => {
                f.write_str("the pilot flies: the loop is late again and again")
            }
            Self::Mode(Transition { from, to, reason, .. }) => {
                write!(f, "autopilot: {from:?} to {to:?}: {reason:?}")
            }
            Self::PilotLost => f.write_str("the pilot's signal is lost: the autopilot holds"),
            Self::PilotBack => f.write_str("the pilot's signal is back"),
            Self::Descends => f.write_str("no pilot: the autopilot descends"),
            Self::FenceReached => f.write_str("the fence is reached: the autopilot goes back"),
            Self::FenceLeft => f.write_str("inside the fence again"),
            Self::TestInputs(change) => change.fmt(f),
            Self::Saturated => f.write_str("a control is at its end"),
        }
    }
}
