//! Reading of a dataset directory: valid data is used as intended, faults are reported.

use std::path::{Path, PathBuf};

use approx::assert_abs_diff_eq;
use hovernav::imu::Motion;
use hovernav::time::Time;
use hovernav_dataset::{Dataset, HeadingReference, LogError, Manifest, Point};
use hovernav_testing::shared;
use tempfile::TempDir;

const IMU_HEADER: &str =
    "t_s,gyro_x_radps,gyro_y_radps,gyro_z_radps,accel_x_mps2,accel_y_mps2,accel_z_mps2";

fn directory(files: &[(&str, &str)]) -> TempDir {
    let dir = tempfile::tempdir().unwrap();
    for (file, text) in files {
        std::fs::write(dir.path().join(file), text).unwrap();
    }
    dir
}

fn open(files: &[(&str, &str)]) -> Result<Dataset, LogError> {
    Dataset::open(directory(files).path())
}

/// `imu.csv` of samples at rest at these times.
fn imu_at(times: &[&str]) -> String {
    let rows = times.iter().enumerate().map(|(index, t)| format!("{t},0.{index}1,0,0,0,0,-9.81\n"));
    format!("{IMU_HEADER}\n{}", rows.collect::<String>())
}

/// `imu.csv` at 100 Hz for `seconds`, and its times.
fn steady_times(from_s: u32, seconds: u32) -> Vec<String> {
    (0..seconds * 100).map(|i| format!("{}.{:02}", from_s + i / 100, i % 100)).collect()
}

fn imu_from(times: &[String]) -> String {
    imu_at(&times.iter().map(String::as_str).collect::<Vec<_>>())
}

fn nanoseconds(dataset: &Dataset) -> Vec<i64> {
    dataset.imu.iter().map(|sample| sample.time.nanoseconds()).collect()
}

fn heli_hover() -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/heli-hover")).to_path_buf()
}

#[test]
fn the_hover_flight_is_read_whole_and_without_complaint() {
    let dataset = Dataset::open(&heli_hover()).unwrap();
    assert_eq!(dataset.warnings, [""; 0]);
    assert_eq!((dataset.imu.len(), dataset.fixes.len(), dataset.controls.len()), (9899, 299, 9899));
    let first = dataset.imu[0];
    assert_eq!(first.time, Time::from_nanoseconds(50_000_000));
    let Motion::Rates { angular_rate_radps, specific_force_mps2 } = first.motion else { panic!() };
    assert_eq!(angular_rate_radps.to_array(), [0.0170975, 0.0047937, -0.0284426]);
    assert_eq!(specific_force_mps2.to_array(), [-0.703895, 0.034117, -11.906963]);
    assert_abs_diff_eq!(first.attitude.unwrap().to_degrees()[2], 61.113, epsilon = 1e-12);
    assert_eq!(first.magnetic_field_gauss.unwrap().to_array(), [0.18499, -0.35479, -0.09445]);
    let fix = dataset.fixes[0];
    assert_eq!(fix.position_sigma_m.unwrap().to_array(), [1.7, 1.7, 3.1]);
    assert_eq!(fix.velocity_sigma_mps.unwrap().to_array(), [0.11, 0.11, 0.27]);
    assert_eq!(fix.velocity_mps().unwrap().to_array(), [0.2963, 0.0851, 0.1840]);
    let manifest = dataset.manifest;
    assert_eq!(manifest.lever_arm_m(Point::Imu).to_array(), [0.03, -0.02, 0.28]);
    assert_eq!(manifest.lever_arm_m(Point::Antenna).to_array(), [-0.35, 0.0, 0.2]);
    assert_eq!(manifest.imu.heading_reference, HeadingReference::True);
    assert_eq!(manifest.imu.magnetic_declination_deg, Some(0.42));
    assert_eq!(manifest.reference.point, Point::Cg);
}

#[test]
fn tables_of_other_editors_are_read_alike() {
    let plain = format!("{IMU_HEADER}\n0.5,1,2,3,4,5,6\n0.6,1,2,3,4,5,7\n");
    let dressed = format!(
        "\u{feff}\"t_s\", {},\r\n\r\n 0.5 ,1.0,\"2\",3,+4,5e0,6,\r\n0.600,1,2,3,4,5,7,,\r\n\r\n",
        &IMU_HEADER[4..]
    );
    let [plain, dressed] = [plain, dressed].map(|imu| open(&[("imu.csv", &imu)]).unwrap());
    assert_eq!(plain.imu.len(), 2);
    assert_eq!(plain.imu, dressed.imu);
    assert_eq!(plain.warnings, dressed.warnings);
}

#[test]
fn increments_are_distinguished_from_rates_by_the_header() {
    let imu = "dvel_z_mps,dvel_y_mps,dvel_x_mps,dtheta_x_rad,dtheta_y_rad,dtheta_z_rad,t_s\n\
               -0.0981,2,1,0.1,0.2,0.3,1\n";
    let dataset = open(&[("imu.csv", imu)]).unwrap();
    let Motion::Increments { angle_rad, velocity_mps } = dataset.imu[0].motion else { panic!() };
    assert_eq!(angle_rad.to_array(), [0.1, 0.2, 0.3]);
    assert_eq!(velocity_mps.to_array(), [1.0, 2.0, -0.0981]);
}

#[test]
fn a_missing_manifest_gps_or_unknown_column_is_said_once() {
    let imu = format!("{IMU_HEADER},colour\n1,0,0,0,0,0,-9.81,red\n");
    let dataset = open(&[("imu.csv", &imu)]).unwrap();
    assert_eq!(
        dataset.warnings,
        [
            "dataset.toml: no such file, so defaults for every key",
            "imu.csv: columns without use: colour",
            "gps.csv: no such file, so no GPS"
        ]
    );
    assert_eq!(
        dataset.manifest,
        Manifest { name: dataset.manifest.name.clone(), ..Manifest::default() }
    );
}

#[test]
fn a_notch_that_cannot_be_is_refused_with_its_range() {
    let imu = format!("{IMU_HEADER}\n1,0,0,0,0,0,-9.81\n");
    for (setting, expected) in [
        ("harmonics = 9", "harmonics: found 9, expected 1 to 4"),
        ("width_hz = 0.0", "width_hz: found 0, expected more than 0, less than 10000 Hz"),
        ("frequency_hz = -3.0", "frequency_hz: found -3, expected 0 to less than 10000 Hz"),
    ] {
        let manifest = format!("[imu.notch]\n{setting}\n");
        let files = [("imu.csv", imu.as_str()), ("dataset.toml", manifest.as_str())];
        let error = open(&files).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn text_where_a_number_should_be_is_refused_with_its_place() {
    let imu = format!("{IMU_HEADER}\n0.5,1,2,3,4,5,6\n\n0.6,1,2,abc,4,5,7\n");
    let error = open(&[("imu.csv", &imu)]).unwrap_err().to_string();
    assert!(
        error.ends_with("imu.csv:4: column gyro_z_radps: found \"abc\", expected a number"),
        "{error}"
    );
    let imu = format!("\r\n{IMU_HEADER}\r\n0.5,1,2,3,4,5,6\r\n0.6,1,2,\"a\nb\",4,5,7\r\n");
    let error = open(&[("imu.csv", &imu)]).unwrap_err().to_string();
    assert!(error.contains("imu.csv:4: column gyro_z_radps: found \"a\\nb\""), "{error}");
    let imu = format!("{IMU_HEADER}\n12:30:05,1,2,3,4,5,6\n");
    let error = open(&[("imu.csv", &imu)]).unwrap_err().to_string();
    assert!(
        error.ends_with("imu.csv:2: column t_s: found \"12:30:05\", expected a time in seconds"),
        "{error}"
    );
}

#[test]
fn a_header_that_cannot_serve_is_refused_with_what_was_found() {
    for (imu, expected) in [
        ("t_s,gyro_x_radps\n1,2\n", "imu.csv:1: expected column gyro_x_radps,gyro_y_radps,"),
        ("time,gyro_x_radps\n1,2\n", "imu.csv:1: expected column t_s, found time,gyro_x_radps"),
        ("t_s,t_s\n1,2\n", "imu.csv:1: expected column t_s once, found t_s,t_s"),
        ("0,0,0\n1,2,3\n", "imu.csv:1: expected a header row of column names, found 0,0,0"),
        ("", "imu.csv: the file is empty, expected a header row"),
        ("\n\n", "imu.csv: the file is empty, expected a header row"),
        (IMU_HEADER, "imu.csv: no rows below the header"),
    ] {
        let error = open(&[("imu.csv", imu)]).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    let error = open(&[]).unwrap_err().to_string();
    assert!(error.ends_with("imu.csv: no such file, and a dataset needs it"), "{error}");
    let gps = "t_s,lat_deg,height_m\n";
    let error = open(&[("imu.csv", &imu_at(&["1"])), ("gps.csv", gps)]).unwrap_err().to_string();
    assert!(
        error.ends_with("gps.csv:1: expected column lon_deg, found t_s,lat_deg,height_m"),
        "{error}"
    );
}

#[test]
fn inertial_rows_that_cannot_be_true_are_rejected_and_counted() {
    let imu = format!(
        "{IMU_HEADER}\n0,0,0,0,0,0,0\n1,0,0,0,0,0,-9.81\n2,,0,0,0,0,-9.81\n3,0,0,nan,0,0,-9.81\n\
         4,inf,0,0,0,0,-9.81\n5,0,0,0,0,0,1e300\n6,0,0,101,0,0,-9.81\n,0,0,0,0,0,-9.81\n\
         8,0,0\n9,0,0,0,0,0,-9.81,7\n10,0,0,0,0,0,-9.8"
    );
    let dataset =
        open(&[("imu.csv", &imu), ("gps.csv", "t_s,lat_deg,lon_deg,height_m\n")]).unwrap();
    assert_eq!(nanoseconds(&dataset), [1_000_000_000, 10_000_000_000]);
    assert_eq!(
        dataset.warnings[1..],
        [
            "imu.csv: line 2 rejected: all zeros, the inertial unit was not measuring",
            "imu.csv: 2 rows, the first at line 4, skipped: a value is missing",
            "imu.csv: 3 rows, the first at line 6, rejected: a value is beyond any vehicle's motion",
            "imu.csv: line 9 skipped: no time",
            "imu.csv: line 10 skipped: fewer fields than the header",
            "imu.csv: line 11 skipped: more fields than the header",
            "gps.csv: found no usable fix",
        ]
    );
}

#[test]
fn a_row_cut_off_by_a_power_failure_is_skipped() {
    for cut in ["0.7,1,2,3,4", "0.7,1,2,3,4,5,-", "0.7,1,2,3,4,5,7e", "\0\0\0\0"] {
        let imu = format!("{IMU_HEADER}\n0.5,1,2,3,4,5,6\n{cut}");
        let dataset = open(&[("imu.csv", &imu)]).unwrap();
        assert_eq!(dataset.imu.len(), 1, "{cut}");
        assert!(dataset.warnings.iter().any(|warning| warning.contains("line 3 skipped")));
    }
}

#[test]
fn one_absurd_time_costs_one_row() {
    for (times, kept) in [
        (["0.0", "0.1", "9e8", "0.3", "0.4"], [0, 1, 3, 4]),
        (["0.0", "0.1", "-5", "0.3", "0.4"], [0, 1, 3, 4]),
        (["0.0", "0.1", "0.1", "0.3", "0.4"], [0, 1, 3, 4]),
        (["0.0", "0.1", "0.2", "0.3", "9e8"], [0, 1, 2, 3]),
        (["-9e8", "0.1", "0.2", "0.3", "0.4"], [1, 2, 3, 4]),
    ] {
        let dataset = open(&[("imu.csv", &imu_at(&times))]).unwrap();
        let expected = kept.map(|index: usize| Time::from_seconds(times[index].parse().unwrap()));
        let found: Vec<Time> = dataset.imu.iter().map(|sample| sample.time).collect();
        assert_eq!(found, expected, "{times:?}");
        assert!(dataset.warnings[1].starts_with("imu.csv: line "), "{:?}", dataset.warnings);
    }
}

#[test]
fn a_clock_that_steps_back_once_loses_no_row_and_is_a_break() {
    let times = [steady_times(0, 60), steady_times(58, 60)].concat();
    let dataset = open(&[("imu.csv", &imu_from(&times))]).unwrap();
    assert_eq!(dataset.imu.len(), 12_000);
    let step = "imu.csv: line 6002: the clock goes back by 1.990 s";
    assert!(dataset.warnings[1].starts_with(step), "{:?}", dataset.warnings);
    assert_abs_diff_eq!(dataset.imu[6000].time - dataset.imu[5999].time, 5.0, epsilon = 1e-9);
}

#[test]
fn two_recordings_in_one_file_are_refused_where_the_second_begins() {
    let times = [steady_times(0, 60), steady_times(0, 60)].concat();
    let error = open(&[("imu.csv", &imu_from(&times))]).unwrap_err();
    assert!(matches!(error, LogError::Clock { line: 6002, rows: 12_000, .. }), "{error}");
}

#[test]
fn every_row_written_twice_is_read_once() {
    let times = imu_from(&steady_times(0, 2));
    let (header, rows) = times.split_once('\n').unwrap();
    let twice: String = rows.lines().map(|row| format!("{row}\n{row}\n")).collect();
    let dataset = open(&[("imu.csv", &format!("{header}\n{twice}"))]).unwrap();
    assert_eq!(dataset.imu.len(), 200);
    assert!(
        dataset.warnings[1]
            .contains("200 rows, the first at line 3, skipped: same time as the row before")
    );
}

#[test]
fn rows_of_one_time_are_put_together() {
    let times: Vec<String> = steady_times(0, 2).into_iter().flat_map(|t| [t.clone(), t]).collect();
    let dataset = open(&[("imu.csv", &imu_from(&times))]).unwrap();
    assert_eq!(dataset.imu.len(), 200);
    let Motion::Rates { angular_rate_radps, .. } = dataset.imu[3].motion else { panic!() };
    // Rows 6 and 7: 0.61 and 0.71 rad/s.
    assert_abs_diff_eq!(angular_rate_radps.x(), 0.66, epsilon = 1e-12);
    let said = "200 rows, the first at line 3, merged with the row before, at the same time";
    assert!(dataset.warnings[1].contains(said), "{:?}", dataset.warnings);
}

#[test]
fn gaps_and_stuck_sensors_keep_their_samples_and_are_said() {
    let mut times = steady_times(0, 2);
    times.drain(100..150);
    let mut imu = imu_from(&times);
    for index in 0..30 {
        imu.push_str(&format!("2.{index:02},0.7,0,0,0,0,-9.81\n"));
    }
    let dataset = open(&[("imu.csv", &imu)]).unwrap();
    assert_eq!(dataset.imu.len(), 180);
    assert_eq!(
        dataset.warnings[1..3],
        [
            "imu.csv: gap of 0.510 s after 0.990000 s",
            "imu.csv: stuck: 30 rows from line 152 on repeat to the last bit, 0.29 s from 2.000000 s on"
        ]
    );
}

#[test]
fn fixes_nowhere_on_earth_are_skipped_and_unknown_sigmas_stay_unknown() {
    let gps = "t_s,lat_deg,lon_deg,height_m,vn_mps,ve_mps,vd_mps,sigma_h_m,sigma_v_m,fix_type,satellites\n\
               1,45,-93,250,1,2,3,1.5,2.5,3,9\n\
               2,99,-93,250,1,2,3,1.5,2.5,3,9\n\
               3,nan,-93,250,1,2,3,1.5,2.5,3,9\n\
               4,0,0,0,0,0,0,1.5,2.5,3,9\n\
               5,45,-93,250,1,2,3,1.5,2.5,0,9\n\
               6,45,-93,250,1,2,,0,2.5,,\n\
               7,45,-93,250,1e9,2,3,1.5,,3,9\n";
    let dataset = open(&[("imu.csv", &imu_at(&["1"])), ("gps.csv", gps)]).unwrap();
    let seconds: Vec<f64> = dataset.fixes.iter().map(|fix| fix.time.seconds()).collect();
    assert_eq!(seconds, [1.0, 6.0, 7.0]);
    let [first, second, third] = dataset.fixes[..] else { panic!() };
    assert_eq!(first.position_sigma_m.unwrap().to_array(), [1.5, 1.5, 2.5]);
    assert_eq!((first.velocity_sigma_mps, first.satellites), (None, Some(9)));
    assert_eq!(second.position_sigma_m, None);
    assert_eq!(
        (second.horizontal_velocity_mps, second.down_velocity_mps),
        (Some([1.0, 2.0]), None)
    );
    assert_eq!(third.horizontal_velocity_mps, None);
    assert_eq!(
        dataset.warnings[1..],
        [
            "gps.csv: line 3 rejected: not a position on Earth, the latitude is beyond 90° (expected degrees, \
             not 1e-7 degrees)",
            "gps.csv: line 4 skipped: a coordinate is missing",
            "gps.csv: line 5 skipped: no fix, latitude and longitude are 0",
            "gps.csv: line 6 skipped: no fix",
            "gps.csv: line 7 with an invalid sigma: sigma ignored",
            "gps.csv: line 8 with a velocity beyond any vehicle's: velocity ignored",
        ]
    );
}

#[test]
fn a_fix_without_height_or_of_two_dimensions_reports_the_horizontal_alone() {
    let gps = "t_s,lat_deg,lon_deg,height_m,fix_type\n\
               1,45,-93,250,3\n\
               2,45,-93,,3\n\
               3,45,-93,250,2\n";
    let dataset = open(&[("imu.csv", &imu_at(&["1"])), ("gps.csv", gps)]).unwrap();
    let flat: Vec<bool> = dataset.fixes.iter().map(|fix| fix.two_dimensional).collect();
    assert_eq!(flat, [false, true, true]);
    assert_eq!(dataset.fixes[1].position.height_m, 250.0);
    assert_eq!(
        dataset.warnings[1..],
        [
            "gps.csv: line 3 without a measured height: used for the horizontal position only",
            "gps.csv: fixes of type 2, 1 of them: two-dimensional, used for the horizontal alone",
        ]
    );
    let typed = |gps: &str| open(&[("imu.csv", &imu_at(&["1"])), ("gps.csv", gps)]).unwrap().fixes;
    // A table with type 1 and without type 3 contains qualities, so that 2 is not a dimension.
    assert!(!typed(&gps.replace(",3\n", ",1\n"))[2].two_dimensional);
    // If the table also contains type 3, type 1 means no fix.
    assert_eq!(typed(&gps.replace("250,3", "250,1")).len(), 2);
}

#[test]
fn fixes_before_the_first_height_are_at_that_and_without_any_at_nought() {
    let gps = "t_s,lat_deg,lon_deg,height_m\n1,45,-93,\n2,45,-93,\n3,45,-93,250\n4,45,-93,\n";
    let read = |gps: &str| open(&[("imu.csv", &imu_at(&["1"])), ("gps.csv", gps)]).unwrap();
    let of = |gps: &str| {
        let heights = read(gps).fixes.into_iter();
        heights.map(|fix| (fix.position.height_m, fix.two_dimensional)).collect::<Vec<_>>()
    };
    assert_eq!(of(gps), [(250.0, true), (250.0, true), (250.0, false), (250.0, true)]);
    let without = gps.replace("250", "");
    assert_eq!(of(&without), [(0.0, true); 4]);
    let said = "gps.csv: no fix has a height: 0 m is assumed, and the height is unknown";
    assert!(read(&without).warnings.iter().any(|warning| warning == said));
}

#[test]
fn a_fix_is_valid_its_latency_before_it_arrives() {
    let dir = directory(&[
        ("dataset.toml", "[gps]\nlatency_s = 0.25\n"),
        ("config.toml", "[gps]\nlatency_s = 0.1\n"),
        ("imu.csv", &imu_at(&["1"])),
        ("gps.csv", "t_s,lat_deg,lon_deg,height_m\n1.5,45,-93,250\n"),
    ]);
    let mut dataset = Dataset::open(dir.path()).unwrap();
    assert_eq!(dataset.fixes[0].time, Time::from_nanoseconds(1_250_000_000));
    dataset.configure(&dir.path().join("config.toml")).unwrap();
    assert_eq!(dataset.fixes[0].time, Time::from_nanoseconds(1_400_000_000));
}

#[test]
fn what_lies_next_to_samples_is_read_and_its_odd_rows_skipped() {
    let dataset = open(&[
        ("imu.csv", &imu_at(&["1"])),
        ("baro.csv", "t_s,pressure_pa,temp_degc\n1,101325,15\n2,89874.6,9\n3,-1,9\n4,,\n"),
        ("mag.csv", "t_s,mag_x_gauss,mag_y_gauss,mag_z_gauss\n1,0.2,0,0.4\n2,0.2,999,0.4\n"),
        ("controls.csv", "t_s,lateral,longitudinal,collective,pedal\n1,0.1,-0.2,0.3,-1\n"),
    ])
    .unwrap();
    assert_eq!(dataset.baro.len(), 2);
    assert_abs_diff_eq!(dataset.baro[0].1, 0.0, epsilon = 1e-9);
    assert_abs_diff_eq!(dataset.baro[1].1, 1000.0, epsilon = 0.1);
    assert_eq!(dataset.magnetometer[0].1.to_array(), [0.2, 0.0, 0.4]);
    assert_eq!(dataset.controls[0].1, [0.1, -0.2, 0.3, -1.0]);
    assert_eq!(
        dataset.warnings[2..],
        [
            "baro.csv: line 4 rejected: a value is out of range",
            "baro.csv: line 5 skipped: a value is missing",
            "mag.csv: line 3 magnetic field rejected: over 100 gauss, as the Earth's field in \
             milligauss is; divide by 1000",
        ]
    );
}

#[test]
fn a_magnetic_field_next_to_the_inertial_samples_is_not_skipped_without_a_word() {
    let samples = "1,0.01,0,0,0,0,-9.81,21000,1000,43000\n2,0.02,0,0,0,0,-9.81,21000,1000,43000\n";
    let imu = format!("{IMU_HEADER},mag_x_gauss,mag_y_gauss,mag_z_gauss\n{samples}");
    let dataset = open(&[("imu.csv", &imu)]).unwrap();
    assert_eq!(dataset.imu.len(), 2);
    assert!(dataset.imu.iter().all(|sample| sample.magnetic_field_gauss.is_none()));
    let told = "imu.csv: 2 rows, the first at line 2, magnetic field rejected: over 100 gauss, as the \
                Earth's field in nT is; divide by 100 000";
    assert!(dataset.warnings.iter().any(|warning| warning == told), "{:?}", dataset.warnings);
}

#[test]
fn sticks_in_percent_are_read_with_a_warning_of_the_unit_that_is_expected() {
    let rows: String = (1..40).map(|t| format!("{t},12,-7,{t},0\n")).collect();
    let controls = format!("t_s,lateral,longitudinal,collective,pedal\n{rows}");
    let dataset = open(&[("imu.csv", &imu_at(&["1"])), ("controls.csv", &controls)]).unwrap();
    assert_eq!((dataset.controls.len(), dataset.controls[38].1), (39, [12.0, -7.0, 39.0, 0.0]));
    let told = "sticks up to 39 in 39 of 39 rows, expected fractions";
    assert!(dataset.warnings.iter().any(|one| one.contains(told)), "{:?}", dataset.warnings);
}

#[test]
fn every_shared_dataset_is_read() {
    for (name, samples, fixes, warnings) in [
        ("car-rtk", 54_858, 2197, 0),
        ("quad-ardupilot-5hz", 32_936, 3341, 1),
        ("quad-gps-glitch", 6321, 853, 0),
        ("quad-p4rtk-vibration", 22_902, 952, 0),
        ("uav-thor75-1hz", 34_811, 637, 1),
    ] {
        let Some(dir) = shared(format!("datasets/{name}")) else { continue };
        let dataset = Dataset::open(&dir).unwrap();
        assert_eq!(
            (dataset.imu.len(), dataset.fixes.len(), dataset.warnings.len()),
            (samples, fixes, warnings),
            "{name}: {:?}",
            dataset.warnings
        );
    }
}
