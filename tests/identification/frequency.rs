//! Frequency responses: the simulated response is found, with correct coherence and bounds.

use std::f64::consts::TAU;

use hovernav_model::{LinearModel, TimeDomain};
use hovernav_sysid::methods::frequency::{
    Band, FrequencyError, FrequencyResponse, ResponseFitSettings, ResponseSettings, fit_response,
    frequency_response, joint_response,
};
use hovernav_sysid::record::{Experiment, Maneuver};
use nalgebra::{Complex, DMatrix, DVector, dmatrix};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const PERIOD_S: f64 = 0.02;
const BAND: Band = Band { first_hz: 0.1, last_hz: 5.0, points: 60 };

/// Coupled roll and yaw rate of a small helicopter, as a discrete model at 50 Hz.
fn plant() -> LinearModel {
    LinearModel {
        a: dmatrix![0.90, 0.02; -0.01, 0.95],
        b: dmatrix![0.5, 0.1; 0.05, -0.3],
        c: DMatrix::identity(2, 2),
        d: DMatrix::zeros(2, 2),
        time: TimeDomain::Discrete { period_s: PERIOD_S },
    }
}

fn true_response(model: &LinearModel, frequency_hz: f64) -> DMatrix<Complex<f64>> {
    let shift = Complex::from_polar(1.0, TAU * frequency_hz * PERIOD_S);
    let complex = |matrix: &DMatrix<f64>| matrix.map(Complex::from);
    let order = model.order();
    let resolvent = DMatrix::from_diagonal_element(order, order, shift) - complex(&model.a);
    complex(&model.c) * resolvent.try_inverse().unwrap() * complex(&model.b) + complex(&model.d)
}

/// A sweep of one stick, without its last two seconds.
fn sweep(samples: usize) -> Vec<f64> {
    let sweep = Maneuver::Sweep {
        amplitude: 1.0,
        first_hz: 0.1,
        last_hz: 5.0,
        duration_s: samples as f64 * PERIOD_S - 2.0,
        fade_s: 2.0,
    };
    sweep.sampled(samples, PERIOD_S, 1.0)
}

/// A sweep on one stick while the pilot moves the other slightly, as in real flights.
fn flight(swept: usize, noise: f64, seed: u64) -> Experiment {
    let samples = 5000;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let own = sweep(samples);
    let mut wander = 0.0;
    let inputs = DMatrix::from_fn(samples, 2, |k, column| {
        if column == swept {
            own[k]
        } else {
            wander = 0.8 * wander + 0.15 * normal();
            wander + 0.3 * own[k]
        }
    });
    let clean = plant().simulate(&inputs, &DVector::zeros(2));
    let outputs = clean.map(|value| value + noise * normal());
    let names = |names: [&str; 2]| names.map(str::to_owned).to_vec();
    let (inputs_named, outputs_named) = (names(["lateral", "pedal"]), names(["p", "r"]));
    Experiment::new(format!("sweep {seed}"), PERIOD_S, inputs_named, outputs_named, inputs, outputs)
        .unwrap()
}

fn flights(noise: f64) -> Vec<Experiment> {
    vec![flight(0, noise, 1), flight(1, noise, 2)]
}

/// Number of coherent points of the plant's responses that are accurate, and number of all coherent points. A point is
/// accurate if its relative error is less than three random errors plus 0.02.
fn within_random_error(found: &FrequencyResponse) -> (usize, usize) {
    let (mut inside, mut all) = (0, 0);
    for (point, &frequency_hz) in found.frequencies_hz.iter().enumerate() {
        let truth = true_response(&plant(), frequency_hz);
        for at in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let coherence = found.coherence[point][at];
            assert!((0.0..=1.0).contains(&coherence));
            if coherence > 0.6 {
                let error = (found.responses[point][at] - truth[at]).norm() / truth[at].norm();
                all += 1;
                inside += usize::from(error < 3.0 * found.random_error[point][at] + 0.02);
            }
        }
    }
    println!("{inside} of {all} points within three times their random error");
    (inside, all)
}

#[test]
fn responses_are_found_within_their_own_random_error() {
    let settings = ResponseSettings::composite(BAND, 100.0);
    let found = frequency_response(&flights(0.05), &settings).unwrap();
    let (inside, all) = within_random_error(&found);
    assert!(all > 150 && inside * 100 >= all * 90, "{inside} of {all}");
}

#[test]
fn conditioning_takes_out_what_the_other_stick_did() {
    let settings = ResponseSettings::composite(BAND, 100.0);
    let both = frequency_response(&flights(0.01), &settings).unwrap();
    let alone: Vec<Experiment> =
        flights(0.01).iter().map(|flight| flight.select(&["lateral"], &["r"]).unwrap()).collect();
    let alone = frequency_response(&alone, &settings).unwrap();
    let point = 20;
    let truth = true_response(&plant(), both.frequencies_hz[point])[(1, 0)];
    let conditioned = (both.responses[point][(1, 0)] - truth).norm() / truth.norm();
    let naive = (alone.responses[point][(0, 0)] - truth).norm() / truth.norm();
    println!("conditioned {conditioned:.3}, alone {naive:.3}");
    assert!(conditioned < 0.1 && naive > 5.0 * conditioned);
}

#[test]
fn coherence_falls_with_noise() {
    let settings = ResponseSettings::composite(BAND, 100.0);
    let [quiet, loud] = [0.01, 1.0].map(|noise| {
        let found = frequency_response(&flights(noise), &settings).unwrap();
        found.multiple_coherence.iter().map(|point| point[0]).sum::<f64>() / BAND.points as f64
    });
    assert!(quiet > 0.97 && loud < quiet - 0.05, "{quiet} {loud}");
}

/// Roll and yaw held by a controller that responds with both sticks to the rates, which gusts move too. A sweep is
/// injected on one stick after the other.
fn held_flight(swept: usize, seed: u64) -> Experiment {
    const FEEDBACK: [[f64; 2]; 2] = [[0.3, 0.05], [-0.05, -0.5]];
    let samples = 10_000;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let own = sweep(samples);
    let model = plant();
    let (mut inputs, mut outputs) = (DMatrix::zeros(samples, 4), DMatrix::zeros(samples, 2));
    let (mut state, mut gust) = (DVector::zeros(2), DVector::zeros(2));
    for k in 0..samples {
        gust = 0.97 * gust + DVector::from_fn(2, |_, _| 0.12 * normal());
        let output = &state + &gust;
        let sticks = DVector::from_fn(2, |stick, _| {
            let injected = if stick == swept { own[k] } else { 0.0 } + 0.05 * normal();
            inputs[(k, stick)] = injected;
            injected - FEEDBACK[stick][0] * output[0] - FEEDBACK[stick][1] * output[1]
        });
        inputs.view_mut((k, 2), (1, 2)).copy_from(&sticks.transpose());
        outputs.row_mut(k).copy_from(&output.transpose());
        state = &model.a * state + &model.b * sticks;
    }
    let names = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
    let inputs_named = names(&["injected_lateral", "injected_pedal", "lateral", "pedal"]);
    Experiment::new("held", PERIOD_S, inputs_named, names(&["p", "r"]), inputs, outputs).unwrap()
}

#[test]
fn under_feedback_the_injected_signal_finds_what_the_sticks_alone_do_not() {
    let flights = [held_flight(0, 21), held_flight(1, 22)];
    let settings = ResponseSettings::composite(BAND, 100.0);
    let references = ["injected_lateral", "injected_pedal"];
    let joint = joint_response(&flights, &references, &settings).unwrap();
    assert_eq!(joint.input_names, ["lateral", "pedal"]);
    let sticks: Vec<Experiment> = flights
        .iter()
        .map(|flight| flight.select(&["lateral", "pedal"], &["p", "r"]).unwrap())
        .collect();
    let direct = frequency_response(&sticks, &settings).unwrap();
    // The mean error over frequencies is the bias; random errors average out.
    for at in [(0, 0), (1, 1)] {
        let bias = |found: &[DMatrix<Complex<f64>>]| {
            let errors = joint.frequencies_hz.iter().zip(found).map(|(&frequency_hz, found)| {
                found[at] / true_response(&plant(), frequency_hz)[at] - 1.0
            });
            errors.sum::<Complex<f64>>().norm() / found.len() as f64
        };
        let (joint, direct) = (bias(&joint.responses), bias(&direct.responses));
        println!("{at:?}: bias {joint:.3} with the injected signal, {direct:.3} without");
        assert!(joint < 0.03 && direct > 3.0 * joint, "{at:?}: {joint} {direct}");
    }
    let (inside, all) = within_random_error(&joint);
    assert!(all > 50 && inside * 100 >= all * 90, "{inside} of {all}");
}

#[test]
fn inputs_that_are_their_own_references_give_the_direct_responses() {
    let settings = ResponseSettings::composite(BAND, 100.0);
    let direct = frequency_response(&flights(0.05), &settings).unwrap();
    let doubled: Vec<Experiment> = flights(0.05)
        .into_iter()
        .map(|mut flight| {
            flight.input_names.extend(["lateral again", "pedal again"].map(str::to_owned));
            flight.inputs = DMatrix::from_fn(flight.samples(), 4, |row, column| {
                flight.inputs[(row, column % 2)]
            });
            flight
        })
        .collect();
    let joint = joint_response(&doubled, &["lateral again", "pedal again"], &settings).unwrap();
    for point in 0..BAND.points {
        let apart = (&joint.responses[point] - &direct.responses[point]).norm();
        assert!(apart < 1e-9 * direct.responses[point].norm(), "{apart}");
        assert!((&joint.coherence[point] - &direct.coherence[point]).norm() < 1e-6);
    }
}

/// p' = Lp p + Llat δlat, r' = Nr r + Nped δped, sampled exactly with the sticks held.
fn rates(theta: &[f64], omegas: &[f64]) -> Option<Vec<DMatrix<Complex<f64>>>> {
    omegas.iter().map(|omega| rates_at(theta, *omega)).collect()
}

fn rates_at(theta: &[f64], omega: f64) -> Option<DMatrix<Complex<f64>>> {
    let [roll_damping, lateral, yaw_damping, pedal] = *theta else { return None };
    let shift = Complex::from_polar(1.0, omega * PERIOD_S);
    let response = |rate: f64, gain: f64| {
        let (pole, gain) = held(rate, gain);
        Complex::from(gain) / (shift - pole)
    };
    let zero = Complex::from(0.0);
    Some(dmatrix![response(roll_damping, lateral), zero; zero, response(yaw_damping, pedal)])
}

/// Discrete pole and gain over one period of x' = rate x + gain u.
fn held(rate: f64, gain: f64) -> (f64, f64) {
    let pole = (rate * PERIOD_S).exp();
    (pole, gain * (pole - 1.0) / rate)
}

#[test]
fn derivatives_are_found_from_sweeps_with_bounds_that_hold() {
    let truth = [-5.3, 26.0, -2.6, -15.0];
    let ((a, b), (c, d)) = (held(truth[0], truth[1]), held(truth[2], truth[3]));
    let model = LinearModel { a: dmatrix![a, 0.0; 0.0, c], b: dmatrix![b, 0.0; 0.0, d], ..plant() };
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let flights: Vec<Experiment> = flights(0.0)
        .into_iter()
        .map(|mut flight| {
            let clean = model.simulate(&flight.inputs, &DVector::zeros(2));
            flight.outputs = clean.map(|value| value + 0.1 * normal());
            flight
        })
        .collect();
    let measured = frequency_response(&flights, &ResponseSettings::composite(BAND, 100.0)).unwrap();
    let start = [-1.0, 5.0, -1.0, -5.0];
    let settings = ResponseFitSettings { min_coherence: 0.8, ..ResponseFitSettings::default() };
    // The off-axis responses are zero: only those on the diagonal are fitted.
    let mut direct = measured.clone();
    for coherence in &mut direct.coherence {
        coherence[(0, 1)] = 0.0;
        coherence[(1, 0)] = 0.0;
    }
    let fit = fit_response(&direct, &start, &settings, rates).unwrap();
    println!("{fit:.3?}");
    for ((found, bound), truth) in fit.parameters.iter().zip(&fit.bounds).zip(truth) {
        assert!((found - truth).abs() < 3.0 * bound, "{found} {truth}");
        assert!((0.0..0.02 * truth.abs()).contains(bound), "{bound}");
    }
    assert!(fit.costs.mean < 50.0 && fit.converged);
}

#[test]
fn a_parameter_the_responses_do_not_show_has_no_bound() {
    let measured =
        frequency_response(&flights(0.05), &ResponseSettings::composite(BAND, 100.0)).unwrap();
    let blind = |theta: &[f64], omegas: &[f64]| rates(&theta[..4], omegas);
    let start = [-1.0, 5.0, -1.0, -5.0, 1.0];
    let mut direct = measured.clone();
    for coherence in &mut direct.coherence {
        coherence[(0, 1)] = 0.0;
        coherence[(1, 0)] = 0.0;
    }
    let fit = fit_response(&direct, &start, &ResponseFitSettings::default(), blind).unwrap();
    assert!(fit.bounds[4] > 1e3, "{:?}", fit.bounds);
}

#[test]
fn what_cannot_be_estimated_is_refused_with_the_reason() {
    let good = flights(0.05);
    let refuse = |experiments: &[Experiment], settings: &ResponseSettings| {
        frequency_response(experiments, settings).unwrap_err()
    };
    let settings = ResponseSettings::composite(BAND, 100.0);
    let mut twins = good.clone();
    for flight in &mut twins {
        let lateral = flight.inputs.column(0).into_owned();
        flight.inputs.set_column(1, &(2.0 * lateral));
    }
    assert!(matches!(refuse(&twins, &settings), FrequencyError::DependentInputs { .. }));
    let beyond = ResponseSettings { band: Band { last_hz: 26.0, ..BAND }, ..settings.clone() };
    assert!(matches!(refuse(&good, &beyond), FrequencyError::Band { .. }));
    let long = ResponseSettings { windows_s: vec![200.0], ..settings.clone() };
    assert!(matches!(refuse(&good, &long), FrequencyError::Window { .. }));
    let joint = |references: &[&str]| joint_response(&good, references, &settings);
    for references in [&["throttle"][..], &["lateral", "pedal"]] {
        assert!(matches!(joint(references), Err(FrequencyError::Experiments { .. })));
    }
    assert!(matches!(refuse(&[], &settings), FrequencyError::Experiments { .. }));
    let noise = frequency_response(&flights(1e6), &settings).unwrap();
    let fit =
        fit_response(&noise, &[-1.0, 5.0, -1.0, -5.0], &ResponseFitSettings::default(), rates);
    assert!(matches!(fit, Err(FrequencyError::TooFewPoints { .. })));
}
