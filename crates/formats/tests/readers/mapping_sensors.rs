//! Foreign text with several sensors of one kind, or one sensor in several files.

use hovernav_dataset::Dataset;
use hovernav_formats::{Options, Proposal, open};

use crate::mapped::mapped;

/// A level flight of 40 s at 25 Hz, with headings from 60° to 100°. The quaternion's components have the order `order`,
/// in which 0 is the scalar.
fn turning(names: &str, order: [usize; 4]) -> (String, String, Dataset) {
    let row = |k: u32| {
        let (time, yaw) = (f64::from(k) * 0.04, (60.0 + f64::from(k) * 0.04).to_radians());
        let quaternion = [(0.5 * yaw).cos(), 0.0, 0.0, (0.5 * yaw).sin()];
        let cells = order.map(|part| format!("{:.6}", quaternion[part])).join(",");
        format!("{time:.2},0.0001,0.0002,0.0174533,0.01,0.02,-9.81,{cells}\n")
    };
    let names = format!("time,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z,{names}");
    mapped(&[("flight.csv", format!("{names}\n{}", (0..1000).map(row).collect::<String>()))])
}

#[test]
fn gravity_shows_the_scalar_of_a_numbered_quaternion() {
    for (names, order) in [
        ("q0,q1,q2,q3", [0, 1, 2, 3]),
        ("q0,q1,q2,q3", [1, 2, 3, 0]),
        ("Quat_q0,Quat_q1,Quat_q2,Quat_q3", [0, 1, 2, 3]),
        ("q[0],q[1],q[2],q[3]", [1, 2, 3, 0]),
        ("qx,qy,qz,qw", [1, 2, 3, 0]),
    ] {
        let (report, mapping, dataset) = turning(names, order);
        let yaw = dataset.imu[0].attitude.unwrap().yaw_rad.to_degrees();
        assert!((yaw - 60.0).abs() < 0.01, "{names} {order:?}: {yaw} {report}\n{mapping}");
    }
}

#[test]
fn rows_of_another_sensor_are_not_merged() {
    for (zero, one, chosen) in [("-9.81", "-9.7", 0), ("0", "-9.7", 1)] {
        let row = |k: u32| {
            let (time, noise) = (f64::from(k / 2) * 0.04, f64::from(k % 7));
            match (k % 2, zero) {
                (0, "0") => format!("{time:.2},0,0,0,0,0,0,0\n"),
                (0, _) => format!("{time:.2},0,1e-4,2e-4,{noise}e-4,0.01,0.02,{zero}\n"),
                _ => format!("{time:.2},1,1e-4,2e-4,{noise}e-4,0.01,0.02,{one}\n"),
            }
        };
        let rows: String = (0..2000).map(row).collect();
        let text = format!("timestamp,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ\n{rows}");
        let (report, mapping, dataset) = mapped(&[("IMU.csv", text)]);
        assert!(mapping.contains(&format!("instance = {chosen}")), "{report}\n{mapping}");
        assert_eq!(dataset.imu.len(), 1000, "{report}");
        let down = dataset.imu[9].motion.mean_rates(0.04).specific_force_mps2.to_array()[2];
        let expected: f64 = if chosen == 0 { zero.parse().unwrap() } else { one.parse().unwrap() };
        assert!((down - expected).abs() < 1e-6, "{down} {report}");
        let told = format!("1000 rows of other sensors than I = {chosen}");
        assert!(dataset.warnings.iter().any(|w| w.contains(&told)), "{:?}", dataset.warnings);
    }
}

#[test]
fn a_counter_is_no_time_where_another_column_is() {
    let row = |k: u32| format!("{k},{},0.01,0.02,-9.81,1e-4,2e-4,{}e-4\n", k * 100, k % 7);
    let rows: String = (0..1000).map(row).collect();
    let names = "PacketCounter,SampleTimeFine,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z";
    let (report, mapping, dataset) = mapped(&[("mt.txt", format!("{names}\n{rows}"))]);
    let length_s = dataset.imu[999].time - dataset.imu[0].time;
    assert!((length_s - 9.99).abs() < 1e-9, "{length_s} {report}\n{mapping}");
}

#[test]
fn ticks_of_100_ns_are_converted_to_utc() {
    for (epoch, unit) in
        [(116_444_736_000_000_000_u64, "filetime"), (621_355_968_000_000_000, "ticks")]
    {
        let row = |k: u64| {
            let ticks = epoch + 17_149_032_000_000_000 + k * 400_000;
            format!("{ticks},0.01,0.02,-9.81,1e-4,2e-4,{}e-4\n", k % 7)
        };
        let rows: String = (0..1000).map(row).collect();
        let text = format!("time,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z\n{rows}");
        let (report, mapping, dataset) = mapped(&[("imu.csv", text)]);
        assert!(mapping.contains(&format!("unit = \"{unit}\"")), "{report}");
        assert_eq!(dataset.imu[25].time.seconds(), 1_714_903_201.0, "{report}");
    }
}

#[test]
fn names_of_loggers_are_read() {
    let row = |k: u32| {
        let time = f64::from(k) * 0.04;
        let fix = match k % 25 {
            24 => format!("-33.85{:04},151.2152974,49.7,1.0,0.0,0.1", k / 25),
            _ => ",,,,,".to_owned(),
        };
        format!("{time:.2},1e-4,2e-4,{}e-4,0.01,0.02,-9.81,{fix}\n", k % 7)
    };
    let rows: String = (0..1000).map(row).collect();
    for names in [
        "gyro_x,gyro_y,gyro_z,acc_x,acc_y,acc_z,PosLla[0],PosLla[1],PosLla[2],VelNed[0],VelNed[1],VelNed[2]",
        "GyrX,GyrY,GyrZ,AccX,AccY,AccZ,GPS[0].Lat,GPS[0].Lng,GPS[0].Alt,GPS[0].Spd,GPS[0].GCrs,GPS[0].VZ",
    ] {
        let (report, mapping, dataset) = mapped(&[("log.csv", format!("time,{names}\n{rows}"))]);
        assert_eq!((dataset.imu.len(), dataset.fixes.len()), (1000, 40), "{report}\n{mapping}");
        let fix = &dataset.fixes[5];
        let moving = fix.horizontal_velocity_mps.map(|[north, _]| north).zip(fix.down_velocity_mps);
        assert_eq!(moving, Some((1.0, 0.1)), "{report}");
    }
    let extra = "gyro_std_x,gyro_std_y,gyro_std_z,accel_bias_x,accel_bias_y,accel_bias_z,gyro_raw_x,gyro_raw_y,\
                 gyro_raw_z,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z";
    let row = |k: u32| {
        let time = f64::from(k) * 0.04;
        format!(
            "{time:.2},7,7,7,1,1,1,700,700,{},1e-4,2e-4,{}e-4,0.01,0.02,-9.81\n",
            700 + k % 5,
            k % 7
        )
    };
    let rows: String = (0..1000).map(row).collect();
    let (report, mapping, dataset) = mapped(&[("log.csv", format!("time,{extra}\n{rows}"))]);
    assert_eq!(dataset.imu.len(), 1000, "{report}");
    assert!(mapping.contains("\"gyro_x\", \"gyro_y\", \"gyro_z\""), "{mapping}");
    assert!(mapping.contains("\"accel_x\", \"accel_y\", \"accel_z\""), "{mapping}");
}

#[test]
fn a_directory_may_contain_a_capture() {
    let place = tempfile::tempdir().unwrap();
    let row = |k: u32| {
        let time = 1_714_903_200.0 + f64::from(k) * 0.04;
        format!("{time:.2},1e-4,2e-4,{}e-4,0.01,0.02,-9.81\n", k % 7)
    };
    let rows: String = (0..1000).map(row).collect();
    let text = format!("time,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z\n{rows}");
    std::fs::write(place.path().join("imu.csv"), text).unwrap();
    let sentence = |body: String| {
        let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
        format!("${body}*{sum:02X}\r\n")
    };
    let capture = (0..40).map(|second| {
        let time = format!("1000{second:02}.00");
        let place = format!("3351.{:04},S,15112.9178,E", 4081 + second);
        sentence(format!("GNGGA,{time},{place},1,12,0.8,49.7,M,0.0,M,,"))
            + &sentence(format!("GNRMC,{time},A,{place},0.3,16.0,050524,,,A"))
    });
    std::fs::write(place.path().join("gps.nmea"), capture.collect::<String>()).unwrap();
    let proposal = Proposal::of(&[place.path().to_path_buf()]).unwrap();
    let out = place.path().join("mapped");
    proposal.write(&out, false).unwrap();
    let dataset = open(&out, &Options::default()).unwrap().dataset;
    assert_eq!((dataset.imu.len(), dataset.fixes.len()), (1000, 40), "{proposal}");
}

#[test]
fn linear_acceleration_and_gravity_of_a_phone_are_added() {
    let file = |row: &dyn Fn(f64) -> String| {
        let rows = (0..4000).map(|k| format!("{:.2},{}\n", f64::from(k) * 0.01, row(f64::from(k))));
        format!("seconds_elapsed,z,y,x\n{}", rows.collect::<String>())
    };
    let linear = file(&|k| format!("{:.4},0.02,{:.4}", 1.5 * k.sin(), 0.5 * k.cos()));
    let (report, mapping, dataset) = mapped(&[
        ("Accelerometer.csv", linear),
        ("Gravity.csv", file(&|_| "9.8,0.1,0.1".to_owned())),
        ("Gyroscope.csv", file(&|k| format!("{:.5},0,0.001", 1e-3 * k.sin()))),
    ]);
    assert_eq!(dataset.imu.len(), 4000, "{report}\n{mapping}");
    let force = dataset.imu[100].motion.mean_rates(0.01).specific_force_mps2.to_array();
    assert!((force[2] + 9.8 + 1.5 * 100f64.sin()).abs() < 1e-3, "{force:?} {report}\n{mapping}");
}

#[test]
fn linear_acceleration_and_gravity_are_added_by_any_name_and_sign() {
    let (force, names) = ([0.1, -0.2, -9.8], ["x", "y", "z"]);
    let row = |sign: f64, linear: bool, k: u32| {
        let sway = [0.5 * f64::from(k).cos(), 0.0, 1.5 * f64::from(k).sin()];
        let of = |axis: usize| sign * if linear { sway[axis] } else { force[axis] };
        [0, 1, 2].map(|axis| format!("{:.5}", of(axis))).join(",")
    };
    let rates = |k: u32| format!("{:.5},0,0.001", 1e-3 * f64::from(k).sin());
    let file = |row: &dyn Fn(u32) -> String| {
        let rows = (0..2000).map(|k| format!("{:.2},{}\n", f64::from(k) * 0.01, row(k)));
        format!("seconds_elapsed,x,y,z\n{}", rows.collect::<String>())
    };
    let named = |stem: &str, unit: &str| names.map(|axis| format!("{stem}{axis}{unit}")).join(",");
    for (linear, gravity, sign) in [
        ("LINEAR ACCELERATION ", "GRAVITY ", 1.0),
        ("motionUserAcceleration", "motionGravity", -1.0 / 9.80665),
        ("user_acc_", "gravity_", -1.0),
    ] {
        let unit = if sign > -0.5 && sign < 0.0 { "(G)" } else { "" };
        let names =
            format!("{},{},{}", named(linear, unit), named(gravity, unit), named("gyro_", ""));
        let rows = (0..2000).map(|k| {
            let time = f64::from(k) * 0.01;
            format!("{time:.2},{},{},{}\n", row(sign, true, k), row(sign, false, k), rates(k))
        });
        let one = mapped(&[("log.csv", format!("time,{names}\n{}", rows.collect::<String>()))]);
        let apart = mapped(&[
            ("LinearAcceleration.csv", file(&|k| row(sign, true, k))),
            ("Gravity.csv", file(&|k| row(sign, false, k))),
            ("Gyroscope.csv", file(&rates)),
        ]);
        for (report, mapping, dataset) in [one, apart] {
            assert_eq!(dataset.imu.len(), 2000, "{linear}: {report}\n{mapping}");
            let force = dataset.imu[100].motion.mean_rates(0.01).specific_force_mps2.to_array();
            let expected = 9.8 - 1.5 * 100f64.sin();
            assert!((force[2].abs() - expected).abs() < 1e-3, "{force:?} {report}\n{mapping}");
            assert!(report.contains("the sum is the specific force"), "{report}");
        }
    }
    let both = |k: u32| format!("{},{},{}", row(1.0, true, k), "0.1,0.2,-9.81", rates(k));
    let names = [named("linear_acc_", ""), named("acc_", ""), named("gyro_", "")].join(",");
    let rows = (0..2000).map(|k| format!("{:.2},{}\n", f64::from(k) * 0.01, both(k)));
    let (_, mapping, _) =
        mapped(&[("log.csv", format!("time,{names}\n{}", rows.collect::<String>()))]);
    assert!(mapping.contains("\"acc_x\", \"acc_y\", \"acc_z\""), "{mapping}");
}

/// Four minutes of rows of a vehicle that rolls, pitches and turns while it moves north: the time, and triples of
/// columns in the order of `triples`, without names.
fn unnamed(triples: &str, counter: bool) -> String {
    let angle = |axis: usize, t: f64| match axis {
        0 => 0.2 * (1.1 * t).sin(),
        1 => 0.15 * (0.7 * t).cos(),
        _ => 0.8 * (0.3 * t).sin(),
    };
    let row = |k: u32| {
        let t = 0.02 * f64::from(k);
        let noise = 1e-3 * f64::from(k * 7 % 13);
        let triple = |letter: char| -> Vec<f64> {
            match letter {
                'e' => [0, 1, 2].map(|axis| angle(axis, t)).to_vec(),
                'd' => [0, 1, 2].map(|axis| angle(axis, t).to_degrees()).to_vec(),
                'g' => [0, 1, 2]
                    .map(|axis| (angle(axis, t + 1e-4) - angle(axis, t)) / 1e-4 + noise)
                    .to_vec(),
                'a' => [noise, 0.3 * (2.0 * t).sin(), -9.81 + noise].to_vec(),
                'm' => [0.215, 0.01 + 1e-4 * noise, 0.43].to_vec(),
                'v' => {
                    [5.0 + (0.2 * t).sin(), 0.5 * (0.13 * t).cos(), 0.1 * (0.9 * t).sin()].to_vec()
                }
                'p' => [47.0 + 4.5e-5 * t, 8.5 + 1e-6 * t, 410.0].to_vec(),
                's' => [14.0, 1.2].to_vec(),
                _ => [0.0; 3].to_vec(),
            }
        };
        let fields = triples.chars().flat_map(triple).map(|value| format!("{value:.7}"));
        let count = if counter { format!("{k} ") } else { String::new() };
        format!("{count}{t:.3} {}\n", fields.collect::<Vec<_>>().join(" "))
    };
    (0..6000).map(row).collect()
}

#[test]
fn the_gyro_of_unnamed_columns_is_the_triple_that_is_a_rate() {
    for (triples, counter, first) in [
        ("gap", false, 2),
        ("agp", false, 5),
        ("pveag", false, 14),
        ("dgap", false, 5),
        ("pdag", true, 12),
        ("psdag", true, 14),
        ("gagap", false, 2),
        ("pev0g0a", false, 14),
        ("gamp", false, 2),
        ("eag", false, 8),
    ] {
        let (report, mapping, _) = mapped(&[("log.txt", unnamed(triples, counter))]);
        let gyro = [0, 1, 2].map(|axis| (first + axis).to_string()).join(" ");
        let line = report.lines().find(|line| line.starts_with("  gyro")).unwrap();
        assert!(line.contains(&format!(" {gyro} ")), "{triples}: expected {gyro}\n{report}");
        let time = if counter { "\"2\"" } else { "\"1\"" };
        assert!(mapping.contains(&format!("column = {time}")), "{triples}\n{mapping}");
        assert!(mapping.contains("unit = \"s\""), "{triples}\n{mapping}");
    }
    // Nothing tells a velocity from a rate without fixes.
    let (report, ..) = mapped(&[("log.txt", unnamed("vag", false))]);
    assert!(report.contains("check: gyro: the columns have no names: read as columns"), "{report}");
    assert!(report.contains("2 3 4") && report.contains("8 9 10"), "{report}");
}

#[test]
fn the_upper_edge_of_a_phone_that_lies_flat_is_forward_and_to_check() {
    let file = |row: &dyn Fn(f64) -> String| {
        let rows = (0..4000).map(|k| format!("{:.2},{}\n", f64::from(k) * 0.01, row(f64::from(k))));
        format!("seconds_elapsed,z,y,x\n{}", rows.collect::<String>())
    };
    let (report, mapping, dataset) = mapped(&[
        ("TotalAcceleration.csv", file(&|k| format!("{:.4},0.5,0.2", 9.8 + 0.01 * k.sin()))),
        ("Gyroscope.csv", file(&|k| format!("{:.5},0.02,0.001", 1e-3 * k.sin()))),
    ]);
    let force = dataset.imu[100].motion.mean_rates(0.01).specific_force_mps2.to_array();
    assert!((force[0] - 0.5).abs() < 1e-3 && (force[1] - 0.2).abs() < 1e-3, "{force:?} {mapping}");
    assert!(report.contains("check: the phone lay flat, and its upper edge"), "{report}");
}
