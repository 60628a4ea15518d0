//! Behaviour of the helicopter after an engine failure.

use approx::assert_abs_diff_eq;
use hovernav::autopilot::HoverConfig;
use hovernav::controls::Sticks;
use hovernav::earth::Geodetic;
use hovernav::frames::Vector;
use hovernav_design::hover::HoverDesign;
use hovernav_model::helicopter::{Helicopter, HelicopterParameters, RotorDrive};
use hovernav_model::shipped;
use hovernav_sim::{
    EngineConfig, Feedback, Flight, FlightConfig, FlightEvent, Vehicle, VehicleConfig, WindConfig,
};

/// Induced velocity of hover, √(m g/2ρA), m/s.
fn induced_mps(parameters: &HelicopterParameters) -> f64 {
    let weight_n = parameters.mass_kg * parameters.gravity_mps2;
    let area_m2 = parameters.main_rotor.disc_area_m2();
    (weight_n / (2.0 * parameters.air_density_kgpm3 * area_m2)).sqrt()
}

/// A calm flight from 400 m with the truth as feedback, whose engine stops at 20 s; `more` happens at the same time.
fn flight(more: &[FlightEvent]) -> Flight {
    let design = HoverDesign::default();
    let gains = design.synthesise(&shipped::raptor60()).unwrap();
    let mut config = FlightConfig {
        wind: WindConfig::calm(),
        feedback: Feedback::Truth,
        duration_s: 100.0,
        ..FlightConfig::new(HoverConfig::new(design.period_s, gains))
    };
    config.start.height_m = 400.0;
    config.events.push((20.0, FlightEvent::PowerLoss));
    config.events.extend(more.iter().map(|event| (20.0, *event)));
    config.fly().unwrap()
}

fn sink_mps(flight: &Flight, at_s: f64) -> f64 {
    let at = flight.samples.iter().find(|sample| sample.truth.time.seconds() >= at_s);
    at.map_or(f64::NAN, |sample| sample.truth.velocity_mps.z())
}

/// Rotor speed and sink rate of a level descent after `seconds` with the collective at `collective`, and the rotor
/// torque.
fn fall(collective: f64, seconds: f64) -> (f64, f64, f64) {
    let helicopter = Helicopter::new(HelicopterParameters::raptor60()).unwrap();
    let sticks = Sticks { collective, ..Sticks::NEUTRAL };
    let EngineConfig { inertia_kgm2, .. } = EngineConfig::default();
    let angular_momentum = inertia_kgm2 * helicopter.parameters().main_rotor.speed_radps;
    let (mut speed, mut state) = (1.0, *helicopter.hover());
    let step_s = 0.002;
    let mut torque_nm = 0.0;
    for _ in 0..(seconds / step_s) as usize {
        let drive = RotorDrive { speed, powered: false };
        let change = helicopter.driven(&state, &sticks, Vector::ZERO, drive);
        state.velocity_mps += Vector::new(0.0, 0.0, change.velocity_mps2.z()) * step_s;
        torque_nm = change.rotor_torque_nm;
        speed -= torque_nm / angular_momentum * step_s;
    }
    (speed, state.velocity_mps.z(), torque_nm)
}

#[test]
fn with_the_collective_down_it_autorotates_as_rotors_do() {
    let parameters = HelicopterParameters::raptor60();
    let (speed, sink_mps, torque_nm) = fall(-1.0, 20.0);
    let share = sink_mps / induced_mps(&parameters);
    println!(
        "rotor at {:.0} %, sink {sink_mps:.2} m/s, {share:.2} induced velocities",
        100.0 * speed
    );
    // A ratio of 1.79 corresponds to a rotor force of 1.25 times dynamic pressure times disc area, as on autogyros:
    // Leishman (2006), equations 12.7 to 12.11, after Harris (2003).
    assert!((1.6..2.1).contains(&share), "{share}");
    assert!((0.6..1.1).contains(&speed) && torque_nm.abs() < 1e-3, "{speed} {torque_nm}");
}

#[test]
fn the_power_of_the_fall_is_what_the_air_takes() {
    // In a steady descent no energy is stored: weight times sink rate heats the air. The blades' drag takes as much of
    // it as the rotor's torque without lift.
    let helicopter = Helicopter::new(HelicopterParameters::raptor60()).unwrap();
    let parameters = helicopter.parameters();
    let (speed, sink_mps, _) = fall(-1.0, 20.0);
    let rotor = &parameters.main_rotor;
    let tip_mps = speed * rotor.tip_speed_mps();
    let swept = parameters.air_density_kgpm3 * rotor.disc_area_m2();
    let profile_w = swept * tip_mps.powi(3) * rotor.solidity() * rotor.profile_drag / 8.0;
    let fall_w = parameters.mass_kg * parameters.gravity_mps2 * sink_mps;
    println!("fall {fall_w:.0} W, blades {profile_w:.0} W");
    assert!((0.2..0.8).contains(&(profile_w / fall_w)), "{}", profile_w / fall_w);
}

#[test]
fn the_higher_the_collective_is_held_the_slower_the_rotor_turns() {
    let [down, held, up] = [-1.0, 0.0, 1.0].map(|collective| fall(collective, 20.0).0);
    println!("rotor at {:.0}, {:.0}, {:.0} %", 100.0 * down, 100.0 * held, 100.0 * up);
    assert!(down > held + 0.1 && held > up + 0.05);
}

#[test]
fn an_autopilot_that_holds_its_height_does_not_save_it() {
    let flight = flight(&[]);
    assert!(flight.crashed_s.is_some_and(|at_s| at_s > 40.0), "{:?}", flight.crashed_s);
}

#[test]
fn a_flight_in_autorotation_sinks_steadily() {
    let down = Sticks { collective: -2.0, ..Sticks::NEUTRAL };
    let flight = flight(&[FlightEvent::AddSticks(down)]);
    let [early, late] = [35.0, 45.0].map(|at_s| sink_mps(&flight, at_s));
    let share = late / induced_mps(&HelicopterParameters::raptor60());
    println!("sink {early:.2} m/s, ten seconds later {late:.2}: {share:.2} induced velocities");
    assert_abs_diff_eq!(early, late, epsilon = 0.5);
    assert!((1.5..2.2).contains(&share));
}

#[test]
fn with_the_engine_running_the_rotor_stays_near_its_speed() {
    let helicopter = Helicopter::new(HelicopterParameters::raptor60()).unwrap();
    let place = Geodetic::from_degrees(1.35, 103.82, 100.0).unwrap();
    let config = VehicleConfig::default();
    let mut vehicle = Vehicle::hovering(&config, helicopter, place, 0.0).unwrap();
    for _ in 0..100 {
        vehicle.step(Sticks { collective: 0.2, ..Sticks::NEUTRAL }, Vector::ZERO, 0.03);
    }
    let expected = 1.0 - 0.2 * config.engine.droop;
    assert_abs_diff_eq!(vehicle.rotor_speed(), expected, epsilon = 1e-3);
}
