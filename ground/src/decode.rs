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
    /// First piece of an incomplete line, and the text of the line up to now.
    line: Option<(Text, String)>,
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
            line: None,
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

    /// Joins the pieces of a line, which have one time and severity. A line whose last piece is lost ends with "…".
    fn text(&mut self, text: &Text, arrived: &mut impl FnMut(Arrived)) {
        if let Some((begun, line)) = self
            .line
            .take_if(|(begun, _)| (begun.time, begun.severity) != (text.time, text.severity))
        {
            arrived(Arrived::Text(level(begun.severity), line + "…"));
        }
        let (_, line) = self.line.get_or_insert_with(|| (*text, String::new()));
        if line.len() < LONGEST_TEXT {
            line.push_str(text.as_str());
        }
        if let Some((_, line)) = self.line.take_if(|_| !text.goes_on) {
            arrived(Arrived::Text(level(text.severity), line));
        }
    }
}

const fn level(severity: Severity) -> TextLevel {
    match severity {
        Severity::Info => TextLevel::Info,
        Severity::Warning => TextLevel::Warning,
        Severity::Error => TextLevel::Error,
    }
}

#[cfg(test)]
mod tests {
    use hovernav::time::Time;

    use super::*;

    #[test]
    fn a_line_whose_last_piece_is_lost_joins_no_other_line() {
        let line = "the pilot flies: the attitude is not known; fly by hand and land. ".repeat(4);
        let (first, rest) = Text::first_of(Time::ZERO + 1.0, Severity::Error, &line);
        assert!(first.goes_on && !rest.is_empty());
        let (second, _) = Text::first_of(Time::ZERO + 2.0, Severity::Info, "engaged");
        let mut decoder = Decoder::new(Rigging::default(), None);
        let mut lines = Vec::new();
        for text in [first, second] {
            decoder.text(&text, &mut |arrived| {
                if let Arrived::Text(level, line) = arrived {
                    lines.push((level, line));
                }
            });
        }
        let cut = format!("{}…", first.as_str());
        assert_eq!(lines, [(TextLevel::Error, cut), (TextLevel::Info, "engaged".to_owned())]);
    }
}
