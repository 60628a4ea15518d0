//! Guarantees of the models.

use approx::assert_abs_diff_eq;
use hovernav::controls::Sticks;
use hovernav::frames::{EulerAngles, Ned, Rotation, Vector};
use hovernav_model::helicopter::{
    Helicopter, HelicopterError, HelicopterParameters, HelicopterState,
};
use hovernav_model::{StateSpace, TimeDomain, hover, shipped};
use nalgebra::DMatrix;

fn raptor() -> Helicopter {
    Helicopter::new(HelicopterParameters::raptor60()).unwrap()
}

const CALM: Vector<Ned> = Vector::ZERO;

#[test]
fn hover_is_steady_right_side_low_and_feels_one_g() {
    let helicopter = raptor();
    let hover = helicopter.hover();
    let rest = helicopter.derivative(hover, &Sticks::default(), CALM);
    assert!(rest.velocity_mps2.norm() < 1e-9);
    assert!(rest.rate_radps2.norm() < 1e-9);
    // An accelerometer in hover measures gravity upwards.
    let up = hover.body_to_ned * rest.specific_force_mps2;
    assert_abs_diff_eq!(up.z(), -helicopter.parameters().gravity_mps2, epsilon = 1e-9);
    // The tail pushes left, so the clockwise helicopter hovers right side low.
    assert!(hover.body_to_ned.euler().roll_rad > 0.01);
}

#[test]
fn every_stick_begins_the_motion_it_is_named_for() {
    let helicopter = raptor();
    let after = |controls: Sticks| -> HelicopterState {
        let mut state = *helicopter.hover();
        for _ in 0..25 {
            state = helicopter.step(&state, &controls, CALM, 0.01);
        }
        state
    };
    let stick = Sticks::default();
    assert!(after(Sticks { lateral: 0.1, ..stick }).rate_radps.x() > 0.05);
    assert!(after(Sticks { longitudinal: 0.1, ..stick }).rate_radps.y() > 0.05);
    assert!(after(Sticks { collective: 0.1, ..stick }).velocity_mps.z() < -0.1);
    assert!(after(Sticks { pedal: 0.1, ..stick }).rate_radps.z() > 0.1);
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
        let velocity = trim.state.velocity_ned_mps();
        assert!((velocity - Vector::new(north, east, down)).norm() < 1e-12);
    }
}

#[test]
fn slow_flight_is_trimmed_in_every_direction_up_to_its_limit() {
    let helicopter = raptor();
    for speed in [2.0, 8.0, 15.0] {
        for heading in 0..8 {
            let (east, north) = (f64::from(heading) * std::f64::consts::FRAC_PI_4).sin_cos();
            let velocity = Vector::new(speed * north, speed * east, 0.0);
            let trim = helicopter.trim(velocity, CALM, 0.0);
            if speed < 10.0 || heading == 0 {
                let angles = trim.unwrap().state.body_to_ned.euler();
                assert!(angles.roll_rad.abs() < 0.5 && angles.pitch_rad.abs() < 0.5);
            }
        }
    }
    let climb = |down| helicopter.trim(Vector::new(0.0, 0.0, down), CALM, 0.0).unwrap();
    assert!(climb(-3.0).controls.collective > 0.2 && climb(1.5).controls.collective < -0.1);
}

#[test]
fn no_state_or_stick_makes_the_helicopter_panic() {
    let helicopter = raptor();
    let extremes = [0.0, -1e3, 1e3, 1e200, -1e200, f64::NAN, f64::INFINITY];
    for one in extremes {
        for other in extremes {
            let mut state = *helicopter.hover();
            state.velocity_mps = Vector::new(one, other, -one);
            state.rate_radps = Vector::new(other, one, other);
            state.lateral_flapping_rad = other;
            let controls = Sticks { collective: one, pedal: other, ..Default::default() };
            let _ = helicopter.step(&state, &controls, Vector::new(other, 0.0, one), 0.01);
        }
    }
}

#[test]
fn wind_and_motion_through_still_air_are_the_same_to_the_forces() {
    let helicopter = raptor();
    let mut state = *helicopter.hover();
    state.body_to_ned = Rotation::from_euler(EulerAngles::from_degrees(4.0, -6.0, 130.0));
    let wind = Vector::<Ned>::new(3.0, -2.0, 0.5);
    let blown = helicopter.derivative(&state, &Sticks::default(), wind);
    state.velocity_mps -= state.body_to_ned.inverse() * wind;
    let moving = helicopter.derivative(&state, &Sticks::default(), CALM);
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

/// The state of these 13 numbers, and back.
fn state_of(x: &[f64; 13]) -> HelicopterState {
    HelicopterState {
        velocity_mps: Vector::new(x[0], x[1], x[2]),
        rate_radps: Vector::new(x[3], x[4], x[5]),
        body_to_ned: Rotation::from_euler(EulerAngles {
            roll_rad: x[6],
            pitch_rad: x[7],
            yaw_rad: x[8],
        }),
        longitudinal_flapping_rad: x[9],
        lateral_flapping_rad: x[10],
        longitudinal_bar_rad: x[11],
        lateral_bar_rad: x[12],
        ..HelicopterState::LEVEL
    }
}

fn derivative_of(
    helicopter: &Helicopter,
    x: &[f64; 13],
    u: &[f64; 4],
    wind: Vector<Ned>,
) -> [f64; 13] {
    let controls = Sticks::from_array(*u);
    let change = helicopter.derivative(&state_of(x), &controls, wind);
    let [du, dv, dw] = change.velocity_mps2.to_array();
    let [dp, dq, dr] = change.rate_radps2.to_array();
    let ([p, q, r], roll, pitch) = ([x[3], x[4], x[5]], x[6], x[7]);
    let heading = (q * roll.sin() + r * roll.cos()) / pitch.cos();
    [
        du,
        dv,
        dw,
        dp,
        dq,
        dr,
        p + heading * pitch.sin(),
        q * roll.cos() - r * roll.sin(),
        heading,
        change.longitudinal_flapping_radps,
        change.lateral_flapping_radps,
        change.longitudinal_bar_radps,
        change.lateral_bar_radps,
    ]
}

#[test]
fn the_linear_model_is_the_slope_of_the_flown_equations() {
    let helicopter = raptor();
    let wind = Vector::new(1.5, -0.5, 0.2);
    for (north, east) in [(0.0, 0.0), (4.0, -1.0), (9.0, 2.0)] {
        let trim = helicopter.trim(Vector::new(north, east, 0.3), wind, 0.4).unwrap();
        let linear = helicopter.linearise(&trim, wind);
        let angles = trim.state.body_to_ned.euler();
        let [u, v, w] = trim.state.velocity_mps.to_array();
        let x = [
            u,
            v,
            w,
            0.0,
            0.0,
            0.0,
            angles.roll_rad,
            angles.pitch_rad,
            angles.yaw_rad,
            trim.state.longitudinal_flapping_rad,
            trim.state.lateral_flapping_rad,
            trim.state.longitudinal_bar_rad,
            trim.state.lateral_bar_rad,
        ];
        let c = trim.controls;
        let sticks = [c.lateral, c.longitudinal, c.collective, c.pedal];
        let h = 1e-5;
        for direction in 0..17 {
            let mut ends = [1.0, -1.0].map(|sign| {
                let (mut x, mut sticks) = (x, sticks);
                if direction < 13 {
                    x[direction] += sign * h;
                } else {
                    sticks[direction - 13] += sign * h;
                }
                derivative_of(&helicopter, &x, &sticks, wind)
            });
            let [after, before] = &mut ends;
            for row in 0..13 {
                let numeric = (after[row] - before[row]) / (2.0 * h);
                let analytic = if direction < 13 {
                    linear.a()[(row, direction)]
                } else {
                    linear.b()[(row, direction - 13)]
                };
                let off = (numeric - analytic).abs();
                assert!(off < 2e-6 * (1.0 + analytic.abs()), "{row} {direction}: {off}");
            }
        }
    }
}

#[test]
fn the_shipped_60_class_model_is_the_linearised_helicopter() {
    let helicopter = raptor();
    let trim = helicopter.trim(CALM, CALM, 0.0).unwrap();
    let (fresh, shipped) = (helicopter.linearise(&trim, CALM), shipped::raptor60());
    assert_abs_diff_eq!(fresh.a(), shipped.a(), epsilon = 1e-9);
    assert_abs_diff_eq!(fresh.b(), shipped.b(), epsilon = 1e-9);
    assert_eq!(fresh.states(), shipped.states());
}

#[test]
fn the_60_class_helicopter_is_damped_as_the_thesis_means_when_read_as_a_step() {
    let slow = hover::quasi_steady(&shipped::raptor60()).unwrap();
    let damping = |state| {
        let index = slow.state(state).unwrap();
        slow.a()[(index, index)]
    };
    assert_abs_diff_eq!(damping("p"), -8.1, epsilon = 0.5);
    assert_abs_diff_eq!(damping("q"), -11.9, epsilon = 0.6);
    assert!((-0.8..-0.4).contains(&damping("w")), "Zw {}", damping("w"));
    assert!((-40.0..-20.0).contains(&damping("r")), "Nr {}", damping("r"));
}

#[test]
fn the_thesis_eigenvalues_come_out_to_every_printed_digit() {
    let thesis = shipped::thesis();
    let printed = |model: &StateSpace, expected: &[(f64, f64)]| {
        let modes = model.modes().unwrap();
        for &(re, im) in expected {
            let found = modes.modes.iter().any(|mode| {
                let rounded = |value: f64| (value * 1e4).round() / 1e4;
                rounded(mode.eigenvalue.re) == re && rounded(mode.eigenvalue.im) == im
            });
            assert!(found, "{re} {im}i is not in\n{modes}");
        }
    };
    let expected = [
        (-0.0009, 0.0),
        (0.0093, 0.0),
        (0.7148, 0.0819),
        (0.7148, -0.0819),
        (0.9910, 0.0),
        (1.0367, 0.0),
    ];
    printed(&hover::roll_pitch(&thesis).unwrap(), &expected);
    printed(&hover::heave(&thesis).unwrap(), &[(0.9890, 0.0)]);
    printed(&hover::yaw(&thesis).unwrap(), &[(0.3093, 0.0), (0.0, 0.0)]);
    let built = hover::ReducedDerivatives::thesis().state_space("%").unwrap();
    assert_eq!((built.a(), built.b()), (thesis.a(), thesis.b()));
}

#[test]
fn a_step_matrix_taken_for_a_continuous_one_is_found_and_explained() {
    let pattern = shipped::thesis().step_taken_for_rate(1.0 / 33.0).unwrap();
    let means = |state: &str| pattern.dampings.iter().find(|each| each.0 == state).unwrap().2;
    for (state, expected) in
        [("p", -8.1), ("q", -11.9), ("u", -0.24), ("v", -0.24), ("w", -0.36), ("r", -38.7)]
    {
        assert!((means(state) - expected).abs() < 0.06, "{state}: {}", means(state));
    }
    let told = pattern.to_string();
    assert!(told.contains("p -8.10") && told.contains("discrete transition matrix"), "{told}");
    assert_eq!(shipped::mettler_r50().step_taken_for_rate(0.02), None);
    assert_eq!(shipped::raptor60().step_taken_for_rate(0.02), None);
}

#[test]
fn the_r50_loses_bar_and_flapping_as_its_reference_does() {
    let Some(path) = hovernav_testing::shared("reference/mettler_r50.json") else { return };
    let text = std::fs::read_to_string(path).unwrap();
    let reference: serde_json::Value = serde_json::from_str(&text).unwrap();
    let reference = &reference["hover"];
    let matrix = |key: &str| -> DMatrix<f64> {
        let rows: Vec<Vec<f64>> = serde_json::from_value(reference[key].clone()).unwrap();
        DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
    };
    let names =
        |key: &str| -> Vec<String> { serde_json::from_value(reference[key].clone()).unwrap() };
    let full = shipped::mettler_r50();
    assert_abs_diff_eq!(*full.a(), matrix("A13_si"), epsilon = 1e-13);
    assert_abs_diff_eq!(*full.b(), matrix("B13_si"), epsilon = 1e-13);
    let sticks = ["lateral", "longitudinal", "pedal", "collective"];
    for (removed, size) in [(&["c", "d", "rfb"][..], 10), (&["c", "d", "rfb", "a", "b"], 8)] {
        let states = names(&format!("states{size}"));
        let states: Vec<&str> = states.iter().map(String::as_str).collect();
        let slow = full.residualised(removed).unwrap().subsystem(&states, &sticks).unwrap();
        assert_abs_diff_eq!(*slow.a(), matrix(&format!("A{size}_si")), epsilon = 1e-11);
        assert_abs_diff_eq!(*slow.b(), matrix(&format!("B{size}_si")), epsilon = 1e-11);
    }
    for (mode, expected) in
        full.modes().unwrap().modes.iter().zip(reference["modes13"].as_array().unwrap())
    {
        let size = expected["wn"].as_f64().unwrap();
        assert_abs_diff_eq!(mode.frequency_radps(), size, epsilon = 1e-9);
        assert_abs_diff_eq!(
            mode.damping_ratio().unwrap(),
            expected["zeta"].as_f64().unwrap(),
            epsilon = 1e-9
        );
    }
}

#[test]
fn flapping_taken_out_of_the_hybrid_model_leaves_rotor_damping() {
    let hybrid = hover::HybridDerivatives {
        tau_f: 0.1,
        la: 0.0,
        lb: 100.0,
        ma: 60.0,
        zw: -0.6,
        nr: -20.0,
        blat: 0.2,
        gravity_mps2: 9.81,
        ..Default::default()
    };
    let slow = hybrid.state_space("stick").unwrap().residualised(&["a", "b"]).unwrap();
    // Lp = −Lb·τf, and the stick's rolling moment is Lb·Blat.
    assert_abs_diff_eq!(slow.a()[(0, 0)], -10.0, epsilon = 1e-12);
    assert_abs_diff_eq!(slow.a()[(1, 1)], -6.0, epsilon = 1e-12);
    assert_abs_diff_eq!(slow.b()[(0, 0)], 20.0, epsilon = 1e-12);
}

#[test]
fn discrete_modes_are_reported_in_continuous_terms() {
    let continuous = shipped::mettler_r50();
    let period_s = 0.02;
    let discrete = StateSpace::new(
        "r50",
        TimeDomain::Discrete { period_s },
        continuous.states().to_vec(),
        continuous.inputs().to_vec(),
        (continuous.a() * period_s).exp(),
        continuous.b().clone(),
    )
    .unwrap();
    let (one, other) = (continuous.modes().unwrap(), discrete.modes().unwrap());
    for (one, other) in one.modes.iter().zip(&other.modes) {
        assert_abs_diff_eq!(one.frequency_radps(), other.frequency_radps(), epsilon = 1e-8);
        assert_abs_diff_eq!(
            one.damping_ratio().unwrap(),
            other.damping_ratio().unwrap(),
            epsilon = 1e-8
        );
    }
}
