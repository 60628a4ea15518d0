//! An emulated Crossbow DMU-HDX-AHRS.

use super::Device;
use super::line::Line;
use hovernav::dmu::{AnglePacket, Calibration, Measurement, Mode, ScaledPacket, VoltagePacket};
use hovernav::imu::ImuSample;
use hovernav::time::Time;

/// Baud rate of the IMU's line.
const BAUD: u32 = 38_400;
/// Bits per byte on the line, with start and stop bit: 8-N-1.
const BITS_PER_BYTE: u32 = 10;

/// Period of the IMU's timer, ns. Source: Crossbow, *AHRS Series User's Manual*, 7430-0004-01, page 16.
const TICK_NS: i64 = 790;

/// Shortest interval of packets in continuous mode, s: 70 Hz, with a margin for unevenly spaced samples. Source: page
/// 16 of Crossbow's *AHRS Series User's Manual*.
const SHORTEST_PACE_S: f64 = 0.95 / 70.0;

/// Longest interval between two samples, s, across which a poll is answered by interpolation.
const LONGEST_HOLD_S: f64 = 0.2;

/// Behaviour of commands that differs between firmware versions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Firmware {
    /// Whether the command `R` resets the IMU to polled voltage mode.
    pub ping_resets: bool,
    /// Whether the command `P` ends continuous mode; otherwise only `G` ends it.
    pub knows_polled: bool,
}

impl Default for Firmware {
    /// The behaviour that the later manuals describe.
    fn default() -> Self {
        Self { ping_resets: false, knows_polled: true }
    }
}

/// Source of the IMU's measurements.
pub trait PacketSource: Send {
    /// The measurement for a poll at `now`, if there is a measurement.
    fn at(&mut self, now: Time) -> Option<AnglePacket>;

    /// The next packet of continuous mode up to `now`, with its time.
    fn due(&mut self, now: Time) -> Option<(Time, AnglePacket)>;

    /// Time of the next packet of continuous mode.
    fn next(&self) -> Option<Time>;

    /// The times of the first and the last measurement.
    fn span(&self) -> Option<(Time, Time)>;
}

/// An emulated IMU at the device's end of a serial line.
///
/// In continuous mode it sends each packet at the time of the packet, but at most 70 packets per second. Its timer
/// follows the time passed to it.
#[derive(Clone, Debug)]
pub struct DmuDevice<S = GivenPackets> {
    /// Firmware behaviour.
    pub firmware: Firmware,
    /// Format of the next packet.
    pub mode: Mode,
    /// Whether the IMU is in continuous mode.
    pub continuous: bool,
    source: S,
    sent: Option<Time>,
    started: bool,
    line: Line,
}

/// Measurements given in advance. A poll is answered with an interpolation between the two neighbours, so polls
/// never return the same sample twice. Before the first and after the last measurement there is no answer.
#[derive(Clone, Debug)]
pub struct GivenPackets {
    packets: Vec<(Time, AnglePacket)>,
    /// Index of the next packet.
    next: usize,
}

impl DmuDevice {
    /// An IMU just switched on, in polled voltage mode, that measures `packets` at their times, in time order. The
    /// device replaces the timers in the packets.
    #[must_use]
    pub fn new(packets: Vec<(Time, AnglePacket)>) -> Self {
        Self::measuring_by(GivenPackets { packets, next: 0 })
    }

    /// An IMU that measures `samples` at their times, in time order, with the ranges and signs of `calibration`, at
    /// 25 °C. Increments are converted to mean rates; a missing attitude or field is sent as zeros.
    #[must_use]
    pub fn measuring(samples: &[ImuSample], calibration: &Calibration) -> Self {
        let packet = |sample: &ImuSample, interval_s: f64| {
            let mean = sample.motion.mean_rates(interval_s);
            let packet = calibration.counts(&Measurement {
                angular_rate_radps: mean.angular_rate_radps,
                specific_force_mps2: mean.specific_force_mps2,
                magnetic_field_gauss: sample.magnetic_field_gauss.unwrap_or_default(),
                attitude: sample.attitude,
                temperature_degc: 25.0,
            });
            (sample.time, packet)
        };
        let first_interval_s = match samples {
            [first, second, ..] => second.time - first.time,
            _ => f64::INFINITY,
        };
        let intervals = samples.windows(2).map(|pair| pair[1].time - pair[0].time);
        let intervals = std::iter::once(first_interval_s).chain(intervals);
        Self::new(samples.iter().zip(intervals).map(|(s, interval)| packet(s, interval)).collect())
    }
}

impl<S: PacketSource> DmuDevice<S> {
    /// An IMU just switched on, in polled voltage mode, that sends the measurements of `source`.
    #[must_use]
    pub fn measuring_by(source: S) -> Self {
        Self {
            firmware: Firmware::default(),
            mode: Mode::Voltage,
            continuous: false,
            source,
            sent: None,
            started: false,
            line: Line::new(BAUD, BITS_PER_BYTE),
        }
    }

    /// Sends `bytes` without a command.
    pub fn send_unsolicited(&mut self, bytes: &[u8], now: Time) {
        self.line.send(bytes.to_vec(), now);
    }

    fn execute(&mut self, command: u8, now: Time) {
        match command {
            b'R' => {
                if self.firmware.ping_resets {
                    (self.mode, self.continuous) = (Mode::Voltage, false);
                }
                self.line.send(vec![b'H'], now);
            }
            b'r' | b'c' | b'a' => {
                self.mode = match command {
                    b'r' => Mode::Voltage,
                    b'c' => Mode::Scaled,
                    _ => Mode::Angle,
                };
                self.line.send(vec![command.to_ascii_uppercase()], now);
            }
            b'P' => self.continuous &= !self.firmware.knows_polled,
            b'C' => (self.continuous, self.started) = (true, true),
            b'G' if self.continuous => self.continuous = false,
            b'G' => {
                self.started = true;
                // A request during a transmission is lost.
                if self.line.is_idle()
                    && let Some(packet) = self.source.at(now)
                {
                    self.send(packet, now);
                }
            }
            _ => {}
        }
    }

    fn send(&mut self, packet: AnglePacket, now: Time) {
        // The timer counts down, and the cast wraps it to 16 bits.
        let timer = 0u16.wrapping_sub(now.nanoseconds().div_euclid(TICK_NS) as u16);
        let packet = AnglePacket { timer, ..packet };
        let AnglePacket { angular_rate, acceleration, magnetic_field, temperature, .. } = packet;
        let bytes = match self.mode {
            Mode::Angle => packet.encode().to_vec(),
            Mode::Scaled => {
                ScaledPacket { angular_rate, acceleration, magnetic_field, temperature, timer }
                    .encode()
                    .to_vec()
            }
            Mode::Voltage => VoltagePacket {
                angular_rate: angular_rate.map(converter_counts),
                acceleration: acceleration.map(converter_counts),
                magnetic_field: magnetic_field.map(converter_counts),
                temperature,
                timer,
            }
            .encode()
            .to_vec(),
        };
        self.line.send(bytes, now);
        self.sent = Some(now);
    }

    /// Advances the device to `now`.
    fn advance(&mut self, now: Time) {
        while let Some((time, packet)) = self.source.due(now) {
            if self.continuous && self.sent.is_none_or(|sent| time - sent >= SHORTEST_PACE_S) {
                self.send(packet, time);
            }
        }
    }
}

impl PacketSource for GivenPackets {
    fn at(&mut self, now: Time) -> Option<AnglePacket> {
        let (after_time, after) = *self.packets.get(self.next)?;
        let (before_time, before) = *self.packets.get(self.next.checked_sub(1)?)?;
        let interval_s = after_time - before_time;
        let share = (now - before_time) / interval_s;
        let between =
            |before: i16, step: i16| before.wrapping_add((share * f64::from(step)).round() as i16);
        let words = |before: [i16; 3], after: [i16; 3]| {
            std::array::from_fn(|k| between(before[k], after[k].saturating_sub(before[k])))
        };
        (interval_s <= LONGEST_HOLD_S).then(|| AnglePacket {
            // Angles are interpolated over the shorter arc.
            attitude: std::array::from_fn(|k| {
                between(before.attitude[k], after.attitude[k].wrapping_sub(before.attitude[k]))
            }),
            angular_rate: words(before.angular_rate, after.angular_rate),
            acceleration: words(before.acceleration, after.acceleration),
            magnetic_field: words(before.magnetic_field, after.magnetic_field),
            temperature: before.temperature,
            timer: 0,
        })
    }

    fn due(&mut self, now: Time) -> Option<(Time, AnglePacket)> {
        let due = self.packets.get(self.next).filter(|(time, _)| *time <= now).copied();
        self.next += usize::from(due.is_some());
        due
    }

    fn next(&self) -> Option<Time> {
        self.packets.get(self.next).map(|(time, _)| *time)
    }

    fn span(&self) -> Option<(Time, Time)> {
        self.packets.first().zip(self.packets.last()).map(|(first, last)| (first.0, last.0))
    }
}

/// Counts of the 12-bit converter for a word: half of its 5 V at zero, 5 V at full scale.
fn converter_counts(word: i16) -> u16 {
    ((i32::from(word) >> 4) + 2048) as u16
}

impl<S: PacketSource> Device for DmuDevice<S> {
    fn receive(&mut self, bytes: &[u8], now: Time) {
        self.advance(now);
        for command in bytes {
            self.execute(*command, now);
        }
    }

    fn next_transmission(&self) -> Option<Time> {
        let sample = self.source.next().filter(|_| self.continuous);
        self.line.next().into_iter().chain(sample).min()
    }

    fn transmit(&mut self, now: Time, wire: &mut Vec<u8>) {
        self.advance(now);
        self.line.take(now, wire);
    }

    fn span(&self) -> Option<(Time, Time)> {
        self.source.span()
    }

    fn is_started(&self) -> bool {
        self.started
    }
}
