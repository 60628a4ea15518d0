//! Input of the pilot's pulses and output of the servo pulses.

use super::error::FlyError;
use super::messages::port_level;
use super::notification::EventLog;
use super::port_name::PortName;
use crate::serial::{Clock, Item, Port, PortConfig, PortEvent, Reader};
use crate::servo::{GpioCapture, PwmOutput, StreamOutput};
use hovernav::controls::{Channels, Sticks};
use hovernav::servo::packet::PacketCapture;
use hovernav::servo::{
    ChannelConfig, Limiter, PilotPulses, PulseCapture as _, PulseOutput as _, Signal, SignalConfig,
    Swashplate,
};
use hovernav::time::Time;
use hovernav_record::{CaptureSection, FlyConfig, Level, Line, Part};

/// Length of the queue of the pilot's stream: 5 s.
const QUEUE: usize = 256;

/// Time from the start until missing pilot pulses are reported, s. Ports are retried every 0.5 s, and a receiver sends
/// every 20 ms.
const FIRST_PULSES_S: f64 = 1.0;

/// Source of the pilot's pulses; there is one per flight.
#[allow(clippy::large_enum_variant)]
enum PilotInput {
    Absent,
    Stream { reader: Reader, capture: PacketCapture, name: PortName },
    Gpio(GpioCapture),
}

/// Events of the pilot's line and the servos.
pub enum ServoEvent<'a> {
    /// Bytes of the pilot's stream, for the record.
    Raw(&'a [u8], Time),
    /// The pilot's line changed.
    Port(&'a PortName, PortEvent),
    /// The line to the servos changed.
    OutputPort(&'a PortName, PortEvent),
    /// The new state of the pilot's signal.
    Signal(Signal),
    /// First failure of the pilot's source or of the servos after a time without failures.
    Failed(String),
}

impl ServoEvent<'_> {
    /// Records the event, and sends a notification unless it is raw bytes.
    pub fn log(&self, log: &mut EventLog, now: Time) {
        let pilot = "pilot_signal";
        match self {
            Self::Raw(bytes, arrival) => log.recorder.raw(Line::Servo, bytes, *arrival),
            Self::Port(port, event) => {
                log.event(now, port_level(event), "servo_port", port.changed(event));
            }
            Self::OutputPort(port, event) => {
                let text = port.changed(event);
                log.event_of(Part::Servos, now, port_level(event), "servo_port", text);
            }
            Self::Signal(Signal::Good) => {
                log.event(now, Level::Info, pilot, "the pilot's signal is good");
            }
            Self::Signal(Signal::Stale(channel)) => {
                let text = format_args!("no pulses on the pilot's {channel} channel");
                log.event(now, Level::Error, pilot, text);
            }
            Self::Signal(Signal::Failsafe) => {
                log.event(now, Level::Error, pilot, "the pilot's signal is lost");
            }
            Self::Failed(why) => log.event(now, Level::Error, "servos", why),
        }
    }
}

/// The pilot's signal in one cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PilotState {
    /// All data of the pulses.
    pub pulses: PilotPulses,
    /// Widths of fresh pulses, ms.
    pub widths_ms: Channels<Option<f64>>,
    /// Width of the aux channel, ms.
    pub aux_ms: Option<f64>,
    /// State of the signal; `None` if no pilot is configured.
    pub signal: Option<Signal>,
}

impl PilotState {
    /// Number of lost pulses, the maximum over the channels.
    pub fn pulses_lost(&self) -> u32 {
        self.pulses.channels.iter().map(|(_, channel)| channel.errors).max().unwrap_or(0)
    }
}

/// Output of the servo pulses.
enum ServoOutput {
    Absent,
    Pwm(PwmOutput),
    Stream(StreamOutput, PortName),
}

/// Result of a command.
pub struct Sent {
    /// Widths sent to the servos, ms; `None` before the pilot's first pulses.
    pub widths_ms: Channels<Option<f64>>,
    /// Whether the output accepted the widths.
    pub good: bool,
    /// Time of the output; `None` if nothing was sent.
    pub at: Option<Time>,
}

/// The pilot, the limits and the servos.
pub struct Servos {
    clock: Clock,
    pilot: PilotInput,
    signal: SignalConfig,
    channels: Channels<ChannelConfig>,
    swashplate: Swashplate,
    limiter: Limiter,
    output: ServoOutput,
    started: bool,
    /// Time at which the lines were opened.
    opened: Time,
    last_signal: Option<Signal>,
    /// Failure of the source in this cycle.
    source_failure: Option<String>,
    failed: bool,
}

impl Servos {
    /// Opens the lines in `config`. The servos stay silent until the pilot's first pulses.
    ///
    /// # Errors
    /// A GPIO line or PWM output that cannot be opened, invalid settings, or a thread that cannot be started.
    pub fn open(config: &FlyConfig, clock: &Clock) -> Result<Self, FlyError> {
        let section = &config.servo;
        let pilot = match &section.capture {
            None => PilotInput::Absent,
            Some(CaptureSection::Serial(line)) => {
                let port = Port::new(PortConfig::new(&line.port, line.baud), clock);
                let reader = Reader::spawn(port, clock, QUEUE)?;
                let name = PortName::new("pilot", "[servo.capture] serial.port", &line.port);
                PilotInput::Stream { reader, capture: PacketCapture::default(), name }
            }
            Some(CaptureSection::Gpio { chip, lines, aux }) => {
                PilotInput::Gpio(GpioCapture::open(chip, lines, *aux)?)
            }
        };
        let output = match &section.stream {
            Some(line) => {
                let port = Port::new(PortConfig::new(&line.port, line.baud), clock);
                let name = PortName::new("servos", "[servo.stream] port", &line.port);
                ServoOutput::Stream(StreamOutput::new(port, clock), name)
            }
            None if section.output.iter().any(|(_, line)| line.is_some()) => {
                ServoOutput::Pwm(PwmOutput::open(&section.output)?)
            }
            None => ServoOutput::Absent,
        };
        Ok(Self {
            clock: clock.clone(),
            pilot,
            signal: section.signal,
            channels: section.channels,
            swashplate: section.swashplate,
            limiter: Limiter::new(section.channels, section.hold_s)?,
            output,
            started: false,
            opened: clock.now(),
            last_signal: None,
            source_failure: None,
            failed: false,
        })
    }

    /// Reads the pilot's pulses.
    pub fn poll(&mut self, now: Time, mut on_event: impl FnMut(ServoEvent<'_>)) -> PilotState {
        let Some((pulses, failure)) = self.pilot.poll(now, &mut on_event) else {
            return PilotState::default();
        };
        self.source_failure = failure;
        let signal = pulses.signal(now, &self.signal);
        let may_yet_come = self.last_signal.is_none()
            && matches!(signal, Signal::Stale(_))
            && now - self.opened < FIRST_PULSES_S;
        if !may_yet_come && self.last_signal.replace(signal) != Some(signal) {
            on_event(ServoEvent::Signal(signal));
        }
        let stale_s = self.signal.stale_after_s;
        PilotState {
            pulses,
            widths_ms: pulses.channels.map(|channel| channel.fresh_ms(now, stale_s)),
            aux_ms: pulses.aux.fresh_ms(now, stale_s),
            signal: Some(signal),
        }
    }

    /// Servo pulse widths, ms, for the pilot's own command, mixed if the swashplate needs it; NaN without a pilot.
    pub fn passed_on_ms(&self, pilot: &PilotState) -> Channels<f64> {
        // In failsafe the receiver generates the pulses, not the pilot.
        let is_pilots = pilot.signal != Some(Signal::Failsafe);
        let own_ms = pilot.widths_ms.map(|width_ms| width_ms.filter(|_| is_pilots));
        self.swashplate.passed_on_ms(&self.channels, &own_ms)
    }

    /// Sends widths, ms, to the servos, limited in range and rate, after the first good signal of the pilot.
    pub fn send(
        &mut self,
        command_ms: &Channels<f64>,
        pilot: &PilotState,
        now: Time,
        mut on_event: impl FnMut(ServoEvent<'_>),
    ) -> Sent {
        if let ServoOutput::Stream(output, name) = &mut self.output
            && let Some(event) = output.poll(now)
        {
            on_event(ServoEvent::OutputPort(name, event));
        }
        if !self.started {
            if pilot.signal != Some(Signal::Good) {
                return Sent { widths_ms: Channels::default(), good: true, at: None };
            }
            self.started = true;
            self.limiter.start_from(command_ms);
        }
        let limited_ms = self.limiter.apply(command_ms, now).map(|servo| servo.width_ms);
        let written = match &mut self.output {
            ServoOutput::Absent => Ok(()),
            ServoOutput::Pwm(output) => {
                output.write(&limited_ms, now).map_err(|error| error.to_string())
            }
            ServoOutput::Stream(output, name) => {
                output.write(&limited_ms).map_err(|error| name.not_written(&error).to_string())
            }
        };
        let good = written.is_ok();
        let drives = !matches!(self.output, ServoOutput::Absent);
        let at = (good && drives).then(|| self.clock.now());
        let failure = written.err().or_else(|| self.source_failure.take());
        let failed_before = std::mem::replace(&mut self.failed, failure.is_some());
        if let Some(failure) = failure.filter(|_| !failed_before) {
            on_event(ServoEvent::Failed(failure));
        }
        Sent { widths_ms: limited_ms.map(Some), good, at }
    }

    /// The pilot's stick positions; `None` unless all four are fresh.
    pub fn sticks(&self, pilot: &PilotState) -> Option<Sticks> {
        self.swashplate.pilot_sticks(&self.channels, &pilot.widths_ms)
    }
}

impl PilotInput {
    fn poll(
        &mut self,
        now: Time,
        on_event: &mut impl FnMut(ServoEvent<'_>),
    ) -> Option<(PilotPulses, Option<String>)> {
        match self {
            Self::Absent => None,
            Self::Stream { reader, capture, name } => {
                while let Some(item) = reader.receive(now) {
                    match item {
                        Item::Bytes { arrival, bytes } => {
                            on_event(ServoEvent::Raw(&bytes, arrival));
                            capture.receive(&bytes, arrival);
                        }
                        Item::Changed(event) => on_event(ServoEvent::Port(name, event)),
                        Item::NotWritten(_) => {}
                    }
                }
                Some((*capture.pulses(), None))
            }
            Self::Gpio(capture) => match capture.poll(now) {
                Ok(pulses) => Some((*pulses, None)),
                Err(error) => Some((PilotPulses::default(), Some(error.to_string()))),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_pulses_are_reported_once_after_a_second() {
        let text = "[dmu]\nport = 'a'\n[receiver]\nport = 'b'\n\
                    [servo.capture]\nserial = { port = '/nowhere/pilot' }\n";
        let config = FlyConfig::parse(text, "fly.toml".as_ref()).unwrap();
        let mut servos = Servos::open(&config, &Clock::start()).unwrap();
        let opened = servos.opened;
        let mut told = Vec::new();
        for cycle in 0..60 {
            let at_s = f64::from(cycle) / 33.0;
            let pilot = servos.poll(opened + at_s, |event| {
                if let ServoEvent::Signal(signal) = event {
                    told.push((at_s, signal));
                }
            });
            assert!(matches!(pilot.signal, Some(Signal::Stale(_))));
        }
        let [(at_s, Signal::Stale(_))] = told[..] else { panic!("{told:?}") };
        assert!((FIRST_PULSES_S..FIRST_PULSES_S + 0.04).contains(&at_s), "{at_s}");
    }
}
