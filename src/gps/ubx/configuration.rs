//! Configures a receiver for NAV-PVT at the wanted rate.

use super::framer::{SYNC, checksum};
use super::message::NAV_PVT;
use super::{Acknowledgement, Decoder};
use crate::time::Time;

/// An unsupported rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConfigurationError {
    /// A rate outside 1 to 10 fixes per second.
    Rate {
        /// The requested rate, Hz.
        found_hz: u8,
    },
}

impl core::fmt::Display for ConfigurationError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self::Rate { found_hz } = self;
        write!(f, "u-blox fix rate: found {found_hz} Hz, expected 1 to 10 Hz")
    }
}

impl core::error::Error for ConfigurationError {}

/// A configuration message in the format of the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Message {
    /// Buffer for the longest message: CFG-VALSET with three keys has 28 bytes.
    bytes: [u8; 32],
    length: usize,
}

impl Message {
    /// The message of class CFG with this `id` and `payload`.
    fn new(id: u8, payload: &[u8]) -> Self {
        let [low, high] = (payload.len() as u16).to_le_bytes();
        let mut message = Self { bytes: [0; 32], length: 0 };
        message.extend(&SYNC);
        message.extend(&[CFG, id, low, high]);
        message.extend(payload);
        let sum = checksum(message.as_bytes().get(2..).unwrap_or_default());
        message.extend(&sum);
        message
    }

    /// The bytes to write.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }

    fn extend(&mut self, bytes: &[u8]) {
        let room = self.bytes.iter_mut().skip(self.length);
        self.length += room.zip(bytes).map(|(room, byte)| *room = *byte).count();
    }

    fn is_answered_by(&self, answer: Acknowledgement) -> bool {
        self.as_bytes().get(2..4) == Some(&[answer.class, answer.id])
    }
}

/// The class of configuration messages.
const CFG: u8 = 0x06;
/// Id of CFG-MSG: rate of one kind of message.
const CFG_MSG: u8 = 0x01;
/// Id of CFG-RATE: rate of measurements and fixes.
const CFG_RATE: u8 = 0x08;
/// Id of CFG-VALSET: values of configuration keys.
const CFG_VALSET: u8 = 0x8A;

// Keys of CFG-VALSET. Source: u-blox, *M10 Interface Description*, UBX-21035062.
const RATE_MEAS: u32 = 0x3021_0001;
const MSGOUT_UBX_NAV_PVT_UART1: u32 = 0x2091_0007;
const UART1OUTPROT_NMEA: u32 = 0x1074_0002;

/// Message class of the NMEA sentences.
const NMEA_CLASS: u8 = 0xF0;
/// Number of NMEA sentences that receivers send by default: GGA, GLL, GSA, GSV, RMC, VTG. At 10 Hz they would fill the
/// serial line.
const NMEA_SENTENCES: u8 = 6;

/// Sets a receiver to NAV-PVT at a rate, with NMEA off, in its volatile memory.
///
/// Up to the M9 it uses CFG-RATE and CFG-MSG, one message after another, each with its acknowledgement. If the receiver
/// rejects CFG-RATE, one CFG-VALSET configures the receiver's first UART (from the M9 on).
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
    /// Switching the NMEA sentences off one after another.
    Nmea(u8),
    Keys,
    Done,
    Refused,
}

impl Configuration {
    /// Time after which an unanswered message is repeated, s.
    pub const RETRY_S: f64 = 1.0;

    /// A configuration for `rate_hz` fixes per second.
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

    /// Message to write to the port at `now`, if any. Takes the answers from `decoder`. Call it often until
    /// [`is_done`](Self::is_done) or [`is_refused`](Self::is_refused).
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

    /// Whether the receiver has rejected both methods.
    #[must_use]
    pub fn is_refused(&self) -> bool {
        self.step == Step::Refused
    }

    /// Number of messages sent. If it grows without end, the line is dead, the baud rate is wrong or the protocol is
    /// another.
    #[must_use]
    pub fn attempts(&self) -> u32 {
        self.attempts
    }

    fn message(&self) -> Option<Message> {
        let measure_rate_ms = 1_000 / u16::from(self.rate_hz.max(1));
        match self.step {
            Step::Rate => {
                let [low, high] = measure_rate_ms.to_le_bytes();
                // A fix from each measurement, aligned to GPS time.
                Some(Message::new(CFG_RATE, &[low, high, 1, 0, 1, 0]))
            }
            Step::Pvt => Some(message_rate(NAV_PVT, 1)),
            Step::Nmea(sentence) => Some(message_rate((NMEA_CLASS, sentence), 0)),
            Step::Keys => {
                let [low, high] = measure_rate_ms.to_le_bytes();
                let [r0, r1, r2, r3] = RATE_MEAS.to_le_bytes();
                let [p0, p1, p2, p3] = MSGOUT_UBX_NAV_PVT_UART1.to_le_bytes();
                let [n0, n1, n2, n3] = UART1OUTPROT_NMEA.to_le_bytes();
                // Version 0, to volatile memory; then each key with its value.
                #[rustfmt::skip]
                let payload = [
                    0, 1, 0, 0,
                    r0, r1, r2, r3, low, high,
                    p0, p1, p2, p3, 1,
                    n0, n1, n2, n3, 0,
                ];
                Some(Message::new(CFG_VALSET, &payload))
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

/// Sends a message with every `rate`-th fix, 0 for never.
fn message_rate((class, id): (u8, u8), rate: u8) -> Message {
    Message::new(CFG_MSG, &[class, id, rate])
}
