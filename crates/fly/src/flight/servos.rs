//! The pilot's pulses in, the servos' pulses out.

use super::run::FlyError;
use crate::serial::{Clock, Item, Parity, Port, PortConfig, PortEvent, Reader};
use crate::servo::{GpioCapture, PwmOutput};
use hovernav::controls::Channels;
use hovernav::servo::packet::PacketCapture;
use hovernav::servo::{
    ChannelConfig, Limiter, PilotPulses, PulseCapture as _, PulseOutput as _, Signal, SignalConfig,
};
use hovernav::time::Time;
use hovernav_log::CaptureSection;
use hovernav_log::FlyConfig;

/// Pieces of the pilot's stream that may wait: 5 s of them.
const QUEUE: usize = 256;

/// Where the pilot's pulses come from.
enum Pilot {
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
    pilot: Pilot,
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
            None => Pilot::Absent,
            Some(CaptureSection::Serial(line)) => {
                let port = PortConfig {
                    path: line.port.to_string_lossy().into_owned(),
                    baud: line.baud,
                    parity: Parity::None,
                };
                let reader = Reader::spawn(Port::new(port, clock), clock, QUEUE)?;
                Pilot::Stream { reader, capture: PacketCapture::default() }
            }
            Some(CaptureSection::Gpio { chip, lines }) => {
                Pilot::Gpio(GpioCapture::open(chip, lines)?)
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
    pub fn pass_through(&mut self, now: Time, mut tell: impl FnMut(ServoEvent<'_>)) -> Widths {
        let Some((pulses, failure)) = self.pilot.poll(now, &mut tell) else {
            return Widths { servos_good: true, ..Widths::default() };
        };
        let mut failure = failure;
        let signal = pulses.signal(now, &self.signal);
        if self.last_signal.replace(signal) != Some(signal) {
            tell(ServoEvent::Signal(signal));
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
        let believed = signal != Signal::Failsafe;
        let command_ms = fresh.map(|width_ms| width_ms.filter(|_| believed).unwrap_or(f64::NAN));
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
            tell(ServoEvent::Failed(failure));
        }
        widths
    }

    /// The pilot's sticks as fractions about trim: lateral, longitudinal, collective, pedal; `None`
    /// unless all four are fresh.
    pub fn sticks(&self, pilot_ms: &Channels<Option<f64>>) -> Option<[f64; 4]> {
        let stick = pilot_ms
            .zip(self.channels)
            .map(|(width_ms, config)| width_ms.map(|width_ms| config.stick(width_ms)));
        Some([stick.lateral?, stick.longitudinal?, stick.collective?, stick.pedal?])
    }
}

impl Pilot {
    fn poll(
        &mut self,
        now: Time,
        tell: &mut impl FnMut(ServoEvent<'_>),
    ) -> Option<(PilotPulses, Option<String>)> {
        match self {
            Self::Absent => None,
            Self::Stream { reader, capture } => {
                while let Some(item) = reader.receive(now) {
                    match item {
                        Item::Bytes { arrival, bytes } => {
                            tell(ServoEvent::Raw(&bytes, arrival));
                            capture.receive(&bytes, arrival);
                        }
                        Item::Changed(event) => tell(ServoEvent::Port(event)),
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
