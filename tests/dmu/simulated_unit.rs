//! An IMU at the far end of a serial line, and the exchange of a link with it.

use hovernav::dmu::{AnglePacket, Link, LinkAction, LinkFault, Mode, Packet, Received};
use hovernav::time::Time;
use hovernav_fly::devices::{Device, DmuDevice, Firmware};

/// Interval of packets in continuous mode, s.
const PACKET_S: f64 = 1.0 / 60.0;

/// Number of packets available: half a minute.
const PACKETS: u32 = 1_800;

#[derive(Clone, Debug)]
pub struct SimulatedUnit {
    pub device: DmuDevice,
    /// Whether the IMU is unplugged: it neither receives nor sends.
    pub unplugged: bool,
    /// All bytes that the IMU sent.
    sent: Vec<u8>,
}

impl SimulatedUnit {
    /// An IMU whose packets contain the words `AH`, which are also bytes of replies to commands.
    pub fn new(firmware: Firmware, mode: Mode, continuous: bool) -> Self {
        let words = [0x4148; 3];
        let packet = AnglePacket {
            attitude: words,
            angular_rate: words,
            acceleration: words,
            magnetic_field: words,
            temperature: 1587,
            timer: 0,
        };
        let time = |index| Time::ZERO + f64::from(index) * PACKET_S;
        let packets = (0..PACKETS).map(|index| (time(index), packet)).collect();
        let mut device = DmuDevice::new(packets);
        (device.firmware, device.mode, device.continuous) = (firmware, mode, continuous);
        Self { device, unplugged: false, sent: Vec::new() }
    }

    pub fn noise(&mut self, bytes: &[u8], now: Time) {
        self.device.send_unsolicited(bytes, now);
    }

    /// Whether the IMU sent this packet, byte for byte.
    pub fn has_sent(&self, packet: &Packet) -> bool {
        let bytes = match packet {
            Packet::Voltage(packet) => packet.encode().to_vec(),
            Packet::Scaled(packet) => packet.encode().to_vec(),
            Packet::Angle(packet) => packet.encode().to_vec(),
        };
        self.sent.windows(bytes.len()).any(|window| window == bytes)
    }

    pub fn command(&mut self, byte: u8, now: Time) {
        if !self.unplugged {
            self.device.receive(&[byte], now);
        }
    }

    /// The bytes that arrived at the other end up to `now`.
    fn arrived(&mut self, now: Time) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.device.transmit(now, &mut bytes);
        if self.unplugged {
            bytes.clear();
        }
        self.sent.extend(&bytes);
        bytes
    }
}

/// A link and an IMU in simulated time.
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

    /// Simulates `duration_s`. The reader wakes every 2 ms at most, so bytes arrive in pieces.
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
