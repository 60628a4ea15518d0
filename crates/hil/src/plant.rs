//! Simulation of the vehicle, its sensors and its pilot.

use hovernav::autopilot::HoverConfig;
use hovernav::controls::{Channels, Sticks};
use hovernav::dmu::{AnglePacket, Calibration, Measurement};
use hovernav::frames::{Ned, Vector};
use hovernav::gps::Fix;
use hovernav::imu::ImuSample;
use hovernav::servo::packet::{PacketCapture, ServoPacket};
use hovernav::servo::{ChannelConfig, Swashplate};
use hovernav::time::Time;
use hovernav_dataset::Truth;
use hovernav_fly::DurationHistogram;
use hovernav_sim::{FlightConfig, ImuTruth, SimulatedDmu, SimulatedGps, State, Vehicle, Wind};

use crate::error::LiveFlightError;
use crate::pilot::Pilot;
use crate::scene::{Act, STICK_CHANNELS, Scene};

/// Simulation steps per period of the autopilot.
const STEPS: u64 = 3;
/// Interval of the pilot's packets, s.
pub(crate) const PILOT_PERIOD_S: f64 = 0.02;
/// Time without servo packets after which the receiver's pulses pass through, s.
const PASS_THROUGH_S: f64 = 0.2;
/// Width of the aux channel with the switch open and closed, ms.
const AUX_MS: (f64, f64) = (1.1, 1.9);
/// Throttle, as a stick fraction, below which the rotors lose power. The pilot's throttle is at trim.
const IDLE: f64 = -0.5;
/// Pulse width of a receiver in failsafe on every channel, ms.
const FAILSAFE_MS: f64 = 1.5;

/// The setup of a live flight.
#[derive(Clone, Debug)]
pub struct LiveConfig {
    /// Vehicle, wind, sensors, start position and seed. The pilot flies with the skill of its autopilot; its events are
    /// ignored.
    pub flight: FlightConfig,
    /// Ranges and signs of the IMU.
    pub calibration: Calibration,
    /// The servo channels as configured in the flight computer.
    pub channels: Channels<ChannelConfig>,
    /// The swashplate as configured in the flight computer.
    pub swashplate: Swashplate,
    /// The acts of the flight.
    pub scene: Scene,
}

/// Regularity of the flight computer's packets to the servos. Packets that the scene cuts off are not counted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ServoPackets {
    /// Number of packets received.
    pub came: u64,
    /// Number of packets that arrived more than 1.5 periods after the previous packet.
    pub late: u64,
    /// Number of missing packets.
    pub missing: u64,
    /// Longest interval between two packets, s.
    pub longest_gap_s: f64,
}

impl ServoPackets {
    /// Adds an interval of `gap_s` to a stream with a period of `period_s`.
    fn add(&mut self, gap_s: f64, period_s: f64) {
        let periods = gap_s / period_s;
        if periods > 1.5 {
            self.late += 1;
            self.missing += (periods.round() as u64).saturating_sub(1);
        }
        self.longest_gap_s = self.longest_gap_s.max(gap_s);
    }
}

/// The state of a live flight in one period.
#[derive(Clone, Copy, Debug)]
pub struct LiveSample {
    /// True state of the centre of gravity.
    pub truth: Truth,
    /// The pilot's sticks, with the moves of the scene.
    pub pilot: Sticks,
    /// Controls commanded to the servos.
    pub commanded: Sticks,
    /// Whether the pilot's switch is closed.
    pub switch_on: bool,
    /// The wind, m/s.
    pub wind_mps: Vector<Ned>,
}

/// The simulation of the vehicle at the other end of the lines.
pub(crate) struct Plant {
    config: LiveConfig,
    skill: HoverConfig,
    step_s: f64,
    steps: u64,
    vehicle: Vehicle,
    wind: Wind,
    wind_mps: Vector<Ned>,
    dmu: SimulatedDmu,
    gps: SimulatedGps,
    next_fix: u64,
    last_fix: Option<Fix>,
    /// Fixes that are not on the receiver's line yet.
    pub fixes: Vec<Fix>,
    pub measured_fixes: Vec<Fix>,
    pub imu: Vec<ImuSample>,
    last_packet: Option<AnglePacket>,
    pilot: Pilot,
    pilot_sticks: Sticks,
    /// Decoder of the flight computer's packets.
    servo_stream: PacketCapture,
    packets: u64,
    /// Time of the last packet of the flight computer.
    last_packet_at: Option<Time>,
    /// Start of the current interval between packets.
    gap_from: Option<Time>,
    servo_packets: ServoPackets,
    commanded: Sticks,
    sequence: u8,
    /// Time at which the IMU sent its last bytes; `None` once the servo command that follows them has arrived.
    unit_sent_at: Option<Time>,
    pub turnaround: DurationHistogram,
    pub samples: Vec<LiveSample>,
}

/// `fix` as received after damage to its message.
fn damaged(fix: Fix) -> Fix {
    Fix {
        position: fix.position.displaced(Vector::new(60.0, 0.0, 0.0)),
        horizontal_velocity_mps: fix
            .horizontal_velocity_mps
            .map(|[north, east]| [north + 20.0, east]),
        ..fix
    }
}

impl Plant {
    pub fn new(config: LiveConfig) -> Result<Self, LiveFlightError> {
        let flight = &config.flight;
        let step_s = flight.autopilot.period_s / STEPS as f64;
        let neutral = flight.autopilot.trim.sticks;
        Ok(Self {
            vehicle: flight.hovering()?.0,
            wind: Wind::new(&flight.wind, step_s, flight.seed)?,
            wind_mps: Vector::ZERO,
            dmu: SimulatedDmu::new(&flight.dmu, flight.seed)?,
            gps: SimulatedGps::new(&flight.gps, flight.seed)?,
            next_fix: 0,
            last_fix: None,
            fixes: Vec::new(),
            measured_fixes: Vec::new(),
            imu: Vec::new(),
            last_packet: None,
            pilot: Pilot::new(flight.autopilot)?,
            pilot_sticks: neutral,
            servo_stream: PacketCapture::default(),
            packets: 0,
            last_packet_at: None,
            gap_from: None,
            servo_packets: ServoPackets::default(),
            commanded: neutral,
            sequence: 0,
            unit_sent_at: None,
            turnaround: DurationHistogram::default(),
            samples: Vec::new(),
            skill: flight.autopilot,
            step_s,
            steps: 0,
            config,
        })
    }

    /// Whether an act of the scene is active.
    pub fn has(&self, act: Act, now: Time) -> bool {
        self.config.scene.has(act, now.seconds())
    }

    pub fn has_crashed(&self) -> bool {
        self.vehicle.has_crashed()
    }

    /// Regularity of the servo packets until now; packets that are overdue count as missing.
    pub fn servo_packets(&self) -> ServoPackets {
        let mut packets = self.servo_packets;
        if let Some(before) = self.gap_from {
            packets.add(self.time() - before, self.skill.period_s);
        }
        packets
    }

    /// Advances the flight to `now`.
    pub fn advance(&mut self, now: Time) {
        while self.time() + self.step_s <= now && !self.vehicle.has_crashed() {
            self.step();
        }
    }

    fn time(&self) -> Time {
        Time::ZERO + self.steps as f64 * self.step_s
    }

    fn step(&mut self) {
        let time = self.time();
        let time_s = time.seconds();
        let state = self.vehicle.state();
        self.wind_mps = self.wind.advance();
        let passed = self.last_packet_at.is_none_or(|at| time - at > PASS_THROUGH_S);
        if passed {
            self.commanded = self.pilot_sticks;
        }
        if self.steps.is_multiple_of(STEPS) {
            let switch_on = self.config.scene.has(Act::Engage, time_s);
            let seen = state.solution(time);
            let still = self.config.scene.has(Act::Still, time_s);
            // The moves of the scene belong to the pilot's sticks, too.
            let moved = self.config.scene.moved(time_s);
            let others = plus(self.commanded, moved, -1.0);
            self.pilot_sticks = self.pilot.sticks(&seen, others, switch_on, still);
            self.samples.push(LiveSample {
                truth: state.truth(time),
                pilot: moved_by(self.pilot_sticks, moved),
                commanded: self.commanded,
                switch_on,
                wind_mps: self.wind_mps,
            });
        }
        self.measure_fixes(time, &state);
        self.vehicle.step(self.commanded, self.wind_mps, self.step_s);
        self.steps += 1;
    }

    fn measure_fixes(&mut self, time: Time, state: &State) {
        let gps = &self.config.flight.gps;
        while Time::ZERO + self.next_fix as f64 / gps.rate_hz <= time {
            self.next_fix += 1;
            let antenna = state.at_point(gps.lever_arm_m);
            let fix = self.gps.measure(time, &antenna.position, antenna.velocity_mps);
            let scene = &self.config.scene;
            if scene.has(Act::NoFix, time.seconds()) {
                continue;
            }
            let frozen = self.last_fix.filter(|_| scene.has(Act::FrozenFix, time.seconds()));
            let said = match frozen {
                Some(last) => Some(Fix { time, ..last }),
                None => fix,
            };
            self.last_fix = said.or(self.last_fix);
            let said = match scene.has(Act::WildFix, time.seconds()) {
                true => said.map(damaged),
                false => said,
            };
            self.fixes.extend(said);
            self.measured_fixes.extend(said);
        }
    }

    /// The IMU's answer to a poll at `now`.
    pub fn packet(&mut self, now: Time) -> Option<AnglePacket> {
        if now < Time::ZERO {
            return None;
        }
        self.advance(now);
        if let Some(last) =
            self.last_packet.filter(|_| self.config.scene.has(Act::FrozenImu, now.seconds()))
        {
            return Some(last);
        }
        let state = self.vehicle.state();
        let sample = self.dmu.measure(
            now,
            &ImuTruth {
                angular_rate_radps: state.inertial_rate_radps,
                specific_force_mps2: state.specific_force_at(self.config.flight.dmu.lever_arm_m),
                body_to_ned: state.body_to_ned,
            },
        );
        self.imu.push(sample);
        let mean = sample.motion.mean_rates(self.skill.period_s);
        let packet = self.config.calibration.counts(&Measurement {
            angular_rate_radps: mean.angular_rate_radps,
            specific_force_mps2: mean.specific_force_mps2,
            magnetic_field_gauss: sample.magnetic_field_gauss.unwrap_or_default(),
            attitude: sample.attitude,
            temperature_degc: 25.0,
        });
        self.last_packet = Some(packet);
        if self.config.scene.has(Act::WildPacket, now.seconds()) {
            return Some(AnglePacket { angular_rate: [i16::MAX; 3], ..packet });
        }
        Some(packet)
    }

    /// The pilot's next packet; `None` while the receiver sends none.
    pub fn pilot_packet(&mut self, now: Time) -> Option<ServoPacket> {
        self.advance(now);
        let time_s = now.seconds();
        let (scene, config) = (&self.config.scene, &self.config);
        if scene.has(Act::PilotLost, time_s) {
            return None;
        }
        let sticks = moved_by(self.pilot_sticks, scene.moved(time_s));
        let throttle_ms = config.channels.throttle.trim_ms;
        let mut widths_ms = if config.swashplate.pilot_is_mixed {
            config.swashplate.widths_ms(&config.channels, sticks, throttle_ms)
        } else {
            let mut plain = Channels { throttle: throttle_ms, ..Channels::default() };
            for (channel, stick) in STICK_CHANNELS.into_iter().zip(sticks.to_array()) {
                plain[channel] = config.channels[channel].width_ms(stick);
            }
            plain
        };
        let receiver_failsafe = scene.has(Act::ReceiverFailsafe, time_s);
        if receiver_failsafe {
            widths_ms = Channels::from_fn(|_| FAILSAFE_MS);
        }
        let aux_ms = if scene.has(Act::Engage, time_s) { AUX_MS.1 } else { AUX_MS.0 };
        let has_aux = !scene.has(Act::AuxLost, time_s);
        let packet = ServoPacket {
            sequence: self.sequence,
            width_ticks: widths_ms.map(|width_ms| Some(ServoPacket::ticks(width_ms))),
            aux_ticks: has_aux.then(|| ServoPacket::ticks(aux_ms)),
            receiver_failsafe,
            started: self.sequence == 0 && time_s < 1.0,
        };
        self.sequence = self.sequence.wrapping_add(1);
        Some(packet)
    }

    /// Reports that the IMU sends bytes at `now`.
    pub fn unit_sent(&mut self, now: Time) {
        // Times before the start of the flight are not measured.
        self.unit_sent_at = (now >= Time::ZERO).then_some(now);
    }

    /// Receives the bytes that the flight computer sends to the servos; they arrive at `now`.
    pub fn command(&mut self, bytes: &[u8], now: Time) {
        if let Some(sent) = self.unit_sent_at.take() {
            self.turnaround.add(now - sent);
        }
        self.advance(now);
        if self.config.scene.has(Act::ServosCut, now.seconds()) {
            self.gap_from = None;
            return;
        }
        let pulses = *self.servo_stream.receive(bytes, now);
        if self.servo_stream.counts().packets == self.packets {
            return;
        }
        self.packets = self.servo_stream.counts().packets;
        self.servo_packets.came += 1;
        if let Some(before) = self.gap_from.replace(now) {
            self.servo_packets.add(now - before, self.skill.period_s);
        }
        let (channels, plate) = (self.config.channels, self.config.swashplate);
        let stick = pulses
            .channels
            .zip(channels)
            .map(|(captured, config)| captured.pulse.map(|pulse| config.stick(pulse.width_ms)));
        if let (Some(lateral), Some(longitudinal), Some(collective), Some(pedal)) =
            (stick.lateral, stick.longitudinal, stick.collective, stick.pedal)
        {
            self.commanded = plate.sticks(Sticks { lateral, longitudinal, collective, pedal });
            self.last_packet_at = Some(now);
            if stick.throttle.is_some_and(|throttle| throttle < IDLE) {
                self.vehicle.lose_power();
            }
        }
    }
}

/// The `held` sticks moved by `moved`, limited to their travel.
fn moved_by(held: Sticks, moved: Sticks) -> Sticks {
    Sticks::from_array(plus(held, moved, 1.0).to_array().map(|stick| stick.clamp(-1.0, 1.0)))
}

/// The sum of `sticks` and `times` × `others`.
fn plus(sticks: Sticks, others: Sticks, times: f64) -> Sticks {
    let (sticks, others) = (sticks.to_array(), others.to_array());
    Sticks::from_array(std::array::from_fn(|stick| sticks[stick] + times * others[stick]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn late_and_missing_packets_are_counted_with_the_longest_gap() {
        let mut packets = ServoPackets::default();
        for gap_s in [0.03, 0.031, 0.029, 0.05, 0.12, 0.03] {
            packets.add(gap_s, 0.03);
        }
        assert_eq!((packets.late, packets.missing), (2, 4));
        assert_eq!(packets.longest_gap_s, 0.12);
    }
}
