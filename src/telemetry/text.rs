//! Text messages about events.

use super::wire::Codec;
use crate::time::Time;

/// Number of bytes of text in one frame.
pub const TEXT: usize = 64;

/// Severity of a text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Normal operation.
    #[default]
    Info,
    /// The flight continues with reduced performance.
    Warning,
    /// A function is lost.
    Error,
}

impl Severity {
    const ALL: [Self; 3] = [Self::Info, Self::Warning, Self::Error];
}

/// A line of text, or a piece of a longer line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Text {
    /// Time of the event, on the flight's clock.
    pub time: Time,
    /// Severity of the event.
    pub severity: Severity,
    /// Whether the next text continues the same line.
    pub goes_on: bool,
    /// Text in UTF-8, padded with zeros.
    pub(super) bytes: [u8; TEXT],
}

impl Text {
    /// Text with the longest beginning of `line` that fits into one frame, and the rest of `line`. The cut is between
    /// characters.
    #[must_use]
    pub fn first_of(time: Time, severity: Severity, line: &str) -> (Self, &str) {
        let end = (0..=TEXT).rev().find(|&end| line.is_char_boundary(end)).unwrap_or(0);
        let (now, rest) = line.split_at_checked(end.min(line.len())).unwrap_or((line, ""));
        let mut bytes = [0; TEXT];
        for (slot, byte) in bytes.iter_mut().zip(now.bytes()) {
            *slot = byte;
        }
        (Self { time, severity, goes_on: !rest.is_empty(), bytes }, rest)
    }

    /// The text; empty if it is not UTF-8.
    #[must_use]
    pub fn as_str(&self) -> &str {
        str::from_utf8(&self.bytes).map(|text| text.trim_end_matches('\0')).unwrap_or_default()
    }

    pub(super) const fn empty() -> Self {
        Self { time: Time::ZERO, severity: Severity::Info, goes_on: false, bytes: [0; TEXT] }
    }

    /// Layout of a text: packs or unpacks all fields in their order. `None` for an unknown code of the severity.
    pub(super) fn walk(&mut self, codec: &mut Codec<'_>, header: &mut [u8; 2]) -> Option<()> {
        codec.bytes(header);
        let mut codes = [self.severity as u8, u8::from(self.goes_on)];
        codec.bytes(&mut codes);
        let [severity, goes_on] = codes;
        self.severity = *Severity::ALL.get(usize::from(severity))?;
        self.goes_on = goes_on != 0;
        codec.time(&mut self.time);
        codec.bytes(&mut self.bytes);
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_cut_between_characters_and_nothing_of_it_is_lost() {
        let line = "ä".repeat(70) + "end";
        let (mut rest, mut told) = (&line[..], String::new());
        loop {
            let (text, left) = Text::first_of(Time::ZERO, Severity::Info, rest);
            told += text.as_str();
            assert_eq!(text.goes_on, !left.is_empty());
            if left.is_empty() {
                break;
            }
            rest = left;
        }
        assert_eq!(told, line);
        assert_eq!(Text::first_of(Time::ZERO, Severity::Info, "").0.as_str(), "");
    }
}
