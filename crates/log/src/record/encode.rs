//! From entries to messages.

use std::io::Write;

use mcap::McapResult;

use super::channel::Channel;
use super::entry::{Entry, Level, Line, Part, Queued};
use super::message::{
    ControlsMessage, CycleMessage, FixMessage, ImuMessage, InnovationsMessage, LocationMessage,
    LogMessage, LostMessage, RawMessage, RestartMessage, ServoMessage, SolutionMessage, Timestamp,
};
use super::writer::MessageWriter;
use hovernav::dmu::{LinkFault, Measurement};
use hovernav::earth::Geodetic;
use hovernav::ekf::{Aid, Notice};
use hovernav::frames::Vector;
use hovernav::gps::ReceiverFix;
use hovernav::gps::quality::Failures;
use hovernav::ins::HeadingSource;
use hovernav::sensors::SensorOutput;
use hovernav::time::Time;

impl<W: Write> MessageWriter<W> {
    /// Writes an entry's messages.
    pub(super) fn entry(&mut self, queued: &Queued) -> McapResult<()> {
        let now = queued.now;
        (self.sequence, self.now) = (queued.sequence, now);
        self.configure_again()?;
        match &queued.entry {
            Entry::Raw(raw) => {
                let channel = match raw.line {
                    Line::Dmu => Channel::DmuRaw,
                    Line::Gps => Channel::GpsRaw,
                    Line::Servo => Channel::ServoRaw,
                };
                self.message(channel, now, &RawMessage::new(now, raw.goes_on, raw.as_bytes()))
            }
            Entry::GpsRestarted => {
                let time_ns = now.nanoseconds();
                self.message(Channel::GpsRestart, now, &RestartMessage { time_ns })
            }
            Entry::Sensor(output) => self.sensor(output),
            Entry::Notice(notice) => self.notice(now, notice),
            Entry::Solution(solution) => {
                let time = solution.time;
                self.message(Channel::Solution, time, &SolutionMessage::from(solution))?;
                let sigma_m = Some(solution.position_sigma_m.to_array());
                self.location(Channel::SolutionLocation, time, &solution.position, sigma_m)
            }
            Entry::Servo { captured_ms, commanded_ms } => {
                let (captured_ms, commanded_ms) = (*captured_ms, *commanded_ms);
                self.message(Channel::Servo, now, &ServoMessage { captured_ms, commanded_ms })
            }
            Entry::Controls([lateral, longitudinal, collective, pedal]) => {
                let (lateral, longitudinal) = (*lateral, *longitudinal);
                let (collective, pedal) = (*collective, *pedal);
                let message = ControlsMessage { lateral, longitudinal, collective, pedal };
                self.message(Channel::Controls, now, &message)
            }
            Entry::Cycle(cycle) => {
                self.message(Channel::Autopilot, now, &CycleMessage::new(now, cycle))
            }
            Entry::Event { level, kind, part, text } => {
                self.event_of(*part, now, *level, kind, text.as_str())
            }
            Entry::Lost { raw, decoded } => {
                let (raw, decoded) = (*raw, *decoded);
                self.message(Channel::Lost, now, &LostMessage { raw, decoded })?;
                let level = if raw > 0 { Level::Error } else { Level::Warning };
                let text = format!("no room for {raw} raw and {decoded} decoded entries");
                self.event(now, level, "entries_lost", &text)
            }
        }
    }

    fn sensor(&mut self, output: &SensorOutput) -> McapResult<()> {
        match output {
            SensorOutput::Measured(Some(time), measurement) => {
                self.message(Channel::Imu, *time, &ImuMessage::new(*time, measurement))
            }
            SensorOutput::Fix(fix, failures) => self.fix(fix, failures),
            SensorOutput::FixWithoutHeight(time) => {
                let text = "a fix without height above the ellipsoid, and no geoid separation set";
                self.event(*time, Level::Warning, "fix_without_height", text)
            }
            SensorOutput::DmuLost(time, fault) => {
                self.event(*time, dmu_lost_level(*fault), "dmu_lost", &fault.to_string())
            }
            SensorOutput::DmuImplausible(time, reason) => {
                self.event(*time, Level::Warning, "dmu_implausible", &reason.to_string())
            }
            SensorOutput::DmuClockFault(time, fault) => {
                self.event(*time, Level::Warning, "dmu_clock", &fault.to_string())
            }
            SensorOutput::Measured(None, _)
            | SensorOutput::WriteDmu(_)
            | SensorOutput::WriteGps(_)
            | SensorOutput::Event(_) => Ok(()),
        }
    }

    fn fix(&mut self, fix: &ReceiverFix, failures: &Failures) -> McapResult<()> {
        let message = FixMessage::new(fix, failures);
        self.message(Channel::GpsFix, fix.arrival, &message)?;
        if let Some(height_m) = fix.height_m {
            let (latitude_rad, longitude_rad) = (fix.latitude_rad, fix.longitude_rad);
            let position = Geodetic { latitude_rad, longitude_rad, height_m };
            let sigma_m = fix.position_sigma_m.map(Vector::to_array);
            self.location(Channel::GpsLocation, fix.arrival, &position, sigma_m)?;
        }
        if message.used {
            return Ok(());
        }
        self.event(fix.arrival, Level::Warning, "fix_refused", &message.refused_for)
    }

    fn notice(&mut self, now: Time, notice: &Notice) -> McapResult<()> {
        match notice {
            Notice::Aligned(alignment) => {
                let heading = match alignment.heading {
                    HeadingSource::Attitude => "heading from the unit's attitude",
                    HeadingSource::SecondAntenna => "heading from two antennas",
                    HeadingSource::Magnetometer => "heading from the magnetometer",
                    HeadingSource::Course => "heading from the course",
                    HeadingSource::Unknown => "heading not known yet",
                };
                let rest = if alignment.at_rest { "at rest" } else { "in motion" };
                let text = format!("aligned {rest} in {:.2} s, {heading}", alignment.duration_s);
                self.event(now, Level::Info, "aligned", &text)
            }
            Notice::HeadingFound { time, sigma_rad, .. } => {
                let text = format!("heading found, sure to {:.1}°", sigma_rad.to_degrees());
                self.event(*time, Level::Info, "heading_found", &text)
            }
            Notice::HeadingReset { time, turn_rad, sigma_rad } => {
                let text = format!(
                    "heading was wrong: turned by {:.0}°, sure to {:.0}°",
                    turn_rad.to_degrees(),
                    sigma_rad.to_degrees()
                );
                self.event(*time, Level::Warning, "heading_reset", &text)
            }
            Notice::HeadingDoubted { time, off_rad, sigma_rad } => {
                let text = format!(
                    "heading in doubt: {:.0}° off by what the fixes say, sure to {:.0}°; less sure now",
                    off_rad.to_degrees(),
                    sigma_rad.to_degrees()
                );
                self.event(*time, Level::Warning, "heading_doubted", &text)
            }
            Notice::FieldDisturbed { time, share, sigma_rad } => {
                let text = format!(
                    "magnetic field {:.0} % off what is usual: the heading that goes by it may be {:.0}° off, and \
                     counts for as much less until the field is back",
                    100.0 * share,
                    sigma_rad.to_degrees()
                );
                self.event(*time, Level::Warning, "field_disturbed", &text)
            }
            Notice::AntennaElsewhere { time, offset_m, sigma_m } => {
                let text = format!(
                    "antenna {:.1} m forward and {:.1} m right of where its lever arm says (one-sigma {sigma_m:.1} m): \
                     taken to stand there",
                    offset_m.x(),
                    offset_m.y()
                );
                self.event(*time, Level::Warning, "antenna_elsewhere", &text)
            }
            Notice::OnWheels { time, sigma_mps } => {
                let text = format!(
                    "the vehicle rolls on wheels: without fixes it is held to its road (one-sigma {sigma_mps:.2} m/s)"
                );
                self.event(*time, Level::Info, "on_wheels", &text)
            }
            Notice::OffWheels { time } => {
                let text = "the vehicle is off its wheels: it is not held to a road";
                self.event(*time, Level::Info, "off_wheels", text)
            }
            Notice::FieldUsual { time, changed } => {
                let text = if *changed {
                    "the magnetic field has stayed changed: it is trusted as it is now"
                } else {
                    "the magnetic field is back where it was"
                };
                self.event(*time, Level::Info, "field_usual", text)
            }
            Notice::Updated(report) => {
                let message = InnovationsMessage::new(report.innovations());
                let time = Time::from_nanoseconds(message.time_ns);
                self.message(Channel::Innovations, time, &message)?;
                let (kind, level) = if report.any_reopened() {
                    ("filter_reopened", Level::Error)
                } else if report.any_rejected() {
                    ("innovation_rejected", Level::Warning)
                } else {
                    return Ok(());
                };
                let refused = message.axes.iter().filter(|(_, axis)| axis.verdict != "accepted");
                let refused: Vec<String> = refused
                    .map(|(name, axis)| {
                        format!("{name} {:.3} ± {:.3}", axis.innovation, axis.sigma)
                    })
                    .collect();
                self.event(time, level, kind, &refused.join(", "))
            }
            Notice::HeadingMissing { time } => {
                let text = "alignment waits for a heading";
                self.event(*time, Level::Warning, "heading_missing", text)
            }
            Notice::NotUsed { time, aid, reason } if reason.is_fault() => {
                let kind = if *aid == Aid::Gps { "fix_unusable" } else { "aid_unusable" };
                let text = format!("the {aid} is not used: {reason}");
                self.event(*time, Level::Warning, kind, &text)
            }
            Notice::GapBridged { time, length_s } => {
                let text = format!("inertial sample: none for {length_s:.3} s: bridged");
                self.event(*time, Level::Warning, "imu_fault", &text)
            }
            Notice::CovarianceReset { time, cause } => {
                let text = format!("inertial sample: {cause}");
                self.event(*time, Level::Warning, "imu_fault", &text)
            }
            Notice::SampleSuspect { time, suspicion } => {
                let text = format!("inertial sample: {suspicion}");
                self.event(*time, Level::Warning, "imu_suspect", &text)
            }
            Notice::SampleRefused { time, fault } => {
                let text = format!("inertial sample: {fault}");
                self.event(*time, Level::Warning, "imu_fault", &text)
            }
            _ => Ok(()),
        }
    }

    fn location(
        &mut self,
        channel: Channel,
        time: Time,
        position: &Geodetic,
        sigma_ned_m: Option<[f64; 3]>,
    ) -> McapResult<()> {
        let frame = if channel == Channel::GpsLocation { "antenna" } else { "body" };
        let unix_ns = self.header.unix_ns(time);
        let message = LocationMessage::new(unix_ns, frame, position, sigma_ned_m);
        self.message(channel, time, &message)
    }

    pub(super) fn event(
        &mut self,
        time: Time,
        level: Level,
        kind: &str,
        text: &str,
    ) -> McapResult<()> {
        self.event_of(Part::of_kind(kind), time, level, kind, text)
    }

    fn event_of(
        &mut self,
        part: Part,
        time: Time,
        level: Level,
        kind: &str,
        text: &str,
    ) -> McapResult<()> {
        let level = match level {
            Level::Info => 2,
            Level::Warning => 3,
            Level::Error => 4,
            Level::Critical => 5,
        };
        let timestamp = Timestamp::new(self.header.unix_ns(time));
        let (message, part) = (text, part.name());
        let message = LogMessage { timestamp, level, message, name: kind, file: "", line: 0, part };
        self.message(Channel::Events, time, &message)
    }
}

/// How much the loss of the inertial unit matters: one that was there is what everything is flown by.
#[must_use]
pub const fn dmu_lost_level(fault: LinkFault) -> Level {
    match fault {
        LinkFault::Startup(_) => Level::Error,
        LinkFault::NoData | LinkFault::Garbled => Level::Critical,
    }
}

impl ImuMessage {
    fn new(time: Time, measurement: &Measurement) -> Self {
        Self {
            time_ns: time.nanoseconds(),
            angular_rate_body_radps: measurement.angular_rate_radps.to_array(),
            specific_force_body_mps2: measurement.specific_force_mps2.to_array(),
            magnetic_field_body_gauss: measurement.magnetic_field_gauss.to_array(),
            temperature_degc: measurement.temperature_degc,
            roll_pitch_yaw_deg: measurement.attitude.map(|attitude| attitude.to_degrees()),
        }
    }
}
