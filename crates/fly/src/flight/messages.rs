//! Texts, severities and causes of flight events.

use std::io;

use crate::serial::PortEvent;
use hovernav::autopilot::{Mode, ProgrammeChange, Reason};
use hovernav::flight_control::{ControlNotice, HandedBack};
use hovernav::health::{Distrust, Health, Trust};
use hovernav_record::{Level, Part, ShortText, Status};

/// Warning for an autopilot without a model of its vehicle.
pub const UNTRIED_GAINS: &str = "the autopilot's gains are not checked: set [autopilot] model in \
                                 fly.toml to the vehicle's model, which checks them before each \
                                 flight";

/// Cause, severity and text for a changed validity of the quantity `name` (attitude, velocity or position). `again` is
/// whether that quantity was valid earlier in the flight.
pub fn of_trust(
    name: &str,
    trust: Trust,
    health: &Health,
    again: bool,
) -> (Part, Level, ShortText) {
    let why =
        [health.tilt, health.velocity, health.vertical_velocity, health.position, health.heading]
            .into_iter()
            .find_map(Result::err);
    let again = if again { " again" } else { "" };
    match (trust, why, health.dead_reckoning_since) {
        (Trust::Valid, ..) => {
            let text = ShortText::new(format_args!("{name} is good{again}"));
            (Part::Estimator, Level::Info, text)
        }
        (Trust::Lost, Some(why), _) => {
            let is_all = health.tilt.is_err();
            // Without attitude only the pilot can fly. The loss of velocity and position follows from the loss of
            // attitude and is only a warning.
            let (level, what) = match name {
                "attitude" if is_all => (Level::Critical, "; fly by hand"),
                _ => (Level::Warning, ""),
            };
            let text = format_args!("{name} is not usable: {why}{what}");
            (part_of(why, is_all), level, ShortText::new(text))
        }
        (_, _, Some(since)) => (
            Part::Receiver,
            Level::Warning,
            ShortText::new(format_args!(
                "{name} is from dead reckoning: the last fix was accepted at {:.2} s",
                since.seconds()
            )),
        ),
        _ => {
            let text = ShortText::new(format_args!("{name} is degraded but usable"));
            (Part::Estimator, Level::Info, text)
        }
    }
}

/// Sensor or function at fault for an unusable quantity; `is_all` is whether the whole estimate is unusable.
const fn part_of(why: Distrust, is_all: bool) -> Part {
    match why {
        Distrust::Stale | Distrust::Missing => Part::InertialUnit,
        Distrust::Frozen if is_all => Part::InertialUnit,
        // One-sigma and disagreement grow while no fixes are accepted.
        Distrust::Frozen
        | Distrust::Velocity
        | Distrust::VerticalVelocity
        | Distrust::Position
        | Distrust::Disagreement => Part::Receiver,
        _ => Part::Estimator,
    }
}

/// Severity and text for a change of the recording.
pub fn of_record(good: bool, status: &Status) -> (Level, ShortText) {
    match (good, status.os_error) {
        (true, _) => (Level::Info, ShortText::new("the record is written again")),
        (false, Some(number)) => {
            let error = io::Error::from_raw_os_error(number);
            (Level::Error, ShortText::new(format_args!("the record is not written: {error}")))
        }
        (false, None) => (Level::Error, ShortText::new("the record loses entries")),
    }
}

/// Severity of a notice of flight control.
pub fn control_level(notice: &ControlNotice) -> Level {
    match notice {
        // The pilot must fly, or people must keep clear.
        ControlNotice::HandedBack(HandedBack::NoAttitude | HandedBack::Late)
        | ControlNotice::DescentStarted => Level::Critical,
        ControlNotice::Mode(transition) => match (transition.to, transition.reason) {
            (Mode::Descent | Mode::Neutral, _) => Level::Critical,
            (_, Reason::Distrust(_)) => Level::Warning,
            _ => Level::Info,
        },
        ControlNotice::Engaged
        | ControlNotice::Released
        // The pilot's own choice.
        | ControlNotice::HandedBack(HandedBack::Override)
        | ControlNotice::PilotSignalRestored
        | ControlNotice::InsideGeofenceAgain
        | ControlNotice::TestInputs(ProgrammeChange::Begins { .. } | ProgrammeChange::Done) => {
            Level::Info
        }
        ControlNotice::PilotLost => Level::Error,
        _ => Level::Warning,
    }
}

/// Cause of a notice of flight control.
pub fn control_part(notice: &ControlNotice) -> Part {
    match notice {
        ControlNotice::Released
        | ControlNotice::SwitchLost
        | ControlNotice::HandedBack(HandedBack::Override)
        | ControlNotice::PilotLost
        | ControlNotice::PilotSignalRestored
        | ControlNotice::DescentStarted => Part::Pilot,
        ControlNotice::HandedBack(HandedBack::NoAttitude) => Part::InertialUnit,
        ControlNotice::HandedBack(HandedBack::Late) => Part::Computer,
        ControlNotice::Mode(transition) => match transition.reason {
            Reason::Switch | Reason::Override => Part::Pilot,
            Reason::Distrust(why) => {
                part_of(why, matches!(transition.to, Mode::Neutral | Mode::Manual))
            }
            Reason::VelocityNotRecovered => Part::Receiver,
            _ => Part::Estimator,
        },
        _ => Part::Autopilot,
    }
}

/// Severity of a change of a port.
pub fn port_level(event: &PortEvent) -> Level {
    if *event == PortEvent::Opened { Level::Info } else { Level::Warning }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hovernav::autopilot::Transition;
    use hovernav::dmu::LinkFault;
    use hovernav::sensors::SensorOutput;
    use hovernav::time::Time;
    use hovernav_record::Happening;

    fn mode(to: Mode, reason: Reason) -> ControlNotice {
        ControlNotice::Mode(Transition { time: Time::ZERO, from: Mode::Position, to, reason })
    }

    #[test]
    fn notices_that_need_immediate_action_are_critical_and_name_the_cause() {
        let frozen = Reason::Distrust(Distrust::Frozen);
        let stale = Reason::Distrust(Distrust::Stale);
        for (notice, part) in [
            (ControlNotice::HandedBack(HandedBack::NoAttitude), Part::InertialUnit),
            (ControlNotice::HandedBack(HandedBack::Late), Part::Computer),
            (ControlNotice::DescentStarted, Part::Pilot),
            (mode(Mode::Neutral, stale), Part::InertialUnit),
            (mode(Mode::Neutral, frozen), Part::InertialUnit),
            (mode(Mode::Descent, Reason::VelocityNotRecovered), Part::Receiver),
        ] {
            assert_eq!(control_level(&notice), Level::Critical, "{notice}");
            assert_eq!(control_part(&notice), part, "{notice}");
        }
        for (notice, level, part) in [
            (mode(Mode::Attitude, frozen), Level::Warning, Part::Receiver),
            (mode(Mode::Position, Reason::Recovered), Level::Info, Part::Estimator),
            (ControlNotice::HandedBack(HandedBack::Override), Level::Info, Part::Pilot),
            (ControlNotice::PilotLost, Level::Error, Part::Pilot),
        ] {
            assert_eq!((control_level(&notice), control_part(&notice)), (level, part), "{notice}");
        }
        let lost = SensorOutput::DmuLost(Time::ZERO, LinkFault::NoData);
        let lost = Happening::of_sensor(&lost).unwrap();
        assert_eq!((lost.part(), lost.level), (Part::InertialUnit, Level::Critical), "{lost:?}");
    }

    #[test]
    fn a_first_valid_estimate_is_not_good_again() {
        let health = Health::none(Distrust::Missing);
        let words = |again| of_trust("attitude", Trust::Valid, &health, again).2;
        assert_eq!(words(false).as_str(), "attitude is good");
        assert_eq!(words(true).as_str(), "attitude is good again");
    }
}
