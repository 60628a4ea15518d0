//! Commands to the receiver, and its start-up sequence.

use super::framer::{DLE, ETX};
use super::{Decoder, IoOptions};
use crate::time::Time;

/// A command to the receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// 0x1F: answers 0x45.
    RequestVersion,
    /// 0x21: answers 0x41.
    RequestTime,
    /// 0x24: answers 0x6D.
    RequestSatellites,
    /// 0x26: answers 0x46 and 0x4B.
    RequestHealth,
    /// 0x25: restarts the receiver, which sends its start-up reports.
    SoftReset,
    /// 0x35 without data: answers 0x55.
    RequestIoOptions,
    /// 0x35: sets the reports, answers 0x55.
    SetIoOptions(IoOptions),
    /// 0x37: answers 0x57 with position and velocity.
    RequestLastFix,
    /// 0x8E-20: superpackets on or off.
    SendSuperpackets(bool),
    /// 0x3C for all satellites; the receiver answers with one 0x5C for each satellite.
    RequestTracking,
}

impl Command {
    /// The command in the format of the line.
    ///
    /// ```
    /// use hovernav::gps::tsip::{Command, IoOptions};
    /// let frame = Command::SetIoOptions(IoOptions::NAVIGATION).encode();
    /// assert_eq!(frame.as_bytes(), [0x10, 0x35, 0x12, 0x02, 0x00, 0x08, 0x10, 0x03]);
    /// ```
    #[must_use]
    pub fn encode(self) -> Frame {
        match self {
            Self::RequestVersion => Frame::new(0x1F, &[]),
            Self::RequestTime => Frame::new(0x21, &[]),
            Self::RequestSatellites => Frame::new(0x24, &[]),
            Self::RequestHealth => Frame::new(0x26, &[]),
            Self::SoftReset => Frame::new(0x25, &[]),
            Self::RequestIoOptions => Frame::new(0x35, &[]),
            Self::SetIoOptions(options) => Frame::new(
                0x35,
                &[options.position, options.velocity, options.timing, options.auxiliary],
            ),
            Self::RequestLastFix => Frame::new(0x37, &[]),
            Self::SendSuperpackets(on) => Frame::new(0x8E, &[0x20, u8::from(on)]),
            Self::RequestTracking => Frame::new(0x3C, &[0]),
        }
    }
}

/// A command in the format of the line, with its stuffing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Buffer for the longest command: four bytes of data, each possibly doubled.
    bytes: [u8; 12],
    length: usize,
}

impl Frame {
    fn new(id: u8, data: &[u8]) -> Self {
        let mut frame = Self { bytes: [0; 12], length: 0 };
        frame.push(DLE);
        frame.push(id);
        for byte in data {
            frame.push(*byte);
            if *byte == DLE {
                frame.push(DLE);
            }
        }
        frame.push(DLE);
        frame.push(ETX);
        frame
    }

    /// The bytes to write.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }

    fn push(&mut self, byte: u8) {
        if let Some(room) = self.bytes.get_mut(self.length) {
            *room = byte;
            self.length += 1;
        }
    }
}

/// Configures a receiver for the required reports, also after a restart of the receiver.
///
/// The receiver answers the command 0x35, which sets its reports, with an echo 0x55. Until the echo arrives, the
/// command is repeated every [`Startup::RETRY_S`].
///
/// ```
/// use hovernav::gps::tsip::{Decoder, Startup};
/// use hovernav::time::Time;
///
/// let mut decoder = Decoder::default();
/// let mut startup = Startup::default();
/// assert!(startup.poll(&decoder, Time::ZERO).is_some());          // to be written to the port
/// assert!(startup.poll(&decoder, Time::ZERO + 0.1).is_none());    // wait for the answer
///
/// let mut answer: &[u8] = &[0x10, 0x55, 0x12, 0x02, 0x00, 0x08, 0x10, 0x03];
/// assert!(decoder.read(&mut answer, Time::ZERO + 0.2).is_none());
/// assert!(startup.is_acknowledged(&decoder));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Startup {
    wanted: IoOptions,
    sent: Option<Time>,
    attempts: u32,
}

impl Default for Startup {
    fn default() -> Self {
        Self::new(IoOptions::NAVIGATION)
    }
}

impl Startup {
    /// Time after which an unanswered command is repeated, s. The answer may be queued behind the reports of one
    /// second.
    pub const RETRY_S: f64 = 2.0;

    /// A start-up sequence for the reports of `wanted`.
    #[must_use]
    pub const fn new(wanted: IoOptions) -> Self {
        Self { wanted, sent: None, attempts: 0 }
    }

    /// Bytes to write to the port at `now`, if any. Call it at least every second, for the whole flight.
    pub fn poll(&mut self, decoder: &Decoder, now: Time) -> Option<Frame> {
        let waiting = self.sent.is_some_and(|sent| (0.0..Self::RETRY_S).contains(&(now - sent)));
        if waiting || self.is_acknowledged(decoder) {
            return None;
        }
        self.sent = Some(now);
        self.attempts = self.attempts.saturating_add(1);
        Some(Command::SetIoOptions(self.wanted).encode())
    }

    /// Whether the receiver has confirmed the required reports.
    #[must_use]
    pub fn is_acknowledged(&self, decoder: &Decoder) -> bool {
        decoder.io_options() == Some(self.wanted)
    }

    /// Number of transmissions of the command. A growing number without an answer means a dead line, a wrong baud
    /// rate or another protocol.
    #[must_use]
    pub fn attempts(&self) -> u32 {
        self.attempts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_start_up_command_is_repeated_until_its_echo_and_again_after_a_restart() {
        let mut decoder = Decoder::default();
        let mut startup = Startup::default();
        let at = |seconds: f64| Time::ZERO + seconds;
        assert!(startup.poll(&decoder, at(0.0)).is_some());
        assert!(startup.poll(&decoder, at(1.9)).is_none());
        assert!(startup.poll(&decoder, at(2.0)).is_some());

        // Options other than the requested ones are no acknowledgement.
        let mut other: &[u8] = &[0x10, 0x55, 0x02, 0x02, 0x00, 0x00, 0x10, 0x03];
        decoder.read(&mut other, at(2.1));
        assert!(!startup.is_acknowledged(&decoder));

        let mut echo: &[u8] = &[0x10, 0x55, 0x12, 0x02, 0x00, 0x08, 0x10, 0x03];
        decoder.read(&mut echo, at(2.2));
        assert!(startup.poll(&decoder, at(60.0)).is_none());
        assert_eq!(startup.attempts(), 2);

        let mut restart: &[u8] = &[0x10, 0x45, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 0x10, 0x03];
        decoder.read(&mut restart, at(61.0));
        assert!(startup.poll(&decoder, at(61.0)).is_some());
    }

    #[test]
    fn an_escape_in_the_data_of_a_command_is_doubled() {
        let options = IoOptions { position: 0x10, velocity: 0x10, timing: 0x10, auxiliary: 0x10 };
        let frame = Command::SetIoOptions(options).encode();
        assert_eq!(
            frame.as_bytes(),
            [0x10, 0x35, 0x10, 0x10, 0x10, 0x10, 0x10, 0x10, 0x10, 0x10, 0x10, 0x03]
        );
    }

    #[test]
    fn commands_are_those_of_the_manual() {
        for (command, bytes) in [
            (Command::RequestVersion, &[0x10, 0x1F, 0x10, 0x03][..]),
            (Command::RequestTime, &[0x10, 0x21, 0x10, 0x03]),
            (Command::RequestIoOptions, &[0x10, 0x35, 0x10, 0x03]),
            (Command::SendSuperpackets(true), &[0x10, 0x8E, 0x20, 0x01, 0x10, 0x03]),
            (Command::RequestTracking, &[0x10, 0x3C, 0x00, 0x10, 0x03]),
        ] {
            assert_eq!(command.encode().as_bytes(), bytes);
        }
    }
}
