//! The C interface gives the same bits as Rust. The tests use a notch at one speed, a notch that follows a rotor, and
//! the raw bytes of both serial lines with the autopilot.

use std::f64::consts::TAU;
use std::mem::MaybeUninit;
use std::ptr::null_mut;

use hovernav::autopilot::{Gains, HoverAutopilot, HoverConfig, Inputs};
use hovernav::dmu::{AnglePacket, Calibration, Flow, Mode as DmuMode};
use hovernav::earth::Geodetic;
use hovernav::ekf::{Estimator, EstimatorConfig, SteplessSolution};
use hovernav::event::Event;
use hovernav::frames::EulerAngles;
use hovernav::gps::Protocol;
use hovernav::gps::quality::Limits;
use hovernav::health::HealthLimits;
use hovernav::imu::{ImuSample as CoreSample, Motion, Notch, NotchConfig};
use hovernav::sensors::{DmuConfig, GpsConfig, SensorOutput, Sensors};
use hovernav::time::Time;
use hovernav_c::settings::{AutopilotConfig, Config, hovernav_default_lines_config};
use hovernav_c::*;

const PERIOD_S: f64 = 0.01;

/// A C object and its memory.
struct Navigator {
    _memory: Vec<u128>,
    nav: *mut Hovernav,
}

impl Navigator {
    fn new(notch: Option<NotchConfig>) -> Self {
        let config = Config::of(&EstimatorConfig::default(), notch, &HealthLimits::default());
        let mut memory = vec![0_u128; HOVERNAV_SIZE / 16];
        let (place, mut nav) = (memory.as_mut_ptr().cast(), null_mut());
        // SAFETY: memory of the given size.
        let status = unsafe {
            hovernav_create(place, HOVERNAV_SIZE, &raw const config, null_mut(), &raw mut nav)
        };
        assert_eq!(status, Status::Ok);
        Self { _memory: memory, nav }
    }

    /// Every bit of the solution, as text.
    fn solution(&self) -> Option<String> {
        let mut solution = MaybeUninit::uninit();
        // SAFETY: `self.nav` is a valid object, and `solution` has room for a solution.
        let status = unsafe { hovernav_get_solution(self.nav, solution.as_mut_ptr()) };
        // SAFETY: written if the status is success.
        (status == Status::Ok).then(|| format!("{:?}", unsafe { solution.assume_init() }))
    }
}

/// Gyros and accelerometers of a vehicle at rest under the vibration of a rotor, after `cycle` samples.
fn shaken(cycle: i64, phase: f64) -> ([f64; 3], [f64; 3]) {
    let grain = 0.002 * (cycle % 7) as f64;
    ([0.01 * phase.sin(), grain, 0.0], [2.0 * phase.cos(), grain, -9.81 + phase.sin()])
}

/// Passes 20 s of data through C and through Rust, and checks for equal bits. If the notch `follows` the rotor, both
/// receive the rotor's speed. Returns the last solution.
fn fly(notch: Option<NotchConfig>, increments: bool, follows: bool) -> String {
    let in_c = Navigator::new(notch);
    let mut in_rust = Estimator::new(EstimatorConfig::default());
    let mut before_rust = notch.map(Notch::new);
    let mut phase = 0.0;
    let mut last = None;
    for cycle in 0..2_000_i64 {
        let rotor_hz = 22.0 + 0.001 * cycle as f64;
        phase += TAU * rotor_hz * PERIOD_S;
        let time = Time::from_nanoseconds(cycle * 10_000_000);
        if follows && cycle % 10 == 0 {
            // SAFETY: an object.
            assert_eq!(unsafe { hovernav_push_rotor_speed(in_c.nav, rotor_hz) }, Status::Ok);
            before_rust.as_mut().unwrap().set_frequency_hz(rotor_hz);
        }
        let (mut gyro, mut accel) = shaken(cycle, phase);
        let (mut has, mut motion) = (
            HOVERNAV_IMU_ATTITUDE,
            Motion::Rates { angular_rate_radps: gyro.into(), specific_force_mps2: accel.into() },
        );
        if increments {
            (gyro, accel) = (gyro.map(|rate| rate * PERIOD_S), accel.map(|force| force * PERIOD_S));
            has |= HOVERNAV_IMU_INCREMENTS;
            motion = Motion::Increments { angle_rad: gyro.into(), velocity_mps: accel.into() };
        }
        let sample =
            ImuSample { time_ns: time.nanoseconds(), has, gyro, accel, ..ImuSample::default() };
        let core =
            CoreSample { attitude: Some(EulerAngles::default()), ..CoreSample::new(time, motion) };
        // SAFETY: an object and a valid pointer.
        assert_eq!(unsafe { hovernav_push_imu(in_c.nav, &raw const sample) }, Status::Ok);
        let core = before_rust.as_mut().map_or(core, |notch| notch.filter(&core));
        in_rust.push(&Event::Imu(core), |_| {});
        if cycle % 100 == 99 {
            let fix = Fix {
                time_ns: time.nanoseconds(),
                has: HOVERNAV_FIX_HORIZONTAL_VELOCITY,
                latitude_deg: 48.0,
                height_m: 500.0,
                ..Fix::default()
            };
            let place = Geodetic::from_degrees(48.0, 0.0, 500.0).unwrap();
            let core = hovernav::gps::Fix {
                horizontal_velocity_mps: Some([0.0; 2]),
                ..hovernav::gps::Fix::at(time, place)
            };
            // SAFETY: an object and a valid pointer.
            assert_eq!(unsafe { hovernav_push_fix(in_c.nav, &raw const fix) }, Status::Ok);
            in_rust.push(&Event::Gps(core), |_| {});
        }
        let solution = in_rust.solution().map(|core| format!("{:?}", Solution::from(&core)));
        last = in_c.solution();
        assert_eq!(last, solution, "cycle {cycle}");
    }
    last.unwrap()
}

#[test]
fn a_notch_in_c_gives_the_bits_of_rust() {
    let without = fly(None, false, false);
    for increments in [false, true] {
        let config = NotchConfig::at_hz(23.0).with_harmonics(2);
        let with = fly(Some(config), increments, false);
        assert_ne!(with, without);
    }
}

#[test]
fn a_notch_that_follows_the_rotor_gives_them_too() {
    let config = NotchConfig::default().with_width_hz(6.0);
    let followed = fly(Some(config), false, true);
    assert_ne!(followed, fly(Some(config), false, false));
}

#[test]
fn a_speed_that_cannot_be_is_refused_and_moves_nothing() {
    let navigator = Navigator::new(Some(NotchConfig::at_hz(23.0)));
    for (rotor_hz, status) in [
        (f64::NAN, Status::OutOfRange),
        (f64::INFINITY, Status::OutOfRange),
        (-1.0, Status::OutOfRange),
        (1e4, Status::OutOfRange),
        (0.0, Status::Ok),
        (23.0, Status::Ok),
    ] {
        // SAFETY: an object.
        let answer = unsafe { hovernav_push_rotor_speed(navigator.nav, rotor_hz) };
        assert_eq!(answer, status, "{rotor_hz}");
    }
}

const CYCLE_S: f64 = 0.0303;
/// Ticks of the inertial unit's timer, 0.79 us each, in a cycle.
const CYCLE_TICKS: u16 = 38_354;

/// Replies of a level Crossbow unit at rest to requests.
fn answer(asked: &[u8], cycle: u32, timer: u16) -> Vec<u8> {
    let shake = (cycle % 3) as i16;
    let packet = AnglePacket {
        attitude: [0, 0, 7_282],
        angular_rate: [shake, 1 - shake, 0],
        acceleration: [shake, -shake, 0x1555],
        temperature: 2_200,
        timer,
        ..AnglePacket::default()
    };
    let answers = asked.iter().flat_map(|byte| match byte {
        b'G' => packet.encode().to_vec(),
        b'R' => vec![b'H'],
        b'r' | b'c' | b'a' => vec![byte.to_ascii_uppercase()],
        _ => Vec::new(),
    });
    answers.collect()
}

/// One second of output of an NMEA receiver at rest.
fn nmea(second: u32) -> Vec<u8> {
    let sentence = |body: String| {
        let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
        format!("${body}*{sum:02X}\r\n")
    };
    let time = format!("12{:02}{:02}.00", second / 60, second % 60);
    let place = format!("GPGGA,{time},4806.0000,N,01136.0000,E,1,09,0.9,473.0,M,47.0,M,,");
    let speed = format!("GPRMC,{time},A,4806.0000,N,01136.0000,E,0.0,0.0,010625,,,A");
    (sentence(place) + &sentence(speed)).into_bytes()
}

/// Sensors, estimator and autopilot of the core.
struct Core {
    sensors: Sensors,
    estimator: Estimator,
    stepless: SteplessSolution,
    autopilot: HoverAutopilot,
}

impl Core {
    /// Processes bytes of the inertial unit or of the receiver. Returns the bytes to write, and the time, ns, until
    /// which to wait for bytes.
    fn read(&mut self, is_dmu: bool, bytes: &[u8], now: Time) -> (Vec<u8>, i64) {
        let mut reply = Vec::new();
        let Self { sensors, estimator, stepless, autopilot } = self;
        let observe = |output| match output {
            SensorOutput::WriteDmu(command) => reply.push(command.byte()),
            SensorOutput::WriteGps(command) => reply.extend_from_slice(command.as_bytes()),
            SensorOutput::Event(event) => {
                autopilot.observe(&event);
                estimator.push_traced(&event, stepless, |notice| autopilot.observe_notice(&notice));
            }
            _ => {}
        };
        if is_dmu {
            let until = sensors.dmu(bytes, now, observe);
            (reply, until.nanoseconds())
        } else {
            sensors.gps(bytes, now, observe);
            (reply, 0)
        }
    }
}

impl Navigator {
    /// As `Core::read`, but through the C interface.
    fn read(&self, is_dmu: bool, bytes: &[u8], now: Time) -> (Vec<u8>, i64) {
        let push = if is_dmu { hovernav_push_dmu_bytes } else { hovernav_push_gps_bytes };
        let mut result = MaybeUninit::<LineResult>::uninit();
        let place = result.as_mut_ptr();
        // SAFETY: an object, bytes of this length, and memory for the result.
        let status =
            unsafe { push(self.nav, bytes.as_ptr(), bytes.len(), now.nanoseconds(), place) };
        assert_eq!(status, Status::Ok);
        // SAFETY: written, because the status is success.
        let result = unsafe { result.assume_init() };
        (result.reply[..result.reply_length as usize].to_vec(), result.read_until_ns)
    }

    /// Every bit of a step of the autopilot, as text.
    fn step(&self, now: Time) -> String {
        let inputs = AutopilotInputs {
            now_ns: now.nanoseconds(),
            has_pilot: 1,
            engage: 1,
            pilot: settings::Sticks::default(),
        };
        let mut outputs = MaybeUninit::<AutopilotOutputs>::uninit();
        // SAFETY: an object and valid pointers.
        let status =
            unsafe { hovernav_step_autopilot(self.nav, &raw const inputs, outputs.as_mut_ptr()) };
        assert_eq!(status, Status::Ok);
        // SAFETY: written, because the status is success.
        format!("{:?}", unsafe { outputs.assume_init() })
    }
}

#[test]
fn raw_bytes_of_both_lines_come_to_the_same_solution_and_sticks() {
    let mut gains = Gains::default();
    gains.heave.tracking_time_s = 1.0;
    gains.attitude.measured[0][0] = 0.1;
    gains.roll_pitch.measured[1][1] = 0.1;
    let hover = HoverConfig::new(CYCLE_S, gains);
    let dmu = DmuConfig {
        mode: DmuMode::Angle,
        flow: Flow::Polled { cycle_s: CYCLE_S },
        calibration: Calibration::new(200.0, 4.0).unwrap(),
        latency_s: DmuMode::Angle.transfer_time_s(),
    };
    let gps = GpsConfig {
        protocol: Protocol::Nmea,
        rate_hz: None,
        latency_s: 0.12,
        geoid_separation_m: None,
        limits: Limits::default(),
    };
    let mut in_rust = Core {
        sensors: Sensors::new(dmu, gps, Time::ZERO),
        estimator: Estimator::new(EstimatorConfig::default()),
        stepless: SteplessSolution::default(),
        autopilot: HoverAutopilot::new(hover).unwrap(),
    };
    let in_c = Navigator::new(None);
    let mut lines = MaybeUninit::uninit();
    let autopilot = AutopilotConfig::of(&hover);
    // SAFETY: an object and valid pointers.
    unsafe {
        let _ = hovernav_default_lines_config(lines.as_mut_ptr(), HOVERNAV_ABI);
        let status = hovernav_start_lines(in_c.nav, lines.as_ptr(), 0, null_mut());
        assert_eq!(status, Status::Ok);
        let status = hovernav_start_autopilot(in_c.nav, &raw const autopilot, null_mut());
        assert_eq!(status, Status::Ok);
    }
    let (mut timer, mut steps) = (0_u16, 0);
    for cycle in 0..1_500_u32 {
        let began = Time::ZERO + f64::from(cycle) * CYCLE_S;
        let now = began + DmuMode::Angle.transfer_time_s();
        timer = timer.wrapping_sub(CYCLE_TICKS);
        let mut said = Vec::new();
        let mut at = began;
        loop {
            let (asked, until) = in_rust.read(true, &said, at);
            assert_eq!(in_c.read(true, &said, at), (asked.clone(), until), "cycle {cycle}");
            said = answer(&asked, cycle, timer);
            at = now;
            if said.is_empty() {
                break;
            }
        }
        if cycle % 33 == 0 {
            let said = nmea(cycle / 33);
            assert_eq!(in_c.read(false, &said, now), in_rust.read(false, &said, now));
        }
        let solution = in_rust.estimator.solution();
        let told = solution.map(|core| format!("{:?}", Solution::from(&core)));
        assert_eq!(in_c.solution(), told, "cycle {cycle}");
        let flown = solution.map(|own| in_rust.stepless.solution(&own));
        steps += u32::from(flown != solution);
        let inputs = Inputs {
            now,
            solution: flown.as_ref(),
            pilot: Some(hovernav::controls::Sticks::NEUTRAL),
            engage: true,
        };
        let outputs = AutopilotOutputs::from(&in_rust.autopilot.step(&inputs));
        assert_eq!(in_c.step(now), format!("{outputs:?}"), "cycle {cycle}");
    }
    assert!(steps > 1_000, "the autopilot flies without the steps of corrections: {steps}");
}
