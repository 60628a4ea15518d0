//! The flight computer of a microcontroller on a desk: `computer.rs` is the part to copy, and this file replaces the
//! chip. A Crossbow IMU and an NMEA receiver, both at rest, are on the lines. Five channels of timers only store their
//! duty.
//!
//! `cargo run --release --example 05_microcontroller`
//!
//! `firmware/embassy` has the same `computer.rs` on an STM32, with DMA and timers.

mod computer;

use std::convert::Infallible;
use std::error::Error;

use computer::{FRAME_MS, FlightComputer};
use embedded_hal::pwm::{ErrorType, SetDutyCycle};
use hovernav::autopilot::{Gains, HoverAutopilot, HoverConfig, Mode};
use hovernav::controls::{Channels, Sticks};
use hovernav::dmu::{AnglePacket, Calibration, Flow, Mode as DmuMode};
use hovernav::ekf::{EstimatorConfig, Solution};
use hovernav::gps::Protocol;
use hovernav::gps::quality::Limits;
use hovernav::sensors::{DmuConfig, GpsConfig, Sensors};
use hovernav::servo::{ChannelConfig, Limiter};
use hovernav::time::Time;

const CYCLE_S: f64 = 0.0303;
/// Ticks of the IMU's timer, 0.79 µs each, in a cycle.
const CYCLE_TICKS: u16 = 38_354;

/// A timer channel that stores its duty: 16 bits, as on most chips.
#[derive(Default)]
struct Channel {
    duty: u16,
}

impl ErrorType for Channel {
    type Error = Infallible;
}

impl SetDutyCycle for Channel {
    fn max_duty_cycle(&self) -> u16 {
        u16::MAX
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        self.duty = duty;
        Ok(())
    }
}

/// Results of a test on the desk.
struct Outcome {
    solution: Option<Solution>,
    mode: Mode,
    /// Pulse of the lateral servo, ms.
    lateral_ms: f64,
}

fn sensors(start: Time) -> Result<Sensors, Box<dyn Error>> {
    let dmu = DmuConfig {
        mode: DmuMode::Angle,
        flow: Flow::Polled { cycle_s: CYCLE_S },
        calibration: Calibration::new(200.0, 4.0)?,
        latency_s: DmuMode::Angle.transfer_time_s(),
    };
    let gps = GpsConfig {
        protocol: Protocol::Nmea,
        rate_hz: None,
        latency_s: 0.1,
        geoid_separation_m: None,
        limits: Limits::default(),
    };
    Ok(Sensors::new(dmu, gps, start))
}

fn sentence(body: &str) -> String {
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${body}*{sum:02X}\r\n")
}

/// One second of output of a receiver at rest.
fn nmea(second: u32) -> String {
    let (minute, second) = (second / 60, second % 60);
    let time = format!("12{minute:02}{second:02}.00");
    sentence(&format!("GPGGA,{time},4806.0000,N,01136.0000,E,1,09,0.9,473.0,M,47.0,M,,"))
        + &sentence(&format!("GPRMC,{time},A,4806.0000,N,01136.0000,E,0.0,0.0,010625,,,A"))
}

fn stand(seconds: f64) -> Result<Outcome, Box<dyn Error>> {
    // A design for the vehicle gives usable gains; these only damp rates.
    let mut gains = Gains::default();
    gains.heave.tracking_time_s = 1.0;
    gains.attitude.measured = [[0.1, 0.0, 0.0, 0.0], [0.0, 0.1, 0.0, 0.0]];
    gains.roll_pitch.measured = [[0.1, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.1, 0.0, 0.0, 0.0, 0.0]];
    let channels = Channels::<ChannelConfig>::default();
    let servos: Channels<Channel> = Channels::default();
    let mut computer = FlightComputer::new(
        sensors(Time::ZERO)?,
        EstimatorConfig::default(),
        HoverAutopilot::new(HoverConfig::new(CYCLE_S, gains))?,
        channels,
        Limiter::new(channels, 0.5)?,
        servos,
    );

    let cycles = (seconds / CYCLE_S) as u32;
    let mut timer = 0_u16;
    let mut mode = Mode::Manual;
    for cycle in 0..cycles {
        let began = Time::ZERO + f64::from(cycle) * CYCLE_S;
        timer = timer.wrapping_sub(CYCLE_TICKS);
        // The IMU answers at once, one byte after another as its start-up requires, until it is silent.
        let (mut reply, _) = computer.dmu(&[], began);
        let now = began + DmuMode::Angle.transfer_time_s();
        while let Some(answer) = answer(reply.as_bytes(), cycle, timer) {
            (reply, _) = computer.dmu(&answer, now);
        }
        if cycle % 33 == 0 {
            computer.gps(nmea(cycle / 33).as_bytes(), now);
        }
        mode = computer.control(Some(Sticks::NEUTRAL), cycle > cycles / 2, now)?.mode;
    }
    let lateral_ms = f64::from(computer.servos.lateral.duty) / f64::from(u16::MAX) * FRAME_MS;
    Ok(Outcome { solution: computer.solution(), mode, lateral_ms })
}

/// The IMU's reply to a request.
fn answer(asked: &[u8], cycle: u32, timer: u16) -> Option<Vec<u8>> {
    // Level: 1 g down. The last bit is noisy, as in every real IMU.
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
    Some(answers.collect()).filter(|answers: &Vec<u8>| !answers.is_empty())
}

fn main() -> Result<(), Box<dyn Error>> {
    let Outcome { solution, mode, lateral_ms } = stand(60.0)?;
    let solution = solution.ok_or("the estimator has not aligned")?;
    let yaw_deg = solution.body_to_ned.euler().yaw_rad.to_degrees();
    println!(
        "{mode:?}: height {:.1} m, heading {yaw_deg:.1}°, lateral servo at {lateral_ms:.3} ms",
        solution.position.height_m
    );
    Ok(())
}

#[test]
fn bytes_on_two_lines_become_pulses() {
    use approx::assert_abs_diff_eq;

    let Outcome { solution, mode, lateral_ms } = stand(60.0).unwrap();
    let solution = solution.unwrap();
    assert_abs_diff_eq!(solution.position.height_m, 520.0, epsilon = 0.5);
    assert_abs_diff_eq!(solution.body_to_ned.euler().yaw_rad.to_degrees(), 40.0, epsilon = 1.0);
    assert!(solution.velocity_mps.norm() < 0.05);
    assert_ne!(mode, Mode::Manual);
    assert_abs_diff_eq!(lateral_ms, 1.5, epsilon = 0.02);
}
