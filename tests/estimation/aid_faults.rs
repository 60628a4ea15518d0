//! A flight with a rangefinder and two antennas, through files, faults and the estimator.

use std::path::Path;

use approx::assert_abs_diff_eq;
use hovernav::autopilot::HoverConfig;
use hovernav::ins::HeadingSource;
use hovernav_dataset::{Dataset, Truth};
use hovernav_design::hover::HoverDesign;
use hovernav_findings::{Sensor, findings};
use hovernav_model::shipped;
use hovernav_replay::Run;
use hovernav_sim::faults::{CATALOGUE, Log};
use hovernav_sim::{AntennasConfig, FlightConfig, RangefinderConfig};

/// Two minutes of hover, 5 m above the ground, written to a directory; returns the truth.
fn hover(dir: &Path) -> Vec<Truth> {
    let design = HoverDesign::default();
    let gains = design.synthesise(&shipped::raptor60()).unwrap();
    let mut config = FlightConfig::new(HoverConfig::new(design.period_s, gains));
    config.duration_s = 120.0;
    config.seed = 4;
    config.rangefinder = Some(RangefinderConfig::over(config.start.height_m - 5.0));
    config.antennas = Some(AntennasConfig::default());
    // Only the antennas give a heading.
    config.dmu.magnetometer = None;
    config.dmu.attitude = None;
    let (dataset, truth) = config.fly().unwrap().dataset();
    dataset.write(dir, &truth).unwrap();
    truth
}

fn estimate(dir: &Path) -> (Dataset, Run) {
    let mut dataset = Dataset::open(dir).unwrap();
    let config = dataset.settings().unwrap();
    let run = hovernav_replay::estimate(&dataset, &config, |_| {});
    (dataset, run)
}

/// Largest errors of height, m, and heading, °, from 20 s on.
fn worst(run: &Run, truth: &[Truth]) -> [f64; 2] {
    let mut worst: [f64; 2] = [0.0; 2];
    for solution in run.solutions.iter().filter(|solution| solution.time.seconds() > 20.0) {
        let at = truth.partition_point(|truth| truth.time < solution.time);
        let Some(truth) = truth.get(at) else { continue };
        let yaw = |attitude: hovernav::frames::Rotation<_, _>| attitude.euler().yaw_rad;
        let off = hovernav::frames::wrap_angle(yaw(solution.body_to_ned) - yaw(truth.body_to_ned));
        worst[0] = worst[0].max((solution.position.height_m - truth.position.height_m).abs());
        worst[1] = worst[1].max(off.to_degrees().abs());
    }
    worst
}

#[test]
fn the_files_of_both_aids_are_read_back_as_they_were_and_used() {
    let dir = tempfile::tempdir().unwrap();
    let truth = hover(dir.path());
    let (dataset, run) = estimate(dir.path());
    assert!(dataset.ranges.len() > 2000 && dataset.headings.len() > 500);
    assert!(dataset.warnings.is_empty(), "{:?}", dataset.warnings);
    let again = tempfile::tempdir().unwrap();
    dataset.write(again.path(), &[]).unwrap();
    let reread = Dataset::open(again.path()).unwrap();
    assert_eq!((&reread.ranges, &reread.manifest), (&dataset.ranges, &dataset.manifest));
    for (a, b) in reread.headings.iter().zip(&dataset.headings) {
        assert_abs_diff_eq!(a.heading_rad, b.heading_rad, epsilon = 1e-12);
        assert_eq!(a.length_m, b.length_m);
    }
    let aligned = run.notices.iter().find_map(|notice| match notice {
        hovernav::ekf::Notice::Aligned(alignment) => Some(alignment.heading),
        _ => None,
    });
    assert_eq!(aligned, Some(HeadingSource::SecondAntenna));
    let [height_m, heading_deg] = worst(&run, &truth);
    println!("worst: height {height_m:.2} m, heading {heading_deg:.2}°");
    assert!(heading_deg < 2.0, "{heading_deg}");
}

#[test]
fn every_fault_of_an_aid_changes_its_own_file_and_does_little_harm() {
    let dir = tempfile::tempdir().unwrap();
    let truth = hover(dir.path());
    let clean = worst(&estimate(dir.path()).1, &truth);
    let log = Log::open(dir.path()).unwrap();
    let faults = ["range.csv", "heading.csv"].into_iter().flat_map(|file| {
        let start = if file == "range.csv" { "range-" } else { "heading-" };
        let of = CATALOGUE.iter().filter(move |entry| entry.name.starts_with(start));
        of.map(move |entry| (entry.name, file))
    });
    for (name, file) in faults {
        let fault = format!("{name}@60").parse().unwrap();
        let out = tempfile::tempdir().unwrap();
        log.with_faults(&[fault], 1).unwrap().write(out.path()).unwrap();
        for entry in std::fs::read_dir(dir.path()).unwrap() {
            let from = entry.unwrap().path();
            let to = out.path().join(from.file_name().unwrap());
            let is_same = std::fs::read(&from).unwrap() == std::fs::read(to).unwrap();
            assert_eq!(is_same, !from.ends_with(file), "{name}: {}", from.display());
        }
        let (dataset, run) = estimate(out.path());
        let [height_m, heading_deg] = worst(&run, &truth);
        let findings = findings(&dataset, &run);
        let words: Vec<&str> = findings.iter().map(|finding| finding.words.as_str()).collect();
        println!("{name}: height {height_m:.2} m, heading {heading_deg:.2}°: {words:?}");
        assert!(height_m < clean[0] + 0.6, "{name}: {height_m} m, clean {}", clean[0]);
        assert!(heading_deg < clean[1] + 3.0, "{name}: {heading_deg}°, clean {}", clean[1]);
        let named = |sensor| findings.iter().any(|finding| finding.sensor == sensor);
        match name {
            "heading-turn" | "heading-gone" => {
                assert!(named(Sensor::SecondAntenna), "{name}: {words:?}");
            }
            "range-step" | "range-stuck" | "range-gone" => {
                assert!(named(Sensor::Rangefinder), "{name}: {words:?}");
            }
            _ => {}
        }
    }
}
