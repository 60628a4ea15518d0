//! Sets the inertial unit to a known mode, from any state.

use core::fmt;

use super::packet::Mode;
use crate::time::Time;

/// A command to the inertial unit: one ASCII byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Command {
    /// Test for a reply. Early firmware also returns to voltage mode.
    Ping,
    /// Send packets of this mode from now on.
    SetMode(Mode),
    /// Send packets only on request.
    Polled,
    /// Send packets without requests.
    Continuous,
    /// Send one packet; in continuous mode, stop sending.
    Request,
}

impl Command {
    /// The byte to send.
    #[must_use]
    pub const fn byte(self) -> u8 {
        match self {
            Self::Ping => b'R',
            Self::SetMode(Mode::Voltage) => b'r',
            Self::SetMode(Mode::Scaled) => b'c',
            Self::SetMode(Mode::Angle) => b'a',
            Self::Polled => b'P',
            Self::Continuous => b'C',
            Self::Request => b'G',
        }
    }

    /// The byte with which the inertial unit replies; `None` for commands without a reply.
    #[must_use]
    pub const fn reply(self) -> Option<u8> {
        match self {
            Self::Ping => Some(b'H'),
            Self::SetMode(Mode::Voltage) => Some(b'R'),
            Self::SetMode(Mode::Scaled) => Some(b'C'),
            Self::SetMode(Mode::Angle) => Some(b'A'),
            Self::Polled | Self::Continuous | Self::Request => None,
        }
    }
}

/// Fault of the last attempt to start the inertial unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StartupError {
    /// Bytes continued to arrive after the inertial unit was commanded to stop.
    NeverQuiet,
    /// No reply arrived before the timeout.
    NoReply {
        /// The command.
        command: Command,
    },
    /// The bytes received are not the single byte of the reply.
    WrongReply {
        /// The command.
        command: Command,
        /// The first byte received.
        found: u8,
        /// Number of bytes received.
        bytes: u32,
    },
}

impl fmt::Display for StartupError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NeverQuiet => f.write_str("bytes kept coming after the commands to stop"),
            Self::NoReply { command } => {
                write!(f, "no reply to '{}'", char::from(command.byte()))
            }
            Self::WrongReply { command, found, bytes } => write!(
                f,
                "{bytes} bytes from {found:#04x} on in reply to '{}'",
                char::from(command.byte())
            ),
        }
    }
}

impl core::error::Error for StartupError {}

/// Shortest silence that proves that the inertial unit does not stream, s. While streaming, its pauses are shorter.
const QUIET_S: f64 = 0.05;

/// Timeout of the wait for this silence, s; after it a request is sent, which stops the stream.
const DRAIN_S: f64 = 0.3;

/// Timeout of a reply, s.
const REPLY_S: f64 = 0.5;

/// Number of attempts.
const ATTEMPTS: u32 = 3;

/// Next action of the caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StartupAction {
    /// Write the command's byte to the inertial unit, then call again.
    Write(Command),
    /// Read until bytes arrive or this time is reached, pass the bytes on, then call again.
    ReadUntil(Time),
    /// The inertial unit is silent, in polled mode, and its packets will have the requested mode.
    Ready,
    /// All attempts failed; the fault is from the last attempt.
    Failed(StartupError),
}

#[derive(Clone, Copy, Debug)]
enum Step {
    /// Send this command next.
    Send(Command),
    /// Wait for silence.
    Drain {
        since: Time,
        insisted: bool,
    },
    /// Wait for the reply to this command, and for the silence after it.
    Listen {
        command: Command,
        since: Time,
        first: Option<u8>,
        bytes: u32,
    },
    Ready,
    Failed(StartupError),
}

/// The start-up sequence: stop the stream, find the inertial unit, set the mode.
///
/// The sequence performs no input or output itself. Call [`Startup::next_action`], carry the action out, and pass the
/// bytes read to [`Startup::receive`].
///
/// The inertial unit may be streaming in any mode at the start. A reply is one byte that also occurs in packets. A
/// reply is therefore expected only after 50 ms of silence, and accepted only as a single byte. An attempt takes at
/// most 1.7 s; there are three.
#[derive(Clone, Debug)]
pub struct Startup {
    mode: Mode,
    attempts_left: u32,
    /// Arrival of the last byte.
    last_byte: Time,
    step: Step,
}

impl Startup {
    /// Creates a start-up sequence that begins `now` and sets packets of `mode`.
    #[must_use]
    pub const fn new(mode: Mode, now: Time) -> Self {
        Self {
            mode,
            attempts_left: ATTEMPTS - 1,
            last_byte: now,
            step: Step::Send(Command::Polled),
        }
    }

    /// Processes bytes that were read; the last byte arrived `now`.
    pub fn receive(&mut self, read: &[u8], now: Time) {
        if read.is_empty() {
            return;
        }
        self.last_byte = now;
        if let Step::Listen { first, bytes, .. } = &mut self.step {
            *first = first.or(read.first().copied());
            *bytes = bytes.saturating_add(u32::try_from(read.len()).unwrap_or(u32::MAX));
        }
    }

    /// The action at time `now`.
    pub fn next_action(&mut self, now: Time) -> StartupAction {
        match self.step {
            Step::Send(command) => {
                self.last_byte = now;
                self.step = if command.reply().is_some() {
                    Step::Listen { command, since: now, first: None, bytes: 0 }
                } else {
                    Step::Drain { since: now, insisted: command == Command::Request }
                };
                StartupAction::Write(command)
            }
            Step::Drain { since, insisted } => self.drain(since, insisted, now),
            Step::Listen { command, since, first, bytes } => match first {
                None => self.await_reply(command, since, now),
                Some(found) => self.check_reply(command, found, bytes, now),
            },
            Step::Ready => StartupAction::Ready,
            Step::Failed(error) => StartupAction::Failed(error),
        }
    }

    fn drain(&mut self, since: Time, insisted: bool, now: Time) -> StartupAction {
        let (quiet, end) = (self.last_byte + QUIET_S, since + DRAIN_S);
        if now >= quiet {
            self.enter(Step::Send(Command::Ping), now)
        } else if now < end {
            StartupAction::ReadUntil(quiet.min(end))
        } else if insisted {
            self.fail(StartupError::NeverQuiet, now)
        } else {
            self.enter(Step::Send(Command::Request), now)
        }
    }

    fn await_reply(&mut self, command: Command, since: Time, now: Time) -> StartupAction {
        let end = since + REPLY_S;
        if now >= end {
            self.fail(StartupError::NoReply { command }, now)
        } else {
            StartupAction::ReadUntil(end)
        }
    }

    fn check_reply(&mut self, command: Command, found: u8, bytes: u32, now: Time) -> StartupAction {
        if bytes > 1 || Some(found) != command.reply() {
            return self.fail(StartupError::WrongReply { command, found, bytes }, now);
        }
        let quiet = self.last_byte + QUIET_S;
        if now < quiet {
            return StartupAction::ReadUntil(quiet);
        }
        let next = match command {
            Command::Ping => Step::Send(Command::SetMode(self.mode)),
            _ => Step::Ready,
        };
        self.enter(next, now)
    }

    fn fail(&mut self, error: StartupError, now: Time) -> StartupAction {
        let next = match self.attempts_left.checked_sub(1) {
            Some(left) => {
                self.attempts_left = left;
                Step::Send(Command::Polled)
            }
            None => Step::Failed(error),
        };
        self.enter(next, now)
    }

    /// Enters a step and returns its action. Every step waits or has an action, so the recursion is one level deep.
    fn enter(&mut self, step: Step, now: Time) -> StartupAction {
        self.step = step;
        self.next_action(now)
    }
}
