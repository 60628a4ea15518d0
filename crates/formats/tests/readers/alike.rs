//! The same flight written in every format, with the same faults: each reader gives the same samples and fixes.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use hovernav_dataset::Dataset;
use hovernav_findings::check_setup;
use hovernav_formats::{Options, Proposal, open};
use tempfile::TempDir;

use crate::mavlink::frame;

/// A fix as the log states it.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    pub time_s: f64,
    pub has_fix: bool,
    pub lat_deg: f64,
    pub lon_deg: f64,
    pub height_m: f64,
    /// Velocity north, m/s; the others are 0. NaN if the log has no velocity.
    pub north_mps: f64,
    /// Number of the receiver, 0 or 1; datasets have one.
    pub receiver: usize,
}

/// Samples at rest at the times `samples_s`, and fixes, in the order of the file: a fix follows the sample before it.
#[derive(Clone, Debug, Default)]
pub struct Flight {
    pub samples_s: Vec<f64>,
    pub fixes: Vec<Row>,
}

impl Flight {
    /// A flight of 20 s with 50 samples and one fix a second, at times from `start_s` on.
    pub fn at_rest(start_s: f64) -> Self {
        let samples_s = (0..1000).map(|k| start_s + 0.02 * f64::from(k)).collect();
        let fixes = (0..20).map(|k| Row {
            time_s: start_s + f64::from(k) + 0.01,
            has_fix: true,
            lat_deg: 47.0 + 1e-6 * f64::from(k),
            lon_deg: 8.0,
            height_m: 400.0 + 0.1 * f64::from(k),
            north_mps: f64::NAN,
            receiver: 0,
        });
        Self { samples_s, fixes: fixes.collect() }
    }

    fn has_velocity(&self) -> bool {
        self.fixes.iter().any(|row| row.north_mps.is_finite())
    }

    fn has_two_receivers(&self) -> bool {
        self.fixes.iter().any(|row| row.receiver > 0)
    }

    /// Passes samples and fixes to `sample` and `fix`, in the order of the file.
    fn each(&self, mut sample: impl FnMut(f64), mut fix: impl FnMut(&Row)) {
        let every = self.samples_s.len() / self.fixes.len().max(1);
        for (index, &time_s) in self.samples_s.iter().enumerate() {
            sample(time_s);
            if let Some(row) = self.fixes.get(index / every).filter(|_| index % every == 0) {
                fix(row);
            }
        }
    }
}

/// A log in one format.
pub struct Written {
    _folder: TempDir,
    pub format: &'static str,
    pub path: PathBuf,
}

impl Written {
    pub fn read(&self) -> Dataset {
        open(&self.path, &Options::default())
            .unwrap_or_else(|error| panic!("{}: {error}", self.format))
            .dataset
    }
}

/// Formats of [`written`].
pub const FORMATS: [&str; 6] = ["dataset", "text", "dataflash", "ulog", "tlog", "mcap"];

/// Writes `flight` in the format of this name.
pub fn written(flight: &Flight, format: &'static str) -> Written {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(match format {
        "dataset" | "text" => format.to_owned(),
        other => format!("flight.{other}"),
    });
    match format {
        "dataset" => dataset(flight, &path),
        "text" => text(flight, folder.path(), &path),
        "dataflash" => fs::write(&path, dataflash(flight)).unwrap(),
        "ulog" => fs::write(&path, ulog(flight)).unwrap(),
        "tlog" => fs::write(&path, tlog(flight)).unwrap(),
        _ => fs::write(&path, mcap(flight)).unwrap(),
    }
    Written { _folder: folder, format, path }
}

/// Writes `imu.csv` and `gps.csv` to `folder`; `time` and `accelerations` are the names of those columns.
pub fn tables(flight: &Flight, folder: &Path, time: &str, accelerations: &str) -> [PathBuf; 2] {
    let mut imu = format!("{time},gyro_x_radps,gyro_y_radps,gyro_z_radps,{accelerations}\n");
    let mut gps = format!("{time},lat_deg,lon_deg,height_m,fix_type");
    gps += if flight.has_velocity() { ",vn_mps,ve_mps,vd_mps" } else { "" };
    gps += if flight.has_two_receivers() { ",I\n" } else { "\n" };
    flight.each(
        |t| writeln!(imu, "{t:.6},0.001,0,0,0.01,0,-9.81").unwrap(),
        |row| {
            let Row { time_s, has_fix, lat_deg, lon_deg, height_m, north_mps, receiver } = row;
            let fix_type = if *has_fix { 3 } else { 0 };
            write!(gps, "{time_s:.6},{lat_deg},{lon_deg},{height_m},{fix_type}").unwrap();
            if flight.has_velocity() {
                write!(gps, ",{north_mps},0,0").unwrap();
            }
            if flight.has_two_receivers() {
                write!(gps, ",{receiver}").unwrap();
            }
            gps.push('\n');
        },
    );
    let files = [folder.join("imu.csv"), folder.join("gps.csv")];
    fs::write(&files[0], imu).unwrap();
    fs::write(&files[1], gps).unwrap();
    files
}

fn dataset(flight: &Flight, path: &Path) {
    fs::create_dir(path).unwrap();
    tables(flight, path, "t_s", "accel_x_mps2,accel_y_mps2,accel_z_mps2");
}

fn text(flight: &Flight, folder: &Path, path: &Path) {
    let files = tables(flight, folder, "time_s", "ax,ay,az");
    Proposal::of(&files).unwrap().write(path, true).unwrap();
}

pub fn dataflash(flight: &Flight) -> String {
    let mut lines = String::from(
        "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\n\
         FMT, 129, 40, IMU, QBffffffBB, TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,GH,AH\n\
         FMT, 130, 60, GPS, QBBIHLLefff, TimeUS,I,Status,GMS,GWk,Lat,Lng,Alt,Spd,GCrs,VZ\n",
    );
    let text = std::cell::RefCell::new(&mut lines);
    flight.each(
        |t| {
            let us = 1e6 * t;
            writeln!(text.borrow_mut(), "IMU, {us:.0}, 0, 0.001, 0, 0, 0.01, 0, -9.81, 1, 1")
                .unwrap();
        },
        |row| {
            let Row { time_s, has_fix, lat_deg, lon_deg, height_m, north_mps, receiver } = row;
            let (us, status) = (1e6 * time_s, if *has_fix { 3 } else { 1 });
            let down_mps = 0.0 * north_mps;
            writeln!(
                text.borrow_mut(),
                "GPS, {us:.0}, {receiver}, {status}, 0, 0, {lat_deg}, {lon_deg}, {height_m}, {north_mps}, 0, {down_mps}"
            )
            .unwrap();
        },
    );
    lines
}

/// A message of a ULog: size, type and body.
pub fn message(kind: u8, content: &[u8]) -> Vec<u8> {
    let size = u16::try_from(content.len()).unwrap().to_le_bytes();
    [&size[..], &[kind], content].concat()
}

pub fn ulog(flight: &Flight) -> Vec<u8> {
    let mut log = b"ULog\x01\x12\x35\x01".to_vec();
    log.extend(0_u64.to_le_bytes());
    for definition in [
        "sensor_combined:uint64_t timestamp;float[3] gyro_rad;float[3] accelerometer_m_s2;",
        "vehicle_gps_position:uint64_t timestamp;double latitude_deg;double longitude_deg;\
         double altitude_ellipsoid_m;double altitude_msl_m;float vel_n_m_s;float vel_e_m_s;\
         float vel_d_m_s;bool vel_ned_valid;uint8_t fix_type;",
    ] {
        log.extend(message(b'F', definition.as_bytes()));
    }
    log.extend(message(b'A', b"\x00\x00\x00sensor_combined"));
    log.extend(message(b'A', b"\x00\x01\x00vehicle_gps_position"));
    if flight.has_two_receivers() {
        log.extend(message(b'A', b"\x01\x02\x00vehicle_gps_position"));
    }
    let bytes = std::cell::RefCell::new(&mut log);
    flight.each(
        |t| {
            let mut row = vec![0, 0];
            row.extend(((1e6 * t) as u64).to_le_bytes());
            row.extend([0.001_f32, 0.0, 0.0, 0.01, 0.0, -9.81].map(f32::to_le_bytes).concat());
            bytes.borrow_mut().extend(message(b'D', &row));
        },
        |fix| {
            let mut row = vec![1 + fix.receiver as u8, 0];
            row.extend(((1e6 * fix.time_s) as u64).to_le_bytes());
            let place = [fix.lat_deg, fix.lon_deg, fix.height_m, fix.height_m];
            row.extend(place.map(f64::to_le_bytes).concat());
            row.extend([fix.north_mps as f32, 0.0, 0.0].map(f32::to_le_bytes).concat());
            row.push(u8::from(fix.north_mps.is_finite()));
            row.push(if fix.has_fix { 3 } else { 1 });
            bytes.borrow_mut().extend(message(b'D', &row));
        },
    );
    log
}

fn tlog(flight: &Flight) -> Vec<u8> {
    let log = std::cell::RefCell::new(Vec::new());
    let stamp = |t: f64| 1_700_000_000_000_000 + (1e6 * t) as u64;
    flight.each(
        |t| {
            let mut payload = ((1e3 * t).round() as u32).to_le_bytes().to_vec();
            let values = [1_i16, 0, -1000, 1, 0, 0, 0, 0, 0];
            payload.extend(values.map(i16::to_le_bytes).concat());
            log.borrow_mut().extend(frame(stamp(t), 0, 26, 170, &payload));
        },
        |row| {
            let mut payload = vec![0; 52];
            payload[..8].copy_from_slice(&((1e6 * row.time_s) as u64).to_le_bytes());
            for (at, value) in
                [(8, 1e7 * row.lat_deg), (12, 1e7 * row.lon_deg), (16, 1e3 * row.height_m)]
            {
                payload[at..at + 4].copy_from_slice(&(value as i32).to_le_bytes());
            }
            // GPS2_RAW has four more bytes before the accuracies. Course and speed may be unknown.
            let (message, seed, at) = if row.receiver == 0 { (24, 24, 24) } else { (124, 87, 28) };
            payload[at..at + 4].fill(0xFF);
            if row.north_mps.is_finite() {
                let [low, high] = ((1e2 * row.north_mps) as u16).to_le_bytes();
                payload[at..at + 4].copy_from_slice(&[low, high, 0, 0]);
            }
            payload[at + 4..at + 6].copy_from_slice(&[if row.has_fix { 3 } else { 1 }, 12]);
            log.borrow_mut().extend(frame(stamp(row.time_s), 0, message, seed, &payload));
        },
    );
    log.into_inner()
}

pub fn mcap(flight: &Flight) -> Vec<u8> {
    let file = tempfile::NamedTempFile::new().unwrap();
    let mut writer =
        mcap::WriteOptions::new().compression(None).create(file.reopen().unwrap()).unwrap();
    let mut channel = |topic: &str, schema: &str| {
        let schema = writer.add_schema(schema, "ros2msg", b"").unwrap();
        writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).unwrap()
    };
    let imu = channel("/imu", "sensor_msgs/msg/Imu");
    let fixes = ["/fix", "/fix_2"].map(|topic| channel(topic, "sensor_msgs/msg/NavSatFix"));
    let velocity = channel("/fix/velocity", "geometry_msgs/msg/TwistStamped");
    let writer = std::cell::RefCell::new(writer);
    let send = |channel_id: u16, t: f64, body: &[u8]| {
        let ns = (1e9 * t) as u64;
        let header = mcap::records::MessageHeader {
            channel_id,
            sequence: 0,
            log_time: ns,
            publish_time: ns,
        };
        let mut data = vec![0, 1, 0, 0];
        data.extend(((ns / 1_000_000_000) as u32).to_le_bytes());
        data.extend(((ns % 1_000_000_000) as u32).to_le_bytes());
        // A frame called "abc", so that the body is aligned to eight bytes.
        data.extend([4, 0, 0, 0, b'a', b'b', b'c', 0]);
        data.extend(body);
        writer.borrow_mut().write_to_known_channel(&header, &data).unwrap();
    };
    let doubles =
        |values: &[f64]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    flight.each(
        |t| {
            let mut values = vec![0.0; 4 + 9];
            values[4] = -1.0;
            values.extend([0.001, 0.0, 0.0]);
            values.extend([0.0; 9]);
            values.extend([0.01, 0.0, 9.81]);
            values.extend([0.0; 9]);
            send(imu, t, &doubles(&values));
        },
        |row| {
            let mut body = vec![if row.has_fix { 0 } else { 0xFF }, 0, 1, 0, 0, 0, 0, 0];
            body.extend(doubles(&[row.lat_deg, row.lon_deg, row.height_m]));
            body.extend(doubles(&[0.0; 9]));
            body.push(0);
            send(fixes[row.receiver], row.time_s, &body);
            if row.north_mps.is_finite() {
                let twist = doubles(&[0.0, row.north_mps, 0.0, 0.0, 0.0, 0.0]);
                send(velocity, row.time_s, &twist);
            }
        },
    );
    let mut writer = writer.into_inner();
    writer.finish().unwrap();
    drop(writer);
    fs::read(file.path()).unwrap()
}

pub fn warns(dataset: &Dataset, words: &str) -> bool {
    dataset.warnings.iter().any(|warning| warning.contains(words))
}

#[test]
fn a_height_of_zero_far_from_all_others_is_no_height_in_every_format() {
    let mut flight = Flight::at_rest(1.0);
    for index in [0, 1, 2, 10, 11] {
        flight.fixes[index].height_m = 0.0;
    }
    let mut at_sea = Flight::at_rest(1.0);
    for (index, row) in at_sea.fixes.iter_mut().enumerate() {
        row.height_m = 0.1 * index.saturating_sub(9) as f64;
    }
    for format in FORMATS {
        let dataset = written(&flight, format).read();
        let heights = dataset.fixes.iter().map(|fix| fix.position.height_m);
        assert!(heights.clone().all(|height_m| height_m > 399.0), "{format}: {heights:?}");
        let unmeasured = dataset.fixes.iter().filter(|fix| fix.two_dimensional).count();
        assert_eq!(unmeasured, 5, "{format}");
        assert!(warns(&dataset, "with a height of 0"), "{format}: {:?}", dataset.warnings);
        let dataset = written(&at_sea, format).read();
        assert!(dataset.fixes.iter().all(|fix| !fix.two_dimensional), "{format}");
    }
}

#[test]
fn every_format_rejects_what_is_no_fix() {
    let mut flight = Flight::at_rest(1.0);
    for row in &mut flight.fixes[..3] {
        (row.lat_deg, row.lon_deg) = (0.0, 0.0);
    }
    flight.fixes[4].has_fix = false;
    for format in FORMATS {
        let dataset = written(&flight, format).read();
        assert_eq!(dataset.imu.len(), 1000, "{format}");
        assert_eq!(dataset.fixes.len(), 16, "{format}: {:?}", dataset.warnings);
        assert!(
            warns(&dataset, "latitude and longitude are 0"),
            "{format}: {:?}",
            dataset.warnings
        );
        assert!(dataset.fixes.iter().all(|fix| !fix.two_dimensional), "{format}");
    }
}

#[test]
fn a_fix_without_a_height_is_horizontal_in_every_format_that_can_state_it() {
    let mut flight = Flight::at_rest(1.0);
    flight.fixes[5].height_m = f64::NAN;
    flight.fixes[6].height_m = -9999.0;
    // MAVLink's height is a whole number of mm.
    for format in FORMATS.into_iter().filter(|format| *format != "tlog") {
        let dataset = written(&flight, format).read();
        let flat: Vec<usize> = (0..dataset.fixes.len())
            .filter(|&index| dataset.fixes[index].two_dimensional)
            .collect();
        assert_eq!(
            (dataset.fixes.len(), &flat[..]),
            (20, &[5, 6][..]),
            "{format}: {:?}",
            dataset.warnings
        );
        assert!((dataset.fixes[5].position.height_m - 400.4).abs() < 0.02, "{format}");
        assert!(warns(&dataset, "without a measured height"), "{format}: {:?}", dataset.warnings);
    }
}

#[test]
fn values_that_stand_for_unknown_ones_are_rejected_in_every_format() {
    for (lat_deg, lon_deg) in [(-9999.0, -9999.0), (214.748_364_7, 214.748_364_7), (1e-7, -1e-7)] {
        let mut flight = Flight::at_rest(1.0);
        for row in &mut flight.fixes[8..11] {
            (row.lat_deg, row.lon_deg) = (lat_deg, lon_deg);
        }
        for format in FORMATS {
            let dataset = written(&flight, format).read();
            assert_eq!(dataset.fixes.len(), 17, "{format} {lat_deg}: {:?}", dataset.warnings);
            assert!(warns(&dataset, "3 rows"), "{format} {lat_deg}: {:?}", dataset.warnings);
        }
    }
}

#[test]
fn a_fix_repeated_on_every_row_is_one_fix_in_every_format() {
    let mut flight = Flight::at_rest(1.0);
    let once = flight.fixes.clone();
    flight.fixes = once
        .iter()
        .flat_map(|row| (0..50).map(|k| Row { time_s: row.time_s + 0.02 * f64::from(k), ..*row }))
        .collect();
    for format in FORMATS {
        let dataset = written(&flight, format).read();
        assert_eq!(dataset.fixes.len(), 20, "{format}: {:?}", dataset.warnings);
    }
}

#[test]
fn velocities_of_zero_while_positions_move_are_found_in_every_format() {
    let mut flight = Flight::at_rest(1.0);
    flight.samples_s = (0..3000).map(|k| 1.0 + 0.02 * f64::from(k)).collect();
    let first = flight.fixes[0];
    let row = |k: u32| {
        let since_s = 0.2 * f64::from(k);
        let (time_s, lat_deg) = (1.01 + since_s, 47.0 + 2e-5 * since_s);
        Row { time_s, lat_deg, north_mps: 0.0, ..first }
    };
    flight.fixes = (0..300).map(row).collect();
    for format in FORMATS {
        let dataset = written(&flight, format).read();
        assert_eq!(dataset.fixes.len(), 300, "{format}: {:?}", dataset.warnings);
        let found: Vec<String> = check_setup(&dataset).iter().map(ToString::to_string).collect();
        let is_told = found.iter().any(|found| found.contains("exactly 0"));
        assert!(is_told, "{format}: {found:?}");
    }
}
