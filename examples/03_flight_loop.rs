//! The complete loop without hardware: sensors, estimator, autopilot, servo pulses and telemetry, 33 times a second,
//! around a simulated helicopter in gusty wind.
//!
//! Between measuring and moving the vehicle, `fly` does the work of a flight computer, in the same order and with the
//! same code.
//!
//! `cargo run --release --example 03_flight_loop`

use std::error::Error;

use hovernav::autopilot::{HoverAutopilot, HoverConfig, Inputs, Mode};
use hovernav::controls::{Channels, Sticks};
use hovernav::ekf::Estimator;
use hovernav::event::Event;
use hovernav::servo::{ChannelConfig, Limiter};
use hovernav::telemetry::{Snapshot, frame};
use hovernav::time::Time;
use hovernav_design::hover::HoverDesign;
use hovernav_model::helicopter::Helicopter;
use hovernav_model::shipped;
use hovernav_sim::{FlightConfig, ImuTruth, SimulatedDmu, SimulatedGps, Vehicle, Wind};

/// Results of the flight.
struct Outcome {
    mode: Mode,
    /// Root mean square of the true speed over the last half, m/s.
    speed_mps: f64,
    /// Bytes of telemetry sent.
    sent: usize,
}

fn fly(seconds: f64) -> Result<Outcome, Box<dyn Error>> {
    let design = HoverDesign::default();
    let gains = design.synthesise(&shipped::raptor60())?;
    let config = FlightConfig::new(HoverConfig::new(design.period_s, gains));
    let period_s = config.autopilot.period_s;

    // The world.
    let helicopter = Helicopter::new(config.helicopter)?;
    let mut vehicle =
        Vehicle::hovering(&config.vehicle, helicopter, config.start, config.heading_rad)?;
    let mut wind = Wind::new(&config.wind, period_s, config.seed)?;
    let mut dmu = SimulatedDmu::new(&config.dmu, config.seed)?;
    let mut gps = SimulatedGps::new(&config.gps, config.seed)?;

    // The flight computer.
    let channels = Channels::<ChannelConfig>::default();
    let mut estimator = Estimator::new(config.settings()?);
    let mut autopilot = HoverAutopilot::new(config.autopilot)?;
    let mut limiter = Limiter::new(channels, 0.5)?;

    let cycles = (seconds / period_s) as u32;
    let (mut square_sum, mut counted, mut sent) = (0.0, 0, 0);
    for cycle in 0..cycles {
        let now = Time::ZERO + f64::from(cycle) * period_s;

        let truth = vehicle.state();
        let felt = ImuTruth {
            angular_rate_radps: truth.inertial_rate_radps,
            specific_force_mps2: truth.at_point(config.dmu.lever_arm_m).specific_force_mps2,
            body_to_ned: truth.body_to_ned,
        };
        let sample = dmu.measure(now, &felt);
        estimator.push(&Event::Imu(sample), |_| {});
        if cycle % 33 == 0 {
            let antenna = truth.at_point(config.gps.lever_arm_m);
            if let Some(fix) = gps.measure(now, &antenna.position, antenna.velocity_mps) {
                estimator.push(&Event::Gps(fix), |_| {});
            }
        }

        // The pilot holds the sticks at trim until the estimator has aligned.
        let solution = estimator.solution();
        let outputs = autopilot.step(&Inputs {
            now,
            solution: solution.as_ref(),
            pilot: Some(Sticks::NEUTRAL),
            engage: solution.is_some(),
        });

        let Sticks { lateral, longitudinal, collective, pedal } = outputs.sticks;
        let wanted = Channels { throttle: 0.0, collective, longitudinal, lateral, pedal };
        let widths_ms = channels.zip(wanted).map(|(channel, stick)| channel.width_ms(stick));
        let pulses = limiter.apply(&widths_ms, now);

        let mut snapshot = Snapshot::at(now);
        snapshot.velocity_mps = solution.map(|solution| solution.velocity_mps);
        snapshot.commanded_ms = pulses.map(|servo| Some(servo.width_ms));
        sent += frame::pack(&snapshot, cycle as u8).len();

        let moved = channels.zip(pulses).map(|(channel, servo)| channel.stick(servo.width_ms));
        let Channels { collective, longitudinal, lateral, pedal, .. } = moved;
        let sticks = Sticks { lateral, longitudinal, collective, pedal };
        vehicle.step(sticks, wind.advance(), period_s);
        if 2 * cycle >= cycles {
            square_sum += vehicle.state().velocity_mps.norm().powi(2);
            counted += 1;
        }
    }
    if vehicle.has_crashed() {
        return Err("the helicopter crashed".into());
    }
    let speed_mps = (square_sum / f64::from(counted)).sqrt();
    Ok(Outcome { mode: autopilot.mode(), speed_mps, sent })
}

fn main() -> Result<(), Box<dyn Error>> {
    let Outcome { mode, speed_mps, sent } = fly(120.0)?;
    println!("{mode:?}: {speed_mps:.2} m/s in gusts of 1.5 m/s, {sent} bytes of telemetry");
    Ok(())
}

#[test]
fn it_hovers_in_gusts_on_its_own_estimate() {
    let outcome = fly(120.0).unwrap();
    assert_eq!(outcome.mode, Mode::Position);
    assert!(outcome.speed_mps < 0.6, "{} m/s", outcome.speed_mps);
    assert_eq!(outcome.sent, 3960 * frame::LENGTH);
}
