//! Replays the bytes of a flight record.

use std::collections::VecDeque;

use super::Device;
use hovernav::time::Time;

/// A device that replays recorded bytes at their arrival times and ignores the host.
#[derive(Clone, Debug)]
pub struct RecordedDevice {
    pieces: VecDeque<(Time, Vec<u8>)>,
    span: Option<(Time, Time)>,
}

impl RecordedDevice {
    /// A device that sends the recorded `pieces`, each with its time of arrival, in order of time.
    #[must_use]
    pub fn new(pieces: Vec<(Time, Vec<u8>)>) -> Self {
        let span = pieces.first().zip(pieces.last()).map(|(first, last)| (first.0, last.0));
        Self { pieces: pieces.into(), span }
    }
}

impl Device for RecordedDevice {
    fn receive(&mut self, _bytes: &[u8], _now: Time) {}

    fn next_transmission(&self) -> Option<Time> {
        self.pieces.front().map(|(time, _)| *time)
    }

    fn transmit(&mut self, now: Time, wire: &mut Vec<u8>) {
        let due = self.pieces.partition_point(|(time, _)| *time <= now);
        wire.extend(self.pieces.drain(..due).flat_map(|(_, bytes)| bytes));
    }

    fn span(&self) -> Option<(Time, Time)> {
        self.span
    }

    fn is_started(&self) -> bool {
        true
    }
}
