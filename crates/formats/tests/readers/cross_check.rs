//! The readers return the same numbers as the reference readers in Python.
//!
//! The reference readers come from the Python package index. Without them, or without the logs, a test prints a
//! message and is skipped.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use hovernav::imu::Motion;
use hovernav_formats::{Log, Options};
use hovernav_testing::{python, shared};

const HERE: &str = env!("CARGO_MANIFEST_DIR");

/// The Python interpreter of an environment with the reference readers.
fn reference_readers() -> Option<PathBuf> {
    python(&["pyulog", "pymavlink"])
}

/// Samples of each kind: a time and numbers.
type Samples = BTreeMap<String, Vec<Vec<f64>>>;

/// The samples that the script `oracle` reads from `log`. Times are made increasing, as the readers do.
fn expected(python: &Path, oracle: &str, log: &Path) -> Samples {
    let script = Path::new(HERE).join("tests/oracles").join(oracle);
    let output = Command::new(python).arg(script).arg(log).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut samples = Samples::new();
    for line in String::from_utf8(output.stdout).unwrap().lines() {
        let mut words = line.split(' ');
        let kind = samples.entry(words.next().unwrap().to_owned()).or_default();
        let sample: Vec<f64> = words.map(|word| word.parse().unwrap()).collect();
        if kind.last().is_none_or(|last| sample[0] > last[0] + 1e-9) {
            kind.push(sample);
        }
    }
    samples
}

fn found(log: &Log) -> Samples {
    let mut samples = Samples::new();
    let mut put = |kind: &str, time: hovernav::time::Time, numbers: &[f64]| {
        let sample = [&[time.seconds()], numbers].concat();
        samples.entry(kind.to_owned()).or_default().push(sample);
    };
    let dataset = &log.dataset;
    let mut last = None;
    for sample in &dataset.imu {
        let interval_s = last.map_or(dataset.imu[1].time - sample.time, |last| sample.time - last);
        last = Some(sample.time);
        let (rate, force) = match sample.motion {
            Motion::Rates { angular_rate_radps, specific_force_mps2 } => {
                (angular_rate_radps, specific_force_mps2)
            }
            Motion::Increments { angle_rad, velocity_mps } => {
                (angle_rad * (1.0 / interval_s), velocity_mps * (1.0 / interval_s))
            }
        };
        put("imu", sample.time, &[rate.to_array(), force.to_array()].concat());
    }
    for fix in &dataset.fixes {
        let or_nan = |array: Option<[f64; 3]>| array.unwrap_or([f64::NAN; 3]);
        let horizontal = fix.horizontal_velocity_mps.unwrap_or([f64::NAN; 2]);
        let position_sigma = or_nan(fix.position_sigma_m.map(|sigma| sigma.to_array()));
        let velocity_sigma = or_nan(fix.velocity_sigma_mps.map(|sigma| sigma.to_array()));
        let numbers = [
            fix.position.latitude_deg(),
            fix.position.longitude_deg(),
            fix.position.height_m,
            horizontal[0],
            horizontal[1],
            fix.down_velocity_mps.unwrap_or(f64::NAN),
            position_sigma[0],
            position_sigma[2],
            velocity_sigma[0],
            fix.satellites.map_or(f64::NAN, f64::from),
        ];
        put("gps", fix.time, &numbers);
    }
    for (time, height_m) in &dataset.baro {
        put("baro", *time, &[*height_m]);
    }
    for (time, field) in &dataset.magnetometer {
        put("mag", *time, &field.to_array());
    }
    for (time, sticks) in &dataset.controls {
        put("controls", *time, sticks);
    }
    for moment in log.onboard.iter().flat_map(|onboard| &onboard.moments) {
        if let Some(attitude) = moment.body_to_ned {
            let [x, y, z, w] = attitude.quaternion().to_array();
            put("attitude", moment.time, &[w, x, y, z]);
            let angles = attitude.euler();
            put("euler", moment.time, &[angles.roll_rad, angles.pitch_rad, angles.yaw_rad]);
        }
        if let Some(velocity) = moment.velocity_mps {
            put("velocity", moment.time, &velocity.to_array());
        }
        if let Some(place) = moment.position {
            let numbers = [place.latitude_deg(), place.longitude_deg(), place.height_m];
            put("position", moment.time, &numbers);
        }
    }
    samples
}

/// Asserts that the readers found the expected samples of every kind.
fn compare(name: &str, expected: &Samples, found: &Samples) {
    let mut compared = 0;
    for (kind, expected) in expected {
        let found = found.get(kind).map_or(&[][..], |found| found);
        assert_eq!(found.len(), expected.len(), "{name}: samples of {kind}");
        for (found, expected) in found.iter().zip(expected) {
            assert_eq!(found.len(), expected.len(), "{name}: numbers of {kind}");
            for (place, (found, expected)) in found.iter().zip(expected).enumerate() {
                // Angles may differ by a full turn.
                let difference = if kind == "euler" && place > 0 {
                    hovernav::frames::wrap_angle(found - expected)
                } else {
                    found - expected
                };
                let is_same = (found.is_nan() && expected.is_nan())
                    || difference.abs() <= 1e-9 * expected.abs().max(1.0);
                assert!(is_same, "{name}: {kind} number {place}: {found}, expected {expected}");
                compared += 1;
            }
        }
    }
    println!("{name}: {compared} numbers compared");
    assert!(compared > 100, "{name}: next to nothing compared");
}

/// Compares the logs `names` with `oracle`, which reads the pilot's `sticks`.
fn check(oracle: &str, sticks: &str, names: &[&str]) {
    let Some(python) = reference_readers() else { return };
    for name in names {
        let Some(path) = shared(format!("logs/{name}")) else { continue };
        let mut options = Options::default();
        options.input = Some(sticks.to_owned());
        let log = hovernav_formats::open(&path, &options);
        let log = log.or_else(|_| hovernav_formats::open(&path, &Options::default())).unwrap();
        compare(name, &expected(&python, oracle, &path), &found(&log));
    }
}

#[test]
fn px4_logs_hold_what_pyulog_reads() {
    let names = [
        "px4-quad-vibration-2025.ulg",
        "px4-quad-motor-failure.ulg",
        "sample_log_small.ulg",
        "sample_appended_multiple.ulg",
        "sample_logging_tagged_and_default_params.ulg",
    ];
    check("ulog.py", "manual_control_setpoint", &names);
}

#[test]
fn dataflash_logs_hold_what_pymavlink_reads() {
    check("dataflash.py", "RCIN", &["ardupilot-bench.bin", "ardupilot-short.bin"]);
}

#[test]
fn a_text_dataflash_log_equals_its_binary_original() {
    let Some(path) = shared("logs/ardupilot-short.bin") else { return };
    let Some(python) = reference_readers() else { return };
    let script = "import sys\nfrom pymavlink import DFReader\nlog = DFReader.DFReader_binary(sys.argv[1])\n\
                  rows = []\nnames = {}\n\
                  while True:\n    m = log.recv_msg()\n    if m is None: break\n    \
                  if m.get_type() == 'FMT':\n        names[m.Name] = m\n    \
                  rows.append((m.get_type(), [str(getattr(m, f)) for f in m.get_fieldnames()]))\n\
                  rows.sort(key=lambda row: row[0] != 'FMT')\n\
                  print('\\n'.join(', '.join([kind] + fields) for kind, fields in rows))";
    let output = Command::new(python).args(["-c", script]).arg(&path).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = tempfile::Builder::new().suffix(".log").tempfile().unwrap();
    fs::write(text.path(), output.stdout).unwrap();
    let in_text = hovernav_formats::open(text.path(), &Options::default()).unwrap();
    let in_bytes = hovernav_formats::open(&path, &Options::default()).unwrap();
    compare("ardupilot-short as text", &found(&in_bytes), &found(&in_text));
}

#[test]
fn a_telemetry_log_holds_what_pymavlink_wrote() {
    let Some(python) = reference_readers() else { return };
    let log = tempfile::Builder::new().suffix(".tlog").tempfile().unwrap();
    let expected = expected(&python, "tlog.py", log.path());
    let read = hovernav_formats::open(log.path(), &Options::default()).unwrap();
    compare("telemetry", &expected, &found(&read));
    assert!(
        read.dataset.notes.iter().any(|note| note.contains("SCALED_IMU2 (1000 messages)")),
        "{:?}",
        read.dataset.warnings
    );
    assert!(!read.dataset.warnings.iter().any(|warning| warning.starts_with("at byte")));
}
