//! Bringing a receiver to NAV-PVT at the wanted rate.

use core::ops::{Deref, DerefMut};

use ublox::UbxPacketMeta;
use ublox::cfg_msg::CfgMsgSinglePortBuilder;
use ublox::cfg_rate::{AlignmentToReferenceTime, CfgRateBuilder};
use ublox::cfg_val::CfgVal;
use ublox::nav_pvt::proto23::NavPvt;
use ublox::packets::cfg_val::{CfgLayerSet, CfgValSetBuilder};

use super::{Acknowledgement, Decoder};
use crate::time::Time;

/// A rate that cannot be had.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConfigurationError {
    /// Fixes per second outside 1 to 10.
    Rate {
        /// What was asked for.
        found_hz: u8,
    },
}

impl core::fmt::Display for ConfigurationError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self::Rate { found_hz } = self;
        write!(f, "a u-blox receiver is set to 1 to 10 fixes per second, not {found_hz}")
    }
}

impl core::error::Error for ConfigurationError {}

/// A configuration message as it goes on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Message {
    bytes: [u8; 64],
    length: usize,
}

impl Message {
    const EMPTY: Self = Self { bytes: [0; 64], length: 0 };

    /// The bytes to write.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }

    fn of(bytes: &[u8]) -> Self {
        let mut buffer = Buffer(Self::EMPTY);
        buffer.extend(bytes.iter().copied());
        buffer.0
    }

    fn is_answered_by(&self, answer: Acknowledgement) -> bool {
        self.as_bytes().get(2..4) == Some(&[answer.class, answer.id])
    }
}

/// What the `ublox` crate writes messages of varying length into.
struct Buffer(Message);

impl Extend<u8> for Buffer {
    fn extend<I: IntoIterator<Item = u8>>(&mut self, bytes: I) {
        let room = self.0.bytes.iter_mut().skip(self.0.length);
        self.0.length += room.zip(bytes).map(|(room, byte)| *room = byte).count();
    }
}

impl Deref for Buffer {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        self.0.as_bytes()
    }
}

impl DerefMut for Buffer {
    fn deref_mut(&mut self) -> &mut [u8] {
        self.0.bytes.get_mut(..self.0.length).unwrap_or_default()
    }
}

/// The NMEA sentences that receivers send unasked: GGA, GLL, GSA, GSV, RMC, VTG. At 10 Hz they would
/// fill the line.
const NMEA_CLASS: u8 = 0xF0;
const NMEA_SENTENCES: u8 = 6;

/// Sets a receiver to NAV-PVT at a rate, with NMEA off, in its volatile memory.
///
/// First by CFG-RATE and CFG-MSG, message by message, each awaiting its acknowledgement (up to the
/// M9); a receiver that refuses CFG-RATE is set by one CFG-VALSET for its first UART (from the M9
/// on).
///
/// ```
/// use hovernav::gps::ubx::{Configuration, Decoder};
/// use hovernav::time::Time;
///
/// let mut decoder = Decoder::default();
/// let mut configuration = Configuration::new(5)?;
/// let message = configuration.poll(&mut decoder, Time::ZERO).unwrap();
/// // CFG-RATE: a measurement each 200 ms, a fix from each, in step with GPS time.
/// assert_eq!(message.as_bytes()[..12], [0xB5, 0x62, 0x06, 0x08, 6, 0, 200, 0, 1, 0, 1, 0]);
/// # Ok::<(), hovernav::gps::ubx::ConfigurationError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Configuration {
    rate_hz: u8,
    step: Step,
    sent: Option<Time>,
    attempts: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Rate,
    Pvt,
    /// Switching off one NMEA sentence after the other.
    Nmea(u8),
    Keys,
    Done,
    Refused,
}

impl Configuration {
    /// Seconds before an unanswered message is sent again.
    pub const RETRY_S: f64 = 1.0;

    /// Aims at `rate_hz` fixes a second.
    ///
    /// # Errors
    /// [`ConfigurationError::Rate`] outside 1 to 10 Hz.
    pub const fn new(rate_hz: u8) -> Result<Self, ConfigurationError> {
        if matches!(rate_hz, 1..=10) {
            Ok(Self { rate_hz, step: Step::Rate, sent: None, attempts: 0 })
        } else {
            Err(ConfigurationError::Rate { found_hz: rate_hz })
        }
    }

    /// What to write to the port at `now`, if anything. Takes the answers out of `decoder`. Call
    /// often until [`is_done`](Self::is_done) or [`is_refused`](Self::is_refused).
    pub fn poll(&mut self, decoder: &mut Decoder, now: Time) -> Option<Message> {
        if let Some((answer, asked)) = decoder.take_acknowledgement().zip(self.message())
            && asked.is_answered_by(answer)
            && self.sent.take().is_some()
        {
            self.step = self.step.after(answer.accepted);
        }
        let waiting = self.sent.is_some_and(|sent| (0.0..Self::RETRY_S).contains(&(now - sent)));
        if waiting {
            return None;
        }
        let message = self.message()?;
        self.sent = Some(now);
        self.attempts = self.attempts.saturating_add(1);
        Some(message)
    }

    /// Whether the receiver has accepted every message.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.step == Step::Done
    }

    /// Whether the receiver has refused both ways of being set.
    #[must_use]
    pub fn is_refused(&self) -> bool {
        self.step == Step::Refused
    }

    /// How many messages were sent; growing without end, it tells of a dead line, a wrong baud rate
    /// or another protocol.
    #[must_use]
    pub fn attempts(&self) -> u32 {
        self.attempts
    }

    fn message(&self) -> Option<Message> {
        let measure_rate_ms = 1_000 / u16::from(self.rate_hz.max(1));
        match self.step {
            Step::Rate => Some(Message::of(
                &CfgRateBuilder {
                    measure_rate_ms,
                    nav_rate: 1,
                    time_ref: AlignmentToReferenceTime::Gps,
                }
                .into_packet_bytes(),
            )),
            Step::Pvt => Some(message_rate(NavPvt::CLASS, NavPvt::ID, 1)),
            Step::Nmea(sentence) => Some(message_rate(NMEA_CLASS, sentence, 0)),
            Step::Keys => {
                let mut buffer = Buffer(Message::EMPTY);
                CfgValSetBuilder {
                    version: 0,
                    layers: CfgLayerSet::RAM,
                    reserved1: 0,
                    cfg_data: &[
                        CfgVal::RateMeas(measure_rate_ms),
                        CfgVal::MsgOutUbxNavPvtUart1(1),
                        CfgVal::Uart1OutProtNmea(false),
                    ],
                }
                .extend_to(&mut buffer);
                Some(buffer.0)
            }
            Step::Done | Step::Refused => None,
        }
    }
}

impl Step {
    fn after(self, accepted: bool) -> Self {
        match (self, accepted) {
            (Self::Rate, false) => Self::Keys,
            (_, false) => Self::Refused,
            (Self::Rate, true) => Self::Pvt,
            (Self::Pvt, true) => Self::Nmea(0),
            (Self::Nmea(sentence), true) if sentence + 1 < NMEA_SENTENCES => {
                Self::Nmea(sentence + 1)
            }
            _ => Self::Done,
        }
    }
}

fn message_rate(msg_class: u8, msg_id: u8, rate: u8) -> Message {
    Message::of(&CfgMsgSinglePortBuilder { msg_class, msg_id, rate }.into_packet_bytes())
}
