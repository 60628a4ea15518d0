//! An airframe with the trim of another airframe, and an airframe with failures.

use approx::assert_abs_diff_eq;
use hovernav::autopilot::HoverConfig;
use hovernav::controls::Sticks;
use hovernav::earth::Geodetic;
use hovernav::frames::Vector;
use hovernav_design::hover::HoverDesign;
use hovernav_model::helicopter::{Helicopter, HelicopterParameters};
use hovernav_model::shipped;
use hovernav_sim::campaign::Campaign;
use hovernav_sim::{
    Feedback, Flight, FlightConfig, FlightEvent, Vehicle, VehicleConfig, WindConfig,
};

fn weighing(mass_kg: f64) -> HelicopterParameters {
    HelicopterParameters { mass_kg, ..HelicopterParameters::raptor60() }
}

fn vehicle(height_m: f64) -> Vehicle {
    let place = Geodetic::from_degrees(1.35, 103.82, height_m).unwrap();
    let helicopter = Helicopter::new(HelicopterParameters::raptor60()).unwrap();
    Vehicle::hovering(&VehicleConfig::default(), helicopter, place, 0.0).unwrap()
}

/// Climb rate after `seconds` with every stick at trim.
fn climb_mps(mut vehicle: Vehicle, seconds: f64) -> f64 {
    for _ in 0..(seconds / 0.03) as usize {
        vehicle.step(Sticks::NEUTRAL, Vector::ZERO, 0.03);
    }
    -vehicle.state().velocity_mps.z()
}

/// Mean collective of the hover of `flight` from `from_s` to `to_s`.
fn collective(flight: &Flight, from_s: f64, to_s: f64) -> f64 {
    let samples = flight.samples.iter();
    let within = samples.filter(|m| (from_s..to_s).contains(&m.truth.time.seconds()));
    let (sum, count) = within
        .fold((0.0, 0.0), |(sum, count), sample| (sum + sample.sticks.collective, count + 1.0));
    sum / count
}

/// A calm flight with the truth as feedback.
fn flight(change: impl FnOnce(&mut FlightConfig)) -> Flight {
    let design = HoverDesign::default();
    let gains = design.synthesise(&shipped::raptor60()).unwrap();
    let mut config = FlightConfig {
        wind: WindConfig::calm(),
        feedback: Feedback::Truth,
        duration_s: 40.0,
        ..FlightConfig::new(HoverConfig::new(design.period_s, gains))
    };
    change(&mut config);
    let flight = config.fly().unwrap();
    assert_eq!(flight.crashed_s, None);
    flight
}

#[test]
fn an_airframe_rigged_for_another_mass_hovers_with_its_collective_elsewhere() {
    let nominal = Helicopter::new(HelicopterParameters::raptor60()).unwrap();
    let collective = |mass_kg| {
        let other = nominal.with_parameters(weighing(mass_kg)).unwrap();
        // The state is a hover: with these sticks, its derivative is zero.
        let change = other.derivative(other.hover(), &other.hover_sticks(), Vector::ZERO);
        assert!(change.velocity_mps2.norm() < 1e-8 && change.rate_radps2.norm() < 1e-8);
        other.hover_sticks().collective
    };
    let [light, own, heavy] = [6.0, 8.0, 10.0].map(collective);
    println!("collective at 6, 8 and 10 kg: {light:.3} {own:.3} {heavy:.3}");
    assert!(own.abs() < 1e-9 && light < -0.1 && heavy > 0.1);
}

#[test]
fn a_heavier_airframe_shows_in_a_flight() {
    let fly = |mass_kg| {
        let flight = flight(|config| {
            config.rigged_for = Some(config.helicopter);
            config.helicopter = weighing(mass_kg);
        });
        collective(&flight, 30.0, 40.0)
    };
    let [own, heavy] = [8.0, 10.0].map(fly);
    println!("collective in flight at 8 and 10 kg: {own:.3} {heavy:.3}");
    assert!(heavy - own > 0.1);
}

#[test]
fn what_the_mass_is_off_by_shows_in_the_figures_of_a_campaign() {
    let design = HoverDesign::default();
    let gains = design.synthesise(&shipped::raptor60()).unwrap();
    let autopilot = HoverConfig::new(design.period_s, gains);
    let campaign = Campaign { duration_s: 40.0, ..Campaign::new(autopilot) };
    let mut draw = campaign.draw(3);
    let mut mean = |factor| {
        draw.drawn[0] = factor;
        campaign.fly(&draw).unwrap().hover.unwrap().sticks_mean[2]
    };
    let [light, heavy] = [0.9, 1.1].map(&mut mean);
    println!("mean collective at nine and eleven tenths of the mass: {light:.3} {heavy:.3}");
    assert!(heavy - light > 0.05);
}

#[test]
fn a_load_dropped_in_flight_is_flown_with_less_collective() {
    let flight = flight(|config| {
        config.rigged_for = Some(config.helicopter);
        config.helicopter = weighing(9.0);
        config.events = vec![(20.0, FlightEvent::Mass(7.0))];
    });
    let [before, after] = [(17.0, 20.0), (30.0, 40.0)].map(|(a, b)| collective(&flight, a, b));
    println!("collective before and after: {before:.3} {after:.3}");
    assert!(before - after > 0.1);
}

#[test]
fn the_ground_carries_a_part_of_the_weight() {
    // The skids are 0.38 m below the centre of gravity.
    let [near, far] = [0.6, 20.0].map(|height_m| climb_mps(vehicle(height_m), 0.5));
    println!("climb after half a second at 0.6 m and at 20 m: {near:.3} {far:.1e} m/s");
    assert!(near > 0.1 && far.abs() < 1e-3);
}

#[test]
fn a_jammed_servo_stays_where_it_is() {
    let mut vehicle = vehicle(30.0);
    let up = Sticks { collective: 0.3, pedal: 0.3, ..Sticks::NEUTRAL };
    vehicle.jam(2);
    vehicle.jam(9);
    vehicle.step(up, Vector::ZERO, 0.5);
    assert_eq!(vehicle.servos().collective, 0.0);
    assert_abs_diff_eq!(vehicle.servos().pedal, 0.3, epsilon = 0.01);
}

/// The gyro acts through the tail's servo: with a jammed servo only the air damps the yaw motion.
#[test]
fn a_jammed_tail_has_no_gyro() {
    let turned_rad = |jams: bool| {
        let mut vehicle = vehicle(30.0);
        if jams {
            vehicle.jam(3);
            vehicle.set_mass(8.2).unwrap();
        }
        let up = Sticks { collective: 0.1, ..Sticks::NEUTRAL };
        for _ in 0..30 {
            vehicle.step(up, Vector::ZERO, 0.03);
        }
        vehicle.state().body_to_ned.euler().yaw_rad.abs()
    };
    let [moving, jammed] = [false, true].map(turned_rad);
    println!(
        "turned after 0.9 s of more torque: {moving:.4} rad, with a jammed tail {jammed:.3} rad"
    );
    assert!(jammed > 5.0 * moving && jammed > 0.1);
}

#[test]
fn a_mass_that_is_none_is_refused() {
    assert!(vehicle(30.0).set_mass(f64::NAN).is_err());
    assert!(vehicle(30.0).set_mass(-1.0).is_err());
}
