//! Comparison of the analytic gradient with differences of the cost.

use std::cell::RefCell;

use approx::assert_abs_diff_eq;
use nalgebra::DMatrix;

use super::problem::Problem;
use super::sweep::Record;
use super::{Settings, identify};
use crate::helicopter::ModelStructure;
use crate::methods::least_squares::Cost as _;
use crate::methods::structure::{Parameter, Structure};
use crate::record::Experiment;

/// Inputs and outputs that no model explains: the gradient must be correct away from the optimum.
fn record(structure: &Structure, samples: usize) -> Record {
    let wave = |rate: f64| {
        move |row: usize, column: usize| {
            (rate * (row as f64 + 3.0) * (1.0 + 0.37 * column as f64)).sin()
        }
    };
    let inputs = DMatrix::from_fn(samples, structure.inputs.len(), wave(0.11)) * 0.1;
    let outputs = DMatrix::from_fn(samples, structure.outputs.len(), wave(0.07));
    let names = (structure.inputs.clone(), structure.outputs.clone());
    let experiment =
        Experiment::new("waves", 0.03, names.0, names.1, inputs, outputs).expect("finite");
    Record::new(structure, &experiment).expect("same names")
}

fn gradient_holds(structure: &Structure, innovations: bool) {
    let records = [record(structure, 100), record(structure, 70)];
    let mut base = structure.start();
    base.extend((0..structure.noises.len()).map(|index| -0.5 + 0.2 * index as f64));
    base.extend((0..structure.outputs.len()).map(|index| -1.0 + 0.15 * index as f64));
    let own = structure.parameters.len();
    let free = (0..base.len())
        .filter(|index| innovations || !(own..own + structure.noises.len()).contains(index))
        .collect::<Vec<_>>();
    let theta: Vec<f64> = free.iter().map(|&index| base[index]).collect();
    let problem = Problem {
        structure,
        records: &records,
        period_s: 0.03,
        innovations,
        base,
        free,
        lower: Vec::new(),
        upper: Vec::new(),
        prior_weight: Vec::new(),
        own: RefCell::new(Problem::guesses(structure, &records)),
    };
    let at = problem.quadratic(&theta).expect("a predictor");
    assert_abs_diff_eq!(
        at.cost,
        problem.cost(&theta).expect("a cost"),
        epsilon = 1e-8 * at.cost.abs()
    );
    for index in 0..theta.len() {
        let step = 1e-4 * theta[index].abs().max(0.1);
        let at_offset = |offset: f64| {
            let mut moved = theta.clone();
            moved[index] += offset;
            problem.cost(&moved).expect("a cost")
        };
        // Fourth order, so that rounding and truncation errors both stay far below the tolerance.
        let difference = (8.0 * (at_offset(step) - at_offset(-step))
            - (at_offset(2.0 * step) - at_offset(-2.0 * step)))
            / (12.0 * step);
        let scale = at.information[(index, index)].sqrt().max(difference.abs()).max(1e-3);
        assert!(
            (at.gradient[index] - difference).abs() < 1e-5 * scale,
            "{} parameter {index}: {} against {difference}",
            structure.name,
            at.gradient[index]
        );
    }
}

#[test]
fn gradients_of_every_helicopter_agree_with_central_differences() {
    for structure in ModelStructure::all() {
        // A bar without effect is unobservable: its initial tilt would be arbitrary.
        let bar = structure.equations.with("Ac", 0.5, false).with("Bd", 0.4, false);
        gradient_holds(&bar, true);
    }
}

#[test]
fn output_error_gradient_agrees_with_central_differences() {
    gradient_holds(&ModelStructure::built_in("heave").unwrap().equations, false);
}

#[test]
fn gradient_holds_through_delay_lag_feedthrough_bias_and_what_is_expected() {
    let structure = Structure::new(
        "everything",
        vec![
            Parameter::new("a", "", -1.5),
            Parameter::new("k", "", 3.0).expected(2.5, 0.2),
            Parameter::new("c", "", 0.7),
            Parameter::new("d", "", 0.4),
            Parameter::new("tau", "s", 0.05),
            Parameter::new("lag", "s", 0.04),
        ],
        "inputs s
         noise n
         outputs x force
         offsets x
         biases force
         delay s tau
         lag s lag
         x' = a*x + y
         y' = -2*y + k/c*s + n
         force = c*x + a*d*y + d*s",
    )
    .expect("valid");
    gradient_holds(&structure, true);
}

#[test]
fn what_is_expected_holds_a_parameter_that_the_flight_does_not_know() {
    // The stick never moves: its estimated effect is the prior, with the prior's sigma as bound.
    let structure = Structure::new(
        "still",
        vec![Parameter::new("a", "", -1.0), Parameter::new("k", "", 3.0).expected(2.5, 0.2)],
        "inputs s
         noise n
         outputs x
         x' = a*x + k*s + n",
    )
    .expect("valid");
    let wave = |row: usize, _| (0.07 * row as f64).sin() + 0.1 * (1.7 * (row * row) as f64).sin();
    let outputs = DMatrix::from_fn(400, 1, wave);
    let names = (structure.inputs.clone(), structure.outputs.clone());
    let inputs = DMatrix::zeros(400, 1);
    let still = Experiment::new("still", 0.03, names.0, names.1, inputs, outputs).expect("finite");
    let found = identify(&structure, &[still], &Settings::innovations(vec![1.0])).expect("found");
    let gain = found.estimates.get("k").expect("it has one");
    assert_abs_diff_eq!(gain.value, 2.5, epsilon = 1e-3);
    assert_abs_diff_eq!(gain.bound / 0.2, 1.0, epsilon = 1e-3);
}

/// Yaw with a pole of 1/30.8 s behind a servo of 13.3 ms, sampled every 30.3 ms. Its commands are held and 42.4 ms late.
fn fast_yaw() -> Experiment {
    const PERIOD_S: f64 = 0.0303;
    const PARTS: usize = 1000;
    let part_s = PERIOD_S / PARTS as f64;
    let (servo_kept, yaw_kept) = ((-part_s / 0.0133).exp(), (-30.8 * part_s).exp());
    let command = |sample: usize| [0.1, -0.06, -0.1, 0.04, 0.0][(sample / 7 + sample / 40) % 5];
    let (mut servo, mut rate) = (0.0, 0.0);
    let mut outputs = DMatrix::zeros(1500, 1);
    for sample in 2..outputs.nrows() {
        let noise = ((sample * sample) as f64 * 0.618).fract() - 0.5;
        outputs[(sample, 0)] = rate + 0.001 * noise;
        for part in 0..PARTS {
            // The newer command arrives after 400 of the 1000 parts.
            let late = if part < 400 { 2 } else { 1 };
            let before = servo;
            servo = servo_kept * servo + (1.0 - servo_kept) * command(sample - late);
            let middle = 0.5 * (before + servo);
            rate = yaw_kept * rate + (1.0 - yaw_kept) * 60.0 / 30.8 * middle;
        }
    }
    let inputs = DMatrix::from_fn(outputs.nrows(), 1, |sample, _| command(sample));
    let names = (vec!["pedal".to_owned()], vec!["r".to_owned()]);
    let experiment = Experiment::new("yaw", PERIOD_S, names.0, names.1, inputs, outputs);
    experiment.expect("finite").slice(10..1500).expect("long enough")
}

#[test]
fn a_pole_as_fast_as_a_sample_is_found_behind_a_servo() {
    let structure = Structure::new(
        "yaw",
        vec![
            Parameter::new("Nr", "1/s", -20.0).within(-60.0, 0.0),
            Parameter::new("Nped", "rad/s²", 40.0),
            Parameter::new("tau", "s", 0.04).within(0.0, 0.2),
            Parameter::new("lag", "s", 0.01).within(0.0, 0.1),
        ],
        "inputs pedal
         noise n
         outputs r
         delay pedal tau
         lag pedal lag
         r' = Nr*r + Nped*pedal + n",
    )
    .expect("valid");
    let found = identify(&structure, &[fast_yaw()], &Settings::innovations(vec![0.1]));
    let found = found.expect("found");
    for (name, truth, accuracy) in
        [("Nr", -30.8, 0.5), ("Nped", 60.0, 0.9), ("tau", 0.0424, 5e-4), ("lag", 0.0133, 5e-4)]
    {
        let own = found.estimates.get(name).expect("it has one");
        println!("{name} {} ± {}, {truth}", own.value, own.bound);
        assert_abs_diff_eq!(own.value, truth, epsilon = accuracy);
    }
}
