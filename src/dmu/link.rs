//! The link to one inertial unit on one serial line: start-up, polled or continuous operation, and restart after a
//! loss.

use core::fmt;

use super::decoder::{Decoder, PacketCounts, Received};
use super::packet::Mode;
use super::startup::{Command, Startup, StartupAction, StartupError};
use crate::time::Time;

/// Source of the packet rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Flow {
    /// The inertial unit sends as fast as it can, about 60 to 70 packets a second.
    Continuous,
    /// The host requests one packet in every cycle.
    Polled {
        /// Time between requests, s, limited to 1/70 s to 0.05 s. The lower limit is the inertial unit's shortest
        /// cycle. Above the upper limit the inertial unit's timer could wrap unnoticed.
        cycle_s: f64,
    },
}

/// Reason for a restart of the link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkFault {
    /// The start-up of the inertial unit failed.
    Startup(StartupError),
    /// No packet has arrived for half a second.
    NoData,
    /// Bytes arrived for 0.2 s without a valid packet among them.
    Garbled,
}

impl fmt::Display for LinkFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Startup(error) => write!(f, "the unit does not start: {error}"),
            Self::NoData => write!(f, "no packet for {NO_DATA_S} s"),
            Self::Garbled => write!(f, "{GARBLED_BYTES} bytes without a packet"),
        }
    }
}

impl core::error::Error for LinkFault {}

/// Next action of the caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkAction {
    /// Write the command's byte to the inertial unit, then call again.
    Write(Command),
    /// Read until bytes arrive or this time is reached, pass the bytes on, then call again.
    ReadUntil(Time),
    /// Report this fault, then call again: the link has restarted.
    Lost(LinkFault),
}

/// Longest time without a packet on a running link, s.
const NO_DATA_S: f64 = 0.5;

/// Number of lost bytes after which the link restarts: 0.2 s of bytes without pause.
const GARBLED_BYTES: u64 = 768;

/// The shortest cycle, s: the inertial unit sends at most 70 packets a second.
/// Source: Crossbow, *AHRS Series User's Manual*, 7430-0004-01, page 16.
const SHORTEST_CYCLE_S: f64 = 1.0 / 70.0;

/// The longest cycle, s: the inertial unit's timer wraps every 51.8 ms.
const LONGEST_CYCLE_S: f64 = 0.05;

#[derive(Clone, Debug)]
enum State {
    Starting(Startup),
    Running {
        /// Time of arrival of the last packet; before the first packet, time of the start of operation.
        last_packet: Time,
        /// Number of bytes lost until the last packet; before the first packet, until the start of operation.
        lost: u64,
        /// Time of the next request in polled operation.
        request: Option<Time>,
    },
}

/// The complete protocol with the inertial unit. It performs no input or output itself.
///
/// Call [`Link::next_action`], carry the action out, and pass the bytes read to [`Link::next_packet`]:
///
/// ```
/// use hovernav::dmu::{AnglePacket, Flow, Link, LinkAction, Mode};
/// use hovernav::time::Time;
///
/// let mut link = Link::new(Mode::Angle, Flow::Polled { cycle_s: 0.0303 }, Time::ZERO);
/// let (mut now, mut packets) = (Time::ZERO, 0);
/// while packets < 3 {
///     // A simulated unit that always answers at once replaces the serial port.
///     let mut reply = Vec::new();
///     match link.next_action(now) {
///         LinkAction::Write(command) => match command.byte() {
///             b'G' => reply.extend(AnglePacket::default().encode()),
///             _ => reply.extend(command.reply()),
///         },
///         LinkAction::ReadUntil(time) => now = time,
///         LinkAction::Lost(fault) => panic!("{fault}"),
///     }
///     let mut bytes = &reply[..];
///     while let Some(_received) = link.next_packet(&mut bytes, now) {
///         packets += 1;
///     }
/// }
/// ```
#[derive(Clone, Debug)]
pub struct Link {
    mode: Mode,
    /// Cycle in polled operation, s.
    cycle_s: Option<f64>,
    decoder: Decoder,
    state: State,
}

impl Link {
    /// A link to an inertial unit in any state; its start-up begins `now`.
    #[must_use]
    pub const fn new(mode: Mode, flow: Flow, now: Time) -> Self {
        let cycle_s = match flow {
            Flow::Continuous => None,
            Flow::Polled { cycle_s } => Some(cycle_s.max(SHORTEST_CYCLE_S).min(LONGEST_CYCLE_S)),
        };
        let state = State::Starting(Startup::new(mode, now));
        Self { mode, cycle_s, decoder: Decoder::new(mode), state }
    }

    /// The next packet in bytes that were read; the last of them arrived `now`. Takes the required bytes from the
    /// front of `bytes`. `None` means that all were taken.
    pub fn next_packet(&mut self, bytes: &mut &[u8], now: Time) -> Option<Received> {
        match &mut self.state {
            State::Starting(startup) => {
                startup.receive(bytes, now);
                *bytes = &[];
                None
            }
            State::Running { last_packet, lost, .. } => {
                let received = self.decoder.next_packet(bytes)?;
                (*last_packet, *lost) = (now, self.decoder.counts().bytes_lost());
                Some(received)
            }
        }
    }

    /// The action at time `now`.
    pub fn next_action(&mut self, now: Time) -> LinkAction {
        match &mut self.state {
            State::Starting(startup) => match startup.next_action(now) {
                StartupAction::Write(command) => LinkAction::Write(command),
                StartupAction::ReadUntil(time) => LinkAction::ReadUntil(time),
                StartupAction::Failed(error) => self.start_over(LinkFault::Startup(error), now),
                StartupAction::Ready => self.run(now),
            },
            State::Running { last_packet, lost, request } => {
                let deadline = *last_packet + NO_DATA_S;
                if self.decoder.counts().bytes_lost() - *lost >= GARBLED_BYTES {
                    return self.start_over(LinkFault::Garbled, now);
                }
                if now >= deadline {
                    return self.start_over(LinkFault::NoData, now);
                }
                let (Some(request), Some(cycle_s)) = (request, self.cycle_s) else {
                    return LinkAction::ReadUntil(deadline);
                };
                if now < *request {
                    return LinkAction::ReadUntil(deadline.min(*request));
                }
                // A late request delays the later requests only if a whole cycle is lost.
                *request = *request + cycle_s;
                if *request <= now {
                    *request = now + cycle_s;
                }
                self.decoder.expect_packet();
                LinkAction::Write(Command::Request)
            }
        }
    }

    /// Whether the start-up of the inertial unit has ended, so that packets are expected.
    #[must_use]
    pub const fn is_running(&self) -> bool {
        matches!(self.state, State::Running { .. })
    }

    /// Counts of the bytes that arrived while the link was running.
    #[must_use]
    pub const fn counts(&self) -> &PacketCounts {
        self.decoder.counts()
    }

    /// Starts operation: the inertial unit has just been silent, so the next byte begins a packet.
    fn run(&mut self, now: Time) -> LinkAction {
        self.decoder.restart();
        let lost = self.decoder.counts().bytes_lost();
        self.state = State::Running {
            last_packet: now,
            lost,
            request: self.cycle_s.map(|cycle_s| now + cycle_s),
        };
        self.decoder.expect_packet();
        LinkAction::Write(if self.cycle_s.is_some() {
            Command::Request
        } else {
            Command::Continuous
        })
    }

    fn start_over(&mut self, fault: LinkFault, now: Time) -> LinkAction {
        self.state = State::Starting(Startup::new(self.mode, now));
        LinkAction::Lost(fault)
    }
}
