//! A serial line: every byte takes its time.

use std::collections::VecDeque;

use hovernav::time::Time;

/// A device that has this much more to say than the line carries loses what comes on top, s.
const LONGEST_BACKLOG_S: f64 = 1.0;

/// The direction from a device to its host.
#[derive(Clone, Debug)]
pub(super) struct Line {
    byte_s: f64,
    /// When the last byte will have arrived.
    free: Time,
    messages: VecDeque<Message>,
}

#[derive(Clone, Debug)]
struct Message {
    /// When its first byte begins.
    start: Time,
    bytes: Vec<u8>,
    /// Bytes that have been taken.
    taken: usize,
}

impl Line {
    /// A line of `baud`, on which a byte is `bits` long, start and stop included.
    pub fn new(baud: u32, bits: u32) -> Self {
        let byte_s = f64::from(bits) / f64::from(baud);
        Self { byte_s, free: Time::from_nanoseconds(i64::MIN), messages: VecDeque::new() }
    }

    /// Queues a message that is ready `now`.
    pub fn send(&mut self, bytes: Vec<u8>, now: Time) {
        let start = self.free.max(now);
        if !bytes.is_empty() && start - now <= LONGEST_BACKLOG_S {
            self.free = start + self.byte_s * bytes.len() as f64;
            self.messages.push_back(Message { start, bytes, taken: 0 });
        }
    }

    /// When to take the next bytes: as a message's first byte arrives, and as its last does.
    pub fn next(&self) -> Option<Time> {
        let message = self.messages.front()?;
        let bytes = if message.taken == 0 { 1 } else { message.bytes.len() };
        Some(self.arrival(message, bytes))
    }

    /// Whether all that was sent has arrived.
    pub fn is_idle(&self) -> bool {
        self.messages.is_empty()
    }

    /// Appends what has arrived by `now` to `wire`.
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

    /// When so many bytes of the message have arrived.
    fn arrival(&self, message: &Message, bytes: usize) -> Time {
        message.start + self.byte_s * bytes as f64
    }
}
