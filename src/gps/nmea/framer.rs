//! Sentences `$body*hh` from bytes; the checksum is required.

use crate::time::Time;

/// Length of the longest accepted body. The standard allows 82 characters in a sentence; receivers send up to 100.
const MAX_BODY: usize = 128;

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    /// Outside a sentence, before a `$`.
    Outside,
    /// In the body, between `$` and `*`.
    Body,
    /// In the checksum: before its first digit, `None`, or before its second digit, with the value of the first.
    Checksum(Option<u8>),
}

/// The text between `$` and `*`, with a valid checksum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line<'a> {
    pub body: &'a [u8],
    /// Arrival of the `$`.
    pub arrival: Time,
}

/// Finds sentences in a stream that arrives in any pieces, with any bytes between the sentences.
#[derive(Clone, Debug)]
pub(super) struct Framer {
    state: State,
    body: [u8; MAX_BODY],
    length: usize,
    sum: u8,
    arrival: Time,
    broken: u32,
}

impl Default for Framer {
    fn default() -> Self {
        Self {
            state: State::Outside,
            body: [0; MAX_BODY],
            length: 0,
            sum: 0,
            arrival: Time::ZERO,
            broken: 0,
        }
    }
}

impl Framer {
    /// Consumes `bytes` up to the end of the next sentence; `None` when all bytes are consumed.
    pub fn next<'a>(&'a mut self, bytes: &mut &[u8], arrival: Time) -> Option<Line<'a>> {
        // Iterations: one per byte.
        loop {
            let (byte, rest) = bytes.split_first()?;
            *bytes = rest;
            if self.advance(*byte, arrival) {
                break;
            }
        }
        Some(Line { body: self.body.get(..self.length)?, arrival: self.arrival })
    }

    /// Number of sentences cut off, or with a missing or wrong checksum.
    pub fn broken(&self) -> u32 {
        self.broken
    }

    /// Processes one byte; returns whether it completes a valid sentence.
    fn advance(&mut self, byte: u8, arrival: Time) -> bool {
        match (self.state, byte) {
            (State::Outside, b'$') => self.start(arrival),
            (State::Outside, _) => {}
            (_, b'$') => {
                self.give_up();
                self.start(arrival);
            }
            (State::Body, b'*') => self.state = State::Checksum(None),
            (State::Body, b' '..=b'~') => {
                if let Some(room) = self.body.get_mut(self.length) {
                    *room = byte;
                    self.length += 1;
                    self.sum ^= byte;
                } else {
                    self.give_up();
                }
            }
            (State::Checksum(first), _) => match (hexadecimal(byte), first) {
                (Some(digit), None) => self.state = State::Checksum(Some(digit)),
                (Some(digit), Some(first)) if (first << 4 | digit) == self.sum => {
                    self.state = State::Outside;
                    return true;
                }
                _ => self.give_up(),
            },
            (State::Body, _) => self.give_up(),
        }
        false
    }

    fn start(&mut self, arrival: Time) {
        self.state = State::Body;
        self.length = 0;
        self.sum = 0;
        self.arrival = arrival;
    }

    fn give_up(&mut self) {
        self.state = State::Outside;
        self.broken = self.broken.saturating_add(1);
    }
}

fn hexadecimal(byte: u8) -> Option<u8> {
    match byte {
        b'0'..=b'9' => Some(byte - b'0'),
        b'a'..=b'f' => Some(byte - b'a' + 10),
        b'A'..=b'F' => Some(byte - b'A' + 10),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bodies(stream: &[u8]) -> Vec<String> {
        let mut framer = Framer::default();
        let mut bytes = stream;
        let mut found = Vec::new();
        while let Some(line) = framer.next(&mut bytes, Time::ZERO) {
            found.push(String::from_utf8(line.body.to_vec()).unwrap());
        }
        found
    }

    #[test]
    fn a_sentence_without_a_checksum_that_holds_is_not_taken() {
        assert_eq!(bodies(b"$GPABC,1*4A\r\n"), ["GPABC,1"]);
        assert_eq!(bodies(b"$GPABC,1*4a\n"), ["GPABC,1"]);
        assert!(bodies(b"$GPABC,1*4B\r\n").is_empty());
        assert!(bodies(b"$GPABC,1\r\n*4A").is_empty());
        assert!(bodies(b"$GPABC,1*\r\n4A").is_empty());
    }

    #[test]
    fn noise_and_broken_sentences_do_not_hide_the_next() {
        assert_eq!(bodies(b"\xff\x00*4A$GPA$GP\x01BC,$GPABC,1*4A"), ["GPABC,1"]);
        let mut long = vec![b'$'];
        long.extend([b'A'; MAX_BODY + 1]);
        long.extend(b"$GPABC,1*4A");
        assert_eq!(bodies(&long), ["GPABC,1"]);
    }
}
