//! The device's end of a line: a pseudo-terminal, or a line of an emulation.

use std::path::Path;

use super::error::PlayError;
use super::terminal::{Received, Terminal};
use crate::serial::{Clock, DeviceEnd};
use hovernav::time::Time;

/// Interval at which an unopened port is checked, s.
const LOOK_S: f64 = 0.005;

/// The device's end of a line; dropping it removes the line.
#[derive(Debug)]
pub(super) enum FarEnd {
    Terminal(Terminal),
    Emulated(DeviceEnd),
}

impl FarEnd {
    /// Creates a line at `path`.
    pub fn open(path: &Path, clock: &Clock) -> Result<Self, PlayError> {
        if !clock.is_emulated() {
            return Ok(Self::Terminal(Terminal::open(path)?));
        }
        let occupied = || PlayError::Occupied { path: path.into() };
        Ok(Self::Emulated(DeviceEnd::new(path, clock).ok_or_else(occupied)?))
    }

    /// Sends as many bytes as the host's port accepts at once; returns their number.
    pub fn send(&mut self, bytes: &[u8]) -> Result<usize, PlayError> {
        match self {
            Self::Terminal(terminal) => terminal.send(bytes),
            Self::Emulated(end) => Ok(end.send(bytes)),
        }
    }

    /// Waits until `deadline` for bytes from the host.
    pub fn receive(
        &mut self,
        buffer: &mut [u8],
        clock: &Clock,
        deadline: Time,
    ) -> Result<Received, PlayError> {
        let received = match self {
            Self::Terminal(terminal) => terminal.receive(buffer, clock.until(deadline))?,
            Self::Emulated(end) => match end.receive(buffer, deadline) {
                Some(count @ 1..) => Received::Bytes(count),
                Some(0) => Received::Nothing,
                None => Received::Closed,
            },
        };
        if received == Received::Closed {
            clock.sleep_until(deadline.min(clock.now() + LOOK_S * clock.speed()));
        }
        Ok(received)
    }
}
