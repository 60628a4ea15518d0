//! A linear hover model as an airframe.

use approx::assert_abs_diff_eq;
use hovernav::controls::Sticks;
use hovernav::frames::{EulerAngles, Rotation, Vector};
use hovernav_model::helicopter::HelicopterState;
use hovernav_model::{LinearAirframe, StateSpace, shipped};
use std::path::Path;

/// States of the test vector, in order, and the derivative of each.
const STATES: [&str; 13] =
    ["u", "v", "w", "p", "q", "r", "phi", "theta", "a", "b", "c", "d", "rfb"];

fn state_of(x: &[f64; 13]) -> HelicopterState {
    HelicopterState {
        velocity_mps: Vector::new(x[0], x[1], x[2]),
        rate_radps: Vector::new(x[3], x[4], x[5]),
        body_to_ned: Rotation::from_euler(EulerAngles {
            roll_rad: x[6],
            pitch_rad: x[7],
            yaw_rad: 0.0,
        }),
        longitudinal_flapping_rad: x[8],
        lateral_flapping_rad: x[9],
        longitudinal_bar_rad: x[10],
        lateral_bar_rad: x[11],
        yaw_feedback_radps: x[12],
    }
}

fn derivative(airframe: &LinearAirframe, x: &[f64; 13], sticks: [f64; 4]) -> [f64; 13] {
    let change = airframe.derivative(&state_of(x), &Sticks::from_array(sticks), Vector::ZERO);
    let [du, dv, dw] = change.velocity_mps2.to_array();
    let [dp, dq, dr] = change.rate_radps2.to_array();
    [
        du,
        dv,
        dw,
        dp,
        dq,
        dr,
        x[3],
        x[4],
        change.longitudinal_flapping_radps,
        change.lateral_flapping_radps,
        change.longitudinal_bar_radps,
        change.lateral_bar_radps,
        change.yaw_feedback_radps2,
    ]
}

#[test]
fn near_a_hover_the_airframe_is_its_model() {
    for model in [shipped::mettler_r50(), shipped::raptor60()] {
        let airframe = LinearAirframe::new(&model).unwrap();
        let step = 1e-6;
        for (column, name) in STATES.into_iter().enumerate() {
            let Ok(own) = model.state(name) else { continue };
            let mut x = [0.0; 13];
            x[column] = step;
            let above = derivative(&airframe, &x, [0.0; 4]);
            for (row, value) in STATES.into_iter().zip(above) {
                let Ok(to) = model.state(row) else { continue };
                // The attitude rates follow from the angular rates, not from the model.
                if ["phi", "theta"].contains(&row) {
                    continue;
                }
                // Gravity in the airframe is standard gravity; in the models it is 9.81 m/s², rounded or tilted by the
                // trim.
                let expected = model.a()[(to, own)];
                assert_abs_diff_eq!(value / step, expected, epsilon = 0.02);
            }
        }
        for (column, stick) in Sticks::NAMES.into_iter().enumerate() {
            let mut sticks = [0.0; 4];
            sticks[column] = 1.0;
            let full = derivative(&airframe, &[0.0; 13], sticks);
            for (row, value) in STATES.into_iter().zip(full) {
                let Ok(to) = model.state(row) else { continue };
                let expected = model.b()[(to, model.input(stick).unwrap())];
                assert_abs_diff_eq!(value, expected, epsilon = 1e-9);
            }
        }
    }
}

#[test]
fn gravity_turns_with_the_attitude_and_the_wind_acts_on_the_body() {
    let airframe = LinearAirframe::new(&shipped::mettler_r50()).unwrap();
    let upside_down = HelicopterState {
        body_to_ned: Rotation::from_euler(EulerAngles {
            roll_rad: std::f64::consts::PI,
            pitch_rad: 0.0,
            yaw_rad: 0.0,
        }),
        ..HelicopterState::LEVEL
    };
    let fall = airframe.derivative(&upside_down, &Sticks::NEUTRAL, Vector::ZERO);
    // Thrust and gravity point the same way, with what roll itself costs in the linear model.
    assert_abs_diff_eq!(fall.velocity_mps2.z(), -2.0 * 9.80665, epsilon = 1e-9);
    let wind = Vector::new(0.0, 0.0, 2.0);
    let gust = airframe.derivative(&HelicopterState::LEVEL, &Sticks::NEUTRAL, wind);
    let sink =
        HelicopterState { velocity_mps: Vector::new(0.0, 0.0, -2.0), ..HelicopterState::LEVEL };
    let climb = airframe.derivative(&sink, &Sticks::NEUTRAL, Vector::ZERO);
    assert_eq!(gust.velocity_mps2, climb.velocity_mps2);
    assert!(gust.velocity_mps2.z() > 1.0);
}

#[test]
fn a_model_that_is_no_vehicle_is_refused_with_the_reason() {
    let shipped = include_str!("../../crates/model/src/data/thesis.toml");
    let refused = |from: &str, to: &str| {
        assert!(shipped.contains(from), "{from}");
        let model = StateSpace::parse(&shipped.replacen(from, to, 1), Path::new("m.toml")).unwrap();
        LinearAirframe::new(&model).unwrap_err().to_string()
    };
    for (from, to, expected) in [
        ("name = \"w\"", "name = \"inflow\"", "the model has no \"w\""),
        (
            "name = \"p\", unit = \"rad/s\"",
            "name = \"p\", unit = \"deg/s\"",
            "p: found the unit \"deg/s\"",
        ),
        ("name = \"pedal\"", "name = \"rudder\"", "the model has no \"pedal\""),
        ("unit = \"%\"", "unit = \"us\"", "found the unit \"us\""),
        ("0.0, 0.0, 0.0, -9.81", "0.0, 0.0, 0.0, 9.81", "row u, column theta: found 9.81"),
        (
            "time_domain = \"continuous\"",
            "time_domain = \"discrete\"\nperiod_s = 0.03",
            "the model is discrete",
        ),
    ] {
        let error = refused(from, to);
        assert!(error.contains(expected), "{error}");
    }
}
