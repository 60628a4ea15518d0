//! A serial line with a transmission time per byte.

use std::collections::VecDeque;

use hovernav::time::Time;

/// Longest backlog of a line, s; further messages are lost.
const LONGEST_BACKLOG_S: f64 = 1.0;

/// The direction of a serial line from the device to the host.
#[derive(Clone, Debug)]
pub(super) struct Line {
    byte_s: f64,
    /// Arrival time of the last queued byte.
    free: Time,
    messages: VecDeque<Message>,
}

#[derive(Clone, Debug)]
struct Message {
    /// Time at which the first byte of the message begins.
    start: Time,
    bytes: Vec<u8>,
    /// Number of bytes already taken.
    taken: usize,
}

impl Line {
    /// A line of `baud` on which a byte has `bits` bits, with start and stop bits.
    pub fn new(baud: u32, bits: u32) -> Self {
        let byte_s = f64::from(bits) / f64::from(baud);
        Self { byte_s, free: Time::from_nanoseconds(i64::MIN), messages: VecDeque::new() }
    }

    /// Queues a message that is ready at `now`.
    pub fn send(&mut self, bytes: Vec<u8>, now: Time) {
        let start = self.free.max(now);
        if !bytes.is_empty() && start - now <= LONGEST_BACKLOG_S {
            self.free = start + self.byte_s * bytes.len() as f64;
            self.messages.push_back(Message { start, bytes, taken: 0 });
        }
    }

    /// Time at which to take the next bytes: at the arrival of the first byte of a message, then of its last.
    pub fn next(&self) -> Option<Time> {
        let message = self.messages.front()?;
        let bytes = if message.taken == 0 { 1 } else { message.bytes.len() };
        Some(self.arrival(message, bytes))
    }

    /// Whether everything sent has arrived.
    pub fn is_idle(&self) -> bool {
        self.messages.is_empty()
    }

    /// Appends the bytes that have arrived by `now` to `wire`.
    pub fn take(&mut self, now: Time, wire: &mut Vec<u8>) {
        while let Some(mut message) = self.messages.pop_front() {
            while let Some(byte) = message.bytes.get(message.taken)
                && self.arrival(&message, message.taken + 1) <= now
            {
                wire.push(*byte);
                message.taken += 1;
            }
            if message.taken < message.bytes.len() {
                self.messages.push_front(message);
                return;
            }
        }
    }

    /// Arrival time of the first `bytes` bytes of the message.
    fn arrival(&self, message: &Message, bytes: usize) -> Time {
        message.start + self.byte_s * bytes as f64
    }
}
