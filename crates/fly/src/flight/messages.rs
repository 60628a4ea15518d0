//! What happens in flight, put into words.

use std::io;

use crate::serial::PortEvent;
use hovernav::autopilot::{Distrust, Health, Mode, ProgrammeChange, Reason, Trust};
use hovernav::ekf::{Aid, Channel, Notice, Report, Verdict};
use hovernav::flight_control::{ControlNotice, HandedBack};
use hovernav::ins::HeadingSource;
use hovernav::sensors::SensorOutput;
use hovernav_log::record::{Level, Part, ShortText, Status, dmu_lost_level};

/// Of an autopilot without the model of its vehicle.
pub const UNTRIED_GAINS: &str = "the autopilot's gains have been tried on no model: set [autopilot] model in \
     fly.toml to the vehicle's, and they are before each flight";

/// A notice of the estimator; `None` for an ordinary update.
pub fn of_notice(notice: &Notice) -> Option<(Part, Level, ShortText)> {
    let text = match notice {
        Notice::Updated(report) if report.any_reopened() => ShortText::new(format_args!(
            "the filter had gone away from what its sensors say, and was opened to it: {}",
            reopened_in_words(report)
        )),
        Notice::Updated(_) => return None,
        Notice::Aligned(alignment) => ShortText::new(format_args!(
            "aligned after {:.1} s, heading {}",
            alignment.duration_s,
            of_source(alignment.heading)
        )),
        Notice::HeadingFound { sigma_rad, .. } => ShortText::new(format_args!(
            "heading found, one-sigma {:.1} deg",
            sigma_rad.to_degrees()
        )),
        Notice::HeadingReset { turn_rad, .. } => ShortText::new(format_args!(
            "heading was wrong: turned by {:.0} deg",
            turn_rad.to_degrees()
        )),
        Notice::HeadingDoubted { off_rad, .. } => ShortText::new(format_args!(
            "heading in doubt, {:.0} deg off by the fixes: less sure now",
            off_rad.to_degrees()
        )),
        Notice::FieldDisturbed { share, sigma_rad, .. } => ShortText::new(format_args!(
            "magnetic field {:.0} % off: heading by it may be {:.0} deg off, counts less",
            100.0 * share,
            sigma_rad.to_degrees()
        )),
        Notice::AntennaElsewhere { offset_m, .. } => ShortText::new(format_args!(
            "antenna {:.1} m fwd, {:.1} m right of its lever arm: taken to be there",
            offset_m.x(),
            offset_m.y()
        )),
        Notice::OnWheels { .. } => ShortText::new("on wheels: without fixes held to its road"),
        Notice::OffWheels { .. } => ShortText::new("off its wheels: not held to a road"),
        Notice::FieldUsual { changed: false, .. } => {
            ShortText::new("the magnetic field is back where it was")
        }
        Notice::FieldUsual { .. } => {
            ShortText::new("the magnetic field has stayed changed: it is trusted as it is now")
        }
        Notice::HeadingMissing { .. } => ShortText::new("alignment waits for a heading"),
        Notice::NotUsed { aid, reason, .. } if reason.is_fault() => {
            ShortText::new(format_args!("{aid} not used: {reason}"))
        }
        Notice::GapBridged { length_s, .. } => ShortText::new(format_args!(
            "inertial unit: gap of {length_s:.2} s in the samples, bridged with the velocity kept and \
                 the uncertainty opened"
        )),
        Notice::CovarianceReset { cause, .. } => {
            ShortText::new(format_args!("inertial unit: {cause}, the fixes decide anew"))
        }
        Notice::SampleSuspect { suspicion, .. } => {
            ShortText::new(format_args!("inertial unit: {suspicion}, the uncertainty opened"))
        }
        Notice::SampleRefused { fault, .. } => {
            ShortText::new(format_args!("inertial unit: sample {fault}"))
        }
        _ => return None,
    };
    let level = match notice {
        Notice::Aligned(_) | Notice::HeadingFound { .. } | Notice::FieldUsual { .. } => Level::Info,
        Notice::OnWheels { .. } | Notice::OffWheels { .. } => Level::Info,
        _ => Level::Warning,
    };
    let part = match notice {
        Notice::GapBridged { .. }
        | Notice::CovarianceReset { .. }
        | Notice::SampleSuspect { .. }
        | Notice::SampleRefused { .. } => Part::InertialUnit,
        Notice::NotUsed { aid: Aid::Gps, .. } | Notice::AntennaElsewhere { .. } => Part::Receiver,
        _ => Part::Estimator,
    };
    Some((part, level, text))
}

/// A part of the estimate that is trusted otherwise than before: whose fault it is, its name, and what of it
/// now. `again` is whether it was good before.
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
            // Without attitude nobody but the pilot can fly; that the rest is lost with it goes without saying.
            let (level, what) = match name {
                "attitude" if is_all => (Level::Critical, "; fly by hand"),
                _ => (Level::Warning, ""),
            };
            let text = format_args!("{name} is not to be flown by: {why}{what}");
            (part_of(why, is_all), level, ShortText::new(text))
        }
        (_, _, Some(since)) => (
            Part::Receiver,
            Level::Warning,
            ShortText::new(format_args!(
                "{name} is by dead reckoning: the last fix was accepted at second {:.2}",
                since.seconds()
            )),
        ),
        _ => {
            let text = ShortText::new(format_args!("{name} is doubtful, but good enough"));
            (Part::Estimator, Level::Info, text)
        }
    }
}

/// Whose fault it is that an estimate is not to be flown by; `is_all` is whether nothing of it is.
const fn part_of(why: Distrust, is_all: bool) -> Part {
    match why {
        Distrust::Stale | Distrust::Missing => Part::InertialUnit,
        Distrust::Frozen if is_all => Part::InertialUnit,
        // Without fixes these grow.
        Distrust::Frozen
        | Distrust::Velocity
        | Distrust::VerticalVelocity
        | Distrust::Position
        | Distrust::Disagreement => Part::Receiver,
        _ => Part::Estimator,
    }
}

/// A fault of a sensor that its driver reports, whose it is and how much it matters; a refused fix has a text of
/// its own for each reason.
pub fn of_sensor_fault(report: &SensorOutput) -> Option<(Part, Level, ShortText)> {
    let (part, level) = (Part::InertialUnit, Level::Warning);
    match report {
        SensorOutput::DmuLost(_, fault) => {
            let text = format_args!("inertial unit: {fault}; look at its power and line");
            Some((part, dmu_lost_level(*fault), ShortText::new(text)))
        }
        SensorOutput::DmuImplausible(_, what) => {
            Some((part, level, ShortText::new(format_args!("inertial unit: {what}"))))
        }
        SensorOutput::DmuClockFault(_, fault) => {
            Some((part, level, ShortText::new(format_args!("inertial unit: {fault}"))))
        }
        SensorOutput::FixWithoutHeight(_) => {
            let text = "a fix without height above the ellipsoid; set geoid_separation_m";
            Some((Part::Receiver, level, ShortText::new(text)))
        }
        _ => None,
    }
}

/// Whether the flight is being recorded, after it was not or was.
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

/// How much what flight control tells matters.
pub fn control_level(notice: &ControlNotice) -> Level {
    match notice {
        // Somebody has to fly, or to keep clear.
        ControlNotice::HandedBack(HandedBack::NoAttitude | HandedBack::Late)
        | ControlNotice::Descends => Level::Critical,
        ControlNotice::Mode(transition) => match (transition.to, transition.reason) {
            (Mode::Descent | Mode::Neutral, _) => Level::Critical,
            (_, Reason::Distrust(_)) => Level::Warning,
            _ => Level::Info,
        },
        ControlNotice::Engaged
        | ControlNotice::Released
        // The pilot's own choice.
        | ControlNotice::HandedBack(HandedBack::Override)
        | ControlNotice::PilotBack
        | ControlNotice::FenceLeft
        | ControlNotice::TestInputs(ProgrammeChange::Begins { .. } | ProgrammeChange::Done) => {
            Level::Info
        }
        ControlNotice::PilotLost => Level::Error,
        _ => Level::Warning,
    }
}

/// Whose doing it is.
pub fn control_part(notice: &ControlNotice) -> Part {
    match notice {
        ControlNotice::Released
        | ControlNotice::SwitchLost
        | ControlNotice::HandedBack(HandedBack::Override)
        | ControlNotice::PilotLost
        | ControlNotice::PilotBack
        | ControlNotice::Descends => Part::Pilot,
        ControlNotice::HandedBack(HandedBack::NoAttitude) => Part::InertialUnit,
        ControlNotice::HandedBack(HandedBack::Late) => Part::Computer,
        ControlNotice::Mode(transition) => match transition.reason {
            Reason::Switch | Reason::Override => Part::Pilot,
            Reason::Distrust(why) => {
                part_of(why, matches!(transition.to, Mode::Neutral | Mode::Manual))
            }
            Reason::Patience => Part::Receiver,
            _ => Part::Estimator,
        },
        _ => Part::Autopilot,
    }
}

/// How much a change of a port matters.
pub fn port_level(event: &PortEvent) -> Level {
    if *event == PortEvent::Opened { Level::Info } else { Level::Warning }
}

/// What the filter was opened to, in words.
fn reopened_in_words(report: &Report) -> &'static str {
    let mut reopened = report.innovations().filter(|axis| axis.verdict == Verdict::Reopened);
    match reopened.next().map(|axis| axis.channel) {
        Some(Channel::PositionNorth | Channel::PositionEast) => "position of the receiver",
        Some(Channel::PositionDown) => "height of the receiver",
        Some(Channel::VelocityNorth | Channel::VelocityEast | Channel::VelocityDown) => {
            "velocity of the receiver"
        }
        Some(Channel::Roll | Channel::Pitch) => "roll and pitch of the inertial unit",
        Some(Channel::Yaw | Channel::BaselineHeading) => "heading",
        Some(Channel::BaroHeight) => "height of the barometer",
        Some(Channel::Range) => "distance to the ground",
        _ => "rest on the ground",
    }
}

/// Where a heading comes from, in words.
const fn of_source(source: HeadingSource) -> &'static str {
    match source {
        HeadingSource::SecondAntenna => "by two antennas",
        HeadingSource::Attitude => "by the unit's own attitude",
        HeadingSource::Magnetometer => "by the magnetometer",
        HeadingSource::Course => "by the course over ground",
        HeadingSource::Unknown => "not known yet",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hovernav::autopilot::Transition;
    use hovernav::dmu::LinkFault;
    use hovernav::time::Time;

    fn mode(to: Mode, reason: Reason) -> ControlNotice {
        ControlNotice::Mode(Transition { time: Time::ZERO, from: Mode::Position, to, reason })
    }

    #[test]
    fn what_somebody_has_to_act_on_at_once_is_critical_and_names_whose_fault_it_is() {
        let frozen = Reason::Distrust(Distrust::Frozen);
        let stale = Reason::Distrust(Distrust::Stale);
        for (notice, part) in [
            (ControlNotice::HandedBack(HandedBack::NoAttitude), Part::InertialUnit),
            (ControlNotice::HandedBack(HandedBack::Late), Part::Computer),
            (ControlNotice::Descends, Part::Pilot),
            (mode(Mode::Neutral, stale), Part::InertialUnit),
            (mode(Mode::Neutral, frozen), Part::InertialUnit),
            (mode(Mode::Descent, Reason::Patience), Part::Receiver),
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
        let (part, level, text) = of_sensor_fault(&lost).unwrap();
        assert_eq!((part, level), (Part::InertialUnit, Level::Critical), "{text}");
    }

    #[test]
    fn what_was_never_bad_is_not_good_again() {
        let health = Health::none(Distrust::Missing);
        let words = |again| of_trust("attitude", Trust::Valid, &health, again).2;
        assert_eq!(words(false).as_str(), "attitude is good");
        assert_eq!(words(true).as_str(), "attitude is good again");
    }
}
