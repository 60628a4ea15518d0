//! The pilot's pulses in, the servos' pulses out.

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
use hovernav_log::record::{Level, Line, Part};
use hovernav_log::{CaptureSection, FlyConfig};

/// Pieces of the pilot's stream that may wait: 5 s of them.
const QUEUE: usize = 256;

/// How long after the start the pilot's pulses may stay away before that is told, s: a port is looked for every
/// half second, a receiver sends every 20 ms.
const FIRST_PULSES_S: f64 = 1.0;

/// Where the pilot's pulses come from; there is one in a flight.
#[allow(clippy::large_enum_variant)]
enum PilotInput {
    Absent,
    Stream { reader: Reader, capture: PacketCapture, name: PortName },
    Gpio(GpioCapture),
}

/// What happened on the way.
pub enum ServoEvent<'a> {
    /// Bytes of the pilot's stream, to be recorded.
    Raw(&'a [u8], Time),
    /// The pilot's line changed.
    Port(&'a PortName, PortEvent),
    /// The line to the servos changed.
    OutputPort(&'a PortName, PortEvent),
    /// The pilot's signal became this.
    Signal(Signal),
    /// The source or the servos failed, for the first time since they worked.
    Failed(String),
}

impl ServoEvent<'_> {
    /// Records it, and notifies of it unless it is only bytes.
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
                log.event(now, Level::Info, pilot, "the pilot's signal is there");
            }
            Self::Signal(Signal::Stale(channel)) => {
                let text = format_args!("no pulses of the pilot's {channel}");
                log.event(now, Level::Error, pilot, text);
            }
            Self::Signal(Signal::Failsafe) => {
                log.event(now, Level::Error, pilot, "the pilot's signal is lost");
            }
            Self::Failed(why) => log.event(now, Level::Error, "servos", why),
        }
    }
}

/// What the pilot sends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PilotState {
    /// Everything known of the pulses.
    pub pulses: PilotPulses,
    /// Widths that are fresh, ms.
    pub widths_ms: Channels<Option<f64>>,
    /// The aux channel's, ms.
    pub aux_ms: Option<f64>,
    /// State of the signal; `None` where no pilot is configured.
    pub signal: Option<Signal>,
}

impl PilotState {
    /// Pulses that were lost, the most of any channel.
    pub fn pulses_lost(&self) -> u32 {
        self.pulses.channels.iter().map(|(_, channel)| channel.errors).max().unwrap_or(0)
    }
}

/// Where the servos' pulses go.
enum ServoOutput {
    Absent,
    Pwm(PwmOutput),
    Stream(StreamOutput, PortName),
}

/// What became of a command.
pub struct Sent {
    /// What the servos are sent, ms; `None` before the pilot's first pulses.
    pub widths_ms: Channels<Option<f64>>,
    /// Whether they took it.
    pub good: bool,
    /// When they had it; `None` where nothing is sent.
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
    /// When the lines were opened.
    opened: Time,
    last_signal: Option<Signal>,
    /// What the source failed by in this cycle.
    source_failure: Option<String>,
    failed: bool,
}

impl Servos {
    /// What `config` names; servos stay silent until the pilot's first pulses.
    ///
    /// # Errors
    /// A GPIO line or PWM output that cannot be had, settings that cannot be, no thread.
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

    /// Takes in the pilot's pulses.
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

    /// The widths, ms, that pass the pilot on, mixed where the swashplate needs it; NaN where there is
    /// nobody.
    pub fn passed_on_ms(&self, pilot: &PilotState) -> Channels<f64> {
        // In failsafe the pulses are the receiver's own, not the pilot's.
        let is_pilots = pilot.signal != Some(Signal::Failsafe);
        let own_ms = pilot.widths_ms.map(|width_ms| width_ms.filter(|_| is_pilots));
        self.swashplate.passed_on_ms(&self.channels, &own_ms)
    }

    /// Sends widths, ms, to the servos within range and rate, once the pilot has been there.
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

    /// The pilot's sticks; `None` unless all four are fresh.
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
    fn pulses_that_stay_away_are_told_once_they_have_had_their_time() {
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
