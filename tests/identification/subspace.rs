//! Subspace identification finds the generating system, and gives the reason where it cannot.

use hovernav_model::{LinearModel, TimeDomain};
use hovernav_sysid::methods::InnovationModel;
use hovernav_sysid::methods::subspace::{
    Criterion, InputFit, RefineSettings, SubspaceError, SubspaceSettings, Weighting, identify,
    refine,
};
use hovernav_sysid::record::Experiment;
use nalgebra::{Complex, DMatrix, dmatrix};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Two inputs, two outputs, a resonance and a lag.
fn coupled() -> InnovationModel {
    let system = LinearModel {
        a: dmatrix![0.9, 0.2, 0.0; -0.2, 0.9, 0.1; 0.0, 0.0, 0.7],
        b: dmatrix![1.0, 0.0; 0.2, 0.5; 0.3, -1.0],
        c: dmatrix![1.0, 0.0, 0.5; 0.0, 1.0, 1.0],
        d: dmatrix![0.0, 0.1; 0.0, 0.0],
        time: TimeDomain::Discrete { period_s: 0.03 },
    };
    InnovationModel { system, gain: dmatrix![0.3, 0.0; 0.1, 0.2; 0.0, 0.1] }
}

/// `model` with white inputs minus `feedback` times the outputs, and with innovations of size `noise`.
fn flown(model: &InnovationModel, feedback: [f64; 2], noise: f64, samples: usize) -> Experiment {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let LinearModel { a, b, c, d, .. } = &model.system;
    let mut inputs = DMatrix::zeros(samples, b.ncols());
    let mut outputs = DMatrix::zeros(samples, c.nrows());
    let mut state = DMatrix::zeros(a.nrows(), 1);
    for k in 0..samples {
        let innovation = DMatrix::from_fn(c.nrows(), 1, |_, _| noise * normal());
        let seen = c * &state + &innovation;
        let input = DMatrix::from_fn(b.ncols(), 1, |row, _| normal() - feedback[row] * seen[row]);
        outputs.set_row(k, &(seen + d * &input).transpose().row(0));
        inputs.set_row(k, &input.transpose().row(0));
        state = a * state + b * input + &model.gain * innovation;
    }
    let names = |letter: &str, count: usize| (0..count).map(|k| format!("{letter}{k}")).collect();
    let (inputs_named, outputs_named) = (names("u", b.ncols()), names("y", c.nrows()));
    Experiment::new("made", 0.03, inputs_named, outputs_named, inputs, outputs).unwrap()
}

/// Feedback gains without feedback.
const OPEN: [f64; 2] = [0.0, 0.0];

fn poles(model: &LinearModel) -> Vec<Complex<f64>> {
    let mut poles: Vec<_> = model.a.complex_eigenvalues().iter().copied().collect();
    poles.sort_by(|one, other| (one.re, one.im).partial_cmp(&(other.re, other.im)).unwrap());
    poles
}

fn farthest(found: &LinearModel, truth: &LinearModel) -> f64 {
    let pairs = poles(found).into_iter().zip(poles(truth));
    pairs.map(|(found, truth)| (found - truth).norm()).fold(0.0, f64::max)
}

const WEIGHTINGS: [Weighting; 3] = [Weighting::N4sid, Weighting::Moesp, Weighting::Cva];

#[test]
fn without_noise_order_poles_and_outputs_are_exact() {
    let truth = coupled();
    let record = flown(&truth, OPEN, 0.0, 600);
    for weighting in WEIGHTINGS {
        let settings = SubspaceSettings { weighting, ..SubspaceSettings::default() };
        let found = identify(&record, &settings).unwrap();
        let system = &found.model.system;
        assert_eq!(system.order(), 3, "{weighting:?} {:?}", found.singular_values);
        assert!(farthest(system, &truth.system) < 1e-8, "{weighting:?}");
        let run = system.simulate(&record.inputs, &found.initial_state);
        assert!((run - &record.outputs).amax() < 1e-7, "{weighting:?}");
        assert!((&system.d - &truth.system.d).amax() < 1e-7, "{weighting:?}");
    }
}

#[test]
fn noise_moves_the_poles_little_and_the_gain_is_found() {
    let truth = coupled();
    let record = flown(&truth, OPEN, 0.5, 4000);
    let settings = SubspaceSettings { order: Some(3), ..SubspaceSettings::default() };
    let found = identify(&record, &settings).unwrap();
    assert!(farthest(&found.model.system, &truth.system) < 0.03);
    // The gain itself depends on the basis; the poles of the predictor do not.
    let predictor = |model: &InnovationModel| LinearModel {
        a: &model.system.a - &model.gain * &model.system.c,
        ..model.system.clone()
    };
    assert!(farthest(&predictor(&found.model), &predictor(&truth)) < 0.06);
}

#[test]
fn the_unit_of_a_signal_does_not_matter() {
    let record = flown(&coupled(), OPEN, 0.3, 1000);
    let mut other = record.clone();
    other.outputs.column_mut(1).scale_mut(1e6);
    other.inputs.column_mut(0).scale_mut(1e-4);
    let settings = SubspaceSettings { order: Some(3), ..SubspaceSettings::default() };
    let [one, two] = [&record, &other].map(|record| identify(record, &settings).unwrap());
    assert!(farthest(&one.model.system, &two.model.system) < 1e-6);
}

#[test]
fn an_unstable_plant_under_feedback_is_found_by_its_predictions() {
    let mut truth = coupled();
    truth.system.a[(2, 2)] = 1.05;
    truth.system.d.fill(0.0);
    truth.gain[(2, 1)] = 0.6;
    let record = flown(&truth, [0.0, -0.15], 0.1, 3000);
    assert!(record.outputs.amax() < 1e3, "the feedback holds it");
    let settings =
        SubspaceSettings { order: Some(3), feedthrough: false, ..SubspaceSettings::default() };
    let found = identify(&record, &settings).unwrap();
    assert_eq!(found.input_fit, InputFit::Prediction);
    println!("subspace {:.4}", farthest(&found.model.system, &truth.system));
    assert!(refine(&found, &record, &RefineSettings::default()).is_none());
    let one_step = RefineSettings {
        criterion: Criterion::OneStep,
        feedthrough: false,
        ..RefineSettings::default()
    };
    let refined = refine(&found, &record, &one_step).unwrap();
    println!("refined {:.4} {:?}", farthest(&refined.model.system, &truth.system), refined.cost);
    assert!(farthest(&refined.model.system, &truth.system) < 0.03);
    assert!(refined.model.predictor_spectral_radius() < 1.0);
}

#[test]
fn a_record_without_inputs_is_a_time_series() {
    let record = flown(&coupled(), OPEN, 0.3, 2000);
    let series = record.select(&[], &["y0", "y1"]).unwrap();
    let settings = SubspaceSettings { order: Some(3), ..SubspaceSettings::default() };
    let found = identify(&series, &settings).unwrap();
    assert!(found.model.system.b.ncols() == 0 && found.model.system.spectral_radius() < 1.0);
}

#[test]
fn what_cannot_be_identified_is_refused_with_the_reason() {
    let record = flown(&coupled(), OPEN, 0.3, 600);
    let order = |order, horizon| SubspaceSettings {
        order: Some(order),
        horizon: Some(horizon),
        ..SubspaceSettings::default()
    };
    let refuse = |record: &Experiment, settings| identify(record, &settings).unwrap_err();
    assert!(matches!(refuse(&record, order(19, 10)), SubspaceError::Order { largest: 18, .. }));
    assert!(matches!(refuse(&record, order(0, 10)), SubspaceError::Order { .. }));
    assert!(matches!(refuse(&record, order(3, 0)), SubspaceError::Order { .. }));
    assert!(matches!(refuse(&record, order(3, 100)), SubspaceError::TooShort { needed: 1000, .. }));
    let mut still = record.clone();
    still.inputs.column_mut(1).fill(0.4);
    let message = refuse(&still, order(3, 10)).to_string();
    assert!(message.contains("input `u1` does not excite"), "{message}");
    let mut twins = record.clone();
    let twin = 2.0 * twins.inputs.column(0);
    twins.inputs.set_column(1, &twin);
    assert!(matches!(refuse(&twins, order(3, 10)), SubspaceError::NotExciting { .. }));
    let mut stuck = record.clone();
    stuck.outputs.column_mut(0).fill(-2.0);
    let message = refuse(&stuck, order(3, 10)).to_string();
    assert!(message.contains("output `y0` is constant"), "{message}");
}

#[test]
fn the_horizon_follows_the_order() {
    // Four resonances and a lag measured by one output: nine states, which ten samples barely determine.
    let mut a = DMatrix::zeros(9, 9);
    let modes = [(0.98, 0.05), (0.95, 0.15), (0.93, 0.3), (0.9, 0.5)];
    for (mode, (size, turn)) in modes.into_iter().enumerate() {
        let (sin, cos) = f64::sin_cos(turn);
        let block = size * dmatrix![cos, sin; -sin, cos];
        a.view_mut((2 * mode, 2 * mode), (2, 2)).copy_from(&block);
    }
    a[(8, 8)] = 0.8;
    let system = LinearModel {
        a,
        b: DMatrix::from_element(9, 1, 0.3),
        c: DMatrix::from_fn(1, 9, |_, state| if state % 2 == 0 { 1.0 } else { 0.2 }),
        d: DMatrix::zeros(1, 1),
        time: TimeDomain::Discrete { period_s: 0.03 },
    };
    let truth = InnovationModel { system, gain: DMatrix::zeros(9, 1) };
    let noisy = flown(&truth, OPEN, 0.3, 4000);
    let clean = flown(&truth, OPEN, 0.0, 4000);
    let error = |horizon| {
        let settings = SubspaceSettings { order: Some(9), horizon, ..SubspaceSettings::default() };
        let found = identify(&noisy, &settings).unwrap().model.system;
        let run = found.simulate(&clean.inputs, &nalgebra::DVector::zeros(9));
        (run - &clean.outputs).norm() / clean.outputs.norm()
    };
    let (own, short) = (error(None), error(Some(10)));
    println!("error of the free run {own:.4}, with ten samples of past and future {short:.4}");
    assert!(own < 0.2 && own < 0.8 * short);
    assert_eq!(own, error(Some(18)));
}
