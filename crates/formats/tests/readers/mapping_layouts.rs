//! Layouts of other people's loggers: a flight in each of them is the flight as it was recorded.

use std::path::Path;

use hovernav::gps::Fix;
use hovernav_dataset::Dataset;
use hovernav_testing::shared;

use crate::mapped::mapped;

const ORIGINAL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../datasets/heli-hover");

/// The rows of `file` of a data set, an empty field as NaN.
fn rows(set: &Path, file: &str) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(set.join(file)).unwrap();
    let number = |field: &str| field.parse().unwrap_or(f64::NAN);
    text.lines().skip(1).map(|line| line.split(',').map(number).collect()).collect()
}

fn joined(values: &[f64]) -> String {
    values.iter().map(f64::to_string).collect::<Vec<_>>().join(",")
}

/// The inertial samples of the set in a plain table.
fn plain_imu(set: &Path) -> (&'static str, String) {
    let rows: String = rows(set, "imu.csv").iter().map(|row| joined(&row[..7]) + "\n").collect();
    ("imu.csv", format!("t_s,gyro_x_radps,gyro_y_radps,gyro_z_radps,ax,ay,az\n{rows}"))
}

/// The original fixes and those of `dataset` agree in position and, where `with_velocity`, in velocity.
fn assert_fixes(dataset: &Dataset, with_velocity: bool, report: &str) {
    let original = rows(Path::new(ORIGINAL), "gps.csv");
    assert_eq!(dataset.fixes.len(), original.len(), "{report}");
    for (fix, row) in dataset.fixes.iter().zip(&original) {
        let Fix { position, .. } = fix;
        let off_deg = (position.latitude_rad.to_degrees() - row[1])
            .hypot(position.longitude_rad.to_degrees() - row[2]);
        assert!(off_deg < 1e-7, "{off_deg}° {report}");
        assert!((position.height_m - row[3]).abs() < 0.02, "{} {report}", position.height_m);
        if with_velocity {
            let [north, east] = fix.horizontal_velocity_mps.unwrap_or([f64::NAN; 2]);
            let off = (north - row[4]).hypot(east - row[5]);
            assert!(off < 0.02, "{off} m/s {report}");
            let down = fix.down_velocity_mps.unwrap_or(f64::NAN);
            assert!((down - row[6]).abs() < 0.02, "{down} m/s {report}");
        }
    }
}

/// Earth-centred coordinates of a fix, m, and its velocity along them, m/s.
fn earth_centred(row: &[f64]) -> ([f64; 3], [f64; 3]) {
    let place = hovernav::earth::Geodetic {
        latitude_rad: row[1].to_radians(),
        longitude_rad: row[2].to_radians(),
        height_m: row[3],
    };
    let velocity = hovernav::frames::Vector::new(row[4], row[5], row[6]);
    let along = place.ecef_to_ned().inverse() * velocity;
    (place.to_ecef().to_array(), along.to_array())
}

#[test]
fn earth_centred_positions_and_velocities_are_converted() {
    let set = Path::new(ORIGINAL);
    for (names, to, with_velocity) in [
        ("t,x,y,z", 1.0, false),
        ("t,x-ecef(m),y-ecef(m),z-ecef(m)", 1.0, false),
        ("t,ecef_x,ecef_y,ecef_z,ecef_vx_mps,ecef_vy_mps,ecef_vz_mps", 1.0, true),
        ("t,ecefX,ecefY,ecefZ,ecefVX (cm/s),ecefVY (cm/s),ecefVZ (cm/s)", 100.0, true),
    ] {
        let row = |row: &Vec<f64>| {
            let (place, velocity) = earth_centred(row);
            let mut values = [&[row[0]][..], &place.map(|value| value * to)].concat();
            if with_velocity {
                values.extend(velocity.map(|value| value * to));
            }
            joined(&values) + "\n"
        };
        let fixes: String = rows(set, "gps.csv").iter().map(row).collect();
        let (report, _, dataset) =
            mapped(&[plain_imu(set), ("gps.csv", format!("{names}\n{fixes}"))]);
        assert_fixes(&dataset, with_velocity, &report);
    }
}

#[test]
fn messages_of_ros_2_without_names_are_read() {
    let set = Path::new(ORIGINAL);
    let stamp = |time_s: f64| {
        let microseconds = (time_s * 1e6).round() as u64;
        format!("{},{}", 1_714_903_200 + microseconds / 1_000_000, microseconds % 1_000_000 * 1000)
    };
    let zeros = ",0".repeat(8);
    let imu = |row: &Vec<f64>| {
        let (gyro, accel) = (&row[1..4], &row[4..7]);
        format!(
            "{},imu_link,0,0,0,1,-1{zeros},{},{},{},0{zeros},{},{},{},0{zeros}\n",
            stamp(row[0]),
            gyro[0],
            -gyro[1],
            -gyro[2],
            accel[0],
            -accel[1],
            -accel[2]
        )
    };
    let fix = |row: &Vec<f64>| {
        format!(
            "{},gps,0,1,{},{},{},1.4,0,0,0,1.4,0,0,0,3.2,2\n",
            stamp(row[0]),
            row[1],
            row[2],
            row[3]
        )
    };
    let twist =
        |row: &Vec<f64>| format!("{},gps,{},{},{},0,0,0\n", stamp(row[0]), row[5], row[4], -row[6]);
    let original = rows(set, "imu.csv");
    let (report, _, dataset) = mapped(&[
        ("imu.csv", original.iter().map(imu).collect()),
        ("fix.csv", rows(set, "gps.csv").iter().map(fix).collect()),
        ("vel.csv", rows(set, "gps.csv").iter().map(twist).collect()),
    ]);
    assert_fixes(&dataset, true, &report);
    for (sample, row) in dataset.imu.iter().zip(&original) {
        let rates = sample.motion.mean_rates(0.02);
        let off = (rates.specific_force_mps2.z() - row[6]).abs();
        assert!(off < 1e-6 && (sample.time.seconds() - 1_714_903_200.0 - row[0]).abs() < 1e-5);
    }
}

#[test]
fn nanoseconds_beside_seconds_are_added() {
    let row =
        |k: u32| format!("{},{},0.01,0.02,{}e-3,0,0,-9.81\n", k / 50, k % 50 * 20_000_000, k % 7);
    let rows: String = (0..1000).map(row).collect();
    for names in ["header.stamp.sec,header.stamp.nanosec", "secs,nsecs"] {
        let (report, _, dataset) =
            mapped(&[("imu.csv", format!("{names},gx,gy,gz,ax,ay,az\n{rows}"))]);
        assert_eq!(dataset.imu.len(), 1000, "{report}");
        assert!((dataset.imu[75].time.seconds() - 1.5).abs() < 1e-9, "{report}");
    }
}

#[test]
fn velocities_in_a_file_of_their_own_are_those_of_the_fixes() {
    let set = Path::new(ORIGINAL);
    let place = |row: &Vec<f64>| joined(&row[..4]) + "\n";
    let fixes: String = rows(set, "gps.csv").iter().map(place).collect();
    for per_mps in [1.0, 100.0] {
        let velocity = |row: &Vec<f64>| {
            let [north, east, down] = [4, 5, 6].map(|at| (row[at] * per_mps * 1e3).round() / 1e3);
            format!("{},{north},{east},{down}\n", row[0])
        };
        let velocities: String = rows(set, "gps.csv").iter().map(velocity).collect();
        let (report, _, dataset) = mapped(&[
            plain_imu(set),
            ("pos.csv", format!("t,latitude,longitude,altitude\n{fixes}")),
            ("vel.csv", format!("t,velN,velE,velD\n{velocities}")),
        ]);
        assert_fixes(&dataset, true, &report);
    }
}

#[test]
fn a_height_that_fits_in_two_units_is_asked_about() {
    for (name, metres_are_shown) in [("car-rtk", false), ("uav-thor75-1hz", true)] {
        let Some(set) = &shared(format!("datasets/{name}")) else { return };
        for per_m in [1.0, 1.0 / 0.3048] {
            let row = |row: &Vec<f64>| {
                let course = row[5].atan2(row[4]).to_degrees().rem_euclid(360.0);
                let height = row[3] * per_m;
                joined(&[row[0], row[1], row[2], height, row[4].hypot(row[5]), course]) + "\n"
            };
            let fixes: String = rows(set, "gps.csv").iter().map(row).collect();
            let (report, _, dataset) = mapped(&[
                plain_imu(set),
                ("gps.csv", format!("t,lat,lon,alt,speed,course\n{fixes}")),
            ]);
            let off_m = (dataset.fixes[9].position.height_m - rows(set, "gps.csv")[9][3]).abs();
            let is_asked = report.contains("check: gps: the unit of alt is not stated");
            assert!(is_asked || off_m < 1.0, "{name} {per_m}: {off_m} m\n{report}");
            assert!(!metres_are_shown || !is_asked && off_m < 1.0, "{name} {per_m}: {report}");
        }
    }
}

#[test]
fn counts_of_512_per_g_are_no_thousandths() {
    let row = |k: u32| format!("{},{},3,-2,{},{},512\n", 20 * k, k % 7, k % 5, k % 3);
    let rows: String = (0..400).map(row).collect();
    let names = "time_ms,gyroADC[0],gyroADC[1],gyroADC[2],accSmooth[0],accSmooth[1],accSmooth[2]";
    let (report, _, dataset) = mapped(&[("LOG.csv", format!("{names}\n{rows}"))]);
    let force = dataset.imu[9].motion.mean_rates(0.02).specific_force_mps2.norm();
    assert!((force - 9.81).abs() < 0.1, "{force} {report}");
}

#[test]
fn a_row_of_kitti_may_follow_a_date_and_a_time() {
    let row = |k: u32| {
        let time_s = 0.1 * f64::from(k);
        let place = format!("{} 8.4 116.4 0.01 0.02 0.3", 49.0 + 1e-6 * f64::from(k));
        let motion = format!("0.1 0.2 9.8{} 0.1 0.2 9.8{}", k % 3, k % 3);
        let rates = format!("0.01 0.02 0.{} 0.01 0.02 0.{}", k % 7, k % 7);
        format!(
            "2011-09-26 13:02:{time_s:09.6} {place} 5 0.1 5 0 0 {motion} {rates} 0.05 0.02 4 11 6 6 6\n"
        )
    };
    let (report, mapping, dataset) = mapped(&[("oxts.txt", (0..500).map(row).collect())]);
    assert_eq!(dataset.imu.len(), 500, "{report}\n{mapping}");
    let rates = dataset.imu[3].motion.mean_rates(0.1).angular_rate_radps.norm();
    assert!((rates - 0.3f64.hypot(0.01f64.hypot(0.02))).abs() < 1e-6, "{rates} {report}");
    assert!(dataset.imu[0].time.seconds() > 1.3e9, "{report}\n{mapping}");
}
