//! The Crossbow DMU-HDX-AHRS as it answers.

use super::Device;
use super::line::Line;
use hovernav::dmu::{AnglePacket, Calibration, Measurement, Mode, ScaledPacket, VoltagePacket};
use hovernav::imu::ImuSample;
use hovernav::time::Time;

/// 38 400 baud, 8-N-1.
const BAUD: u32 = 38_400;
const BITS_PER_BYTE: u32 = 10;

/// A tick of the unit's timer, ns. Source: Crossbow, *AHRS Series User's Manual*, 7430-0004-01,
/// page 16.
const TICK_NS: i64 = 790;

/// Packets of continuous mode follow each other no faster, s: 70 a second (page 16 of the same), with
/// room for samples that are not evenly spaced.
const SHORTEST_PACE_S: f64 = 0.95 / 70.0;

/// Between samples that are farther apart than this a poll finds nothing, s.
const LONGEST_HOLD_S: f64 = 0.2;

/// What a unit's firmware does with commands on which the versions differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Firmware {
    /// `R` resets to voltage mode, polled.
    pub ping_resets: bool,
    /// `P` ends continuous mode; if not, only `G` does.
    pub knows_polled: bool,
}

impl Default for Firmware {
    /// As the later manuals describe it.
    fn default() -> Self {
        Self { ping_resets: false, knows_polled: true }
    }
}

/// Where the unit's measurements come from.
pub trait PacketSource: Send {
    /// What it measures when it is asked at `now`; `None` while there is nothing to measure.
    fn at(&mut self, now: Time) -> Option<AnglePacket>;

    /// The next packet that it sends by itself in continuous mode, up to `now`, and its time.
    fn due(&mut self, now: Time) -> Option<(Time, AnglePacket)>;

    /// When it next sends by itself.
    fn next(&self) -> Option<Time>;

    /// The times of the first and the last measurement.
    fn span(&self) -> Option<(Time, Time)>;
}

/// The inertial unit at the far end of its line.
///
/// In continuous mode it sends each of its packets at that packet's time, leaving out those that come
/// faster than 70 a second. The timer runs with the time that it is given.
#[derive(Clone, Debug)]
pub struct DmuDevice<S = GivenPackets> {
    /// What it does with commands.
    pub firmware: Firmware,
    /// What it sends, from the next packet on.
    pub mode: Mode,
    /// Whether it sends unasked.
    pub continuous: bool,
    source: S,
    sent: Option<Time>,
    started: bool,
    line: Line,
}

/// Measurements that are known beforehand. Asked for a packet, the unit interpolates between the two
/// around that moment, so that no poll ever reads the same twice. Before the first and after the last
/// it is silent.
#[derive(Clone, Debug)]
pub struct GivenPackets {
    packets: Vec<(Time, AnglePacket)>,
    /// The first packet that is still to come.
    next: usize,
}

impl DmuDevice {
    /// A unit just switched on, in voltage mode and polled, that is going to measure `packets`, each
    /// at its time, in order of time. Their timers are replaced.
    #[must_use]
    pub fn new(packets: Vec<(Time, AnglePacket)>) -> Self {
        Self::measuring_by(GivenPackets { packets, next: 0 })
    }

    /// A unit that is going to measure `samples`, each at its time, in order of time, with the ranges
    /// and signs of `calibration`, at 25 °C. Increments become mean rates; an attitude or a field that
    /// a sample lacks is sent as zeros.
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
    /// A unit just switched on, in voltage mode and polled, whose measurements `source` makes.
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

    /// Puts `bytes` on the line though no command asked for them.
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
                // A request that comes while it sends is lost.
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
        // It counts down, and the cast takes the turns off.
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

    /// Brings the device up to `now`.
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
            // Angles turn the short way round.
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

/// The 12-bit converter behind a word: half of its 5 V at zero, all of them at full scale.
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
