//! Prediction error: the true parameters are found within their bounds.

use approx::assert_abs_diff_eq;
use hovernav_sysid::helicopter::ModelStructure;
use hovernav_sysid::methods::prediction_error::{Dropping, Settings, Status, identify};
use hovernav_sysid::methods::structure::{Parameter, Structure};
use hovernav_sysid::record::Experiment;
use nalgebra::DMatrix;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;
use rand_distr::{Distribution as _, StandardNormal};

use crate::r50_flight;

#[test]
fn thirty_five_parameters_of_the_r50_return_from_a_start_twenty_percent_wrong() {
    let flight = r50_flight::fly(7, 2000);
    let wrong = r50_flight::wrong_start(0.2);
    let truth = ModelStructure::built_in("r50").unwrap().equations;
    let began = std::time::Instant::now();
    let found = identify(&wrong, &[flight], &Settings::innovations(vec![0.5; 6])).unwrap();
    println!("{:?}, {} iterations", began.elapsed(), found.iterations);
    println!("{}", found.estimates);
    assert!(found.converged);
    let mut errors = Vec::new();
    let mut worst: f64 = 0.0;
    for (parameter, estimate) in truth.parameters.iter().zip(&found.estimates.list) {
        assert_eq!(estimate.status, Status::Free, "{}", estimate.name);
        let error = (estimate.value - parameter.start).abs();
        errors.push(100.0 * error / parameter.start.abs());
        worst = worst.max(error / estimate.bound);
    }
    errors.sort_by(f64::total_cmp);
    println!("median error {:.2} %, worst {worst:.2} bounds", errors[errors.len() / 2]);
    assert_eq!(errors.len(), 35);
    assert!(errors[errors.len() / 2] <= 5.0);
    assert!(worst <= 4.0);
}

fn plain_heave() -> Structure {
    Structure::new(
        "heave",
        vec![
            Parameter::new("Zw", "1/s", -0.5).within(-10.0, 5.0),
            Parameter::new("Zcol", "m/s²", -15.0),
        ],
        "inputs collective
         noise n_w
         outputs w
         offsets w
         w' = Zw*w + Zcol*collective + n_w",
    )
    .unwrap()
}

/// Heave with process noise, driven by a square wave that acts `delay` whole samples late.
fn heave(seed: u64, samples: usize, delay: usize) -> Experiment {
    let (zw, zcol, period_s) = (-0.8_f64, -12.0, 0.03);
    let transition = (zw * period_s).exp();
    let gain = (transition - 1.0) / zw;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let mut inputs = DMatrix::zeros(samples, 1);
    let mut outputs = DMatrix::zeros(samples, 1);
    let mut w = 0.4;
    for sample in 0..samples {
        inputs[(sample, 0)] = if (sample / 50) % 2 == 0 { 0.1 } else { -0.1 };
        outputs[(sample, 0)] = w + 0.05 * normal();
        let felt = if sample >= delay { inputs[(sample - delay, 0)] } else { inputs[(0, 0)] };
        w = transition * w + gain * (zcol * felt + 0.3 + 0.5 * normal());
    }
    let names = |name: &str| vec![name.to_owned()];
    Experiment::new("heave", period_s, names("collective"), names("w"), inputs, outputs).unwrap()
}

#[test]
fn errors_over_many_flights_are_as_large_as_their_bounds() {
    let structure = plain_heave();
    let flights = 200;
    let mut normalised = 0.0;
    for seed in 0..flights {
        let found = identify(&structure, &[heave(seed, 800, 0)], &Settings::innovations(vec![0.3]))
            .unwrap();
        let error = nalgebra::Vector2::new(
            found.estimates.get("Zw").unwrap().value + 0.8,
            found.estimates.get("Zcol").unwrap().value + 12.0,
        );
        let covariance = found.estimates.covariance.fixed_view::<2, 2>(0, 0).into_owned();
        normalised += error.dot(&(covariance.try_inverse().unwrap() * error)) / flights as f64;
    }
    // The expected value is the mean of 200 χ² of two degrees of freedom: 2 ± 3·√(4/200), with a margin for finite
    // records.
    println!("normalised squared error {normalised:.3}, expected 2");
    assert!((1.6..2.5).contains(&normalised), "{normalised}");
}

#[test]
fn bounds_that_know_the_residuals_are_colored_hold_where_white_ones_do_not() {
    // The model lacks the process noise: the residuals of output error are far from white.
    let structure = plain_heave();
    let mut settings = Settings::output_error();
    settings.residual_correlation_s = 3.0;
    let (mut colored, mut white) = (0.0, 0.0);
    for seed in 0..100 {
        let found = identify(&structure, &[heave(seed, 800, 0)], &settings).unwrap();
        let gain = found.estimates.get("Zcol").unwrap();
        colored += ((gain.value + 12.0) / gain.bound).powi(2) / 100.0;
        white += ((gain.value + 12.0) / gain.white_bound).powi(2) / 100.0;
    }
    println!("normalised squared error {colored:.2} coloured, {white:.2} white, expected 1");
    assert!(white > 3.0);
    assert!(colored < 2.0);
}

/// The inflation and Akaike's criterion are components of the penalty for a stabiliser bar.
#[test]
fn a_likelihood_of_colored_residuals_is_overstated_as_often_as_the_inflation_reports() {
    let structure = plain_heave();
    let known = structure.clone().with("Zcol", -12.0, true);
    let mut settings = Settings::output_error();
    settings.residual_correlation_s = 3.0;
    let (mut rise, mut told) = (0.0, 0.0);
    for seed in 0..100 {
        let flight = [heave(seed, 800, 0)];
        let free = identify(&structure, &flight, &settings).unwrap();
        let held = identify(&known, &flight, &settings).unwrap();
        // Akaike's criterion has a penalty of 2 for the free parameter.
        rise += (held.aic + 2.0 - free.aic) / 100.0;
        told += free.estimates.inflation(&["Zcol"]).unwrap() / 100.0;
    }
    println!(
        "−2 ln L of the true value is {rise:.2} higher, {told:.2} by the inflation, 1 if white"
    );
    assert!(told > 3.0 && (0.6..1.7).contains(&(rise / told)), "{rise}, {told}");
}

#[test]
fn a_transport_delay_is_found_to_a_fraction_of_a_sample() {
    let structure = Structure::new(
        "delayed heave",
        vec![
            Parameter::new("Zw", "1/s", -0.5),
            Parameter::new("Zcol", "m/s²", -10.0),
            Parameter::new("tau", "s", 0.02).within(0.0, 0.5),
        ],
        "inputs collective\nnoise n_w\noutputs w\noffsets w\ndelay collective tau
         w' = Zw*w + Zcol*collective + n_w",
    )
    .unwrap();
    let flights = [heave(1, 800, 3), heave(2, 800, 3), heave(3, 800, 3)];
    let found = identify(&structure, &flights, &Settings::innovations(vec![0.3])).unwrap();
    println!("{}", found.estimates);
    let tau = found.estimates.get("tau").unwrap();
    assert_abs_diff_eq!(tau.value, 0.09, epsilon = 3.0 * tau.bound);
    assert!(tau.bound < 0.015);
}

#[test]
fn several_flights_share_parameters_and_keep_their_own_trim() {
    let structure = plain_heave();
    let mut second = heave(2, 800, 0);
    second.name = "other trim".into();
    // A different trim of the stick is a different constant force.
    second.inputs.add_scalar_mut(0.2);
    let flights = [heave(1, 800, 0), second];
    let found = identify(&structure, &flights, &Settings::innovations(vec![0.3])).unwrap();
    println!("{}", found.estimates);
    for (name, truth) in [("Zw", -0.8), ("Zcol", -12.0)] {
        let estimate = found.estimates.get(name).unwrap();
        assert!((estimate.value - truth).abs() < 4.0 * estimate.bound);
    }
    assert_abs_diff_eq!(found.own[0].offsets[0], 0.3, epsilon = 0.3);
    assert_abs_diff_eq!(found.own[1].offsets[0], 0.3 + 12.0 * 0.2, epsilon = 0.4);
}

#[test]
fn a_parameter_the_data_do_not_know_is_dropped_and_the_log_says_why() {
    let structure = Structure::new(
        "heave with an input too many",
        vec![
            Parameter::new("Zw", "1/s", -0.5),
            Parameter::new("Zcol", "m/s²", -10.0),
            Parameter::new("Zped", "m/s²", 1.0),
        ],
        "inputs collective pedal\nnoise n_w\noutputs w\noffsets w
         w' = Zw*w + Zcol*collective + Zped*pedal + n_w",
    )
    .unwrap();
    let heave = heave(5, 800, 0);
    let pedal = DMatrix::from_fn(800, 1, |sample, _| 0.01 * (sample as f64 * 0.2).sin());
    let inputs = DMatrix::from_columns(&[heave.inputs.column(0), pedal.column(0)]);
    let names = vec!["collective".to_owned(), "pedal".to_owned()];
    let flight =
        Experiment::new("heave", 0.03, names, heave.output_names.clone(), inputs, heave.outputs)
            .unwrap();
    let settings =
        Settings { dropping: Some(Dropping::default()), ..Settings::innovations(vec![0.3]) };
    let found = identify(&structure, &[flight], &settings).unwrap();
    println!("{:?}\n{}", found.log, found.estimates);
    assert_eq!(found.estimates.get("Zped").unwrap().status, Status::Dropped);
    assert_eq!(found.estimates.get("Zcol").unwrap().status, Status::Free);
    assert!(found.log[0].starts_with("Zped dropped at 0: its "), "{}", found.log[0]);
}

#[test]
fn no_fit_prints_without_the_bounds_behind_it() {
    let structure = plain_heave();
    let found =
        identify(&structure, &[heave(1, 800, 0)], &Settings::innovations(vec![0.3])).unwrap();
    let fit = found.simulate(&[heave(9, 800, 0)], 5.0).unwrap();
    let text = fit.to_string();
    println!("{text}");
    assert!(text.contains("bound %") && text.contains("Zcol"));
    let (channels, estimates) = fit.channels();
    assert!(estimates.get("Zw").unwrap().bound > 0.0);
    // A true model reaches the noise floor, which gusts and sensors leave unexplained.
    assert_abs_diff_eq!(channels[0].percent, channels[0].floor_percent, epsilon = 8.0);
}
