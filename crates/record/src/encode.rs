//! Conversion of entries to messages.

use std::io::Write;

use mcap::McapResult;

use crate::channel::Channel;
use crate::entry::{Entry, Level, Line, Part, Queued};
use crate::happening::Happening;
use crate::message::{
    ControlsMessage, CycleMessage, FixMessage, ImuMessage, InnovationsMessage, LocationMessage,
    LogMessage, LostMessage, RawMessage, RestartMessage, ServoMessage, SolutionMessage, Timestamp,
};
use crate::writer::MessageWriter;
use hovernav::dmu::Measurement;
use hovernav::earth::Geodetic;
use hovernav::ekf::Notice;
use hovernav::frames::Vector;
use hovernav::gps::ReceiverFix;
use hovernav::gps::quality::Failures;
use hovernav::sensors::SensorOutput;
use hovernav::time::Time;

impl<W: Write> MessageWriter<W> {
    /// Writes the messages of an entry.
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
            Entry::Notice(notice) => self.notice(notice),
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
                self.message(Channel::Imu, *time, &ImuMessage::new(*time, measurement))?;
            }
            SensorOutput::Fix(fix, failures) => self.fix(fix, failures)?,
            _ => {}
        }
        self.happening(Happening::of_sensor(output))
    }

    fn fix(&mut self, fix: &ReceiverFix, failures: &Failures) -> McapResult<()> {
        let message = FixMessage::new(fix, failures);
        self.message(Channel::GpsFix, fix.arrival, &message)?;
        let Some(height_m) = fix.height_m else { return Ok(()) };
        let (latitude_rad, longitude_rad) = (fix.latitude_rad, fix.longitude_rad);
        let position = Geodetic { latitude_rad, longitude_rad, height_m };
        let sigma_m = fix.position_sigma_m.map(Vector::to_array);
        self.location(Channel::GpsLocation, fix.arrival, &position, sigma_m)
    }

    fn notice(&mut self, notice: &Notice) -> McapResult<()> {
        if let Notice::Updated(report) = notice {
            let message = InnovationsMessage::new(report.innovations());
            let time = Time::from_nanoseconds(message.time_ns);
            self.message(Channel::Innovations, time, &message)?;
        }
        self.happening(Happening::of_notice(notice))
    }

    fn happening(&mut self, happening: Option<Happening>) -> McapResult<()> {
        let Some(Happening { time, level, kind, text, .. }) = happening else { return Ok(()) };
        self.event(time.unwrap_or(self.now), level, kind, text.as_str())
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
