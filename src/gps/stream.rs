//! One receiver, whichever protocol it speaks.

use super::{Counts, ReceiverFix, nmea, tsip, ubx};
use crate::time::Time;

/// The language of a receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Protocol {
    /// Trimble Standard Interface Protocol.
    Tsip,
    /// NMEA 0183 sentences.
    Nmea,
    /// u-blox binary.
    Ubx,
}

/// A decoder chosen at run time; where the protocol is known beforehand, take that protocol's own
/// `Decoder`, which has the same three methods.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "one receiver exists per flight, and no heap does")]
pub enum Receiver {
    /// See [`tsip::Decoder`].
    Tsip(tsip::Decoder),
    /// See [`nmea::Decoder`].
    Nmea(nmea::Decoder),
    /// See [`ubx::Decoder`].
    Ubx(ubx::Decoder),
}

impl Receiver {
    /// A decoder that has seen nothing yet.
    #[must_use]
    pub fn new(protocol: Protocol) -> Self {
        match protocol {
            Protocol::Tsip => Self::Tsip(tsip::Decoder::default()),
            Protocol::Nmea => Self::Nmea(nmea::Decoder::default()),
            Protocol::Ubx => Self::Ubx(ubx::Decoder::default()),
        }
    }

    /// Consumes `bytes`, which arrived at `arrival`, up to the end of the next epoch; `None` when
    /// they are used up. Call again until then.
    pub fn read(&mut self, bytes: &mut &[u8], arrival: Time) -> Option<ReceiverFix> {
        match self {
            Self::Tsip(decoder) => decoder.read(bytes, arrival),
            Self::Nmea(decoder) => decoder.read(bytes, arrival),
            Self::Ubx(decoder) => decoder.read(bytes, arrival),
        }
    }

    /// The epoch still being put together, as far as it came: for when the line has fallen silent
    /// until the next epoch, or a log is at its end.
    pub fn flush(&mut self) -> Option<ReceiverFix> {
        match self {
            Self::Tsip(decoder) => decoder.flush(),
            Self::Nmea(decoder) => decoder.flush(),
            Self::Ubx(decoder) => decoder.flush(),
        }
    }

    /// What became of all messages so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        match self {
            Self::Tsip(decoder) => decoder.counts(),
            Self::Nmea(decoder) => decoder.counts(),
            Self::Ubx(decoder) => decoder.counts(),
        }
    }
}
