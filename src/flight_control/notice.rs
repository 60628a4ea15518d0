//! Notices of flight control.

use core::fmt;

use super::bounces::{MAX_ENGAGEMENTS, STEADY_S};
use crate::autopilot::{Mode, ProgrammeChange, Readiness, Reason, Transition};
use crate::health::Distrust;

/// Reason why the autopilot gave the sticks back while the switch is closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HandedBack {
    /// The pilot moved a stick beyond the override travel.
    Override,
    /// Attitude is unknown, and there is a pilot.
    NoAttitude,
    /// The loop was late several times in a row.
    Late,
}

/// A notice of a cycle.
// Boxing the large variant would allocate in the loop.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ControlNotice {
    /// The autopilot takes over.
    Engaged,
    /// The switch was closed, but the autopilot does not take over: see [`Readiness::failed`].
    Refused(Readiness),
    /// The switch was opened: the pilot flies.
    Released,
    /// The signal of the aux channel alone is lost, and with it the pilot's switch: the pilot flies.
    SwitchLost,
    /// The switch has been closed since its first pulse, as after a restart in flight: it has no effect until it has
    /// been opened.
    SwitchMustBeReset,
    /// The switch was closed after several engagements in a row: it has no effect until it has been open for some time.
    SwitchBounces,
    /// The pilot flies although the switch is closed, until it has been opened.
    HandedBack(HandedBack),
    /// The autopilot changed its mode.
    Mode(Transition),
    /// The pilot's signal is lost while the autopilot flies: the autopilot holds.
    PilotLost,
    /// The pilot's signal is back.
    PilotSignalRestored,
    /// The pilot's signal did not return: the autopilot descends.
    DescentStarted,
    /// The vehicle reached the geofence: it returns to the centre, at its own height. This height is limited to the
    /// range from the centre's height to 0.72 of the geofence's height above it.
    GeofenceReached,
    /// The vehicle is well inside the geofence again.
    InsideGeofenceAgain,
    /// A stick has been at its end for longer than the configured time; attitude has priority.
    Saturated,
    /// A test input begins, or the programme ends.
    TestInputs(ProgrammeChange),
}

/// States who flies now, why, and what to do.
impl fmt::Display for ControlNotice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Engaged => {
                f.write_str("the autopilot flies; to take over, open the switch or move a stick far")
            }
            Self::Refused(readiness) => {
                let failed = readiness.failed().count();
                write!(
                    f,
                    "the autopilot does not take over: {failed} of its checks fail; the pilot flies on; open \
                     the switch before another attempt"
                )
            }
            Self::Released => f.write_str("the pilot flies: the switch is open"),
            Self::SwitchLost => f.write_str(
                "the pilot flies: the switch's channel is lost; check its wire and the receiver",
            ),
            Self::SwitchMustBeReset => f.write_str(
                "the pilot flies: the switch is already closed; open the switch to engage again",
            ),
            Self::SwitchBounces => write!(
                f,
                "the pilot flies: the switch bounces, {MAX_ENGAGEMENTS} engagements in a row; leave it open for \
                 {STEADY_S} s to engage again"
            ),
            Self::HandedBack(why) => {
                let what = match why {
                    HandedBack::Override => "a stick was moved; open the switch before engaging again",
                    HandedBack::NoAttitude => "the attitude is not known; fly by hand and land",
                    HandedBack::Late => {
                        "the loop was late several times in a row; fly by hand, then find the cause of the load"
                    }
                };
                write!(f, "the pilot flies: {what}")
            }
            Self::Mode(transition) => mode_in_words(transition, f),
            Self::PilotLost => f.write_str(
                "the pilot's signal is lost: the autopilot holds; check transmitter and receiver",
            ),
            Self::PilotSignalRestored => f.write_str("the pilot's signal is back"),
            Self::DescentStarted => f.write_str(
                "no pilot: the autopilot descends; keep clear below; the sticks act again when the signal returns",
            ),
            Self::GeofenceReached => f.write_str(
                "the geofence is reached: the autopilot goes back to its centre; take over to fly on",
            ),
            Self::InsideGeofenceAgain => f.write_str("inside the geofence again"),
            Self::TestInputs(change) => change.fmt(f),
            Self::Saturated => f.write_str(
                "a control is at its end, attitude has priority; take over if this lasts",
            ),
        }
    }
}

fn mode_in_words(transition: &Transition, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let Transition { to, reason, .. } = transition;
    let what = match to {
        Mode::Manual => "the pilot flies",
        Mode::Position => "the autopilot holds position",
        Mode::Velocity => "the autopilot holds velocity but not position: it may drift",
        Mode::Attitude => "the autopilot holds attitude alone: it drifts with the wind",
        Mode::Descent => "the autopilot descends",
        Mode::Neutral => "the sticks go to trim: the vehicle is uncontrolled",
    };
    let again = if *reason == Reason::Recovered { " again" } else { "" };
    write!(f, "{what}{again}, as ")?;
    match reason {
        Reason::Switch => f.write_str("the switch was moved"),
        Reason::Override => f.write_str("a stick was moved"),
        Reason::Recovered => f.write_str("the estimate is good enough for it"),
        Reason::VelocityNotRecovered => f.write_str("velocity did not recover in time"),
        Reason::Distrust(Distrust::Frozen) if matches!(to, Mode::Neutral | Mode::Manual) => {
            f.write_str("the inertial unit repeats the same sample")
        }
        Reason::Distrust(Distrust::Frozen) => f.write_str("the receiver repeats the same fix"),
        Reason::Distrust(why) => write!(f, "{why}"),
    }?;
    match (to, reason) {
        (_, Reason::Switch | Reason::Override | Reason::Recovered) | (Mode::Manual, _) => Ok(()),
        (Mode::Position | Mode::Velocity, _) => f.write_str("; wait for it, or take over"),
        (Mode::Attitude | Mode::Descent, _) => f.write_str("; take over"),
        (Mode::Neutral, _) => f.write_str("; take over at once"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::Time;

    /// Messages contain no identifiers of the program, and fit into a record.
    #[test]
    fn a_change_of_mode_is_reported_in_plain_words_with_what_to_do() {
        let distrusts = [
            Distrust::Missing,
            Distrust::NotFinite,
            Distrust::Stale,
            Distrust::Tilt,
            Distrust::Heading,
            Distrust::Velocity,
            Distrust::VerticalVelocity,
            Distrust::Position,
            Distrust::Frozen,
            Distrust::Disagreement,
        ];
        let others =
            [Reason::Switch, Reason::Override, Reason::Recovered, Reason::VelocityNotRecovered];
        for reason in distrusts.map(Reason::Distrust).into_iter().chain(others) {
            for to in Mode::ALL {
                let time = Time::ZERO;
                let told =
                    ControlNotice::Mode(Transition { time, from: Mode::Position, to, reason })
                        .to_string();
                assert!(told.len() <= 160, "{told}");
                for name in ["Distrust", "Recovered", "VelocityNotRecovered", "Position", "Neutral"]
                {
                    assert!(!told.contains(name), "{told}");
                }
                let grave = matches!(reason, Reason::Distrust(_) | Reason::VelocityNotRecovered);
                let advised = told.contains("take over");
                assert_eq!(advised, grave && to != Mode::Manual, "{told}");
            }
        }
        let lost = Transition {
            time: Time::ZERO,
            from: Mode::Position,
            to: Mode::Velocity,
            reason: Reason::Distrust(Distrust::Position),
        };
        assert_eq!(
            ControlNotice::Mode(lost).to_string(),
            "the autopilot holds velocity but not position: it may drift, as position is too uncertain; \
             wait for it, or take over"
        );
    }
}
