//! Decodes the bytes of the link to values and texts, in either protocol.

use hovernav::telemetry::frame::{self, Message};
use hovernav::telemetry::{Severity, Text};

use crate::frames::{self, Rigging, Values};
use crate::mavlink::{self, Said};
use crate::store::TextLevel;

/// The protocol of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Protocol {
    /// The packed telemetry frames of hovernav.
    Frames,
    /// MAVLink, 1 or 2.
    Mavlink,
}

/// A decoded item.
pub enum Arrived {
    /// Values, with the vehicle's time, s, if the message contains it.
    Values(Option<f64>, Values),
    /// A text.
    Text(TextLevel, String),
}

/// Counts of the stream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Number of bytes.
    pub bytes: u64,
    /// Number of complete frames.
    pub frames: u64,
    /// Number of damaged frames.
    pub damaged: u64,
    /// Number of frames missing in the sequence, including damaged frames.
    pub lost: u64,
}

/// A decoder that detects the protocol, unless it is given.
pub struct Decoder {
    rigging: Rigging,
    protocol: Option<Protocol>,
    frames: frame::Decoder,
    mavlink: mavlink::Decoder,
    /// The first pieces of an incomplete text.
    text: String,
    bytes: u64,
}

/// Length, bytes, after which further pieces of a text are dropped.
const LONGEST_TEXT: usize = 512;

impl Decoder {
    /// A decoder for a vehicle with this rigging; `protocol` if it is known.
    #[must_use]
    pub fn new(rigging: Rigging, protocol: Option<Protocol>) -> Self {
        Self {
            rigging,
            protocol,
            frames: frame::Decoder::default(),
            mavlink: mavlink::Decoder::default(),
            text: String::new(),
            bytes: 0,
        }
    }

    /// The protocol, once it is known.
    #[must_use]
    pub const fn protocol(&self) -> Option<Protocol> {
        self.protocol
    }

    /// The counts of the stream.
    #[must_use]
    pub fn counts(&self) -> Counts {
        let of_frames = self.frames.counts();
        let of_mavlink = &self.mavlink.counts;
        let (frames, damaged, lost) = match self.protocol {
            Some(Protocol::Frames) => (of_frames.frames, of_frames.damaged, of_frames.missing),
            Some(Protocol::Mavlink) => {
                (of_mavlink.messages, of_mavlink.damaged, of_mavlink.missing)
            }
            None => (0, 0, 0),
        };
        Counts { bytes: self.bytes, frames, damaged, lost }
    }

    /// Decodes bytes that arrived at `arrival_s`, s, and calls `arrived` for each item.
    pub fn receive(&mut self, bytes: &[u8], arrival_s: f64, mut arrived: impl FnMut(Arrived)) {
        self.bytes += bytes.len() as u64;
        if self.protocol != Some(Protocol::Mavlink) {
            for byte in bytes {
                let Some(Ok(message)) = self.frames.push_message(*byte) else { continue };
                self.protocol = Some(Protocol::Frames);
                match message {
                    Message::Snapshot(frame) => {
                        let values = frames::of_snapshot(&frame.snapshot, &self.rigging);
                        arrived(Arrived::Values(Some(frame.snapshot.time.seconds()), values));
                    }
                    Message::Supplement(supplement) => {
                        let values = frames::of_supplement(&supplement);
                        arrived(Arrived::Values(Some(supplement.time.seconds()), values));
                    }
                    Message::Text(text) => self.text(&text, &mut arrived),
                    _ => {}
                }
            }
        }
        if self.protocol != Some(Protocol::Frames) {
            self.mavlink.receive(bytes, arrival_s, |said| {
                arrived(match said {
                    Said::Values(time_s, values) => Arrived::Values(time_s, values),
                    Said::Text(level, text) => Arrived::Text(level, text),
                });
            });
            if self.mavlink.is_spoken {
                self.protocol = Some(Protocol::Mavlink);
            }
        }
    }

    fn text(&mut self, text: &Text, arrived: &mut impl FnMut(Arrived)) {
        if self.text.len() < LONGEST_TEXT {
            self.text.push_str(text.as_str());
        }
        if text.goes_on {
            return;
        }
        let level = match text.severity {
            Severity::Info => TextLevel::Info,
            Severity::Warning => TextLevel::Warning,
            Severity::Error => TextLevel::Error,
        };
        arrived(Arrived::Text(level, std::mem::take(&mut self.text)));
    }
}
