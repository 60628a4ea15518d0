//! Units and rates of foreign text that no name states: a flight shows them.

use std::fs;
use std::path::Path;

use hovernav_dataset::Dataset;

use crate::mapped::mapped;

const ORIGINAL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../datasets/heli-hover");

fn rows(file: &str) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(Path::new(ORIGINAL).join(file)).unwrap();
    text.lines().skip(1).map(|l| l.split(',').map(|f| f.parse().unwrap()).collect()).collect()
}

/// The flight in one table, mapped: the columns `names` with the text of `row` for each sample, and the receiver's
/// columns on the row after each fix. `row` has the number of the sample and its values.
fn flown(
    names: &str,
    height_per_m: f64,
    row: impl Fn(usize, &[f64]) -> String,
) -> (String, String, Dataset) {
    let gps = rows("gps.csv");
    let (mut text, mut next) = (format!("{names},lat,lon,alt,vn,ve,vd\n"), 0);
    for (k, sample) in rows("imu.csv").iter().enumerate() {
        let fix = match gps.get(next).filter(|fix| fix[0] <= sample[0]) {
            Some(fix) => {
                next += 1;
                let [lat, lon, height, vn, ve, vd] = [1, 2, 3, 4, 5, 6].map(|column| fix[column]);
                format!("{lat},{lon},{:.3},{vn},{ve},{vd}", height * height_per_m)
            }
            None => ",,,,,".to_owned(),
        };
        text += &format!("{},{fix}\n", row(k, sample));
    }
    mapped(&[("flight.csv", text)])
}

/// The samples of an IMU, gyro and accelerometer multiplied by these factors.
fn motion(sample: &[f64], gyro: f64, accel: f64) -> String {
    let scaled = (1..7).map(|k| format!("{:.5}", sample[k] * if k < 4 { gyro } else { accel }));
    scaled.collect::<Vec<_>>().join(",")
}

const PLAIN: &str = "gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z";

#[test]
fn inertial_samples_show_the_unit_of_the_height() {
    for per_m in [1.0, 1.0 / 0.3048] {
        let row = |_: usize, sample: &[f64]| format!("{},{}", sample[0], motion(sample, 1.0, 1.0));
        let (report, mapping, dataset) = flown(&format!("t_s,{PLAIN}"), per_m, row);
        let expected_m = rows("gps.csv")[100][3];
        let off_m = (dataset.fixes[100].position.height_m - expected_m).abs();
        assert!(off_m < 0.01, "{off_m} {report}\n{mapping}");
        let is_found = report.contains("the inertial samples agree with alt if its unit is ft");
        // Smaller climbs would fit this receiver's heights as well.
        let is_asked = report.contains("check: gps: the unit of alt is not stated");
        assert_eq!([is_found, is_asked], [per_m != 1.0, per_m == 1.0], "{report}");
    }
}

#[test]
fn units_of_thousandths_are_read_by_name_and_by_the_flight() {
    const G: f64 = 9.80665;
    let milli = 1e3 * 180.0 / std::f64::consts::PI;
    for (names, gyro, accel) in [
        ("gyro_x_mdps,gyro_y_mdps,gyro_z_mdps,accel_x_mg,accel_y_mg,accel_z_mg", milli, 1e3 / G),
        ("gyro_x [mdeg/s],gyro_y [mdeg/s],gyro_z [mdeg/s],ax (mg),ay (mg),az (mg)", milli, 1e3 / G),
        (
            "gyro_x (mrad/s),gyro_y (mrad/s),gyro_z (mrad/s),ax (cm/s^2),ay (cm/s^2),az (cm/s^2)",
            1e3,
            1e2,
        ),
        (PLAIN, milli, 1e3 / G),
        (PLAIN, 1e3, 1e3 / G),
    ] {
        let row =
            |_: usize, sample: &[f64]| format!("{},{}", sample[0], motion(sample, gyro, accel));
        let (report, mapping, dataset) = flown(&format!("t_s,{names}"), 1.0, row);
        let samples = rows("imu.csv");
        assert_eq!(dataset.imu.len(), samples.len(), "{names}: {report}");
        let rates = dataset.imu[500].motion.mean_rates(0.03);
        let off = rates.angular_rate_radps.to_array()[2] - samples[500][3];
        assert!(off.abs() < 1e-6, "{names} {gyro}: {off} {report}\n{mapping}");
        let off = rates.specific_force_mps2.to_array()[2] - samples[500][6];
        assert!(off.abs() < 1e-3, "{names} {accel}: {off} {report}\n{mapping}");
    }
}

#[test]
fn a_counter_is_no_time_beside_one_and_has_the_rate_of_the_file_or_of_the_flight() {
    for (names, is_count) in [
        ("index,epoch", false),
        ("frame,recorded", false),
        (",t_s", false),
        ("# Update Rate: 33.0Hz\nsample", true),
        ("packet", true),
    ] {
        let row = |k: usize, sample: &[f64]| {
            let motion = motion(sample, 1.0, 1.0);
            if is_count { format!("{k},{motion}") } else { format!("{k},{},{motion}", sample[0]) }
        };
        let (report, mapping, dataset) = flown(&format!("{names},{PLAIN}"), 1.0, row);
        let [first, .., last] = &dataset.imu[..] else { panic!("{names}: {report}") };
        let length_s = last.time - first.time;
        assert!((length_s / 299.94 - 1.0).abs() < 0.01, "{names}: {length_s} {report}\n{mapping}");
        assert_eq!(mapping.contains("unit = \"count\""), is_count, "{names}: {mapping}");
    }
    let at_rest = |k: usize| format!("{k},1e-4,2e-4,{}e-4,0.01,0.02,-9.81\n", k % 7);
    let text = format!("packet,{PLAIN}\n{}", (0..1000).map(at_rest).collect::<String>());
    let (report, ..) = mapped(&[("imu.csv", text)]);
    assert!(report.contains("the counter packet of imu.csv counts rows"), "{report}");
}

#[test]
fn a_quaternion_has_any_length_and_order_also_in_a_file_of_its_own() {
    let quaternion = |sample: &[f64]| {
        let [a, b, c] = [7, 8, 9].map(|column| 0.5 * sample[column].to_radians());
        let ([sa, ca], [sb, cb], [sc, cc]) =
            ([a.sin(), a.cos()], [b.sin(), b.cos()], [c.sin(), c.cos()]);
        let w = ca * cb * cc + sa * sb * sc;
        let x = sa * cb * cc - ca * sb * sc;
        let y = ca * sb * cc + sa * cb * sc;
        [w, x, y, ca * cb * sc - sa * sb * cc]
    };
    for (stem, order, length) in [
        ("q", [0, 1, 2, 3], 1.0),
        ("q", [1, 2, 3, 0], 32_768.0),
        ("att_q", [1, 2, 3, 0], 0.8),
        ("Quat", [0, 1, 2, 3], 1e4),
    ] {
        let parts = |sample: &[f64]| {
            let of = quaternion(sample);
            order.map(|part| format!("{:.6}", length * of[part])).join(",")
        };
        let names = [1, 2, 3, 4].map(|number| format!("{stem}{number}")).join(",");
        let row = |_: usize, sample: &[f64]| {
            format!("{},{},{}", sample[0], motion(sample, 1.0, 1.0), parts(sample))
        };
        let together = flown(&format!("t_s,{PLAIN},{names}"), 1.0, row);
        let table = |names: &str, row: &dyn Fn(&[f64]) -> String| {
            let rows = rows("imu.csv");
            let rows = rows.iter().map(|sample| format!("{},{}\n", sample[0], row(sample)));
            format!("t_s,{names}\n{}", rows.collect::<String>())
        };
        let apart = mapped(&[
            ("imu.csv", table(PLAIN, &|sample| motion(sample, 1.0, 1.0))),
            ("attitude.csv", table(&names, &parts)),
        ]);
        for (report, mapping, dataset) in [together, apart] {
            let attitude = dataset.imu[500].attitude;
            let yaw_deg = attitude.map_or(f64::NAN, |attitude| attitude.yaw_rad.to_degrees());
            let off_deg = (yaw_deg - rows("imu.csv")[500][9]).abs();
            assert!(off_deg < 0.1, "{stem} {order:?}: {off_deg} {report}\n{mapping}");
        }
    }
}

#[test]
fn counts_of_a_gyro_are_read_by_the_flight_and_those_that_fit_alike_are_named() {
    let mut asked = 0;
    for counts in [16.4, 131.0] {
        let row = |_: usize, sample: &[f64]| {
            let gyro = |axis: usize| (sample[axis].to_degrees() * counts).round();
            let accel = |axis: usize| (sample[axis] / 9.80665 * 4096.0).round();
            let all = [gyro(1), gyro(2), gyro(3), accel(4), accel(5), accel(6)];
            format!("{},{}", sample[0], all.map(|value| value.to_string()).join(","))
        };
        let (report, mapping, dataset) = flown("t_s,gx,gy,gz,ax,ay,az", 1.0, row);
        let original = rows("imu.csv");
        let norm = |of: &[f64]| of.iter().map(|x| x * x).sum::<f64>().sqrt();
        let read = |sample: &hovernav::imu::ImuSample| {
            sample.motion.mean_rates(0.03).angular_rate_radps.norm()
        };
        let ratio = dataset.imu.iter().map(read).sum::<f64>()
            / original.iter().map(|sample| norm(&sample[1..4])).sum::<f64>();
        // A calm hover does not tell all scales apart: those that it does not are named.
        let counts = format!("counts, {counts} per deg/s");
        let is_right = (0.97..1.03).contains(&ratio);
        assert!(is_right || report.contains(&counts), "{counts}: {ratio} {report}\n{mapping}");
        assert!(!report.contains("cdeg/s") && !report.contains("mrad/s"), "{report}");
        asked += usize::from(report.contains("check: gyro"));
    }
    assert!(asked > 0);
}
