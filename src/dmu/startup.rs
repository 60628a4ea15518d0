//! Bringing the unit into a known mode, whatever it was doing before.

use core::fmt;

use super::packet::Mode;
use crate::time::Time;

/// A command to the unit: one ASCII byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Command {
    /// Is anybody there? Early firmware also returns to voltage mode.
    Ping,
    /// Send packets of this mode from now on.
    SetMode(Mode),
    /// Send packets only when asked.
    Polled,
    /// Send packets without being asked.
    Continuous,
    /// Send one packet; during continuous mode, stop.
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

    /// The byte that the unit answers, if it answers by one.
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

/// What kept the unit from starting, at the last attempt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StartupError {
    /// Bytes kept coming after the unit was commanded to stop.
    NeverQuiet,
    /// No reply in time.
    NoReply {
        /// The command.
        command: Command,
    },
    /// Another byte than the reply, or more bytes than that.
    WrongReply {
        /// The command.
        command: Command,
        /// The first byte that came.
        found: u8,
        /// How many came.
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

/// Silence that proves that the unit streams no more, s; it never pauses as long.
const QUIET_S: f64 = 0.05;

/// How long to wait for that silence before stopping the unit by other means, s.
const DRAIN_S: f64 = 0.3;

/// How long to wait for a reply, s.
const REPLY_S: f64 = 0.5;

/// Attempts before giving up.
const ATTEMPTS: u32 = 3;

/// What the caller is to do next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StartupAction {
    /// Write the command's byte, then ask again.
    Write(Command),
    /// Read until bytes come or this time is reached, hand over the bytes, ask again.
    ReadUntil(Time),
    /// The unit is silent, in polled mode, and its packets will be of the mode asked for.
    Ready,
    /// All attempts failed, the last one so.
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
    /// Wait for the reply to this command, and for the silence behind it.
    Listen {
        command: Command,
        since: Time,
        first: Option<u8>,
        bytes: u32,
    },
    Ready,
    Failed(StartupError),
}

/// The start-up sequence: stop the stream, find the unit, set the mode.
///
/// It does no input or output itself. Ask [`Startup::next_action`] what to do, do it, and hand over
/// what was read by [`Startup::receive`].
///
/// The unit may be streaming in any mode when it begins. A reply is one byte that also occurs in
/// packets, so none is looked for before the line has been silent for 50 ms, and none counts that is
/// not alone. An attempt takes at most 1.7 s; there are three.
#[derive(Clone, Debug)]
pub struct Startup {
    mode: Mode,
    attempts_left: u32,
    /// When the last byte came.
    heard: Time,
    step: Step,
}

impl Startup {
    /// A sequence that ends with packets of `mode`, beginning `now`.
    #[must_use]
    pub const fn new(mode: Mode, now: Time) -> Self {
        Self { mode, attempts_left: ATTEMPTS - 1, heard: now, step: Step::Send(Command::Polled) }
    }

    /// Takes bytes that were read, of which the last came `now`.
    pub fn receive(&mut self, read: &[u8], now: Time) {
        if read.is_empty() {
            return;
        }
        self.heard = now;
        if let Step::Listen { first, bytes, .. } = &mut self.step {
            *first = first.or(read.first().copied());
            *bytes = bytes.saturating_add(u32::try_from(read.len()).unwrap_or(u32::MAX));
        }
    }

    /// What to do at time `now`.
    pub fn next_action(&mut self, now: Time) -> StartupAction {
        match self.step {
            Step::Send(command) => {
                self.heard = now;
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
        let (quiet, end) = (self.heard + QUIET_S, since + DRAIN_S);
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
        let quiet = self.heard + QUIET_S;
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

    /// Takes a step and says at once what it asks for; every step either waits or has an answer, so
    /// this goes one deep.
    fn enter(&mut self, step: Step, now: Time) -> StartupAction {
        self.step = step;
        self.next_action(now)
    }
}
