//! From a recorded flight to its derivatives: `heli-hover` through the estimator.

use std::collections::HashMap;
use std::path::PathBuf;

use hovernav::log::Dataset;
use hovernav::sysid::helicopter::Kind;
use hovernav::sysid::identify::{Identification, Velocity, identify};
use hovernav::sysid::test_points::{STICKS, find_test_points};

fn folder() -> Option<PathBuf> {
    let path = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/datasets/heli-hover"));
    if path.is_dir() {
        return Some(path);
    }
    println!("skipped: {} is missing", path.display());
    None
}

fn identified(kind: Kind, velocity: Velocity) -> Option<Identification> {
    let mut dataset = Dataset::open(&folder()?).unwrap();
    let config = dataset.settings().unwrap();
    let solutions = dataset.smooth(&config, |_| ()).solutions;
    Some(identify(&dataset, &solutions, kind, velocity).unwrap())
}

fn truth() -> HashMap<String, f64> {
    let path = folder().unwrap().join("true-parameters.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn report(found: &Identification) {
    println!("== {} {:?}", found.kind, found.velocity);
    println!("{:?} {:?}", found.warnings, found.tones);
    println!("{:#?}", found.identified.log);
    println!("iterations {} converged {}", found.identified.iterations, found.identified.converged);
    println!("estimation {}", found.estimation);
    if let Some(validation) = &found.validation {
        for channel in validation.channels().0 {
            println!(
                "validation {} {:.1} % floor {:.1} %",
                channel.name, channel.percent, channel.floor_percent
            );
        }
    }
    for (name, value) in truth() {
        let name = if name == "tau" { "tau_f".to_owned() } else { name };
        if let Some(estimate) = found.identified.estimates.get(&name) {
            println!(
                "{name}: {:.4} true {value:.4}, off {:.1} %, {:.1} bounds",
                estimate.value,
                100.0 * (estimate.value / value - 1.0),
                (estimate.value - value).abs() / estimate.bound
            );
        }
    }
}

#[test]
fn test_points_are_found_from_the_sticks() {
    let Some(folder) = folder() else { return };
    let dataset = Dataset::open(&folder).unwrap();
    let points = find_test_points(&dataset.controls);
    for point in &points {
        println!(
            "{:?} {:.2} {:.2}",
            point.stick,
            point.first_step.seconds(),
            point.last_step.seconds()
        );
    }
    for stick in 0..STICKS.len() {
        let own = points.iter().filter(|point| point.stick == Some(stick)).count();
        assert_eq!(own, 3, "{}", STICKS[stick]);
    }
}

#[test]
fn explore() {
    for kind in [Kind::Yaw, Kind::Heave, Kind::RollPitch, Kind::Hybrid] {
        let began = std::time::Instant::now();
        let Some(found) = identified(kind, Velocity::Estimated) else { return };
        report(&found);
        println!("{:?}", began.elapsed());
    }
}
