//! From a recorded flight to its derivatives: `heli-hover` through the estimator.

use std::collections::HashMap;
use std::path::Path;
use std::sync::LazyLock;

use approx::assert_abs_diff_eq;
use hovernav_dataset::Dataset;
use hovernav_sysid::helicopter::{
    FlightRecord, Identification, ModelStructure, Velocity, flight_warnings, identify,
};
use hovernav_sysid::methods::prediction_error::{Estimates, Fit};
use hovernav_sysid::record::{STICKS, find_test_points, stepped};

use crate::data;

fn folder() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/heli-hover"))
}

fn identified(name: &str, velocity: Velocity) -> Identification {
    let (dataset, solutions) = data::flown();
    let found =
        identify(&dataset, &solutions, ModelStructure::built_in(name).unwrap(), velocity).unwrap();
    println!("== {name}, {velocity:?} {:?} {:?}", found.warnings, found.tones);
    println!("{:#?}", found.identified.log);
    println!("{} iterations, AIC {:.0}", found.identified.iterations, found.identified.aic);
    println!("estimation: {}", found.estimation);
    println!("validation: {:#?}", found.validation.as_ref().unwrap().channels().0);
    found
}

/// Requests shared by several tests.
pub static YAW: LazyLock<Identification> = LazyLock::new(|| identified("yaw", Velocity::Estimated));
pub static HEAVE: LazyLock<Identification> =
    LazyLock::new(|| identified("heave", Velocity::Estimated));

fn percent(fit: &Fit, name: &str) -> f64 {
    fit.channels().0.iter().find(|channel| channel.name == name).unwrap().percent
}

/// Settings of the dataset's simulation, used only for scoring.
fn truth() -> HashMap<String, f64> {
    let path = folder().join("true-parameters.json");
    let mut truth: HashMap<String, f64> =
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let tau = truth.remove("tau").unwrap();
    truth.insert("tau_f".into(), tau);
    truth
}

/// A value and its bound: of a parameter, or of the ratio of two.
fn value(estimates: &Estimates, name: &str) -> (f64, f64) {
    let Some((over, under)) = name.split_once('/') else {
        let estimate = estimates.get(name).unwrap();
        return (estimate.value, estimate.bound);
    };
    let (above, below) = (estimates.get(over).unwrap(), estimates.get(under).unwrap());
    let (one, other) = (above.bound / above.value, below.bound / below.value);
    let joint = estimates.correlation(over, under).unwrap() * one * other;
    let ratio = above.value / below.value;
    (ratio, ratio.abs() * (one * one + other * other - 2.0 * joint).sqrt())
}

fn score(found: &Identification, names: &[&str]) {
    let truth = truth();
    for name in names {
        let expected = match name.split_once('/') {
            Some((over, under)) => truth[over] / truth[under],
            None => truth[*name],
        };
        let (value, bound) = value(&found.identified.estimates, name);
        let bounds = (value - expected).abs() / bound;
        let off = 100.0 * (value / expected - 1.0);
        println!("{name}: {value:.4}, true {expected:.4}: {off:.1} %, {bounds:.1} bounds");
        assert!(bounds < 3.0, "{name}: {bounds} bounds");
        if (bound / value).abs() < 0.1 {
            assert!(off.abs() < 15.0, "{name}: off by {off} %");
        }
    }
}

#[test]
fn three_repetitions_on_each_stick_are_found_and_slow_flight_is_distinguished() {
    let dataset = Dataset::open(folder()).unwrap();
    let points = find_test_points(&dataset.controls);
    for (stick, name) in STICKS.iter().enumerate() {
        let own: Vec<_> = points.iter().filter(|point| point.stick == Some(stick)).collect();
        assert_eq!(own.len(), 3, "{name}");
        for point in own {
            // A doublet: deflection to one side, to the other side, and return to zero; each deflection is held for 1.5
            // s.
            assert_abs_diff_eq!(point.last_step - point.first_step, 3.0, epsilon = 0.1);
        }
    }
    assert_eq!(points.iter().filter(|point| point.stick.is_none()).count(), 4);
}

#[test]
fn a_flight_without_steps_has_no_test_points() {
    let still: Vec<_> = (0..1000)
        .map(|sample| {
            let time_s = f64::from(sample) * 0.03;
            let time = hovernav::time::Time::from_seconds(time_s);
            (time, [0.05 * time_s.sin(), 0.0, 0.02, f64::NAN])
        })
        .collect();
    assert_eq!(find_test_points(&still), Vec::new());
    assert_eq!(find_test_points(&[]), Vec::new());
}

#[test]
fn of_a_stick_that_is_held_and_stepped_the_steps_are_what_is_deliberate() {
    let controls: Vec<(hovernav::time::Time, [f64; 4])> = (0..660)
        .map(|sample| {
            let time_s = f64::from(sample) / 33.0;
            let held = 0.05 * time_s.sin();
            let step = if (6.0..7.5).contains(&time_s) { 0.12 } else { 0.0 };
            (hovernav::time::Time::ZERO + time_s, [held, held, held + step, held])
        })
        .collect();
    let deliberate = stepped(&controls);
    assert_eq!(deliberate.len(), controls.len());
    for ((time, _), own) in controls.iter().zip(deliberate) {
        let expected = if (6.0..7.5).contains(&time.seconds()) { 0.12 } else { 0.0 };
        assert!((own[2] - expected).abs() < 0.005, "{time}: {own:?}");
        assert_eq!([own[0], own[1], own[3]], [0.0; 3]);
    }
    assert_eq!(stepped(&[]), Vec::<[f64; 4]>::new());
}

#[test]
fn yaw_and_heave_alone_return_their_derivatives() {
    let (yaw, heave) = (&*YAW, &*HEAVE);
    score(yaw, &["Nr", "Nped"]);
    assert!(percent(yaw.validation.as_ref().unwrap(), "r") > 90.0);
    score(heave, &["Zw", "Zcol"]);
    assert!(percent(heave.validation.as_ref().unwrap(), "w") > 80.0);
}

#[test]
fn the_whole_hover_returns_its_derivatives_and_flies_what_it_has_not_seen() {
    let found = identified("hybrid", Velocity::Estimated);
    score(&found, &["Zw", "Zcol", "Nr", "Nped", "Lb", "Ma", "Blat/tau_f", "Alon/tau_f"]);
    for fit in [&found.estimation, found.validation.as_ref().unwrap()] {
        for name in ["r", "w", "p", "q"] {
            assert!(percent(fit, name) >= 75.0, "{name}: {} %", percent(fit, name));
        }
        for name in ["u", "v"] {
            assert!(percent(fit, name) >= 65.0, "{name}: {} %", percent(fit, name));
        }
    }
}

#[test]
fn held_gps_velocity_loses_what_the_estimators_keeps() {
    let held = identified("heave", Velocity::HeldGps);
    let of = |found: &Identification| percent(found.validation.as_ref().unwrap(), "w");
    assert!(of(&HEAVE) > of(&held) + 30.0, "{} against {}", of(&HEAVE), of(&held));
}

/// Asserts that `structure` finds `sticks` 80 ms later in a record with sticks 80 ms early than in the original,
/// `before`.
fn assert_found_late(before: &Identification, structure: &str, sticks: &[&str]) {
    let (mut dataset, solutions) = data::flown();
    for (time, _) in &mut dataset.controls {
        *time = time.offset_by(-0.08);
    }
    let after = data::identified(&dataset, &solutions, structure);
    for stick in sticks {
        let late_s = |found: &Identification| {
            let found = &found.identified;
            found.delay(stick).unwrap().value + found.lag(stick).unwrap().value
        };
        let (before, after) = (late_s(before), late_s(&after));
        println!("{stick}: {:.1} ms late, then {:.1} ms", 1e3 * before, 1e3 * after);
        assert!((after - before - 0.08).abs() < 0.005, "{stick}: {before} s, then {after} s");
    }
}

#[test]
fn sticks_recorded_80_ms_early_are_found_80_ms_late() {
    assert_found_late(&YAW, "yaw", &["pedal"]);
    assert_found_late(&HEAVE, "heave", &["collective"]);
}

#[test]
#[ignore = "ten seconds: two identifications of roll and pitch"]
fn cyclic_sticks_recorded_80_ms_early_are_found_80_ms_late() {
    let (dataset, solutions) = data::flown();
    let before = data::identified(&dataset, &solutions, "flapping");
    assert_found_late(&before, "flapping", &["lateral", "longitudinal"]);
}

#[test]
fn what_was_not_recorded_is_skipped_and_reported() {
    let (mut dataset, mut solutions) = data::flown();
    let whole = &*YAW;
    let start = solutions[0].time;
    let after_s = |time: hovernav::time::Time| time - start;
    dataset.controls.retain(|(time, _)| !(160.0..175.0).contains(&after_s(*time)));
    solutions.retain(|solution| !(200.0..210.0).contains(&after_s(solution.time)));
    let found = data::identified(&dataset, &solutions, "yaw");
    println!("{:?}", found.warnings);
    println!("{} s of {} s", found.estimated_s, whole.estimated_s);
    for of in ["sticks", "motion"] {
        let told = format!("{of} not recorded from ");
        assert_eq!(found.warnings.iter().filter(|own| own.starts_with(&told)).count(), 1);
    }
    assert!(whole.warnings.is_empty());
    assert!(found.estimated_s < whole.estimated_s - 5.0);
    for point in &found.test_points {
        for gap in [160.0..175.0, 200.0..210.0] {
            assert!(after_s(point.end) <= gap.start + 0.1 || after_s(point.start) >= gap.end - 0.1);
        }
    }
    score(&found, &["Nr", "Nped"]);

    // Times without a record do not count as rest: the warnings about the sticks must not report the same times again.
    dataset.controls.retain(|(time, _)| after_s(*time) < 160.0);
    let flight = FlightRecord::new(&dataset, &solutions, Velocity::Estimated).unwrap();
    let warnings = flight_warnings(&flight, &found.identified.structure);
    assert!(!warnings.iter().any(|own| own.contains("does not move")), "{warnings:?}");

    // Sticks on another clock do not overlap the flight. They must not be reported as sticks that never move.
    dataset.controls.iter_mut().for_each(|(time, _)| *time = time.offset_by(1000.0));
    let told = identify(
        &dataset,
        &solutions,
        ModelStructure::built_in("yaw").unwrap(),
        Velocity::Estimated,
    )
    .map(drop)
    .unwrap_err();
    assert!(told.to_string().contains("do not overlap in time"), "{told}");
}
