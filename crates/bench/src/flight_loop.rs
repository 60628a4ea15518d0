//! The work of the flight loop: decode, estimate, control, servos, telemetry, record.

use std::hint::black_box;
use std::io;
use std::path::Path;
use std::time::Instant;

use hovernav::autopilot::{Gains, HoverConfig};
use hovernav::controls::Channels;
use hovernav::dmu::{AnglePacket, Calibration, Command, Flow, Mode};
use hovernav::earth::STANDARD_GRAVITY_MPS2;
use hovernav::ekf::layout::WithoutHeightAids;
use hovernav::ekf::{Estimator, Notice, Solution, SteplessSolution};
use hovernav::event::Event;
use hovernav::flight_control::{ControlInputs, FlightControl, FlightControlConfig};
use hovernav::gps::Protocol;
use hovernav::gps::quality::Limits;
use hovernav::imu::{ImuSample, Motion};
use hovernav::sensors::{DmuConfig, GpsConfig, SensorOutput, Sensors};
use hovernav::servo::packet::{PacketCapture, ServoPacket};
use hovernav::servo::{ChannelConfig, Limiter};
use hovernav::telemetry::{Snapshot, frame};
use hovernav::time::Time;
use hovernav_record::{Entry, FlyConfig, Header, Line, Recorder};

use crate::PERIOD_S;
use crate::distribution::{Distribution, Pace, Times};
use crate::flight::{FIX_EVERY, Flight};
use crate::receiver::nav_pvt;

/// Cycles before the timing starts: start-up, alignment, and readiness of the autopilot.
const WARM_UP: u64 = 1_000;
/// Time from the request for a packet to the last byte of the packet, s.
const ANSWER_S: f64 = 0.008;
/// Ticks of the inertial unit's timer per period.
const TICKS: u16 = (PERIOD_S / 0.79e-6) as u16;

/// A flight computer without serial lines.
struct Computer {
    sensors: Sensors,
    flight: FlightLoop,
}

/// The state of the flight computer that receives the sensor data.
struct FlightLoop {
    estimator: Estimator<WithoutHeightAids, 26>,
    stepless: SteplessSolution,
    control: FlightControl,
    capture: PacketCapture,
    limiter: Limiter,
    recorder: Recorder,
    solution: Option<Solution>,
    last_fix: Option<Time>,
    /// Commands that the inertial unit has not answered yet.
    asked: Vec<Command>,
    sent: u8,
}

fn words(error: impl std::fmt::Display) -> String {
    error.to_string()
}

impl Computer {
    fn new(start: Time) -> Result<Self, String> {
        let mut gains = Gains::default();
        gains.heave.tracking_time_s = 1.0;
        gains.roll_pitch.measured =
            [[0.1, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.1, 0.0, 0.0, 0.0, 0.0]];
        gains.yaw.measured = [[0.2, 0.0]];
        let dmu = DmuConfig {
            mode: Mode::Angle,
            flow: Flow::Polled { cycle_s: PERIOD_S },
            calibration: Calibration::new(200.0, 4.0).map_err(words)?,
            latency_s: ANSWER_S,
        };
        let gps = GpsConfig {
            protocol: Protocol::Ubx,
            rate_hz: None,
            latency_s: 0.1,
            geoid_separation_m: None,
            limits: Limits::default(),
        };
        let config = "[dmu]\nport = 'none'\n[receiver]\nport = 'none'\nprotocol = 'ubx'\n";
        let config = FlyConfig::parse(config, Path::new("bench")).map_err(words)?;
        let header = Header::new(config, start, 0);
        let flight = FlightLoop {
            estimator: Estimator::with_layout(Flight::config()),
            stepless: SteplessSolution::default(),
            control: FlightControl::new(FlightControlConfig::new(HoverConfig::new(
                PERIOD_S, gains,
            )))
            .map_err(words)?,
            capture: PacketCapture::default(),
            limiter: Limiter::new(Channels::<ChannelConfig>::default(), 0.5).map_err(words)?,
            recorder: Recorder::start(io::sink(), &header).map_err(words)?,
            solution: None,
            last_fix: None,
            asked: Vec::new(),
            sent: 0,
        };
        Ok(Self { sensors: Sensors::new(dmu, gps, start), flight })
    }

    /// The work between two waits.
    fn cycle(&mut self, dmu: &[u8], gps: &[u8], pilot: &[u8], now: Time) {
        let Self { sensors, flight } = self;
        flight.recorder.raw(Line::Dmu, dmu, now);
        let until = sensors.dmu(dmu, now, |output| flight.observe(now, output));
        if !gps.is_empty() {
            flight.recorder.raw(Line::Gps, gps, now);
            sensors.gps(gps, now, |output| flight.observe(now, output));
            // The line is silent after the message.
            sensors.gps(&[], now, |output| flight.observe(now, output));
        }
        black_box(until);
        flight.fly(pilot, now);
    }
}

impl FlightLoop {
    fn observe(&mut self, now: Time, output: SensorOutput) {
        match output {
            SensorOutput::WriteDmu(command) => self.asked.push(command),
            SensorOutput::Event(event) => self.estimate(now, &event),
            other => self.recorder.push(now, Entry::Sensor(other)),
        }
    }

    fn estimate(&mut self, now: Time, event: &Event) {
        let Self { estimator, stepless, control, recorder, .. } = self;
        if let Event::Gps(_) = event {
            self.last_fix = Some(now);
        }
        control.observe(event);
        estimator.push_traced(event, stepless, |notice: Notice| {
            control.observe_notice(&notice);
            recorder.push(now, notice);
        });
        if let Event::Imu(_) = event {
            let solution = estimator.solution();
            if let Some(solution) = solution {
                recorder.push(now, Entry::Solution(solution));
            }
            self.solution = solution.map(|solution| stepless.solution(&solution));
        }
    }

    /// One cycle of pilot input, control, servo output and telemetry.
    fn fly(&mut self, pilot: &[u8], now: Time) {
        self.capture.receive(pilot, now);
        let solution = self.solution;
        let inputs = ControlInputs {
            now,
            solution: solution.as_ref(),
            fix_age_s: self.last_fix.map(|fix| now - fix),
            pulses: self.capture.pulses(),
            servos_good: true,
            late_cycles: 0,
        };
        let outputs = self.control.step(&inputs, |notice| {
            black_box(notice);
        });
        let pulses = self.limiter.apply(&outputs.widths_ms, now);
        if let Some(sticks) = outputs.sticks {
            self.recorder.push(now, Entry::Controls(sticks.to_array()));
        }
        let ms = |width_ms: f64| width_ms as f32;
        let commanded_ms = pulses.map(|servo| ms(servo.width_ms)).to_array();
        let entry = Entry::Servo { captured_ms: [1.5; 5], commanded_ms };
        self.recorder.push(now, entry);

        let mut snapshot = Snapshot::at(now);
        if let Some(solution) = &solution {
            snapshot = snapshot.with_solution(solution);
        }
        snapshot.commanded_ms = pulses.map(|servo| Some(servo.width_ms));
        black_box(frame::pack(&snapshot, self.sent));
        self.sent = self.sent.wrapping_add(1);
    }

    /// The inertial unit's answer to all pending commands.
    fn answer(&mut self, packet: &AnglePacket) -> Vec<u8> {
        let mut bytes = Vec::new();
        for command in self.asked.drain(..) {
            match command.reply() {
                Some(reply) => bytes.push(reply),
                None if command.byte() == b'G' => bytes.extend(packet.encode()),
                None => {}
            }
        }
        bytes
    }
}

/// A sample in raw counts: ranges 200 °/s and 4 g, see `Calibration`.
fn packet(sample: &ImuSample, timer: u16) -> AnglePacket {
    let count = |value: f64, full: f64| (value / (full * 1.5) * 32_768.0).round() as i16;
    let angle = |radians: f64| (radians / std::f64::consts::PI * 32_768.0) as i32 as i16;
    let mut packet = AnglePacket { timer, temperature: 2_200, ..AnglePacket::default() };
    if let Motion::Rates { angular_rate_radps, specific_force_mps2 } = sample.motion {
        let rates = angular_rate_radps.to_array();
        packet.angular_rate = rates.map(|rate| count(rate.to_degrees(), 200.0));
        // The inertial unit's accelerometers count in the opposite direction.
        packet.acceleration =
            specific_force_mps2.to_array().map(|force| count(-force / STANDARD_GRAVITY_MPS2, 4.0));
    }
    if let Some(angles) = sample.attitude {
        packet.attitude = [angle(angles.roll_rad), angle(angles.pitch_rad), angle(angles.yaw_rad)];
    }
    if let Some(field) = sample.magnetic_field_gauss {
        packet.magnetic_field = field.to_array().map(|gauss| count(gauss, 1.25));
    }
    packet
}

/// Times `cycles` cycles.
pub fn time(cycles: u64, clock_ns: f64) -> Result<Distribution, String> {
    let mut flight = Flight::new()?;
    let mut computer = Computer::new(Time::ZERO)?;
    let mut times = Times::with_capacity(cycles);
    let mut timer = 0_u16;
    let mut pace = Pace::begin();
    for cycle in 0..WARM_UP + cycles {
        pace.rest();
        timer = timer.wrapping_sub(TICKS);
        let request = Flight::time(cycle);
        let now = request + ANSWER_S;
        let sample = flight.sample(cycle);
        // The request to the inertial unit happens in an earlier wake-up and is not timed.
        let Computer { sensors, flight: FlightLoop { asked, .. } } = &mut computer;
        sensors.dmu(&[], request, |output| {
            if let SensorOutput::WriteDmu(command) = output {
                asked.push(command);
            }
        });
        let dmu = computer.flight.answer(&packet(&sample, timer));
        let message =
            (cycle % FIX_EVERY == 0).then(|| nav_pvt(&flight.fix(cycle), cycle / FIX_EVERY));
        let gps: &[u8] = message.as_ref().map_or(&[], |bytes| bytes);
        let pilot = ServoPacket {
            sequence: cycle as u8,
            width_ticks: Channels::from_fn(|_| Some(ServoPacket::ticks(1.5))),
            aux_ticks: Some(ServoPacket::ticks(if cycle > WARM_UP / 2 { 2.0 } else { 1.0 })),
            ..ServoPacket::default()
        }
        .encode();

        let start = Instant::now();
        computer.cycle(black_box(&dmu), black_box(gps), black_box(&pilot), now);
        if cycle >= WARM_UP {
            times.push(start);
        }
    }
    if computer.flight.solution.is_none() || computer.flight.last_fix.is_none() {
        return Err("the synthetic flight does not reach the estimator".into());
    }
    Ok(times.distribution(clock_ns))
}
