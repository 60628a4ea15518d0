//! A unit at the far end of a serial line, and the conversation of a link with it.

use std::collections::VecDeque;

use hovernav::dmu::{AnglePacket, Link, LinkAction, LinkFault, Mode, Received, ScaledPacket};
use hovernav::dmu::{Packet, VoltagePacket};
use hovernav::time::Time;

/// Seconds a byte takes on the line.
const BYTE_S: f64 = 10.0 / 38_400.0;

/// Seconds between packets of continuous mode.
const PACKET_S: f64 = 1.0 / 60.0;

/// What the unit does with commands; each firmware knows only some of them.
#[derive(Clone, Copy, Debug)]
pub struct Firmware {
    /// `R` resets to voltage mode, polled.
    pub ping_resets: bool,
    /// `P` ends continuous mode; if not, only `G` does.
    pub knows_polled: bool,
}

#[derive(Clone, Debug)]
pub struct SimulatedUnit {
    pub firmware: Firmware,
    pub mode: Mode,
    pub continuous: bool,
    /// Neither hears nor speaks.
    pub unplugged: bool,
    /// Template of its packets; only the timer moves.
    pub words: i16,
    /// Bytes on the line and when each arrives.
    line: VecDeque<(Time, u8)>,
    line_free: Time,
    next_packet: Time,
    pub sent: Vec<Packet>,
}

impl SimulatedUnit {
    pub fn new(firmware: Firmware, mode: Mode, continuous: bool) -> Self {
        Self {
            firmware,
            mode,
            continuous,
            unplugged: false,
            words: 0x4148,
            line: VecDeque::new(),
            line_free: Time::ZERO,
            next_packet: Time::ZERO,
            sent: Vec::new(),
        }
    }

    fn send(&mut self, bytes: &[u8], now: Time) {
        self.line_free = self.line_free.max(now);
        for byte in bytes {
            self.line_free = self.line_free + BYTE_S;
            self.line.push_back((self.line_free, *byte));
        }
    }

    pub fn noise(&mut self, bytes: &[u8], now: Time) {
        self.send(bytes, now);
    }

    fn send_packet(&mut self, now: Time) {
        let words = [self.words; 3];
        let timer = 0u16.wrapping_sub((now.seconds() / 0.79e-6) as u64 as u16);
        let (angular_rate, acceleration, magnetic_field, temperature) = (words, words, words, 1587);
        let angle = AnglePacket {
            attitude: words,
            angular_rate,
            acceleration,
            magnetic_field,
            temperature,
            timer,
        };
        let scaled =
            ScaledPacket { angular_rate, acceleration, magnetic_field, temperature, timer };
        let volts = words.map(i16::cast_unsigned);
        let voltage = VoltagePacket {
            angular_rate: volts,
            acceleration: volts,
            magnetic_field: volts,
            temperature,
            timer,
        };
        let (packet, bytes) = match self.mode {
            Mode::Angle => (Packet::Angle(angle), angle.encode().to_vec()),
            Mode::Scaled => (Packet::Scaled(scaled), scaled.encode().to_vec()),
            Mode::Voltage => (Packet::Voltage(voltage), voltage.encode().to_vec()),
        };
        self.sent.push(packet);
        self.send(&bytes, now);
    }

    pub fn command(&mut self, byte: u8, now: Time) {
        if self.unplugged {
            return;
        }
        match byte {
            b'R' => {
                if self.firmware.ping_resets {
                    (self.mode, self.continuous) = (Mode::Voltage, false);
                }
                self.send(b"H", now);
            }
            b'r' | b'c' | b'a' => {
                self.mode = match byte {
                    b'r' => Mode::Voltage,
                    b'c' => Mode::Scaled,
                    _ => Mode::Angle,
                };
                self.send(&[byte.to_ascii_uppercase()], now);
            }
            b'P' => self.continuous &= !self.firmware.knows_polled,
            b'C' => (self.continuous, self.next_packet) = (true, now),
            b'G' if self.continuous => self.continuous = false,
            b'G' => self.send_packet(now),
            other => panic!("no such command: {other:#04x}"),
        }
    }

    /// What has arrived at the other end up to `now`.
    fn arrived(&mut self, now: Time) -> Vec<u8> {
        while self.continuous && self.next_packet <= now {
            let at = self.next_packet;
            if !self.unplugged {
                self.send_packet(at);
            }
            self.next_packet = at + PACKET_S;
        }
        let count = self.line.iter().take_while(|(time, _)| *time <= now).count();
        let bytes: Vec<u8> = self.line.drain(..count).map(|(_, byte)| byte).collect();
        if self.unplugged { Vec::new() } else { bytes }
    }
}

/// A link and a unit in simulated time.
pub struct Conversation {
    pub link: Link,
    pub unit: SimulatedUnit,
    pub now: Time,
    pub packets: Vec<(Time, Received)>,
    pub faults: Vec<(Time, LinkFault)>,
}

impl Conversation {
    pub fn new(link: Link, unit: SimulatedUnit, now: Time) -> Self {
        Self { link, unit, now, packets: Vec::new(), faults: Vec::new() }
    }

    /// Lets `duration_s` pass. The reader wakes every 2 ms at most, so bytes come in pieces.
    pub fn run(&mut self, duration_s: f64) {
        let end = self.now + duration_s;
        while self.now < end {
            let wait = match self.link.next_action(self.now) {
                LinkAction::Write(command) => {
                    self.unit.command(command.byte(), self.now);
                    continue;
                }
                LinkAction::Lost(fault) => {
                    self.faults.push((self.now, fault));
                    continue;
                }
                LinkAction::ReadUntil(time) => time,
            };
            self.now =
                wait.min(self.now + 2e-3).max(Time::from_nanoseconds(self.now.nanoseconds() + 1));
            let read = self.unit.arrived(self.now);
            let mut bytes = &read[..];
            while let Some(received) = self.link.next_packet(&mut bytes, self.now) {
                self.packets.push((self.now, received));
            }
        }
    }
}
