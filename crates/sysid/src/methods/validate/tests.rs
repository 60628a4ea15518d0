use super::*;
use approx::assert_abs_diff_eq;
use hovernav_model::{LinearModel, TimeDomain};
use nalgebra::dmatrix;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

fn names(name: &str) -> Vec<String> {
    vec![name.to_owned()]
}

fn lag(pole: f64) -> InnovationModel {
    let system = LinearModel {
        a: dmatrix![pole],
        b: dmatrix![1.0],
        c: dmatrix![1.0],
        d: dmatrix![0.0],
        time: TimeDomain::Discrete { period_s: 0.1 },
    };
    InnovationModel { system, gain: dmatrix![0.3] }
}

/// White inputs through `plant`, whose innovations have the size `noise`.
fn flown(plant: &InnovationModel, samples: usize, noise: f64, seed: u64) -> Experiment {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let inputs = DMatrix::from_fn(samples, 1, |_, _| normal());
    let mut outputs = DMatrix::zeros(samples, 1);
    let mut state = 0.0;
    for k in 0..samples {
        let innovation = noise * normal();
        outputs[(k, 0)] = state + innovation;
        state = plant.system.a[0] * state + inputs[(k, 0)] + plant.gain[0] * innovation;
    }
    Experiment::new(format!("flight {seed}"), 0.1, names("u"), names("y"), inputs, outputs).unwrap()
}

const ALL: [Horizon; 3] = [Horizon::Steps(1), Horizon::Steps(10), Horizon::Simulation];

#[test]
fn the_true_model_leaves_nothing_in_its_residuals() {
    let plant = lag(0.8);
    let [one, other] = [1, 2].map(|seed| flown(&plant, 3000, 0.5, seed));
    let validation = validate(&plant, &one, &other, &ALL).unwrap();
    assert!(validation.residuals.nothing_left(), "{validation}");
    let fits: Vec<f64> = validation.scores.iter().map(|score| score.fit_percent).collect();
    assert!(fits[0] > fits[1] && fits[1] > fits[2] - 1.0 && fits[2] > 60.0, "{fits:?}");
    assert!(validation.scores[0].held_fit_percent < fits[0]);
}

#[test]
fn a_wrong_pole_is_seen_in_the_residuals() {
    let [one, other] = [1, 2].map(|seed| flown(&lag(0.8), 3000, 0.5, seed));
    let validation = validate(&lag(0.6), &one, &other, &ALL).unwrap();
    assert!(validation.residuals.inputs[0][0].something_left());
    assert!(!validation.shortcomings().is_empty());
}

#[test]
fn the_data_of_the_fit_is_refused_in_whole_and_in_part() {
    let plant = lag(0.8);
    let flight = flown(&plant, 600, 0.5, 1);
    let part = flight.slice(100..400).unwrap();
    let overlap = flight.slice(300..600).unwrap();
    for (estimation, validation) in [(&flight, &flight), (&flight, &part), (&part, &overlap)] {
        let refusal = validate(&plant, estimation, validation, &ALL).unwrap_err();
        assert!(matches!(refusal, Refusal::NotHeldOut { .. }), "{refusal}");
    }
}

#[test]
fn an_unstable_model_is_refused_in_simulation_and_judged_some_steps_ahead() {
    let plant = lag(1.02);
    let [one, other] = [1, 2].map(|seed| flown(&plant, 200, 0.5, seed));
    let refusal = validate(&plant, &one, &other, &ALL).unwrap_err();
    assert!(refusal.to_string().contains("spectral radius 1.0200"), "{refusal}");
    assert!(validate(&plant, &one, &other, &ALL[..2]).is_ok());
    let blind = InnovationModel { gain: dmatrix![0.0], ..plant };
    let refusal = validate(&blind, &one, &other, &ALL[..2]).unwrap_err();
    assert!(matches!(refusal, Refusal::UnstablePredictor { .. }), "{refusal}");
}

#[test]
fn an_output_that_does_not_move_gives_no_number() {
    let plant = lag(0.8);
    let [one, mut other] = [1, 2].map(|seed| flown(&plant, 200, 0.5, seed));
    other.outputs.fill(1.0);
    let refusal = validate(&plant, &one, &other, &ALL).unwrap_err();
    assert!(refusal.to_string().contains("`y` is constant"), "{refusal}");
}

#[test]
fn theil_separates_an_offset_a_size_and_the_rest() {
    let wave: Vec<f64> = (0..1000).map(|k| (0.0628 * f64::from(k)).sin()).collect();
    let offset: Vec<f64> = wave.iter().map(|value| value + 0.5).collect();
    let larger: Vec<f64> = wave.iter().map(|value| 1.5 * value).collect();
    let late: Vec<f64> = (0..1000).map(|k| (0.0628 * f64::from(k) - 0.5).sin()).collect();
    assert!(theil(&wave, &offset).bias > 0.999);
    assert!(theil(&wave, &larger).variance > 0.99);
    assert!(theil(&wave, &late).covariance > 0.99);
    let opposite: Vec<f64> = wave.iter().map(|value| -value).collect();
    assert_abs_diff_eq!(theil(&wave, &opposite).coefficient, 1.0, epsilon = 1e-12);
    assert_eq!(theil(&wave, &wave).coefficient, 0.0);
}

#[test]
fn fits_have_their_fixed_points() {
    let wave = DMatrix::from_fn(100, 1, |k, _| (k as f64).sin());
    let mean = DMatrix::from_element(100, 1, wave.mean());
    assert_eq!(fit_percent(&wave, &wave), [100.0]);
    assert!(fit_percent(&wave, &mean)[0].abs() < 1e-9);
    assert!(fit_percent(&mean, &wave)[0].is_nan());
}
