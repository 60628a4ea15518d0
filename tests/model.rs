//! What the models promise.

use hovernav::frames::{EulerAngles, Ned, Rotation, Vector};
use hovernav::model::helicopter::{
    Controls, Helicopter, HelicopterError, HelicopterParameters, HelicopterState,
};

fn raptor() -> Helicopter {
    Helicopter::new(HelicopterParameters::raptor60()).unwrap()
}

const CALM: Vector<Ned> = Vector::ZERO;

#[test]
fn hover_carries_the_weight_by_momentum_theory() {
    let helicopter = raptor();
    let hover = helicopter.hover();
    let rest = helicopter.derivative(hover, &Controls::default(), CALM);
    println!("{hover:?} {rest:?}");
    assert!(rest.velocity_mps2.norm() < 1e-9);
    assert!(rest.rate_radps2.norm() < 1e-9);
    // An accelerometer in hover reads gravity upwards.
    let up = hover.body_to_ned * rest.specific_force_mps2;
    assert!((up.z() + helicopter.parameters().gravity_mps2).abs() < 1e-9);
    // The tail pushes left, so the clockwise helicopter hovers right side low.
    assert!(hover.body_to_ned.euler().roll_rad > 0.01);
}

#[test]
fn every_stick_begins_the_motion_it_is_named_for() {
    let helicopter = raptor();
    let after = |controls: Controls| -> HelicopterState {
        let mut state = *helicopter.hover();
        for _ in 0..25 {
            state = helicopter.step(&state, &controls, CALM, 0.01);
        }
        state
    };
    let stick = Controls::default();
    assert!(after(Controls { lateral: 0.1, ..stick }).rate_radps.x() > 0.05);
    assert!(after(Controls { longitudinal: 0.1, ..stick }).rate_radps.y() > 0.05);
    assert!(after(Controls { collective: 0.1, ..stick }).velocity_mps.z() < -0.1);
    assert!(after(Controls { pedal: 0.1, ..stick }).rate_radps.z() > 0.1);
}

#[test]
fn trimmed_flight_stays_trimmed() {
    let helicopter = raptor();
    for (north, east, down) in
        [(0.0, 0.0, 0.0), (5.0, 0.0, 0.0), (-3.0, 2.0, 0.0), (8.0, 3.0, -1.0)]
    {
        let wind = Vector::new(1.0, -2.0, 0.0);
        let trim = helicopter.trim(Vector::new(north, east, down), wind, 0.7).unwrap();
        let rest = helicopter.derivative(&trim.state, &trim.controls, wind);
        assert!(rest.velocity_mps2.norm() < 1e-9 && rest.rate_radps2.norm() < 1e-9);
        println!("{north} {east} {down}: {:?}", trim.controls);
        let velocity = trim.state.velocity_ned_mps();
        assert!((velocity - Vector::new(north, east, down)).norm() < 1e-12);
    }
}

#[test]
fn wind_and_motion_through_still_air_are_the_same_to_the_forces() {
    let helicopter = raptor();
    let mut state = *helicopter.hover();
    state.body_to_ned = Rotation::from_euler(EulerAngles::from_degrees(4.0, -6.0, 130.0));
    let wind = Vector::<Ned>::new(3.0, -2.0, 0.5);
    let blown = helicopter.derivative(&state, &Controls::default(), wind);
    state.velocity_mps = state.velocity_mps - state.body_to_ned.inverse() * wind;
    let moving = helicopter.derivative(&state, &Controls::default(), CALM);
    assert!((blown.specific_force_mps2 - moving.specific_force_mps2).norm() < 1e-12);
    assert!((blown.rate_radps2 - moving.rate_radps2).norm() < 1e-11);
}

#[test]
fn what_no_helicopter_can_do_is_refused_with_the_reason() {
    let mut heavy = HelicopterParameters::raptor60();
    heavy.mass_kg = f64::NAN;
    let error = Helicopter::new(heavy).unwrap_err();
    assert!(error.to_string().contains("mass_kg: found NaN"), "{error}");
    let error = raptor().trim(Vector::new(f64::NAN, 0.0, 0.0), CALM, 0.0).unwrap_err();
    assert!(matches!(error, HelicopterError::NoTrim { .. }), "{error}");
}
