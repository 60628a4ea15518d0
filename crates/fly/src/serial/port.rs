//! A serial line that is reopened automatically.

use std::fmt;
use std::io;

use super::Clock;
use super::line::Line;
use super::port_config::{PortConfig, PortFault};
use hovernav::time::Time;

/// Wait after the first failure to open, s; it doubles up to [`LONGEST_BACK_OFF_S`].
const SHORTEST_BACK_OFF_S: f64 = 0.05;
/// Longest wait between attempts, s: a device that reconnects in flight is needed at once, and an attempt is cheap.
const LONGEST_BACK_OFF_S: f64 = 0.5;

/// Time for which a port must stay open to reset the back-off, s.
const STEADY_S: f64 = 1.0;

/// Number of bytes written at once. A terminal with room for one byte has room for all of them: drivers wake a writer
/// only when there is room for hundreds.
const WRITE_CHUNK: usize = 64;

/// A change of a port's state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PortEvent {
    /// The port was opened.
    Opened,
    /// The port cannot be opened. Reported at the first attempt and when the cause changes.
    CannotOpen(PortFault),
    /// The open port was lost.
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

/// Result of a read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Read {
    /// Bytes, at the front of the buffer.
    Bytes {
        /// Number of bytes, at least one.
        count: usize,
        /// Time at which the read returned: the arrival of the last byte plus the wake-up delay.
        arrival: Time,
    },
    /// No data until the deadline.
    Silent,
    /// The port changed.
    Changed(PortEvent),
}

/// Reasons why bytes were not written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum WriteError {
    /// The port is not open.
    Closed,
    /// The line accepted no more bytes until the deadline.
    Stuck {
        /// Number of bytes accepted.
        written: usize,
    },
    /// The port was lost during the write; the next read reports it, too.
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

/// Statistics of a port since its creation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PortCounts {
    /// Bytes read.
    pub bytes_read: u64,
    /// Bytes written.
    pub bytes_written: u64,
    /// Number of times the port was opened.
    pub opened: u64,
    /// Number of failed attempts to open the port.
    pub failed_to_open: u64,
    /// Number of times the port was lost.
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

/// A serial line that is opened when available, and reopened after a loss.
pub struct Port {
    config: PortConfig,
    clock: Clock,
    state: State,
    back_off_s: f64,
    /// An unreported change.
    pending: Option<PortEvent>,
    counts: PortCounts,
}

impl Port {
    /// The line of `config`; the first read or write opens it.
    #[must_use]
    pub fn new(config: PortConfig, clock: &Clock) -> Self {
        let state = State::Closed { retry: clock.now(), reported: None };
        let (back_off_s, counts) = (SHORTEST_BACK_OFF_S, PortCounts::default());
        Self { config, clock: clock.clone(), state, back_off_s, pending: None, counts }
    }

    /// Reads the available bytes, waiting until `deadline`, and returns as soon as data arrive or the port changes.
    /// Available bytes are read even if the deadline is past. A closed port is retried 50 ms after a failure; the
    /// wait doubles each time, up to 0.5 s.
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

    /// Writes `bytes`, waiting until `deadline` for the line to accept them, not to send them. A closed port is
    /// retried as by a read.
    ///
    /// # Errors
    /// [`WriteError`] if not all bytes were accepted.
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

    /// Whether the port was open at the last read or write.
    #[must_use]
    pub fn is_open(&self) -> bool {
        matches!(self.state, State::Open { .. })
    }

    /// Statistics of the port.
    #[must_use]
    pub fn counts(&self) -> PortCounts {
        self.counts
    }

    /// Path and settings of the line.
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

/// Whether the error is temporary, so that the call is repeated: no data, or an interrupt by a signal.
fn is_passing(error: &io::Error) -> bool {
    use io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    matches!(error.kind(), TimedOut | Interrupted | WouldBlock)
}
