//! Texts for the reports of the estimator and of the sensors' drivers. Record, terminal and ground station use the same
//! text and level.

use std::fmt;

use crate::entry::{Level, Part, ShortText};
use hovernav::dmu::LinkFault;
use hovernav::ekf::{Aid, Channel, Innovation, Notice, ResetCause, Verdict};
use hovernav::gps::quality::Failures;
use hovernav::ins::HeadingSource;
use hovernav::sensors::SensorOutput;
use hovernav::time::Time;
use hovernav_findings::FindingKind;

/// An event with its text, for record, terminal and ground station.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Happening {
    /// Time of the event, if the report contains one.
    pub time: Option<Time>,
    /// Severity.
    pub level: Level,
    /// Kind, for programs.
    pub kind: &'static str,
    /// Kind of the finding that `hovernav estimate` would report for this event; `None` for information about the
    /// flight.
    pub finding: Option<FindingKind>,
    /// Text for people.
    pub text: ShortText,
}

impl Happening {
    /// Event of a notice of the estimator; `None` for an ordinary update.
    #[must_use]
    pub fn of_notice(notice: &Notice) -> Option<Self> {
        let warning = Level::Warning;
        let (time, level, kind, text) = match notice {
            Notice::Updated(report) if report.any_reset() => {
                let text = format_args!(
                    "the filter had diverged from its sensors and was reset to them: {}",
                    Beyond::of(report.innovations(), Verdict::Reset)
                );
                (report.time(), warning, "filter_reopened", ShortText::new(text))
            }
            Notice::Updated(report) if report.contradicts_itself() => {
                let text = format_args!("contradicts itself: rejected until consistent again");
                (report.time(), warning, "contradicts_itself", ShortText::new(text))
            }
            Notice::Updated(report) if report.any_rejected() => {
                let beyond = Beyond::of(report.innovations(), Verdict::Rejected);
                let text = ShortText::new(format_args!("rejected by the filter: {beyond}"));
                (report.time(), warning, "innovation_rejected", text)
            }
            Notice::Updated(report) if report.position_drift_m().is_some() => {
                let position_drift_m = report.position_drift_m().unwrap_or_default();
                let text = format_args!(
                    "position drifted from the receiver's own velocity by {position_drift_m:.0} m: one-sigma enlarged"
                );
                (report.time(), warning, "place_walks", ShortText::new(text))
            }
            Notice::Aligned(alignment) => {
                let rest = if alignment.at_rest { "at rest" } else { "in motion" };
                let text = format_args!(
                    "aligned {rest} in {:.1} s, heading {}",
                    alignment.duration_s,
                    of_source(alignment.heading)
                );
                (None, Level::Info, "aligned", ShortText::new(text))
            }
            Notice::SetupSuspect { time, fault } => {
                let kind = if fault.is_of_receiver() { "gps_setup" } else { "imu_setup" };
                (Some(*time), Level::Error, kind, ShortText::new(format_args!("set-up: {fault}")))
            }
            Notice::HeadingFound { time, sigma_rad, .. } => {
                let sigma_deg = sigma_rad.to_degrees();
                let text = format_args!("heading found, one-sigma {sigma_deg:.1}°");
                (Some(*time), Level::Info, "heading_found", ShortText::new(text))
            }
            Notice::HeadingReset { time, turn_rad, sigma_rad } => {
                let (turn_deg, sigma_deg) = (turn_rad.to_degrees(), sigma_rad.to_degrees());
                let text = format_args!(
                    "heading was inconsistent with GPS: turned by {turn_deg:.0}°, one-sigma now {sigma_deg:.0}°"
                );
                (Some(*time), warning, "heading_reset", ShortText::new(text))
            }
            Notice::HeadingSuspect { time, off_rad, sigma_rad } => {
                let (off_deg, sigma_deg) = (off_rad.to_degrees(), sigma_rad.to_degrees());
                let text = format_args!(
                    "heading suspect, {off_deg:.0}° off according to GPS: one-sigma now {sigma_deg:.0}°"
                );
                (Some(*time), warning, "heading_doubted", ShortText::new(text))
            }
            Notice::MagneticFieldDisturbed { time, share, sigma_rad, lasts } => {
                let (percent, sigma_deg) = (100.0 * share, sigma_rad.to_degrees());
                let text = if *lasts {
                    ShortText::new(
                        "magnetic field has stayed changed: the old or the new field may be right, heading one-sigma enlarged",
                    )
                } else {
                    ShortText::new(format_args!(
                        "magnetic field {percent:.0} % off: its heading may be {sigma_deg:.0}° off and is weighted less"
                    ))
                };
                (Some(*time), warning, "field_disturbed", text)
            }
            Notice::AntennaOffsetFound { time, offset_m, sigma_m } => {
                let text = format_args!(
                    "antenna {:.1} m forward, {:.1} m right of its lever arm (one-sigma {sigma_m:.1} m): the filter \
                     uses that position",
                    offset_m.x(),
                    offset_m.y()
                );
                (Some(*time), warning, "antenna_elsewhere", ShortText::new(text))
            }
            Notice::WheelConstraintOn { time, sigma_mps } => {
                let text = format_args!(
                    "the vehicle rolls on wheels: without fixes it is constrained to its road (one-sigma \
                     {sigma_mps:.2} m/s)"
                );
                (Some(*time), Level::Info, "on_wheels", ShortText::new(text))
            }
            Notice::WheelConstraintOff { time } => {
                let text =
                    ShortText::new("the vehicle does not roll on wheels: no constraint to a road");
                (Some(*time), Level::Info, "off_wheels", text)
            }
            Notice::MagneticFieldUsual { time, changed } => {
                let text = if *changed {
                    "the magnetic field has stayed changed: the new field is used"
                } else {
                    "the magnetic field is back to its earlier value"
                };
                (Some(*time), Level::Info, "field_usual", ShortText::new(text))
            }
            Notice::HeadingMissing { time } => {
                let text = ShortText::new("alignment waits for a heading");
                (Some(*time), warning, "heading_missing", text)
            }
            Notice::NotUsed { time, aid, reason } if reason.is_fault() => {
                let kind = if *aid == Aid::Gps { "fix_unusable" } else { "aid_unusable" };
                let text = ShortText::new(format_args!("{aid} not used: {reason}"));
                (Some(*time), warning, kind, text)
            }
            Notice::GapBridged { time, length_s } => {
                let text = format_args!(
                    "inertial unit: gap of {length_s:.2} s in the samples, bridged at the last velocity with a larger \
                     uncertainty"
                );
                (Some(*time), warning, "imu_fault", ShortText::new(text))
            }
            Notice::CovarianceReset { time, cause: cause @ ResetCause::Misaligned { .. } } => {
                let text = ShortText::new(format_args!("attitude {cause}"));
                (Some(*time), warning, "aligned_anew", text)
            }
            Notice::CovarianceReset { time, cause } => {
                let text = format_args!("inertial unit: {cause}; the next fixes set the state");
                (Some(*time), warning, "imu_fault", ShortText::new(text))
            }
            Notice::SampleSuspect { time, suspicion } => {
                let text = format_args!("inertial unit: {suspicion}, uncertainty enlarged");
                (Some(*time), warning, "imu_suspect", ShortText::new(text))
            }
            Notice::SampleRejected { time, fault } => {
                let text = ShortText::new(format_args!("inertial unit: sample rejected: {fault}"));
                (Some(*time), warning, "imu_fault", text)
            }
            _ => return None,
        };
        Some(Self { time, level, kind, finding: FindingKind::of_notice(notice), text })
    }

    /// Event of a sensor's driver; `None` for an ordinary packet or fix.
    #[must_use]
    pub fn of_sensor(output: &SensorOutput) -> Option<Self> {
        let warning = Level::Warning;
        let (time, level, kind, text) = match output {
            SensorOutput::DmuLost(time, fault) => {
                let text = format_args!("inertial unit: {fault}; check its power and line");
                (*time, dmu_lost_level(*fault), "dmu_lost", ShortText::new(text))
            }
            SensorOutput::DmuImplausible(time, what) => {
                let text = ShortText::new(format_args!("inertial unit: {what}"));
                (*time, warning, "dmu_implausible", text)
            }
            SensorOutput::DmuClockFault(time, fault) => (
                *time,
                warning,
                "dmu_clock",
                ShortText::new(format_args!("inertial unit: {fault}")),
            ),
            SensorOutput::Fix(fix, failures) if !failures.is_empty() => {
                let text = ShortText::new(format_args!("fix rejected: {}", Reasons(failures)));
                (fix.arrival, warning, "fix_refused", text)
            }
            SensorOutput::FixWithoutHeight(time) => {
                let text =
                    "fix without height above the ellipsoid: set [receiver] geoid_separation_m";
                (*time, warning, "fix_without_height", ShortText::new(text))
            }
            _ => return None,
        };
        let finding = FindingKind::of_sensor(output);
        Some(Self { time: Some(time), level, kind, finding, text })
    }

    /// Sensor or part of the vehicle.
    #[must_use]
    pub fn part(&self) -> Part {
        Part::of_kind(self.kind)
    }
}

/// Severity of a loss of the inertial unit: critical only after it has worked, because the
/// flight then depends on it.
const fn dmu_lost_level(fault: LinkFault) -> Level {
    match fault {
        LinkFault::Startup(_) => Level::Error,
        LinkFault::NoData | LinkFault::Garbled => Level::Critical,
    }
}

/// Source of a heading, in words.
const fn of_source(source: HeadingSource) -> &'static str {
    match source {
        HeadingSource::SecondAntenna => "by two antennas",
        HeadingSource::Attitude => "by the unit's own attitude",
        HeadingSource::Magnetometer => "by the magnetometer",
        HeadingSource::Course => "by the course over ground",
        HeadingSource::Unknown => "not known yet",
    }
}

/// Innovations of an update with one verdict: displays the worst one and the number of others.
struct Beyond<'a> {
    worst: Option<&'a Innovation>,
    count: usize,
}

impl<'a> Beyond<'a> {
    fn of(innovations: impl Iterator<Item = &'a Innovation>, verdict: Verdict) -> Self {
        let size = |one: Option<&Innovation>| one.map_or(-1.0, |one| one.normalised().abs());
        innovations.filter(|one| one.verdict == verdict).fold(
            Self { worst: None, count: 0 },
            |so_far, one| Self {
                worst: if size(Some(one)) > size(so_far.worst) { Some(one) } else { so_far.worst },
                count: so_far.count + 1,
            },
        )
    }
}

impl fmt::Display for Beyond<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(worst) = self.worst else { return f.write_str("nothing") };
        let (name, unit) = named(worst.channel);
        let is_angle = unit.starts_with('°');
        let (scale, space) = if is_angle { (1.0_f64.to_degrees(), "") } else { (1.0, " ") };
        let (off, sigma) = (scale * worst.innovation, scale * worst.sigma);
        write!(f, "{name} {off:+.2}{space}{unit} off, one-sigma {sigma:.2}{space}{unit}")?;
        match self.count {
            ..=1 => Ok(()),
            count => write!(f, ", and {} more", count - 1),
        }
    }
}

/// Reasons for the rejection of a fix, separated by semicolons.
struct Reasons<'a>(&'a Failures);

impl fmt::Display for Reasons<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0
            .iter()
            .enumerate()
            .try_for_each(|(place, why)| write!(f, "{}{why}", if place == 0 { "" } else { "; " }))
    }
}

/// Name of a channel in words, and the unit in which its values are shown.
const fn named(channel: Channel) -> (&'static str, &'static str) {
    match channel {
        Channel::PositionNorth => ("the receiver's position north", "m"),
        Channel::PositionEast => ("the receiver's position east", "m"),
        Channel::PositionDown => ("the receiver's height (down)", "m"),
        Channel::VelocityNorth => ("the receiver's velocity north", "m/s"),
        Channel::VelocityEast => ("the receiver's velocity east", "m/s"),
        Channel::VelocityDown => ("the receiver's velocity down", "m/s"),
        Channel::Roll => ("the inertial unit's roll", "°"),
        Channel::Pitch => ("the inertial unit's pitch", "°"),
        Channel::Yaw => ("the heading of the inertial unit or its magnetometer", "°"),
        Channel::BaroHeight => ("the barometer's height", "m"),
        Channel::Range => ("the rangefinder's distance", "m"),
        Channel::BaselineHeading => ("the heading of two antennas", "°"),
        Channel::RestRateX | Channel::RestRateY | Channel::RestRateZ => {
            ("a turn of a vehicle at rest", "°/s")
        }
        Channel::Own(_) => ("a measurement of your own sensor", ""),
        Channel::WheelsRight | Channel::WheelsDown => ("a motion across the road", "m/s"),
        Channel::RestVelocityNorth | Channel::RestVelocityEast | Channel::RestVelocityDown => {
            ("a motion of a vehicle at rest", "m/s")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn innovation(channel: Channel, innovation: f64, sigma: f64, verdict: Verdict) -> Innovation {
        Innovation { time: Time::ZERO, channel, innovation, sigma, verdict }
    }

    #[test]
    fn what_a_gate_refused_is_reported_by_its_worst_in_the_units_people_read() {
        let all = [
            innovation(Channel::Yaw, -0.042, 0.007, Verdict::Rejected),
            innovation(Channel::VelocityNorth, 9.0, 0.1, Verdict::Accepted),
            innovation(Channel::VelocityDown, 1.5, 0.3, Verdict::Rejected),
        ];
        let words = Beyond::of(all.iter(), Verdict::Rejected).to_string();
        let expected = "the heading of the inertial unit or its magnetometer -2.41° off, one-sigma 0.40°, and 1 more";
        assert_eq!(words, expected);
        let words = Beyond::of(all[2..].iter(), Verdict::Rejected).to_string();
        assert_eq!(words, "the receiver's velocity down +1.50 m/s off, one-sigma 0.30 m/s");
    }

    #[test]
    fn a_fault_in_flight_has_the_kind_that_estimate_gives_it() {
        use hovernav::dmu::{PlausibilityFault, Sensor};
        use hovernav::ekf::ImuFault;
        let time = Time::ZERO;
        let refused = |fault| Notice::SampleRejected { time, fault };
        for (notice, kind) in [
            (Notice::GapBridged { time, length_s: 0.3 }, FindingKind::Gap),
            (refused(ImuFault::Stuck), FindingKind::Stuck),
            (refused(ImuFault::NotFinite), FindingKind::NotANumber),
            (Notice::HeadingMissing { time }, FindingKind::HeadingUnknown),
        ] {
            let happening = Happening::of_notice(&notice).unwrap();
            assert_eq!((happening.level, happening.finding), (Level::Warning, Some(kind)));
        }
        let sensor = Sensor::Gyros;
        for (fault, kind) in [
            (
                PlausibilityFault::Jump { sensor, axis: 0, counts: i16::MAX },
                FindingKind::NotANumber,
            ),
            (PlausibilityFault::Saturated { sensor, axis: 0 }, FindingKind::Clipping),
            (PlausibilityFault::Stuck { sensor, packets: 16 }, FindingKind::Stuck),
        ] {
            let happening = Happening::of_sensor(&SensorOutput::DmuImplausible(time, fault));
            assert_eq!(happening.unwrap().finding, Some(kind));
        }
    }
}
