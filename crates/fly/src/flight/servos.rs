//! The pilot's pulses in, the servos' pulses out.

use super::error::FlyError;
use super::messages::port_level;
use super::notification::EventLog;
use crate::serial::{Clock, Item, Port, PortConfig, PortEvent, Reader};
use crate::servo::{GpioCapture, PwmOutput};
use hovernav::controls::{Channels, Sticks};
use hovernav::servo::packet::PacketCapture;
use hovernav::servo::{
    ChannelConfig, Limiter, PilotPulses, PulseCapture as _, PulseOutput as _, Signal, SignalConfig,
};
use hovernav::time::Time;
use hovernav_log::record::{Level, Line};
use hovernav_log::{CaptureSection, FlyConfig};

/// Pieces of the pilot's stream that may wait: 5 s of them.
const QUEUE: usize = 256;

/// Where the pilot's pulses come from.
enum PilotInput {
    Absent,
    Stream { reader: Reader, capture: PacketCapture },
    Gpio(GpioCapture),
}

/// What happened on the way.
pub enum ServoEvent<'a> {
    /// Bytes of the pilot's stream, to be recorded.
    Raw(&'a [u8], Time),
    /// The pilot's line changed.
    Port(PortEvent),
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
            Self::Port(event) => {
                log.event(now, port_level(event), "servo_port", format_args!("pilot: {event}"));
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

/// Widths in and out, ms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Widths {
    /// What the pilot sends, where it is fresh.
    pub pilot_ms: Channels<Option<f64>>,
    /// What the servos are sent.
    pub commanded_ms: Channels<Option<f64>>,
    /// Whether the pilot is there.
    pub signal_good: bool,
    /// Whether the receiver says that it has lost the transmitter.
    pub receiver_failsafe: bool,
    /// Whether the servos took what they were sent.
    pub servos_good: bool,
    /// Pulses of the pilot that were lost, the most of any channel.
    pub pulses_lost: u32,
}

/// The pilot, the limits and the servos.
pub struct Servos {
    pilot: PilotInput,
    signal: SignalConfig,
    channels: Channels<ChannelConfig>,
    limiter: Limiter,
    output: Option<PwmOutput>,
    started: bool,
    last_signal: Option<Signal>,
    failed: bool,
}

impl Servos {
    /// What `config` names; servos stay silent until the pilot's first pulses.
    ///
    /// # Errors
    /// A GPIO line or PWM output that cannot be had, settings that cannot be, no thread.
    pub fn open(config: &FlyConfig, clock: Clock) -> Result<Self, FlyError> {
        let section = &config.servo;
        let pilot = match &section.capture {
            None => PilotInput::Absent,
            Some(CaptureSection::Serial(line)) => {
                let port = Port::new(PortConfig::new(&line.port, line.baud), clock);
                let reader = Reader::spawn(port, clock, QUEUE)?;
                PilotInput::Stream { reader, capture: PacketCapture::default() }
            }
            Some(CaptureSection::Gpio { chip, lines, aux }) => {
                PilotInput::Gpio(GpioCapture::open(chip, lines, *aux)?)
            }
        };
        let wanted = section.output.iter().any(|(_, line)| line.is_some());
        let output = wanted.then(|| PwmOutput::open(&section.output)).transpose()?;
        Ok(Self {
            pilot,
            signal: section.signal,
            channels: section.channels,
            limiter: Limiter::new(section.channels, section.hold_s)?,
            output,
            started: false,
            last_signal: None,
            failed: false,
        })
    }

    /// One cycle with the pilot in command: takes in the pilot's pulses and sends them on, within
    /// range and rate.
    pub fn pass_through(&mut self, now: Time, mut on_event: impl FnMut(ServoEvent<'_>)) -> Widths {
        let Some((pulses, failure)) = self.pilot.poll(now, &mut on_event) else {
            return Widths { servos_good: true, ..Widths::default() };
        };
        let mut failure = failure;
        let signal = pulses.signal(now, &self.signal);
        if self.last_signal.replace(signal) != Some(signal) {
            on_event(ServoEvent::Signal(signal));
        }
        let fresh = pulses.channels.map(|channel| channel.fresh_ms(now, self.signal.stale_after_s));
        let mut widths = Widths {
            pilot_ms: fresh,
            signal_good: signal == Signal::Good,
            receiver_failsafe: signal == Signal::Failsafe,
            servos_good: true,
            pulses_lost: pulses
                .channels
                .iter()
                .map(|(_, channel)| channel.errors)
                .max()
                .unwrap_or(0),
            ..Widths::default()
        };
        // In failsafe the pulses are the receiver's own, not the pilot's.
        let is_pilots = signal != Signal::Failsafe;
        let command_ms = fresh.map(|width_ms| width_ms.filter(|_| is_pilots).unwrap_or(f64::NAN));
        if !self.started {
            if !widths.signal_good {
                return widths;
            }
            self.started = true;
            self.limiter.start_from(&command_ms);
        }
        let limited_ms = self.limiter.apply(&command_ms, now).map(|servo| servo.width_ms);
        widths.commanded_ms = limited_ms.map(Some);
        if let Some(output) = &mut self.output
            && let Err(error) = output.write(&limited_ms, now)
        {
            widths.servos_good = false;
            failure = Some(error.to_string());
        }
        let failed_before = std::mem::replace(&mut self.failed, failure.is_some());
        if let Some(failure) = failure.filter(|_| !failed_before) {
            on_event(ServoEvent::Failed(failure));
        }
        widths
    }

    /// The pilot's sticks; `None` unless all four are fresh.
    pub fn sticks(&self, pilot_ms: &Channels<Option<f64>>) -> Option<Sticks> {
        let stick = pilot_ms
            .zip(self.channels)
            .map(|(width_ms, config)| width_ms.map(|width_ms| config.stick(width_ms)));
        Some(Sticks {
            lateral: stick.lateral?,
            longitudinal: stick.longitudinal?,
            collective: stick.collective?,
            pedal: stick.pedal?,
        })
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
            Self::Stream { reader, capture } => {
                while let Some(item) = reader.receive(now) {
                    match item {
                        Item::Bytes { arrival, bytes } => {
                            on_event(ServoEvent::Raw(&bytes, arrival));
                            capture.receive(&bytes, arrival);
                        }
                        Item::Changed(event) => on_event(ServoEvent::Port(event)),
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
