//! Injected faults: the copies contain exactly the stated fault, and the estimator survives it.

use std::path::Path;

use hovernav_dataset::Dataset;
use hovernav_replay::estimate;
use hovernav_sim::faults::{CATALOGUE, Campaign, Fault, Flight, Log, Outcome, csv, standard_cells};

fn log_dir() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/heli-hover"))
}

fn heli_hover() -> Flight {
    Flight::Dataset(log_dir().into())
}

fn copy(faults: &[&str], seed: u64) -> tempfile::TempDir {
    let faults: Vec<Fault> = faults.iter().map(|fault| fault.parse().unwrap()).collect();
    let dir = tempfile::tempdir().unwrap();
    let log = Log::open(log_dir()).unwrap();
    log.with_faults(&faults, seed).unwrap().write(dir.path()).unwrap();
    dir
}

/// The files of the dataset that differ in `dir`.
fn changed(dir: &Path) -> Vec<String> {
    let files = std::fs::read_dir(log_dir()).unwrap().map(|entry| entry.unwrap().file_name());
    let mut changed: Vec<String> = files
        .filter(|file| {
            std::fs::read(log_dir().join(file)).unwrap() != std::fs::read(dir.join(file)).unwrap()
        })
        .map(|file| file.into_string().unwrap())
        .collect();
    changed.sort();
    changed
}

/// The first 12 s of the flight, with a rangefinder.
fn short_flight() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    for (file, lines) in [("imu.csv", 400), ("gps.csv", 13), ("dataset.toml", usize::MAX)] {
        let text = std::fs::read_to_string(log_dir().join(file)).unwrap();
        let text: Vec<&str> = text.lines().take(lines).collect();
        std::fs::write(dir.path().join(file), text.join("\n")).unwrap();
    }
    let ranges: String = (0..120).map(|step| format!("{},2.0\n", 0.1 * f64::from(step))).collect();
    std::fs::write(dir.path().join("range.csv"), format!("t_s,range_m\n{ranges}")).unwrap();
    dir
}

/// A campaign repeats a fault with a given start over its seeds exactly if the copies depend on the seed.
#[test]
fn a_fault_counts_as_random_if_its_copies_differ_between_seeds() {
    let flight = short_flight();
    let log = Log::open(flight.path()).unwrap();
    let files = ["imu.csv", "gps.csv", "range.csv", "dataset.toml"];
    let mut compared = 0;
    for entry in &CATALOGUE {
        let fault: Fault = format!("{}@4:3", entry.name).parse().unwrap();
        let copies = [1, 2].map(|seed| {
            let copy = log.with_faults(&[fault], seed).ok()?;
            let dir = tempfile::tempdir().unwrap();
            copy.write(dir.path()).unwrap();
            Some(files.map(|file| std::fs::read(dir.path().join(file)).unwrap()))
        });
        let [Some(one), Some(other)] = copies else { continue };
        assert_eq!(fault.is_drawn(), one != other, "{}", entry.name);
        compared += 1;
    }
    assert!(compared > 30, "{compared}");
}

fn campaign(flights: Vec<Flight>, cells: &[&str], seeds: u64) -> Vec<Outcome> {
    let cells = cells.iter().map(|cell| cell.split(' ').map(|f| f.parse().unwrap()).collect());
    Campaign { flights, cells: cells.collect(), seeds }.run(|| {}).unwrap()
}

#[test]
fn every_fault_changes_its_own_file_and_no_other() {
    // The flight has neither a rangefinder nor a second antenna: see `aid_faults.rs`.
    let absent = |name: &str| name.starts_with("range-") || name.starts_with("heading-");
    for entry in CATALOGUE.iter().filter(|entry| !absent(entry.name)) {
        let expected: &[&str] = match entry.name {
            name if name.starts_with("lever-") => &["dataset.toml"],
            "gps-time" | "outage" | "frozen-fix" | "gps-garbage" | "no-velocity"
            | "swap-latlon" | "radians" => &["gps.csv"],
            name if name.starts_with("glitch-") || name.starts_with("height-") => &["gps.csv"],
            // No gyro of this flight reaches 100°/s; a separate test below covers clipping.
            "clip-gyro" => &[],
            _ => &["imu.csv"],
        };
        let dir = copy(&[entry.name], 3);
        assert_eq!(changed(dir.path()), expected, "{}", entry.name);
        assert!(dir.path().join("faults.json").exists());
    }
}

#[test]
fn a_copy_without_effect_is_the_log_byte_for_byte_and_so_is_its_solution() {
    let dir = copy(&["vibration=1", "clip-accel=100", "glitch-step=0", "packet-loss=0"], 1);
    assert!(changed(dir.path()).is_empty());
    let solve = |dir: &Path| {
        let mut dataset = Dataset::open(dir).unwrap();
        let config = dataset.settings().unwrap();
        estimate(&dataset, &config, |_| {}).solutions
    };
    assert_eq!(solve(dir.path()), solve(log_dir()));
}

#[test]
fn a_seed_gives_the_same_faults_again_and_another_seed_gives_others() {
    let read = |seed| {
        let dir = copy(&["vibration=3", "glitch-step", "gap=1", "packet-loss=5"], seed);
        ["imu.csv", "gps.csv"].map(|file| std::fs::read(dir.path().join(file)).unwrap())
    };
    assert_eq!(read(5), read(5));
    let ([imu, gps], [other_imu, other_gps]) = (read(5), read(6));
    assert!(imu != other_imu && gps != other_gps);
}

#[test]
fn a_gap_takes_its_samples_out_and_leaves_the_others_as_they_were() {
    let dir = copy(&["gap=2@100"], 1);
    let lines = |dir: &Path| std::fs::read_to_string(dir.join("imu.csv")).unwrap();
    let (before, after) = (lines(log_dir()), lines(dir.path()));
    let time = |line: &&str| line.split(',').next().unwrap().parse::<f64>().unwrap_or(-1.0);
    let kept = before.lines().filter(|line| !(100.0..102.0).contains(&time(line)));
    assert!(kept.eq(after.lines()));
}

#[test]
fn vibration_becomes_as_many_times_as_strong_as_asked() {
    // The samples' deviation from the mean of their neighbours is nearly all vibration.
    let rough = |dir: &Path| {
        let dataset = Dataset::open(dir).unwrap();
        let forces: Vec<f64> = (dataset.imu.iter())
            .map(|sample| match sample.motion {
                hovernav::imu::Motion::Rates { specific_force_mps2, .. } => specific_force_mps2.z(),
                hovernav::imu::Motion::Increments { velocity_mps, .. } => velocity_mps.z(),
            })
            .collect();
        let squares = forces.windows(3).map(|w| (w[1] - 0.5 * (w[0] + w[2])).powi(2));
        (squares.sum::<f64>() / forces.len() as f64).sqrt()
    };
    for (factor, seed) in [(0.5, 1), (2.0, 2), (4.0, 3)] {
        let dir = copy(&[&format!("vibration={factor}")], seed);
        let ratio = rough(dir.path()) / rough(log_dir());
        assert!((ratio / factor - 1.0).abs() < 0.05, "{ratio}, expected {factor}");
    }
}

#[test]
fn gyros_clip_at_the_range_asked_for() {
    let dir = copy(&["clip-gyro=20"], 1);
    let dataset = Dataset::open(dir.path()).unwrap();
    let largest = dataset.imu.iter().map(|sample| match sample.motion {
        hovernav::imu::Motion::Rates { angular_rate_radps: rate, .. } => {
            rate.to_array().map(f64::abs).into_iter().fold(0.0, f64::max)
        }
        hovernav::imu::Motion::Increments { .. } => f64::NAN,
    });
    assert_eq!(largest.fold(0.0, f64::max), 20f64.to_radians());
}

#[test]
fn a_fault_of_something_that_a_log_has_not_is_refused() {
    let dir = copy(&["lever-arm=0"], 1);
    std::fs::remove_file(dir.path().join("gps.csv")).unwrap();
    let log = Log::open(dir.path()).unwrap();
    let refusal = log.with_faults(&["outage".parse().unwrap()], 1).unwrap_err().to_string();
    assert!(refusal.contains("fault outage=30"), "{refusal}");
}

#[test]
fn no_fault_brings_the_estimator_to_panic_or_to_nan() {
    let campaign = Campaign {
        flights: vec![heli_hover(), Flight::Simulated],
        cells: standard_cells(),
        seeds: 1,
    };
    let outcomes = campaign.run(|| {}).unwrap();
    assert!(outcomes.len() > 80);
    for Outcome { flight, faults, measures, .. } in &outcomes {
        assert!(!measures.panicked && !measures.nan, "{flight} {faults}");
    }
}

#[test]
fn a_campaign_gives_the_same_table_again() {
    let run = || csv(&campaign(vec![heli_hover(), Flight::Simulated], &["gap=2", "jitter=3"], 2));
    assert_eq!(run(), run());
}

/// Faults of `heli-hover` under which nearly all errors stay inside 3 sigma.
#[test]
fn faults_that_the_filter_knows_how_to_take_stay_inside_three_sigma() {
    let cells = [
        "vibration=2",
        "vibration=4",
        "outage=10",
        "outage=30",
        "jitter=3",
        "no-velocity",
        "attitude-frozen@105:60",
        "attitude-late=1",
    ];
    for Outcome { faults, seed, measures, .. } in campaign(vec![heli_hover()], &cells, 3) {
        let inside = measures.inside_motion;
        assert!(inside >= 0.97, "{faults} seed {seed}: {inside}");
        assert!(!measures.diverged, "{faults} seed {seed}");
    }
}
