//! Guarantees of the design.

use approx::assert_abs_diff_eq;
use hovernav_design::hover::HoverDesign;
use hovernav_design::{
    CheckedDesign, DesignError, Loop, bode, discrete_lqr, kalman, logarithmic_frequencies, lqr,
    observability, reachability, root_locus, sampled_lqr, step_response, zero_order_hold,
};
use hovernav_model::{Signal, StateSpace, TimeDomain, hover, shipped};
use hovernav_testing::shared;
use nalgebra::{Complex, DMatrix, DVector, dmatrix};
use serde_json::Value;
use std::path::Path;

fn reference(name: &str) -> Option<Value> {
    let text = std::fs::read_to_string(shared(format!("reference/{name}.json"))?).unwrap();
    Some(serde_json::from_str(&text).unwrap())
}

fn matrix(value: &Value) -> DMatrix<f64> {
    let rows: Vec<Vec<f64>> = serde_json::from_value(value.clone()).unwrap();
    DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
}

fn diagonal(values: &[f64]) -> DMatrix<f64> {
    DMatrix::from_diagonal(&DVector::from_row_slice(values))
}

fn signals(names: &[&str]) -> Vec<Signal> {
    names.iter().map(|name| Signal::new(name, "1")).collect()
}

/// A continuous model with states x0, x1, … and inputs u0, u1, ….
fn model(a: DMatrix<f64>, b: DMatrix<f64>) -> StateSpace {
    let named = |letter: &str, count: usize| {
        (0..count).map(|index| Signal::new(&format!("{letter}{index}"), "1")).collect()
    };
    let (states, inputs) = (named("x", a.nrows()), named("u", b.ncols()));
    StateSpace::new("test", TimeDomain::Continuous, states, inputs, a, b).unwrap()
}

fn spectral_radius(a: &DMatrix<f64>) -> f64 {
    a.complex_eigenvalues().iter().map(|value| value.norm()).fold(0.0, f64::max)
}

#[test]
fn the_thesis_gains_come_out_to_every_printed_digit() {
    let thesis = shipped::thesis();
    let yaw = lqr(&hover::yaw(&thesis).unwrap(), &diagonal(&[1.0, 100.0]), &diagonal(&[1.0, 1.0]));
    let printed_yaw = dmatrix![0.0136, 0.0661; -2.0576, -9.9998];
    for (found, printed) in yaw.unwrap().gain.iter().zip(&printed_yaw) {
        assert_eq!((found * 1e4).round() / 1e4, *printed);
    }
    let roll_pitch = lqr(
        &hover::roll_pitch(&thesis).unwrap(),
        &diagonal(&[1.0, 1.0, 1.0, 1.0, 2.0, 1.0]),
        &diagonal(&[0.01, 0.001]),
    )
    .unwrap();
    let printed = dmatrix![
        -38.312, 31.807, -48.756, 84.394, -21.346, -0.62251;
        29.425, -26.887, -424.20, 405.19, -60.082, -71.578;
    ];
    for (found, printed) in roll_pitch.gain.iter().zip(&printed) {
        let digits = 10f64.powf(4.0 - f64::abs(*printed).log10().floor());
        assert_eq!((found * digits).round() / digits, *printed);
    }
    if let Some(reference) = reference("thesis") {
        let exact = matrix(&reference["K_care"]);
        assert!((&roll_pitch.gain - &exact).norm() < 1e-10 * exact.norm());
        for pole in reference["eig_closed"].as_array().unwrap() {
            let pole = Complex::new(pole[0].as_f64().unwrap(), pole[1].as_f64().unwrap());
            assert!(roll_pitch.poles.iter().any(|found| (found - pole).norm() < 1e-8));
        }
    }
}

#[test]
fn the_thesis_models_are_controllable_and_observable_with_the_printed_ranks() {
    let thesis = shipped::thesis();
    let roll_pitch = hover::roll_pitch(&thesis).unwrap();
    let yaw = hover::yaw(&thesis).unwrap();
    for (model, rank) in [(&roll_pitch, 6), (&yaw, 2)] {
        for found in [reachability(model, 1.0).unwrap(), observability(model, 1.0).unwrap()] {
            assert_eq!((found.rank, found.states), (rank, rank));
            assert!(found.modes.iter().all(|&(_, distance)| distance > 1e-4));
            assert!(found.gramian_eigenvalues.iter().all(|&value| value > 0.0));
        }
    }
}

#[test]
fn an_unreached_mode_is_found_by_rank_pencil_and_gramian() {
    let model =
        model(dmatrix![-1.0, 1.0, 0.0; 0.0, -2.0, 0.0; 0.0, 0.0, -3.0], dmatrix![0.0; 1.0; 0.0]);
    let found = reachability(&model, 10.0).unwrap();
    assert_eq!(found.rank, 2);
    let distance =
        |at: f64| found.modes.iter().find(|(mode, _)| (mode.re - at).abs() < 1e-9).unwrap().1;
    assert!(distance(-3.0) < 1e-12 && distance(-1.0) > 0.1);
    assert!(found.gramian_eigenvalues[2].abs() < 1e-12 && found.gramian_eigenvalues[1] > 1e-3);
    // ∫ e^(−4t) dt over a long horizon.
    assert_abs_diff_eq!(found.gramian[(1, 1)], 0.25, epsilon = 1e-12);
}

#[test]
fn a_held_double_integrator_moves_as_its_closed_form() {
    let model = model(dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0]);
    let t = 0.3;
    let held = zero_order_hold(&model, t, 0.0).unwrap();
    assert_abs_diff_eq!(*held.a(), dmatrix![1.0, t; 0.0, 1.0], epsilon = 1e-16);
    assert_abs_diff_eq!(*held.b(), dmatrix![t * t / 2.0; t], epsilon = 1e-16);
}

#[test]
fn a_fractional_delay_is_exact() {
    let r50 = shipped::mettler_r50();
    let (period_s, fine) = (0.03, 30);
    for delay in [0, 12, 30, 75] {
        let delay_s = delay as f64 * period_s / fine as f64;
        let coarse = zero_order_hold(&r50, period_s, delay_s).unwrap();
        let step = zero_order_hold(&r50, period_s / fine as f64, 0.0).unwrap();
        let input = |period: isize| match period {
            ..0 => DVector::zeros(4),
            period => DVector::from_fn(4, |row, _| ((row + 1) as f64 * period as f64).sin()),
        };
        let mut exact = DVector::zeros(13);
        let mut state = DVector::zeros(coarse.states().len());
        for period in 0..20isize {
            for part in 0..fine {
                let acting = (period * fine + part - delay).div_euclid(fine);
                exact = step.a() * exact + step.b() * input(acting);
            }
            state = coarse.a() * state + coarse.b() * input(period);
        }
        let error = (state.rows(0, 13) - &exact).norm() / exact.norm();
        assert!(error < 1e-11, "{delay_s} s: {error}");
    }
    let names = zero_order_hold(&r50, 0.03, 0.04).unwrap();
    assert_eq!(names.states()[13].name, "lateral_1_ago");
    assert_eq!(names.states().len(), 13 + 2 * 4);
}

#[test]
fn the_printed_gain_is_unstable_at_33_hz_and_the_sampled_design_is_not() {
    let model = hover::roll_pitch(&shipped::thesis()).unwrap();
    let (q, r) = (diagonal(&[1.0, 1.0, 1.0, 1.0, 2.0, 1.0]), diagonal(&[0.01, 0.001]));
    let printed = lqr(&model, &q, &r).unwrap().gain;
    let held = zero_order_hold(&model, 1.0 / 33.0, 0.0).unwrap();
    let radius = spectral_radius(&(held.a() - held.b() * printed));
    assert_abs_diff_eq!(radius, 7.9, epsilon = 0.05);
    for delay_s in [0.0, 0.01, 0.03] {
        let sampled = sampled_lqr(&model, &q, &r, 1.0 / 33.0, delay_s).unwrap();
        assert!(sampled.poles.iter().all(|pole| pole.norm() < 1.0));
    }
}

#[test]
fn the_sampled_cost_is_the_continuous_cost_of_the_sampled_flight() {
    let model = hover::roll_pitch(&shipped::raptor60()).unwrap();
    let (q, r) = (diagonal(&[0.1, 0.1, 1.0, 1.0, 0.2, 0.2]), diagonal(&[2.0, 3.0]));
    let (period_s, fine) = (0.03, 300);
    for delay_s in [0.0, 0.012] {
        let design = sampled_lqr(&model, &q, &r, period_s, delay_s).unwrap();
        let step = zero_order_hold(&model, period_s / fine as f64, 0.0).unwrap();
        let late = (delay_s / period_s * fine as f64).round() as usize;
        let mut whole = DVector::zeros(design.model.states().len());
        whole[2] = 0.3;
        whole[5] = -1.0;
        let promised = whole.dot(&(&design.cost * &whole));
        let (mut x, mut old, mut cost) = (whole.rows(0, 6).into_owned(), DVector::zeros(2), 0.0);
        for _ in 0..3000 {
            if delay_s > 0.0 {
                whole.rows_mut(6, 2).copy_from(&old);
            }
            whole.rows_mut(0, 6).copy_from(&x);
            let new = -&design.gain * &whole;
            for part in 0..fine {
                let u = if part < late { &old } else { &new };
                let next = step.a() * &x + step.b() * u;
                let middle = (&x + &next) * 0.5;
                // Simpson's rule needs the state at the middle; the mean of the states at both ends is accurate enough.
                let form = |x: &DVector<f64>| x.dot(&(&q * x)) + u.dot(&(&r * u));
                cost +=
                    (form(&x) + 4.0 * form(&middle) + form(&next)) / 6.0 * period_s / fine as f64;
                x = next;
            }
            old = new;
        }
        assert!((cost - promised).abs() < 1e-4 * promised, "{cost} {promised}");
    }
}

#[test]
fn sampling_fast_brings_back_the_continuous_gain() {
    let model = hover::roll_pitch(&shipped::raptor60()).unwrap();
    let (q, r) = (DMatrix::identity(6, 6), DMatrix::identity(2, 2));
    let slow = lqr(&model, &q, &r).unwrap().gain;
    let fast = sampled_lqr(&model, &q, &r, 1e-5, 0.0).unwrap().gain;
    assert!((fast - &slow).norm() < 1e-3 * slow.norm());
}

#[test]
fn a_steady_kalman_gain_is_that_of_its_closed_form() {
    // A random walk measured with noise: p² = w·p + w·v for the prediction.
    let (w, v) = (0.01, 0.25);
    let walk = StateSpace::new(
        "walk",
        TimeDomain::Discrete { period_s: 1.0 },
        signals(&["x"]),
        signals(&["u"]),
        dmatrix![1.0],
        dmatrix![1.0],
    )
    .unwrap();
    let (gain, p) = kalman(&walk, &dmatrix![w], &dmatrix![v]).unwrap();
    let expected = 0.5 * (w + (w * w + 4.0 * w * v).sqrt());
    assert_abs_diff_eq!(p[(0, 0)], expected, epsilon = 1e-15);
    assert_abs_diff_eq!(gain[(0, 0)], expected / (expected + v), epsilon = 1e-14);
    let (gain, p) =
        kalman(&model(dmatrix![0.0], dmatrix![1.0]), &dmatrix![w], &dmatrix![v]).unwrap();
    assert_abs_diff_eq!(p[(0, 0)], (w * v).sqrt(), epsilon = 1e-15);
    assert_abs_diff_eq!(gain[(0, 0)], (w / v).sqrt(), epsilon = 1e-14);
}

#[test]
fn what_has_no_design_is_refused_with_the_reason() {
    let (q, r) = (DMatrix::identity(2, 2), dmatrix![1.0]);
    let told = |result: Result<_, DesignError>| match result {
        Ok(_) => panic!("expected a refusal"),
        Err(error) => error.to_string(),
    };
    let stuck = model(dmatrix![0.5, 0.0; 0.0, -1.0], dmatrix![0.0; 1.0]);
    let error = told(lqr(&stuck, &q, &r).map(drop));
    assert!(error.contains("mode 0.5") && error.contains("no input"), "{error}");

    let free = model(dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0]);
    let error = told(lqr(&free, &dmatrix![1.0, 0.0; 0.0, -1.0], &r).map(drop));
    assert!(error.starts_with("Q: found the eigenvalue -1"), "{error}");
    let error = told(lqr(&free, &q, &dmatrix![0.0]).map(drop));
    assert!(error.starts_with("R: found the eigenvalue 0"), "{error}");
    let error = told(lqr(&free, &dmatrix![1.0, 0.0; f64::NAN, 1.0], &r).map(drop));
    assert!(error.contains("NaN"), "{error}");
    let error = told(lqr(&free, &dmatrix![1.0, 0.5; 0.0, 1.0], &r).map(drop));
    assert!(error.contains("not symmetric"), "{error}");
    let error = told(lqr(&free, &dmatrix![1.0], &r).map(drop));
    assert!(error.contains("found 1x1, expected 2x2"), "{error}");
    let error = told(discrete_lqr(&free, &q, &r).map(drop));
    assert!(error.contains("the model is continuous, expected a discrete"), "{error}");
    let held = zero_order_hold(&free, 0.1, 0.0).unwrap();
    let error = told(lqr(&held, &q, &r).map(drop));
    assert!(error.contains("the model is discrete, expected a continuous"), "{error}");
    let error = told(zero_order_hold(&free, 0.1, -0.1).map(drop));
    assert!(error.contains("delay_s"), "{error}");
    // A double integrator whose cost contains neither state: nothing requires stability.
    let error = told(lqr(&free, &DMatrix::zeros(2, 2), &r).map(drop));
    assert!(error.contains("no stabilising solution"), "{error}");
    // A double integrator whose cost contains one state: the other state would keep its value.
    let error = told(
        lqr(
            &model(diagonal(&[0.0, 1.0]), DMatrix::identity(2, 2)),
            &diagonal(&[0.0, 1.0]),
            &DMatrix::identity(2, 2),
        )
        .map(drop),
    );
    assert!(error.contains("no stabilising solution"), "{error}");
    let stuck = zero_order_hold(&stuck, 0.1, 0.0).unwrap();
    let error = told(discrete_lqr(&stuck, &q, &r).map(drop));
    assert!(error.contains("no input controls it"), "{error}");
}

/// A model in degrees must not be designed for as if its numbers were radians.
#[test]
fn a_state_in_another_unit_is_refused_by_name() {
    let model = shipped::raptor60().to_toml();
    for (unit, other, name) in
        [("rad/s", "deg/s", "p"), ("m/s", "ft/s", "u"), ("rad", "deg", "phi")]
    {
        let state = |unit: &str| format!("{{ name = \"{name}\", unit = \"{unit}\" }}");
        let text = model.replacen(&state(unit), &state(other), 1);
        let model = StateSpace::parse(&text, Path::new("model.toml")).unwrap();
        let refused = CheckedDesign::new(model.clone(), HoverDesign::for_model(&model));
        let told = refused.map(drop).unwrap_err().to_string();
        assert_eq!(told, format!("state {name}: found the unit {other}, expected {unit}"));
    }
}

/// k/(s(s + 1)(s + 2)) as a loop.
fn third_order(k: f64) -> Loop {
    let plant =
        model(dmatrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; 0.0, -2.0, -3.0], dmatrix![0.0; 0.0; 1.0]);
    Loop::state_feedback(&plant, &dmatrix![k, 0.0, 0.0]).unwrap()
}

#[test]
fn margins_of_a_textbook_loop_are_those_of_its_closed_form() {
    let margins = third_order(1.0).margins().unwrap();
    let channel = &margins.channels[0];
    // |L| at √2 rad/s is k/6.
    let up = channel.gain_up.unwrap();
    assert_abs_diff_eq!(up.margin, 6.0, epsilon = 1e-9);
    assert_abs_diff_eq!(up.frequency_radps, 2f64.sqrt(), epsilon = 1e-9);
    assert_eq!(channel.gain_down, None);
    let phase = channel.phase.unwrap();
    let w = phase.frequency_radps;
    assert_abs_diff_eq!(w * (w * w + 1.0).sqrt() * (w * w + 4.0).sqrt(), 1.0, epsilon = 1e-9);
    let expected = std::f64::consts::FRAC_PI_2 - w.atan() - (0.5 * w).atan();
    assert_abs_diff_eq!(phase.margin, expected, epsilon = 1e-9);
    assert_abs_diff_eq!(channel.delay_s.unwrap(), expected / w, epsilon = 1e-9);
    let bandwidth = channel.disturbance_rejection_bandwidth_radps.unwrap();
    let open = third_order(1.0).open().linear().frequency_response(bandwidth).unwrap()[(0, 0)];
    let sensitivity = (Complex::new(1.0, 0.0) + open).inv().norm();
    assert_abs_diff_eq!(sensitivity, 0.5f64.sqrt(), epsilon = 1e-9);
    // The guaranteed disk margin is within the single-channel margins.
    assert!(margins.disk_gain()[1] <= up.margin && margins.disk_phase_rad() <= phase.margin);
    assert!(margins.sensitivity.value > 1.0);
}

#[test]
fn a_loop_at_its_gain_margin_is_on_the_border() {
    for gain in [5.999_999, 6.000_001] {
        let poles = third_order(gain).closed_poles().unwrap();
        let stable = poles.iter().all(|pole| pole.re < 0.0);
        assert_eq!(stable, gain < 6.0);
    }
    let error = third_order(6.1).margins().unwrap_err();
    assert!(matches!(error, DesignError::UnstableLoop { .. }), "{error}");
}

#[test]
fn a_sampled_loop_dies_at_the_margins_reported_for_each_channel() {
    let plant = hover::roll_pitch(&shipped::raptor60()).unwrap();
    let plant = zero_order_hold(&plant, 1.0 / 33.0, 0.0).unwrap();
    let design =
        discrete_lqr(&plant, &DMatrix::identity(6, 6), &(DMatrix::identity(2, 2) * 10.0)).unwrap();
    let margins = Loop::state_feedback(&plant, &design.gain).unwrap().margins().unwrap();
    let radius = |channel: usize, factor: f64| {
        let mut gain = design.gain.clone();
        gain.row_mut(channel).scale_mut(factor);
        spectral_radius(&(plant.a() - plant.b() * gain))
    };
    for (index, channel) in margins.channels.iter().enumerate() {
        assert_eq!(channel.name, plant.inputs()[index].name);
        let up = channel.gain_up.unwrap().margin;
        assert_abs_diff_eq!(radius(index, up), 1.0, epsilon = 1e-6);
        assert!(radius(index, 0.99 * up) < 1.0);
        if let Some(down) = channel.gain_down {
            assert_abs_diff_eq!(radius(index, down.margin), 1.0, epsilon = 1e-6);
        }
    }
    // The loop stays stable with both channels at once, each at either end of the disk.
    let [low, high] = margins.disk_gain();
    for (one, other) in [(low, high), (high, low), (low, low), (high, high)] {
        let mut gain = design.gain.clone();
        gain.row_mut(0).scale_mut(1.0 + 0.999 * (one - 1.0));
        gain.row_mut(1).scale_mut(1.0 + 0.999 * (other - 1.0));
        assert!(spectral_radius(&(plant.a() - plant.b() * gain)) < 1.0);
    }
}

#[test]
fn continuous_optimal_loops_have_the_margins_that_kalman_promised() {
    let plant = hover::roll_pitch(&shipped::mettler_r50()).unwrap();
    let design = lqr(&plant, &DMatrix::identity(6, 6), &DMatrix::identity(2, 2)).unwrap();
    let margins = Loop::state_feedback(&plant, &design.gain).unwrap().margins().unwrap();
    assert!(margins.sensitivity.value < 1.0 + 1e-6);
    for channel in &margins.channels {
        assert!(channel.gain_up.is_none());
        assert!(channel.gain_down.is_none_or(|crossing| crossing.margin <= 0.5));
        assert!(channel.phase.is_none_or(|crossing| crossing.margin >= 60f64.to_radians()));
    }
}

#[test]
fn a_loop_cut_at_either_end_of_a_single_channel_is_the_same_loop() {
    let plant = model(dmatrix![0.0, 1.0; 0.0, -1.0], dmatrix![0.0; 1.0])
        .with_outputs(signals(&["y"]), dmatrix![1.0, 0.0], dmatrix![0.0])
        .unwrap();
    let controller = model(dmatrix![-5.0], dmatrix![1.0])
        .with_outputs(signals(&["u"]), dmatrix![-10.0], dmatrix![3.0])
        .unwrap();
    let input = Loop::at_plant_input(&plant, &controller).unwrap().margins().unwrap();
    let output = Loop::at_plant_output(&plant, &controller).unwrap().margins().unwrap();
    let (one, other) = (input.channels[0].phase.unwrap(), output.channels[0].phase.unwrap());
    assert_abs_diff_eq!(one.margin, other.margin, epsilon = 1e-9);
    let held = zero_order_hold(&plant, 0.1, 0.0).unwrap();
    assert!(Loop::at_plant_input(&held, &controller).is_err());
}

#[test]
fn responses_of_a_first_order_lag_are_those_of_its_closed_form() {
    let lag = model(dmatrix![-2.0], dmatrix![2.0]);
    let points = bode(&lag, "u0", 0, &[2.0]).unwrap();
    assert_abs_diff_eq!(points[0].0, -20.0 * 2f64.sqrt().log10(), epsilon = 1e-12);
    assert_abs_diff_eq!(points[0].1, -45.0, epsilon = 1e-12);
    let step = step_response(&lag, "u0", 2.0, 0.1).unwrap();
    for (&time, &output) in step.time_s.iter().zip(&step.outputs) {
        assert_abs_diff_eq!(output, 1.0 - (-2.0 * time).exp(), epsilon = 1e-14);
    }
    let frequencies = logarithmic_frequencies(0.1, 10.0, 3);
    assert_abs_diff_eq!(frequencies[1], 1.0, epsilon = 1e-15);
    assert_eq!(frequencies.len(), 3);
    assert!(bode(&lag, "none", 0, &[1.0]).is_err() && bode(&lag, "u0", 1, &[1.0]).is_err());
}

#[test]
fn the_root_locus_follows_each_pole() {
    let plant = model(dmatrix![0.0, 1.0; 0.0, -2.0], dmatrix![0.0; 1.0]);
    let gains: Vec<f64> = (0..40).map(|index| 0.1 * f64::from(index)).collect();
    let locus = root_locus(&plant, "u0", 0, &gains).unwrap();
    for (gain, poles) in gains.iter().zip(&locus) {
        for pole in poles {
            // s² + 2s + k = 0.
            assert!((pole * pole + pole * 2.0 + gain).norm() < 1e-12);
        }
    }
    for rows in locus.windows(2).skip(12) {
        assert!((rows[0][0] - rows[1][0]).norm() < 0.2);
    }
}
