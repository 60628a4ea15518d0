//! A receiver decoder for any protocol.

#[cfg(feature = "nmea")]
use super::nmea;
#[cfg(feature = "tsip")]
use super::tsip;
#[cfg(feature = "ubx")]
use super::ubx;
use super::{MessageCounts, ReceiverFix, ReceiverHeading};
use crate::time::Time;

/// Protocol of a receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Protocol {
    /// Trimble Standard Interface Protocol.
    #[cfg(feature = "tsip")]
    Tsip,
    /// NMEA 0183 sentences.
    #[cfg(feature = "nmea")]
    Nmea,
    /// u-blox binary.
    #[cfg(feature = "ubx")]
    Ubx,
}

/// A decoder chosen at run time. If the protocol is known in advance, use its own `Decoder`, which has the same three
/// methods.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "one receiver exists per flight, and no heap does")]
pub enum Receiver {
    /// See [`tsip::Decoder`].
    #[cfg(feature = "tsip")]
    Tsip(tsip::Decoder),
    /// See [`nmea::Decoder`].
    #[cfg(feature = "nmea")]
    Nmea(nmea::Decoder),
    /// See [`ubx::Decoder`].
    #[cfg(feature = "ubx")]
    Ubx(ubx::Decoder),
}

impl Receiver {
    /// Creates a decoder for `protocol`.
    #[must_use]
    pub fn new(protocol: Protocol) -> Self {
        match protocol {
            #[cfg(feature = "tsip")]
            Protocol::Tsip => Self::Tsip(tsip::Decoder::default()),
            #[cfg(feature = "nmea")]
            Protocol::Nmea => Self::Nmea(nmea::Decoder::default()),
            #[cfg(feature = "ubx")]
            Protocol::Ubx => Self::Ubx(ubx::Decoder::default()),
        }
    }

    /// Consumes `bytes`, which arrived at `arrival`, up to the end of the next epoch. `None` when all bytes are
    /// consumed; call again until then.
    pub fn read(&mut self, bytes: &mut &[u8], arrival: Time) -> Option<ReceiverFix> {
        match self {
            #[cfg(feature = "tsip")]
            Self::Tsip(decoder) => decoder.read(bytes, arrival),
            #[cfg(feature = "nmea")]
            Self::Nmea(decoder) => decoder.read(bytes, arrival),
            #[cfg(feature = "ubx")]
            Self::Ubx(decoder) => decoder.read(bytes, arrival),
        }
    }

    /// The fix of the incomplete epoch. Use it when the line is silent until the next epoch, or at the end of a log.
    pub fn flush(&mut self) -> Option<ReceiverFix> {
        match self {
            #[cfg(feature = "tsip")]
            Self::Tsip(decoder) => decoder.flush(),
            #[cfg(feature = "nmea")]
            Self::Nmea(decoder) => decoder.flush(),
            #[cfg(feature = "ubx")]
            Self::Ubx(decoder) => decoder.flush(),
        }
    }

    /// Takes the last heading of two antennas, once; only u-blox receivers give one.
    pub fn take_antenna_heading(&mut self) -> Option<ReceiverHeading> {
        match self {
            #[cfg(feature = "ubx")]
            Self::Ubx(decoder) => decoder.take_antenna_heading(),
            #[cfg(any(feature = "tsip", feature = "nmea"))]
            _ => None,
        }
    }

    /// Counts of all messages since the start.
    #[must_use]
    pub fn counts(&self) -> MessageCounts {
        match self {
            #[cfg(feature = "tsip")]
            Self::Tsip(decoder) => decoder.counts(),
            #[cfg(feature = "nmea")]
            Self::Nmea(decoder) => decoder.counts(),
            #[cfg(feature = "ubx")]
            Self::Ubx(decoder) => decoder.counts(),
        }
    }
}
