//! The four serial lines, and the simulated flight at their other end.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use hovernav::dmu::AnglePacket;
use hovernav::gps::Protocol;
use hovernav::servo::packet::LENGTH;
use hovernav::time::Time;
use hovernav_dataset::Dataset;
use hovernav_fly::DurationHistogram;
use hovernav_fly::devices::{Device, DmuDevice, GpsDevice, PacketSource};
use hovernav_fly::play::{Begin, Cut, CutKind, EmulatedPort, Player};
use hovernav_fly::serial::Clock;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::error::LiveFlightError;
use crate::plant::{LiveConfig, LiveSample, PILOT_PERIOD_S, Plant, ServoPackets};
use crate::scene::Act;

/// Duration of one of the pilot's packets, s: 57 600 baud, 10 bits per byte.
const PILOT_PACKET_S: f64 = LENGTH as f64 * 10.0 / 57_600.0;

/// Paths of the lines.
#[derive(Clone, Debug)]
pub struct LinePaths {
    /// The IMU.
    pub dmu: PathBuf,
    /// The GPS receiver.
    pub gps: PathBuf,
    /// The pilot's pulses.
    pub pilot: PathBuf,
    /// The servos.
    pub servos: PathBuf,
}

impl LinePaths {
    /// `dmu`, `gps`, `pilot` and `servos` in `directory`.
    #[must_use]
    pub fn within(directory: impl Into<PathBuf>) -> Self {
        let directory = directory.into();
        Self {
            dmu: directory.join("dmu"),
            gps: directory.join("gps"),
            pilot: directory.join("pilot"),
            servos: directory.join("servos"),
        }
    }
}

type SharedPlant = Arc<Mutex<Plant>>;

fn lock(plant: &SharedPlant) -> MutexGuard<'_, Plant> {
    plant.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A simulated helicopter at the other end of four lines. Dropping it ends the flight.
pub struct LiveFlight {
    plant: SharedPlant,
    player: Player,
    duration_s: f64,
}

impl LiveFlight {
    /// Creates the lines at `paths` and flies by `clock`. The flight begins when the flight computer has opened all
    /// lines and requests packets from the IMU. `protocol` is that of the receiver.
    ///
    /// # Errors
    /// [`LiveFlightError`] for invalid settings or a line that cannot be created.
    pub fn start(
        config: LiveConfig,
        protocol: Protocol,
        paths: &LinePaths,
        clock: &Clock,
    ) -> Result<Self, LiveFlightError> {
        config.channels.check()?;
        config.swashplate.check(&config.channels)?;
        let duration_s = config.flight.duration_s;
        let latency_s = config.flight.gps.latency_s;
        let span = (Time::ZERO, Time::ZERO + duration_s);
        let cuts = |wire, adapter| {
            let cut = |(start_s, duration_s): (f64, f64), kind| Cut {
                start: Time::ZERO + start_s,
                duration_s,
                kind,
            };
            let wires = config.scene.spans(wire).map(|span| cut(span, CutKind::Wire));
            let adapters = config.scene.spans(adapter).map(|span| cut(span, CutKind::Adapter));
            wires.chain(adapters).collect::<Vec<_>>()
        };
        let (dmu_cuts, gps_cuts) =
            (cuts(Act::DmuCut, Act::DmuPulled), cuts(Act::GpsCut, Act::GpsPulled));
        let plant: SharedPlant = Arc::new(Mutex::new(Plant::new(config)?));
        let of = || Arc::clone(&plant);
        let source = LiveDmu { plant: of(), span };
        let device = DmuDevice::measuring_by(source);
        let dmu = LiveUnit { plant: of(), device, noise: Noise::new() };
        let gps = LiveGps {
            plant: of(),
            device: GpsDevice::new(protocol, &[], 0.0).with_utc_of(clock),
            latency_s,
            span,
            noise: Noise::new(),
        };
        let pilot = LivePilot { plant: of(), next: Time::ZERO, ready: None };
        let servos = LiveServos { plant: of() };
        let ports = vec![
            EmulatedPort { cuts: dmu_cuts, ..EmulatedPort::new(&paths.dmu, dmu) },
            EmulatedPort { cuts: gps_cuts, ..EmulatedPort::new(&paths.gps, gps) },
            EmulatedPort::new(&paths.pilot, pilot),
            EmulatedPort::new(&paths.servos, servos),
        ];
        let player = Player::start(ports, clock, Begin::WhenAsked)?;
        Ok(Self { plant, player, duration_s })
    }

    /// Time since the start of the flight, s; `None` before the start.
    #[must_use]
    pub fn elapsed_s(&self) -> Option<f64> {
        self.player.elapsed_s()
    }

    /// The latest sample.
    #[must_use]
    pub fn latest(&self) -> Option<LiveSample> {
        lock(&self.plant).samples.last().copied()
    }

    /// Time of the crash, s, if any.
    #[must_use]
    pub fn crashed_s(&self) -> Option<f64> {
        let plant = lock(&self.plant);
        let last = plant.samples.last().filter(|_| plant.has_crashed())?;
        Some(last.truth.time.seconds())
    }

    /// Time from the last byte of the IMU's packet to the first byte for the servos, with the wake-up delays of
    /// both ends.
    #[must_use]
    pub fn turnaround(&self) -> DurationHistogram {
        lock(&self.plant).turnaround.clone()
    }

    /// Regularity of the flight computer's packets to the servos.
    #[must_use]
    pub fn servo_packets(&self) -> ServoPackets {
        lock(&self.plant).servo_packets()
    }

    /// Whether the flight has ended, crashed, or lost a line permanently.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        self.elapsed_s().is_some_and(|elapsed_s| elapsed_s > self.duration_s)
            || self.player.is_finished()
            || self.crashed_s().is_some()
    }

    /// Ends the flight. Returns a dataset of the sensor measurements and the commanded controls, and the samples
    /// with the truth.
    ///
    /// # Errors
    /// The error of the first line that failed.
    pub fn end(self) -> Result<(Dataset, Vec<LiveSample>), LiveFlightError> {
        self.player.stop()?;
        let mut plant = lock(&self.plant);
        let samples = std::mem::take(&mut plant.samples);
        let dataset = Dataset {
            imu: std::mem::take(&mut plant.imu),
            fixes: std::mem::take(&mut plant.measured_fixes),
            controls: samples
                .iter()
                .map(|sample| (sample.truth.time, sample.commanded.to_array()))
                .collect(),
            ..Dataset::default()
        };
        Ok((dataset, samples))
    }
}

/// The simulated IMU as a source of packets.
struct LiveDmu {
    plant: SharedPlant,
    span: (Time, Time),
}

impl PacketSource for LiveDmu {
    fn at(&mut self, now: Time) -> Option<AnglePacket> {
        lock(&self.plant).packet(now)
    }

    fn due(&mut self, _now: Time) -> Option<(Time, AnglePacket)> {
        None
    }

    fn next(&self) -> Option<Time> {
        None
    }

    fn span(&self) -> Option<(Time, Time)> {
        Some(self.span)
    }
}

/// The emulated IMU, with a record of the times at which it sends packets.
struct LiveUnit {
    plant: SharedPlant,
    device: DmuDevice<LiveDmu>,
    noise: Noise,
}

/// Mean number of bytes from one damaged byte of a noisy line to the next.
const DAMAGED_EVERY: u32 = 100;

/// Damage to the bytes of a line: each byte is damaged by chance, independently of the others. Damage at a fixed
/// interval would affect every message of a receiver whose messages have the length of this interval, as NAV-PVT has.
struct Noise(ChaCha8Rng);

impl Noise {
    fn new() -> Self {
        Self(ChaCha8Rng::seed_from_u64(0))
    }

    /// Passes `bytes` on. If the line `is_noisy`, one byte in a hundred is changed.
    fn pass(&mut self, bytes: &mut [u8], is_noisy: bool) {
        for byte in bytes.iter_mut().filter(|_| is_noisy) {
            if self.0.next_u32().is_multiple_of(DAMAGED_EVERY) {
                *byte ^= 0x24;
            }
        }
    }
}

impl Device for LiveUnit {
    fn receive(&mut self, bytes: &[u8], now: Time) {
        self.device.receive(bytes, now);
    }

    fn next_transmission(&self) -> Option<Time> {
        self.device.next_transmission()
    }

    fn transmit(&mut self, now: Time, wire: &mut Vec<u8>) {
        let before = wire.len();
        self.device.transmit(now, wire);
        if wire.len() > before {
            let mut plant = lock(&self.plant);
            plant.unit_sent(now);
            let is_noisy = plant.has(Act::DmuNoise, now);
            self.noise.pass(&mut wire[before..], is_noisy);
        }
    }

    fn span(&self) -> Option<(Time, Time)> {
        self.device.span()
    }

    fn is_started(&self) -> bool {
        self.device.is_started()
    }
}

/// The emulated GPS receiver.
struct LiveGps {
    plant: SharedPlant,
    device: GpsDevice,
    latency_s: f64,
    span: (Time, Time),
    noise: Noise,
}

impl Device for LiveGps {
    fn receive(&mut self, bytes: &[u8], now: Time) {
        self.device.receive(bytes, now);
    }

    fn next_transmission(&self) -> Option<Time> {
        self.device.next_transmission()
    }

    fn transmit(&mut self, now: Time, wire: &mut Vec<u8>) {
        let mut plant = lock(&self.plant);
        plant.advance(now);
        for fix in plant.fixes.drain(..) {
            self.device.will_have(&fix, self.latency_s);
        }
        let is_noisy = plant.has(Act::GpsNoise, now);
        drop(plant);
        let before = wire.len();
        self.device.transmit(now, wire);
        self.noise.pass(&mut wire[before..], is_noisy);
    }

    fn span(&self) -> Option<(Time, Time)> {
        Some(self.span)
    }

    fn is_started(&self) -> bool {
        true
    }
}

/// The pilot's receiver and the microcontroller that times its pulses.
struct LivePilot {
    plant: SharedPlant,
    /// Time at which the next frame ends.
    next: Time,
    /// A packet in transmission, and the arrival of its last byte.
    ready: Option<(Time, [u8; LENGTH])>,
}

impl Device for LivePilot {
    fn receive(&mut self, _bytes: &[u8], _now: Time) {}

    fn next_transmission(&self) -> Option<Time> {
        Some(self.ready.map_or(self.next, |(arrival, _)| arrival))
    }

    fn transmit(&mut self, now: Time, wire: &mut Vec<u8>) {
        if now < Time::ZERO {
            return;
        }
        loop {
            if let Some((arrival, bytes)) = self.ready {
                if arrival > now {
                    return;
                }
                wire.extend(bytes);
                self.ready = None;
            }
            if self.next > now {
                return;
            }
            let frame = self.next;
            // Frames missed during a long pause are skipped.
            self.next =
                if now - frame > 0.5 { now + PILOT_PERIOD_S } else { frame + PILOT_PERIOD_S };
            let packet = lock(&self.plant).pilot_packet(frame.max(Time::ZERO));
            self.ready = packet.map(|packet| (frame + PILOT_PACKET_S, packet.encode()));
        }
    }

    fn span(&self) -> Option<(Time, Time)> {
        None
    }

    fn is_started(&self) -> bool {
        true
    }
}

/// The emulated microcontroller that drives the servos.
struct LiveServos {
    plant: SharedPlant,
}

impl Device for LiveServos {
    fn receive(&mut self, bytes: &[u8], now: Time) {
        if now >= Time::ZERO {
            lock(&self.plant).command(bytes, now);
        }
    }

    fn next_transmission(&self) -> Option<Time> {
        None
    }

    fn transmit(&mut self, _now: Time, _wire: &mut Vec<u8>) {}

    fn span(&self) -> Option<(Time, Time)> {
        None
    }

    fn is_started(&self) -> bool {
        true
    }
}
