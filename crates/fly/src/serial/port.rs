//! One serial line that comes back by itself.

use std::fmt;
use std::io;
use std::path::Path;

use serialport::Parity;

use super::Clock;
use super::line::Line;
use hovernav::time::Time;

/// The wait after a first failure to open, s; it doubles up to [`LONGEST_BACK_OFF_S`].
const SHORTEST_BACK_OFF_S: f64 = 0.05;
/// A device in flight that is plugged in again is wanted at once, and looking for it costs nothing.
const LONGEST_BACK_OFF_S: f64 = 0.5;

/// A port that was lost sooner than this after it opened is opened again no sooner than the back-off
/// had come to, s.
const STEADY_S: f64 = 1.0;

/// Bytes written at once. A terminal that takes a byte takes as many without blocking: drivers wake
/// a writer only when there is room for hundreds.
const WRITE_CHUNK: usize = 64;

/// Which line, and how it is set: eight data bits, one stop bit, no flow control.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct PortConfig {
    /// The device, as `/dev/ttyUSB0` or `COM3`; a link is followed each time the port is opened.
    pub path: String,
    /// Bits per second.
    pub baud: u32,
    /// The parity bit.
    pub parity: Parity,
}

impl PortConfig {
    /// The line at `path` at `baud` bits per second, without a parity bit.
    pub fn new(path: impl AsRef<Path>, baud: u32) -> Self {
        let path = path.as_ref().to_string_lossy().into_owned();
        Self { path, baud, parity: Parity::None }
    }

    /// The same with another parity bit.
    #[must_use]
    pub fn with_parity(self, parity: Parity) -> Self {
        Self { parity, ..self }
    }
}

/// Why a port is not open.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PortFault {
    /// There is no such device.
    Missing,
    /// We are not allowed to open it.
    Denied,
    /// Another program has it.
    Busy,
    /// The device went away.
    HungUp,
    /// Anything else, in the system's words.
    Other(String),
}

impl fmt::Display for PortFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Missing => "there is no such device",
            Self::Denied => "permission denied",
            Self::Busy => "another program has it",
            Self::HungUp => "the device went away",
            Self::Other(text) => text,
        })
    }
}

impl std::error::Error for PortFault {}

/// A change of a port's state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PortEvent {
    /// It is open.
    Opened,
    /// It cannot be opened. Reported at the first attempt and whenever the cause changes.
    CannotOpen(PortFault),
    /// It was open, and is no more.
    Lost(PortFault),
}

impl fmt::Display for PortEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Opened => f.write_str("open"),
            Self::CannotOpen(fault) => write!(f, "cannot be opened: {fault}"),
            Self::Lost(fault) => write!(f, "lost: {fault}"),
        }
    }
}

/// What a read came to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Read {
    /// Bytes, at the front of the buffer.
    Bytes {
        /// How many, at least one.
        count: usize,
        /// When the read returned: after the last byte came, by the time it took to wake up.
        arrival: Time,
    },
    /// Nothing until the deadline.
    Silent,
    /// The port changed.
    Changed(PortEvent),
}

/// Why bytes were not written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum WriteError {
    /// The port is not open.
    Closed,
    /// The line took no more until the deadline.
    Stuck {
        /// Bytes that it took.
        written: usize,
    },
    /// The port was lost over it; the next read says so too.
    Lost(PortFault),
}

impl fmt::Display for WriteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Closed => f.write_str("not written: the port is not open"),
            Self::Stuck { written } => {
                write!(f, "only {written} bytes written before the deadline")
            }
            Self::Lost(fault) => write!(f, "not written: {fault}"),
        }
    }
}

impl std::error::Error for WriteError {}

/// What a port did since it was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PortCounts {
    /// Bytes read.
    pub bytes_read: u64,
    /// Bytes written.
    pub bytes_written: u64,
    /// Times it was opened.
    pub opened: u64,
    /// Attempts to open it that failed.
    pub failed_to_open: u64,
    /// Times it was lost.
    pub lost: u64,
}

enum State {
    Open {
        line: Line,
        since: Time,
    },
    Closed {
        retry: Time,
        /// The last cause that was reported.
        reported: Option<PortFault>,
    },
}

/// A serial line that is opened when it is there, and again when it comes back.
pub struct Port {
    config: PortConfig,
    clock: Clock,
    state: State,
    back_off_s: f64,
    /// A change that has yet to be reported.
    pending: Option<PortEvent>,
    counts: PortCounts,
}

impl Port {
    /// The line of `config`, to be opened by the first read or write.
    #[must_use]
    pub fn new(config: PortConfig, clock: &Clock) -> Self {
        let state = State::Closed { retry: clock.now(), reported: None };
        let (back_off_s, counts) = (SHORTEST_BACK_OFF_S, PortCounts::default());
        Self { config, clock: clock.clone(), state, back_off_s, pending: None, counts }
    }

    /// Reads what there is, waiting for it up to `deadline`, and returns as soon as anything comes or
    /// the port changes. What has come is read even if the deadline is past. A port that is not open
    /// is tried 50 ms after it failed, then after twice as long each time, up to 0.5 s.
    pub fn read_until(&mut self, buffer: &mut [u8], deadline: Time) -> Read {
        loop {
            if let Some(event) = self.pending.take() {
                return Read::Changed(event);
            }
            match &mut self.state {
                State::Open { line, .. } => match line.read(buffer, &self.clock, deadline) {
                    Ok(0) => self.lose(PortFault::HungUp),
                    Ok(count) => {
                        self.counts.bytes_read += count as u64;
                        return Read::Bytes { count, arrival: self.clock.now() };
                    }
                    Err(error) if is_passing(&error) => {
                        if self.clock.now() >= deadline {
                            return Read::Silent;
                        }
                    }
                    Err(error) => self.lose(error.into()),
                },
                State::Closed { retry, .. } => {
                    let retry = *retry;
                    if self.clock.now() >= retry {
                        self.open();
                    } else if self.clock.now() >= deadline {
                        return Read::Silent;
                    } else {
                        self.clock.sleep_until(retry.min(deadline));
                    }
                }
            }
        }
    }

    /// Writes `bytes`, waiting up to `deadline` for the line to take them; not for them to be sent. A
    /// port that is not open is tried when its time has come, as by a read.
    ///
    /// # Errors
    /// [`WriteError`]: why not all of them were taken.
    pub fn write(&mut self, bytes: &[u8], deadline: Time) -> Result<(), WriteError> {
        if let State::Closed { retry, .. } = self.state
            && self.pending.is_none()
            && self.clock.now() >= retry
        {
            self.open();
        }
        let State::Open { line, .. } = &mut self.state else { return Err(WriteError::Closed) };
        let mut written = 0;
        while let Some(rest @ [_, ..]) = bytes.get(written..) {
            let chunk = &rest[..rest.len().min(WRITE_CHUNK)];
            match line.write(chunk, &self.clock, deadline) {
                Ok(count) => {
                    written += count;
                    self.counts.bytes_written += count as u64;
                }
                Err(error) if is_passing(&error) => {
                    if self.clock.now() >= deadline {
                        return Err(WriteError::Stuck { written });
                    }
                }
                Err(error) => {
                    let fault = PortFault::from(error);
                    self.lose(fault.clone());
                    return Err(WriteError::Lost(fault));
                }
            }
        }
        Ok(())
    }

    /// Whether the port is open, as far as is known.
    #[must_use]
    pub fn is_open(&self) -> bool {
        matches!(self.state, State::Open { .. })
    }

    /// What the port did so far.
    #[must_use]
    pub fn counts(&self) -> PortCounts {
        self.counts
    }

    /// Which line it is.
    #[must_use]
    pub fn config(&self) -> &PortConfig {
        &self.config
    }

    fn open(&mut self) {
        let opened = Line::open(&self.config, &self.clock);
        let now = self.clock.now();
        match opened {
            Ok(line) => {
                self.state = State::Open { line, since: now };
                self.counts.opened += 1;
                self.pending = Some(PortEvent::Opened);
            }
            Err(fault) => {
                self.counts.failed_to_open += 1;
                if let State::Closed { reported, .. } = &self.state
                    && reported.as_ref() != Some(&fault)
                {
                    self.pending = Some(PortEvent::CannotOpen(fault.clone()));
                }
                self.state = State::Closed { retry: now + self.back_off_s, reported: Some(fault) };
                self.back_off_s = (2.0 * self.back_off_s).min(LONGEST_BACK_OFF_S);
            }
        }
    }

    fn lose(&mut self, fault: PortFault) {
        let now = self.clock.now();
        if let State::Open { line, since } = &self.state {
            line.clear_output();
            if now - *since >= STEADY_S {
                self.back_off_s = SHORTEST_BACK_OFF_S;
            }
        }
        self.state = State::Closed { retry: now + self.back_off_s, reported: None };
        self.back_off_s = (2.0 * self.back_off_s).min(LONGEST_BACK_OFF_S);
        self.counts.lost += 1;
        self.pending = Some(PortEvent::Lost(fault));
    }
}

impl fmt::Debug for Port {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Port")
            .field("config", &self.config)
            .field("is_open", &self.is_open())
            .field("counts", &self.counts)
            .finish_non_exhaustive()
    }
}

/// Whether to try again: nothing came, or a signal did.
fn is_passing(error: &io::Error) -> bool {
    use io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    matches!(error.kind(), TimedOut | Interrupted | WouldBlock)
}
