//! Foreign receivers: positions of several sources, heights with the height of the geoid, velocities in a file of their
//! own.

use crate::mapped::mapped;

/// Length of the logs, s.
const LENGTH_S: u32 = 60;

/// Latitude of a receiver that moves north at 5 m/s, degrees.
fn latitude_deg(time_s: f64) -> f64 {
    -33.85 + 5.0 * time_s / 110_930.0
}

/// A table of rows at `rate_hz`; `row` has the time, s.
fn table(names: &str, rate_hz: u32, row: impl Fn(f64) -> String) -> String {
    let rows = (0..LENGTH_S * rate_hz).map(|k| row(f64::from(k) / f64::from(rate_hz)) + "\n");
    format!("{names}\n{}", rows.collect::<String>())
}

#[test]
fn position_height_and_velocity_are_of_one_source() {
    let imu = ["accel:X", "accel:Y", "accel:Z", "gyro:X", "gyro:Y", "gyro:Z"];
    let imu = imu.map(|part| format!("IMU_ATTI(0):{part}")).join(",");
    for (filter, receiver) in [
        ("IMU_ATTI(0):Latitude,IMU_ATTI(0):Longitude,IMU_ATTI(0):velN,IMU_ATTI(0):velE", "GPS:"),
        ("ekf_lat,ekf_lon,ekf_vn,ekf_ve", "gps_"),
        ("INS.Lat,INS.Lng,INS.velN,INS.velE", "GPS[0]."),
    ] {
        let names = ["Lat", "Long", "heightMSL", "velN", "velE", "velD"];
        let names = names.map(|name| format!("{receiver}{name}")).join(",");
        let row = |t: f64| {
            let lat = latitude_deg(t.floor());
            let filtered = format!("{:.8},151.2,7.0,1.0", lat + 1e-3);
            let force = format!("0.001,0.002,{:.4}", -1.0 - 1e-4 * (7.0 * t).sin());
            format!("{t:.2},{filtered},{force},0.1,0.2,0.3,{lat:.8},151.2,49.7,5.0,0.2,0.1")
        };
        let text = table(&format!("offsetTime,{filter},{imu},{names}"), 20, row);
        let (report, mapping, dataset) = mapped(&[("FLY.csv", text)]);
        assert!(dataset.fixes.len() >= 59, "{report}\n{mapping}");
        let fix = &dataset.fixes[20];
        let off_deg = fix.position.latitude_rad.to_degrees() - latitude_deg(20.0);
        assert!(off_deg.abs() < 1e-7, "{receiver}: {off_deg} {report}");
        assert_eq!(fix.horizontal_velocity_mps, Some([5.0, 0.2]), "{report}");
        assert!(report.contains("position, height and velocity are read from"), "{report}");
    }
}

#[test]
fn the_height_of_the_geoid_is_added_to_heights_above_it_only() {
    for (names, height) in [
        ("altitude,undulation", "31.2,18.5"),
        ("hMSL (m),Geoid Separation (m)", "31.2,18.5"),
        ("Altitude Ellipsoid (m),Undulation (m)", "49.7,18.5"),
        ("hMSL,height_ellipsoid,undulation", "31.2,49.7,18.5"),
    ] {
        let row = |t: f64| format!("{t:.0},{:.8},151.2,{height}", latitude_deg(t));
        let text = table(&format!("time_s,latitude,longitude,{names}"), 1, row);
        let (report, _, dataset) = mapped(&[("gps.csv", text)]);
        let height_m = dataset.fixes[10].position.height_m;
        assert!((height_m - 49.7).abs() < 1e-9, "{names}: {height_m} {report}");
    }
}

#[test]
fn a_twist_in_a_file_of_its_own_is_the_velocity_of_the_fixes() {
    const EPOCH_NS: f64 = 1.7e18;
    let stamp = |t: f64| format!("{:.0},0,{:.0}", EPOCH_NS + t * 1e9, EPOCH_NS + t * 1e9);
    let header = "%time,field.header.seq,field.header.stamp";
    let axes = |of: &str| ["x", "y", "z"].map(|axis| format!("field.{of}.{axis}")).join(",");
    let imu = || {
        let names = [axes("angular_velocity"), axes("linear_acceleration")].join(",");
        let row = |t: f64| format!("{},1e-4,2e-4,{:.5},0.01,0.02,9.81", stamp(t), 1e-4 * t.sin());
        ("imu.csv", table(&format!("{header},{names}"), 50, row))
    };
    let fixes = || {
        let row = |t: f64| format!("{},{:.8},151.2,49.7", stamp(t), latitude_deg(t));
        (
            "fix.csv",
            table(&format!("{header},field.latitude,field.longitude,field.altitude"), 1, row),
        )
    };
    for (file, stem, east_north_up, is_read) in [
        ("vel.csv", "twist.linear", "0.2,5.0,-0.1", true),
        ("fix_velocity.csv", "twist.twist.linear", "0.2,5.0,-0.1", true),
        ("odom.csv", "twist.twist.linear", "5.0,0.0,0.0", false),
        ("cmd_vel.csv", "twist.linear", "0.2,5.0,-0.1", false),
    ] {
        let row = |t: f64| format!("{},{east_north_up},0,0,0", stamp(t + 0.004));
        let names = [axes(stem), axes(&stem.replace("linear", "angular"))].join(",");
        let twist = table(&format!("{header},{names}"), 1, row);
        let (report, mapping, dataset) = mapped(&[imu(), fixes(), (file, twist)]);
        assert_eq!(dataset.fixes.len(), 60, "{report}\n{mapping}");
        let fix = &dataset.fixes[20];
        let velocity = fix.horizontal_velocity_mps.zip(fix.down_velocity_mps);
        let expected = is_read.then_some(([5.0, 0.2], 0.1));
        assert_eq!(velocity, expected, "{file}: {report}\n{mapping}");
    }
}

#[test]
fn a_blackbox_of_betaflight_is_counts() {
    const COUNTS_PER_G: f64 = 2048.0;
    let names = "loopIteration,time (us),baroAlt (cm),gyroADC[0],gyroADC[1],gyroADC[2],accSmooth[0],accSmooth[1],accSmooth[2]";
    let units = names.replace("]", "] (u)").replace("gyroADC[0] (u)", "gyroADC[0] (deg/s)");
    let units = units.replace("(u)", "");
    for (above, counts_per_degps, counts_per_g, names) in [
        ("", 1.0, COUNTS_PER_G, names),
        (
            "\"looptime\",\"125\"\n\"gyro_scale\",\"0x3f800000\"\n\"acc_1G\",\"2048\"\n",
            1.0,
            COUNTS_PER_G,
            names,
        ),
        ("H gyro_scale:0x3d800000\nH acc_1G:512\n", 16.0, 512.0, names),
        ("", 1.0, 4096.0, &units),
    ] {
        let row = |t: f64| {
            let gyro = [2.0, -3.0, (20.0 * t.sin()).round()].map(|rate| rate * counts_per_degps);
            let force = [0.0, 0.01, 1.0].map(|force| (force * counts_per_g).round());
            let values = [&gyro[..], &force[..]].concat();
            let values =
                values.iter().map(|value| format!("{value:.0}")).collect::<Vec<_>>().join(",");
            format!("{:.0},{:.0},{:.0},{values}", 500.0 * t, 1e6 * t, 100.0 + 10.0 * t)
        };
        let gps = "time (us),GPS_numSat,GPS_coord[0],GPS_coord[1],GPS_altitude";
        let fix = |t: f64| format!("{:.0},12,{:.7},151.2,49.7", 1e6 * t, latitude_deg(t));
        let (report, mapping, dataset) = mapped(&[
            ("btfl.csv", format!("{above}{}", table(names, 100, row))),
            ("btfl.gps.csv", table(gps, 5, fix)),
        ]);
        assert_eq!((dataset.imu.len(), dataset.fixes.len()), (6000, 300), "{report}\n{mapping}");
        let rates = dataset.imu[100].motion.mean_rates(0.01);
        let turn_degps = rates.angular_rate_radps.to_array().map(f64::to_degrees);
        assert!((turn_degps[0] - 2.0).abs() < 1e-6, "{turn_degps:?} {report}\n{mapping}");
        let force_mps2 = rates.specific_force_mps2.to_array();
        assert!((force_mps2[2].abs() - 9.80665).abs() < 0.01, "{force_mps2:?} {report}");
        assert!(report.contains("are read as counts"), "{report}");
        let climbed_m = dataset.baro.last().unwrap().1 - dataset.baro[0].1;
        assert!((climbed_m - 6.0).abs() < 0.02, "{climbed_m} {report}");
    }
}
