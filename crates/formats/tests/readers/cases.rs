//! Input files from users that are difficult to read correctly.

use std::path::PathBuf;

use hovernav_dataset::Dataset;
use hovernav_findings::check_setup;
use hovernav_formats::{Log, Options, Proposal, open};
use hovernav_testing::shared;

fn case(name: &str) -> Option<PathBuf> {
    shared(PathBuf::from("cases").join(name))
}

fn read(name: &str) -> Option<Log> {
    Some(open(&case(name)?, &Options::default()).unwrap_or_else(|error| panic!("{name}: {error}")))
}

fn refusal(name: &str) -> Option<String> {
    Some(open(&case(name)?, &Options::default()).err().map(|error| error.to_string()).unwrap())
}

/// The report of `init` on these files, and the dataset from its mapping.
fn mapped(names: &[&str]) -> Option<(String, Dataset)> {
    let paths: Option<Vec<PathBuf>> = names.iter().map(|name| case(name)).collect();
    let folder = tempfile::tempdir().unwrap();
    let proposal = Proposal::of(&paths?).unwrap_or_else(|error| panic!("{names:?}: {error}"));
    proposal.write(folder.path(), true).unwrap();
    let dataset = open(folder.path(), &Options::default()).unwrap().dataset;
    Some((proposal.to_string(), dataset))
}

fn has(sentences: &[String], words: &str) -> bool {
    sentences.iter().any(|sentence| sentence.contains(words))
}

#[test]
fn fixes_at_zero_are_rejected() {
    for name in ["null-island.ulg", "null-island.bin"] {
        let Some(Log { dataset, .. }) = read(name) else { return };
        assert!(has(&dataset.warnings, "14 rows"), "{name}: {:?}", dataset.warnings);
        assert!(dataset.fixes.iter().all(|fix| fix.position.latitude_deg() > 1.0), "{name}");
    }
}

#[test]
fn a_clock_that_steps_back_is_a_break() {
    let Some(Log { dataset, .. }) = read("clock-step-back-60s.ulg") else { return };
    assert!(has(&dataset.warnings, "the clock goes back by 59.970 s"), "{:?}", dataset.warnings);
    assert_eq!(dataset.imu.len(), 9899);
    assert!(dataset.fixes.len() >= 297, "{}", dataset.fixes.len());
}

#[test]
fn a_good_second_sensor_replaces_a_bad_first_one() {
    let Some(Log { dataset, .. }) = read("gps-0-no-fix-gps-1-good.bin") else { return };
    assert!(dataset.fixes.len() > 290 && has(&dataset.notes, "GPS 1"), "{:?}", dataset.notes);
    let Some(Log { dataset, .. }) = read("imu-0-marked-unhealthy.bin") else { return };
    assert!(has(&dataset.notes, "IMU 1 (9899 messages) is read"), "{:?}", dataset.notes);
    assert!(has(&dataset.notes, "--imu selects another"), "{:?}", dataset.notes);
}

#[test]
fn of_a_shared_line_the_richer_protocol_is_read_and_nothing_is_damaged() {
    let Some(Log { dataset, .. }) = read("ubx-and-nmea-mixed.log") else { return };
    assert_eq!(dataset.fixes.len(), 120);
    assert!(dataset.fixes.iter().all(|fix| fix.velocity_sigma_mps.is_some()));
    for protocol in ["UBX", "NMEA 0183"] {
        let note = dataset.notes.iter().find(|note| note.contains(protocol)).unwrap();
        assert!(note.contains(" 0 damaged"), "{note}");
    }
    let Some(Log { dataset, .. }) = read("gns-no-fix-counted-damaged.nmea") else { return };
    assert!(has(&dataset.notes, " 0 damaged"), "{:?}", dataset.notes);
    let Some(refusal) = refusal("ubx-raw-measurements-only.ubx") else { return };
    assert!(refusal.contains("UBX with raw measurements only"), "{refusal}");
}

#[test]
fn names_in_the_wild_are_understood() {
    for (names, samples, fixes) in [
        (&["rostopic-echo-p-imu.csv", "rostopic-echo-p-fix.csv"][..], 1979, 60),
        (&["vn310-imu.csv", "vn310-gnss.csv"], 999, 109),
        (&["kitti-oxts-with-time.txt"], 4917, 149),
        (&["sensor-logger-phone"], 1979, 60),
        (&["phyphox"], 1999, 301),
        (&["local_time.csv"], 1999, 0),
        (&["own-export.pos"], 0, 2739),
        (&["micros-wrap-2pow32.csv"], 1979, 59),
        (&["sentinel-9999.csv"], 1979, 54),
        (&["mtk-logger-units-in-cells.csv"], 0, 59),
        (
            &["imu-csv-and-receiver-capture/imu.csv", "imu-csv-and-receiver-capture/gps.nmea"],
            1999,
            60,
        ),
    ] {
        let Some((report, dataset)) = mapped(names) else { return };
        let found = (dataset.imu.len(), dataset.fixes.len());
        assert_eq!(found, (samples, fixes), "{names:?}: {report}");
        if let ([first, ..], [fix, ..]) = (&dataset.imu[..], &dataset.fixes[..]) {
            assert!((fix.time - first.time).abs() < 10.0, "{names:?}: {report}");
        }
    }
    let Some((report, _)) = mapped(&["local_time.csv"]) else { return };
    assert!(report.contains("local_time is local and names no zone"), "{report}");
}

#[test]
fn the_axes_of_kitti_are_those_of_its_description() {
    let Some((report, _)) = mapped(&["kitti-oxts-with-time.txt"]) else { return };
    assert!(report.contains("gyro      19 20 21"), "{report}");
    assert!(report.contains("accel     13 14 15"), "{report}");
}

#[test]
fn bags_without_a_height_and_in_parts_are_read() {
    let Some(Log { dataset, .. }) = read("altitude-nan.mcap") else { return };
    assert_eq!(dataset.fixes.len(), 59);
    assert!(dataset.fixes.iter().all(|fix| fix.two_dimensional));
    let Some(Log { dataset, .. }) = read("rosbag2-split") else { return };
    let length_s = dataset.imu[dataset.imu.len() - 1].time - dataset.imu[0].time;
    assert!((length_s - 79.9).abs() < 0.2, "{length_s}");
}

#[test]
fn the_gps_week_of_a_log_dates_its_exports() {
    let Some(Log { dataset, .. }) = read("gps-week-in-log-but-exports-1970.bin") else { return };
    let date = dataset.manifest.date.map(|date| date.to_string()).unwrap_or_default();
    assert!(date.starts_with("2024-05-05T"), "{date}");
}

#[test]
fn decimal_commas_are_read_and_named() {
    let Some(Log { dataset, .. }) = read("dataflash-decimal-comma.log") else { return };
    assert!(has(&dataset.warnings, "decimal commas"), "{:?}", dataset.warnings);
    assert_eq!((dataset.imu.len(), dataset.fixes.len()), (1979, 59));
    assert!((dataset.fixes[0].position.latitude_deg() - 1.352_098).abs() < 1e-6);
}

#[test]
fn rounded_times_and_velocities_of_zero_are_found_by_the_check_of_the_setup() {
    for (name, words) in
        [("epoch-in-float32", "single precision"), ("velocity-all-zero", "exactly 0")]
    {
        let Some(Log { dataset, .. }) = read(name) else { return };
        let found: Vec<String> = check_setup(&dataset).iter().map(ToString::to_string).collect();
        assert!(has(&found, words), "{name}: {found:?}");
    }
}

#[test]
fn fixes_at_a_pole_are_rejected_with_the_limit() {
    for name in ["pole-89.9", "pole-89.99"] {
        let Some(Log { dataset, .. }) = read(name) else { return };
        assert!(dataset.fixes.is_empty(), "{name}");
        assert!(
            has(&dataset.warnings, "latitude limit of 89.8°"),
            "{name}: {:?}",
            dataset.warnings
        );
    }
}
