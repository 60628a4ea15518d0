//! Real logs of other autopilots: read or rejected, and estimated without divergence.

use std::path::Path;

use hovernav::time::Time;
use hovernav_dataset::Dataset;
use hovernav_findings::check_fitness;
use hovernav_formats::{Format, Log, Options, open};
use hovernav_replay::estimate;
use hovernav_testing::shared;

fn read(name: &str) -> Option<Log> {
    shared(format!("logs/{name}")).map(|path| open(&path, &Options::default()).unwrap())
}

fn says(log: &Log, words: &str) -> bool {
    let Dataset { warnings, notes, .. } = &log.dataset;
    warnings.iter().chain(notes).any(|sentence| sentence.contains(words))
}

#[test]
fn each_log_has_the_expected_contents() {
    for (name, format, samples, fixes) in [
        ("px4-quad-vibration-2025.ulg", Format::Ulog, 15_843, 397),
        ("px4-quad-motor-failure.ulg", Format::Ulog, 341, 179),
        ("sample_log_small.ulg", Format::Ulog, 1_298, 32),
        ("sample_appended_multiple.ulg", Format::Ulog, 2_373, 0),
        ("sample_logging_tagged_and_default_params.ulg", Format::Ulog, 2_028, 44),
        ("ardupilot-bench.bin", Format::Dataflash, 8_878, 0),
        ("ardupilot-short.bin", Format::Dataflash, 45, 5),
    ] {
        let Some(log) = read(name) else { continue };
        assert_eq!(log.format, format, "{name}");
        assert_eq!(log.dataset.imu.len(), samples, "{name}");
        assert_eq!(log.dataset.fixes.len(), fixes, "{name}");
        assert!(log.onboard.is_some(), "{name}");
        let fitness =
            check_fitness(&log.dataset, Path::new(name)).map_err(|error| error.to_string());
        match name {
            "px4-quad-motor-failure.ulg" => {
                let error = fitness.unwrap_err();
                assert!(error.contains("samples a second, expected at least 18"), "{error}");
            }
            _ if fixes == 0 => assert!(fitness.is_err(), "{name}"),
            _ => assert_eq!(fitness, Ok(Vec::new()), "{name}"),
        }
    }
}

#[test]
fn warnings_describe_the_deficiencies_of_a_log() {
    if let Some(log) = read("px4-quad-vibration-2025.ulg") {
        assert!(says(&log, "accelerometers at full scale between 25.0"));
        assert!(says(&log, "vehicle_gps_position 0 (397 messages) is read"));
        let marked = log.dataset.imu.iter().filter(|sample| sample.clipped.accel[2]).count();
        assert_eq!(marked, 146);
        let date = log.dataset.manifest.date.and_then(|date| Some(date.date?.to_string()));
        assert_eq!(date.as_deref(), Some("2025-02-10"));
        assert_eq!(log.dataset.manifest.gps.latency_s, 0.11);
    }
    if let Some(log) = read("px4-quad-motor-failure.ulg") {
        assert!(says(&log, "integrate over 3 % of their interval"));
        let antenna_m = log.dataset.manifest.gps.antenna_lever_arm_m.to_array();
        assert!((antenna_m[1] - 0.046).abs() < 1e-6, "{antenna_m:?}");
    }
    if let Some(log) = read("ardupilot-short.bin") {
        assert!(says(&log, "heights are above mean sea level"));
        assert!(says(&log, "instantaneous values at 50 Hz"));
        assert!(says(&log, "at byte 65512: the file ends within a message"));
    }
}

#[test]
fn an_instance_is_read_by_its_number_or_rejected() {
    let Some(path) = shared("logs/ardupilot-short.bin") else { return };
    let mut options = Options::default();
    options.imu = Some(1);
    let second = open(&path, &options).unwrap();
    let first = open(&path, &Options::default()).unwrap();
    assert_eq!(second.dataset.imu.len(), first.dataset.imu.len());
    assert_ne!(second.dataset.imu[0].motion, first.dataset.imu[0].motion);
    options.imu = Some(7);
    let error = open(&path, &options).unwrap_err().to_string();
    assert!(error.contains("found no instance 7; the log has IMU 0 (45 messages)"), "{error}");
}

/// The log has heavy vibration: the accelerometers clip from 25 s on, and the vehicle rolls over at 68 s.
#[test]
fn clipping_and_a_roll_over_do_not_make_the_filter_diverge() {
    let Some(mut log) = read("px4-quad-vibration-2025.ulg") else { return };
    let config = log.dataset.settings().unwrap();
    let run = estimate(&log.dataset, &config, |_| {});
    assert!(run.solutions.len() > 15_000);
    let mut farthest_m: [f64; 2] = [0.0; 2];
    for fix in &log.dataset.fixes {
        let after = run.solutions.partition_point(|solution| solution.time < fix.time);
        let Some(solution) = run.solutions.get(after) else { continue };
        let [north, east, down] = solution.position.displacement_from(&fix.position).to_array();
        farthest_m = [farthest_m[0].max(north.hypot(east)), farthest_m[1].max(down.abs())];
    }
    println!("from the fixes at most {farthest_m:.1?} m");
    assert!(farthest_m[0] < 20.0 && farthest_m[1] < 10.0, "{farthest_m:?}");

    let onboard = log.onboard.as_mut().unwrap();
    onboard.moments.retain(|moment| moment.time < Time::ZERO + 60.0);
    let difference = onboard.difference(&run.solutions).unwrap().difference;
    let median = |axis: &str| difference[axis].median;
    let all = ["roll_deg", "pitch_deg", "yaw_deg", "vn_mps", "ve_mps", "vd_mps"].map(median);
    println!("difference to the estimator on board up to 60 s, medians: {all:.3?}");
    assert!(all[0] < 1.0 && all[1] < 1.0 && all[2] < 4.0, "{all:?}");
    assert!(all[3..].iter().all(|&median| median < 0.3), "{all:?}");
}
