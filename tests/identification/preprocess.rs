//! Preparation adds no shift, and bad data is reported before the fit.

use approx::assert_abs_diff_eq;
use hovernav_sysid::methods::excitation::{InputFault, check_inputs};
use hovernav_sysid::methods::subspace::{SubspaceSettings, identify};
use hovernav_sysid::methods::validate::{Horizon, validate};
use hovernav_sysid::record::preprocess::{
    KinematicChannels, KinematicFault, LowPass, SegmentSettings, check_kinematics,
    excited_segments, resample, uniform,
};
use hovernav_sysid::record::{Experiment, Maneuver};
use nalgebra::DMatrix;

use crate::data::recorded;

/// Reference vectors: `scipy.signal.filtfilt` (SciPy 1.17) with `butter(order, hz, fs=33)`, its
/// default odd padding; `sosfiltfilt` for order 8.
const ZERO_PHASE: &str = include_str!("zero_phase.csv");

#[test]
fn zero_phase_filtering_equals_scipy_to_ten_digits() {
    let rows: Vec<Vec<f64>> = ZERO_PHASE
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|field| field.parse().unwrap()).collect())
        .collect();
    let column = |index: usize| -> Vec<f64> { rows.iter().map(|row| row[index]).collect() };
    let filters = [(2, 3.0), (4, 3.0), (5, 6.0), (1, 1.0), (8, 4.0)];
    for (index, (order, cutoff_hz)) in filters.into_iter().enumerate() {
        let filter = LowPass::butterworth(order, cutoff_hz, 1.0 / 33.0).unwrap();
        let ours = filter.zero_phase(&column(0)).unwrap();
        let worst = ours
            .iter()
            .zip(column(index + 1))
            .map(|(ours, theirs)| (ours - theirs).abs())
            .fold(0.0, f64::max);
        assert!(worst < 1e-10, "order {order}: {worst:e}");
    }
}

#[test]
fn a_low_pass_has_half_power_at_its_cutoff_and_no_phase() {
    let (period_s, cutoff_hz) = (0.01, 4.0);
    let filter = LowPass::butterworth(4, cutoff_hz, period_s).unwrap();
    let tone = |hz: f64| -> Vec<f64> {
        (0..2000).map(|k| (std::f64::consts::TAU * hz * period_s * f64::from(k)).sin()).collect()
    };
    let passed = filter.zero_phase(&tone(cutoff_hz)).unwrap();
    // Filtered twice, so a half in amplitude, sample by sample: no shift.
    for (before, after) in tone(cutoff_hz)[500..1500].iter().zip(&passed[500..1500]) {
        assert_abs_diff_eq!(*after, 0.5 * before, epsilon = 1e-6);
    }
}

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|&name| name.to_owned()).collect()
}

fn experiment(inputs: &[&str], signals: DMatrix<f64>, outputs: DMatrix<f64>) -> Experiment {
    let output_names: Vec<String> = (0..outputs.ncols()).map(|k| format!("y{k}")).collect();
    Experiment::new("made", 0.02, names(inputs), output_names, signals, outputs).unwrap()
}

#[test]
fn a_slow_tone_survives_another_clock_and_a_fast_one_does_not_come_back_as_another() {
    let tone =
        |hz: f64, period_s: f64, k: usize| (std::f64::consts::TAU * hz * period_s * k as f64).sin();
    let outputs = DMatrix::from_fn(3000, 2, |k, column| tone([1.0, 15.0][column], 0.02, k));
    let made = experiment(&[], DMatrix::zeros(3000, 0), outputs);
    let slower = resample(&made, 0.05).unwrap();
    assert_eq!(slower.samples(), 1200);
    for k in 100..1100 {
        assert_abs_diff_eq!(slower.outputs[(k, 0)], tone(1.0, 0.05, k), epsilon = 2e-3);
        assert!(slower.outputs[(k, 1)].abs() < 1e-3, "15 Hz would come back as 5 Hz");
    }
    let faster = resample(&made, 0.01).unwrap();
    assert!((0..5999).all(|k| (faster.outputs[(k, 0)] - tone(1.0, 0.01, k)).abs() < 2e-3));
}

#[test]
fn uneven_times_are_put_on_a_grid_and_gaps_are_named() {
    let times: Vec<f64> = (0..200).map(|k| 0.1 * f64::from(k) + 0.03 * f64::from(k % 3)).collect();
    let values: Vec<f64> = times.iter().map(|t| t * t).collect();
    let even = uniform(&times, &values, 0.05, 0.3).unwrap();
    assert!(even.iter().enumerate().skip(4).take(380).all(|(k, value)| {
        let t = 0.05 * k as f64;
        (value - t * t).abs() < 1e-9
    }));
    let mut gap = times.clone();
    gap[100..].iter_mut().for_each(|time| *time += 1.0);
    let message = uniform(&gap, &values, 0.05, 0.3).unwrap_err().to_string();
    assert!(message.contains("longer than the 0.3 s"), "{message}");
    gap[50] = gap[49];
    assert!(uniform(&gap, &values, 0.05, 2.0).unwrap_err().to_string().contains("sample 50"));
}

#[test]
fn each_manoeuvre_is_one_segment() {
    let doublet = Maneuver::Doublet { amplitude: 0.1, hold_s: 0.5 };
    let mut sticks = DMatrix::zeros(3000, 2);
    for (column, start_s) in [(0, 5.0), (1, 25.0), (0, 45.0)] {
        for (row, value) in doublet.sampled(3000, 0.02, start_s).into_iter().enumerate() {
            sticks[(row, column)] += value;
        }
    }
    let made = experiment(&["lateral", "pedal"], sticks, DMatrix::zeros(3000, 1));
    let segments = excited_segments(&made, &SegmentSettings::default());
    assert_eq!(segments, [200..450, 1200..1450, 2200..2450]);
}

#[test]
fn inputs_that_move_as_one_are_named() {
    let sweep = Maneuver::Sweep {
        amplitude: 0.1,
        first_hz: 0.2,
        last_hz: 3.0,
        duration_s: 58.0,
        fade_s: 1.0,
    };
    let own = sweep.sampled(3000, 0.02, 1.0);
    let sticks = DMatrix::from_fn(3000, 3, |k, column| match column {
        0 => own[k],
        1 => -0.5 * own[k] + 0.002 * (0.7 * k as f64).sin(),
        _ => 0.3,
    });
    let made = experiment(&["lateral", "pedal", "collective"], sticks, DMatrix::zeros(3000, 1));
    let report = check_inputs(&made);
    for fault in &report.faults {
        println!("{fault}");
    }
    let constant = InputFault::Constant { input: "collective".to_owned() };
    assert!(report.faults.contains(&constant));
    let collinear = |fault: &InputFault| matches!(fault, InputFault::Collinear { input, explained } if input == "pedal" && *explained > 0.99);
    assert!(report.faults.iter().any(collinear));
    assert!(report.faults.iter().any(|fault| matches!(fault, InputFault::Coherent { .. })));
    assert!(report.condition > 100.0);
}

/// Attitude, rates, velocity and specific force of one body that rocks about all axes.
fn rocking() -> Experiment {
    let (period_s, samples, gravity) = (0.01, 6000, 9.806_65);
    let mut outputs = DMatrix::zeros(samples, 11);
    for k in 0..samples {
        let t = period_s * k as f64;
        let (roll, roll_rate) = (0.2 * (0.9 * t).sin(), 0.18 * (0.9 * t).cos());
        let (pitch, pitch_rate) = (0.15 * (0.7 * t).cos(), -0.105 * (0.7 * t).sin());
        let yaw_rate = 0.3 * (0.4 * t).cos();
        let p = roll_rate - yaw_rate * pitch.sin();
        let q = pitch_rate * roll.cos() + yaw_rate * pitch.cos() * roll.sin();
        let r = -pitch_rate * roll.sin() + yaw_rate * pitch.cos() * roll.cos();
        let velocity = [(0.5 * t).sin(), 2.0 * (0.6 * t).cos(), 0.5 * (0.8 * t).sin()];
        let change = [0.5 * (0.5 * t).cos(), -1.2 * (0.6 * t).sin(), 0.4 * (0.8 * t).cos()];
        let [u, v, w] = velocity;
        let force = [
            change[0] + q * w - r * v + gravity * pitch.sin(),
            change[1] + r * u - p * w - gravity * pitch.cos() * roll.sin(),
            change[2] + p * v - q * u - gravity * pitch.cos() * roll.cos(),
        ];
        let row = [roll, pitch, p, q, r, u, v, w, force[0], force[1], force[2]];
        for (column, value) in row.into_iter().enumerate() {
            outputs[(k, column)] = value;
        }
    }
    let outputs_names = names(&["phi", "theta", "p", "q", "r", "u", "v", "w", "ax", "ay", "az"]);
    Experiment::new("rocking", period_s, vec![], outputs_names, DMatrix::zeros(samples, 0), outputs)
        .unwrap()
}

const CHANNELS: KinematicChannels<'static> = KinematicChannels {
    roll: Some("phi"),
    pitch: Some("theta"),
    p: Some("p"),
    q: Some("q"),
    r: Some("r"),
    u: Some("u"),
    v: Some("v"),
    w: Some("w"),
    specific_force: Some(["ax", "ay", "az"]),
};

#[test]
fn one_rigid_body_closes_its_kinematics() {
    let report = check_kinematics(&rocking(), &CHANNELS).unwrap();
    assert_eq!(report.relations.len(), 5);
    for relation in &report.relations {
        assert!((relation.scale - 1.0).abs() < 1e-3 && relation.explained > 0.999, "{relation:?}");
    }
    assert!(report.faults.is_empty(), "{:?}", report.faults);
}

#[test]
fn a_wrong_unit_sign_or_clock_is_named() {
    let wrong = |change: &dyn Fn(&mut DMatrix<f64>)| {
        let mut body = rocking();
        change(&mut body.outputs);
        check_kinematics(&body, &CHANNELS).unwrap().faults
    };
    let degrees = wrong(&|outputs| outputs.column_mut(0).scale_mut(57.3));
    assert!(matches!(degrees[0], KinematicFault::Scale(_) | KinematicFault::Unrelated(_)));
    let mirrored = wrong(&|outputs| outputs.column_mut(3).neg_mut());
    assert!(
        mirrored.iter().any(|fault| matches!(fault, KinematicFault::Sign(relation)
        if relation.equation.starts_with("θ̇"))),
        "{mirrored:?}"
    );
    let late = wrong(&|outputs| {
        let roll = outputs.column(0).into_owned();
        for k in 12..roll.len() {
            outputs[(k, 0)] = roll[k - 12];
        }
    });
    assert!(
        late.iter().any(|fault| matches!(fault, KinematicFault::Skew(relation)
        if (relation.skew_s - 0.12).abs() < 0.021)),
        "{late:?}"
    );
    // A gyro bias and a slow drift are estimated by the filter: they are not faults of the record.
    assert!(wrong(&|outputs| outputs.column_mut(2).add_scalar_mut(0.01)).is_empty());
}

/// The first half and the whole of the recorded hover of an Align T-REX 550.
#[test]
fn the_trex_550_record_says_what_is_wrong_with_it() {
    let Some(record) = recorded("trex550_hover", 4, 0.01) else { return };
    let (first, _) = record.halves().unwrap();
    let inputs = check_inputs(&first);
    println!("first half:");
    for fault in &inputs.faults {
        println!("  {fault}");
    }
    assert!(inputs.faults.contains(&InputFault::Constant { input: "ped".to_owned() }));
    for fault in &check_inputs(&record).faults {
        println!("whole: {fault}");
    }
    let channels = KinematicChannels { specific_force: None, ..CHANNELS };
    let report = check_kinematics(&record, &channels).unwrap();
    for relation in &report.relations {
        println!("  {relation:?}");
    }
    for fault in &report.faults {
        println!("  {fault}");
    }
    for equation in ["φ̇", "θ̇"] {
        let named = |fault: &KinematicFault| fault.to_string().starts_with(equation);
        assert!(report.faults.iter().any(named), "{equation}");
    }
    let reversed = |fault: &KinematicFault| matches!(fault, KinematicFault::Sign(relation) if relation.equation.starts_with("v̇"));
    assert!(report.faults.iter().any(reversed));
}

#[test]
fn no_good_model_is_made_of_the_trex_550_record() {
    let Some(record) = recorded("trex550_hover", 4, 0.01) else { return };
    let (first, second) = record.halves().unwrap();
    let trim = first.means();
    let (first, second) = (first.about(&trim), second.about(&trim));
    let outputs = ["p", "q", "u", "v"];
    let with_pedal = first.select(&["lat", "lon", "ped", "col"], &outputs).unwrap();
    let pass = SubspaceSettings { order: Some(6), ..SubspaceSettings::default() };
    let refusal = identify(&with_pedal, &pass).unwrap_err();
    println!("with the pedal: {refusal}");
    assert!(refusal.to_string().contains("input `ped` does not excite"));

    let sticks = ["lat", "lon", "col"];
    let [first, second] = [first, second].map(|half| half.select(&sticks, &outputs).unwrap());
    for stable in [false, true] {
        let found = identify(&first, &SubspaceSettings { stable, ..pass }).unwrap();
        match validate(&found.model, &first, &second, &[Horizon::Steps(1), Horizon::Simulation]) {
            Err(refusal) => println!("refused: {refusal}"),
            Ok(validation) => {
                println!("{validation}nothing left: {}", validation.residuals.nothing_left());
                assert!(!validation.shortcomings().is_empty());
            }
        }
    }
}
