//! What happens in flight, put into words.

use std::io;

use crate::serial::PortEvent;
use hovernav::autopilot::{Health, ProgrammeChange, Trust};
use hovernav::ekf::Notice;
use hovernav::flight_control::ControlNotice;
use hovernav::sensors::SensorOutput;
use hovernav_log::record::{Level, ShortText, Status};

/// A notice of the estimator; `None` for an ordinary update.
pub fn of_notice(notice: &Notice) -> Option<(Level, ShortText)> {
    let text = match notice {
        Notice::Updated(report) if report.any_reopened() => ShortText::new(format_args!(
            "gps refused until now: the filter had locked itself out, and was reopened, {:.1} off",
            report.innovations().map(|one| one.innovation.abs()).fold(0.0, f64::max)
        )),
        Notice::Updated(_) => return None,
        Notice::Aligned(alignment) => ShortText::new(format_args!(
            "aligned after {:.1} s, heading by {:?}",
            alignment.duration_s, alignment.heading
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
        Notice::FieldRestored { .. } => ShortText::new("magnetic field what it was again"),
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
        Notice::Aligned(_) | Notice::HeadingFound { .. } => Level::Info,
        _ => Level::Warning,
    };
    Some((level, text))
}

/// A part of the estimate that is trusted otherwise than before: its name, and what of it now.
pub fn of_trust(name: &str, trust: Trust, health: &Health) -> (Level, ShortText) {
    let why =
        [health.tilt, health.velocity, health.vertical_velocity, health.position, health.heading]
            .into_iter()
            .find_map(Result::err);
    match (trust, why, health.dead_reckoning_since) {
        (Trust::Valid, ..) => (Level::Info, ShortText::new(format_args!("{name} is good again"))),
        (Trust::Lost, Some(why), _) => {
            (Level::Warning, ShortText::new(format_args!("{name} is not to be flown by: {why}")))
        }
        (_, _, Some(since)) => (
            Level::Warning,
            ShortText::new(format_args!(
                "{name} is by dead reckoning: the last fix was accepted at second {:.2}",
                since.seconds()
            )),
        ),
        _ => (Level::Info, ShortText::new(format_args!("{name} is doubtful, but good enough"))),
    }
}

/// A fault of a sensor that its driver reports; a refused fix has a text of its own for each reason.
pub fn of_sensor_fault(report: &SensorOutput) -> Option<ShortText> {
    match report {
        SensorOutput::DmuLost(_, fault) => {
            Some(ShortText::new(format_args!("inertial unit: {fault}")))
        }
        SensorOutput::DmuImplausible(_, what) => {
            Some(ShortText::new(format_args!("inertial unit: {what}")))
        }
        SensorOutput::DmuClockFault(_, fault) => {
            Some(ShortText::new(format_args!("inertial unit: {fault}")))
        }
        SensorOutput::FixWithoutHeight(_) => {
            Some(ShortText::new("a fix without height above the ellipsoid; set geoid_separation_m"))
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
        ControlNotice::Engaged
        | ControlNotice::Released
        | ControlNotice::PilotBack
        | ControlNotice::FenceLeft
        | ControlNotice::Mode(_)
        | ControlNotice::TestInputs(ProgrammeChange::Begins { .. } | ProgrammeChange::Done) => {
            Level::Info
        }
        ControlNotice::PilotLost | ControlNotice::Descends => Level::Error,
        _ => Level::Warning,
    }
}

/// How much a change of a port matters.
pub fn port_level(event: &PortEvent) -> Level {
    if *event == PortEvent::Opened { Level::Info } else { Level::Warning }
}
