//! Every response of the estimator ends in a sentence with sensor, time, size and cause.

use std::path::Path;

use hovernav::autopilot::HoverConfig;
use hovernav::earth::Geodetic;
use hovernav::frames::Vector;
use hovernav_dataset::Dataset;
use hovernav_design::hover::HoverDesign;
use hovernav_findings::{Finding, FindingKind, Sensor, Severity, sentences};
use hovernav_model::shipped;
use hovernav_replay::estimate;
use hovernav_sim::FlightConfig;
use hovernav_sim::campaign::SensorGrade;
use hovernav_sim::faults::{Fault, Log};
use hovernav_testing::shared;

fn log_dir() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/heli-hover"))
}

/// Findings of `heli-hover` with these faults.
fn findings(faults: &[&str]) -> Vec<Finding> {
    let faults: Vec<Fault> = faults.iter().map(|fault| fault.parse().unwrap()).collect();
    let dir = tempfile::tempdir().unwrap();
    Log::open(log_dir()).unwrap().with_faults(&faults, 2).unwrap().write(dir.path()).unwrap();
    let mut dataset = Dataset::open(dir.path()).unwrap();
    let config = dataset.settings().unwrap();
    let run = estimate(&dataset, &config, |_| {});
    hovernav_findings::findings(&dataset, &run)
}

#[test]
fn a_flight_without_fault_gives_no_warning() {
    assert_eq!(sentences(&findings(&[])), [""; 0]);
}

#[test]
fn a_simulated_hover_without_fault_gives_no_warning() {
    let design = HoverDesign::default();
    let gains = design.synthesise(&shipped::raptor60()).unwrap();
    for seed in 11..25 {
        let mut config = FlightConfig::new(HoverConfig::new(design.period_s, gains));
        (config.dmu, config.gps) = SensorGrade::Thesis.sensors();
        config.dmu.rate_hz = 1.0 / design.period_s;
        config.start_at(Geodetic::from_degrees(1.3521, 103.8198, 50.0).unwrap());
        config.heading_rad = 60f64.to_radians();
        (config.seed, config.duration_s) = (seed, 120.0);
        let (mut dataset, _) = config.fly().unwrap().dataset();
        let settings = dataset.settings().unwrap();
        let run = estimate(&dataset, &settings, |_| {});
        assert_eq!(sentences(&hovernav_findings::findings(&dataset, &run)), [""; 0], "seed {seed}");
    }
}

#[test]
fn real_flights_give_no_warning_but_of_their_gps_and_their_gaps() {
    for (name, allowed) in [
        ("car-rtk", &[][..]),
        ("quad-p4rtk-vibration", &[]),
        ("quad-ardupilot-5hz", &[FindingKind::Gap, FindingKind::Rejected, FindingKind::TimeOffset]),
        ("quad-hover-aided", &[FindingKind::Rejected, FindingKind::TimeOffset]),
    ] {
        let Some(dir) = shared(format!("datasets/{name}")) else { continue };
        let mut dataset = Dataset::open(&dir).unwrap();
        let config = dataset.settings().unwrap();
        let run = estimate(&dataset, &config, |_| {});
        for finding in hovernav_findings::findings(&dataset, &run)
            .iter()
            .filter(|finding| finding.is_warning())
        {
            assert!(allowed.contains(&finding.kind), "{name}: {}", finding.words);
        }
    }
}

#[test]
fn each_fault_ends_in_a_sentence_with_its_span_and_size() {
    for (fault, kind, expected) in [
        ("outage=20@100", FindingKind::Outage, "no fix for"),
        ("gap=2@100", FindingKind::Gap, "gap of 2."),
        ("gap=10@100", FindingKind::Unusable, "the inertial samples were missing"),
        ("packet-loss=25", FindingKind::SamplesLost, "% of the samples are missing"),
        ("stuck=all@100:2", FindingKind::Stuck, "all readings repeated"),
        ("stuck=gz@100:5", FindingKind::StuckAxis, "gyro z"),
        ("clip-accel=1.5", FindingKind::Clipping, "full scale of 14.7 m/s² (1.50 g)"),
        ("glitch-step=60@100:15", FindingKind::Rejected, "glitch"),
        ("frozen-fix@100", FindingKind::FrozenFix, "repeat the previous one"),
        ("no-velocity", FindingKind::VelocityAbsent, "velocity absent in 299 of 299 fixes"),
        ("height-held@100", FindingKind::HeightHeld, "height held at"),
        ("gps-time=0.15", FindingKind::TimeOffset, "latency_s = 0.1"),
        ("gyro-bias=0.5@100", FindingKind::BiasStep, "gyro bias of axis"),
    ] {
        let found = findings(&[fault]);
        let named = found.iter().find(|finding| finding.is_warning() && finding.kind == kind);
        let Some(finding) = named else { panic!("{fault}: {:?}", sentences(&found)) };
        assert!(finding.words.contains(expected), "{fault}: {}", finding.words);
        if fault.contains("@100") {
            // The one finding starts at 90 s, because its span starts with its window.
            let near = (88.0..102.5).contains(&finding.start_s) && finding.end_s < 165.0;
            assert!(near, "{fault}: {finding:?}");
        }
    }
}

#[test]
fn fixes_within_gaps_that_come_soon_after_each_other_are_no_fault_of_a_clock() {
    let found = findings(&["gap=2.5@100", "gap=2.5@104"]);
    let unusable: Vec<_> =
        found.iter().filter(|finding| finding.kind == FindingKind::Unusable).collect();
    assert!(!unusable.is_empty(), "{found:?}");
    for finding in unusable {
        assert!(finding.words.contains("the inertial samples were missing"), "{}", finding.words);
    }
}

/// The log has fixes with a vertical velocity but an empty height.
#[test]
fn a_height_that_is_empty_is_no_height_held_and_no_velocity_absent() {
    let found = findings(&["height-empty@100"]);
    assert_eq!(sentences(&found), [""; 0]);
    assert!(found.iter().any(|finding| finding.words.contains("gps without height from 99")
        || finding.words.contains("gps without height from 100")));
}

#[test]
fn fixes_that_are_off_by_more_than_the_filter_follows_are_found_by_when_the_vehicle_accelerates() {
    // The offset of each log as it is, s, and the offsets that are added.
    for (name, own_s, lates_s) in [
        ("heli-hover", 0.07, &[-1.0, 5.0, 18.0][..]),
        ("quad-p4rtk-vibration", -0.05, &[0.8, 1.5, -18.0]),
        ("uav-thor75-1hz", 0.08, &[0.8, -0.7, -5.0, 18.0]),
        ("car-rtk", 0.06, &[1.0, 5.0, -18.0]),
        ("quad-ardupilot-5hz", 0.27, &[-1.0, 18.0]),
        ("quad-gps-glitch", 0.21, &[1.0, 18.0]),
        ("quad-hover-aided", 0.2, &[-5.0, 18.0]),
    ] {
        let Some(dir) = shared(format!("datasets/{name}")) else { continue };
        for &late_s in lates_s {
            let mut dataset = Dataset::open(&dir).unwrap();
            for fix in &mut dataset.fixes {
                fix.time = fix.time.offset_by(late_s);
            }
            let config = dataset.settings().unwrap();
            let run = estimate(&dataset, &config, |_| {});
            let found = hovernav_findings::findings(&dataset, &run);
            let Some(told) = found.iter().find(|finding| finding.sensor == Sensor::Clocks) else {
                panic!("{name}, {late_s} s: {found:#?}")
            };
            assert_eq!(told.severity, Severity::Error, "{name}, {late_s} s: {}", told.words);
            assert_eq!(told.words.contains("have UTC"), f64::abs(late_s) == 18.0, "{}", told.words);
            let (_, latency) = told.words.split_once("latency_s = ").unwrap();
            let off_s = latency.parse::<f64>().unwrap() - late_s - own_s;
            assert!(off_s.abs() < 0.1, "{name}, {late_s} s: {}", told.words);
            let wrong = |finding: &&Finding| {
                finding.kind == FindingKind::SetUp && finding.sensor != Sensor::Clocks
            };
            assert_eq!(found.iter().find(wrong), None, "{name}, {late_s} s");
        }
    }
}

#[test]
fn a_clock_of_the_samples_that_does_not_run_at_the_rate_of_the_fixes_is_reported() {
    for (name, fast_percent) in [
        ("uav-thor75-1hz", 0.5),
        ("uav-thor75-1hz", -0.2),
        ("quad-ardupilot-5hz", -0.2),
        ("car-rtk", -0.2),
    ] {
        let Some(dir) = shared(format!("datasets/{name}")) else { continue };
        let mut dataset = Dataset::open(&dir).unwrap();
        let start = dataset.imu[0].time;
        for sample in &mut dataset.imu {
            let since_s = sample.time - start;
            sample.time = sample.time.offset_by(0.01 * fast_percent * since_s);
        }
        let config = dataset.settings().unwrap();
        let run = estimate(&dataset, &config, |_| {});
        let found = hovernav_findings::findings(&dataset, &run);
        let told = found.iter().find(|finding| finding.kind == FindingKind::ClockRate).unwrap();
        let (_, rate) = told.words.split_once("its clock runs ").unwrap();
        let (percent, side) = rate.split_once(" % ").unwrap();
        let off = percent.parse::<f64>().unwrap() - f64::abs(fast_percent);
        let side_is_right = side.starts_with(if fast_percent > 0.0 { "fast" } else { "slow" });
        assert!(off.abs() < 0.05 && side_is_right, "{name}, {fast_percent} %: {}", told.words);
        assert!(found.iter().all(|finding| finding.kind != FindingKind::TimeOffset), "{name}");
    }
}

#[test]
fn a_latency_beyond_what_the_filter_remembers_is_as_good_as_none_in_a_log() {
    let error_m = |late_s: f64| {
        let mut dataset = Dataset::open(log_dir()).unwrap();
        dataset.manifest.gps.latency_s = late_s;
        let config = dataset.settings().unwrap();
        let run = estimate(&dataset, &config, |_| {});
        assert!(run.fixes_compared.used > 280, "{late_s} s: {:?}", run.fixes_compared);
        let last = run.solutions.last().unwrap().position;
        let fix = dataset.fixes.last().unwrap().position;
        last.displacement_from(&fix).norm()
    };
    for late_s in [0.3, 0.45, 0.7, 3.0] {
        let (with_m, without_m) = (error_m(late_s), error_m(0.0));
        assert!((with_m - without_m).abs() < 0.5, "{late_s} s: {with_m} {without_m}");
    }
}

#[test]
fn a_receiver_that_states_a_third_of_what_it_scatters_by_is_named() {
    let mut dataset = Dataset::open(log_dir()).unwrap();
    for fix in &mut dataset.fixes {
        fix.position_sigma_m = Some(Vector::new(0.4, 0.4, 0.8));
    }
    let config = dataset.settings().unwrap();
    let run = estimate(&dataset, &config, |_| {});
    let found = hovernav_findings::findings(&dataset, &run);
    let named = found.iter().find(|finding| finding.kind == FindingKind::Understated);
    let Some(finding) = named else { panic!("{:?}", sentences(&found)) };
    assert!(finding.is_warning() && finding.words.contains("understates the one-sigmas of its"));
}

#[test]
fn what_happens_often_takes_no_hundred_lines() {
    let mut faults: Vec<String> = (0..40).map(|k| format!("gap=0.5@{}", 70 + 5 * k)).collect();
    faults.push("packet-loss=5".into());
    let faults: Vec<&str> = faults.iter().map(String::as_str).collect();
    let found = findings(&faults);
    assert!(found.iter().filter(|finding| finding.kind == FindingKind::Gap).count() >= 40);
    let told = sentences(&found);
    assert!(told.len() < 12, "{told:#?}");
    assert!(told.iter().any(|sentence| sentence.contains("more times")), "{told:#?}");
}

#[test]
fn findings_are_in_order_and_within_the_log() {
    let found = findings(&["outage=10", "gap=1", "mag-vector=0.3"]);
    assert!(found.windows(2).all(|pair| pair[0].start_s <= pair[1].start_s));
    for finding in &found {
        assert!(finding.start_s <= finding.end_s && finding.end_s <= 300.0, "{finding:?}");
        assert!(finding.severity < Severity::Error && !finding.words.is_empty());
    }
}
