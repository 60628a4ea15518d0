//! Units of gyros and accelerometers: by name, and by size where no name states them.

use hovernav_dataset::Dataset;

use crate::mapped::mapped;

/// Highest rate of the flight that [`flight`] writes, deg/s.
const HIGH_DEGPS: f64 = 60.0;

/// A minute of rolling by up to 60 deg/s, with the rate times `rate` and gravity times `force`, in columns called by
/// `names`.
fn flight(names: &str, rate: f64, force: f64) -> (String, Dataset) {
    let row = |k: u32| {
        let time_s = 0.02 * f64::from(k);
        let roll_degps = HIGH_DEGPS * (3.0 * time_s).sin();
        let (noise, down) = (1e-3 * f64::from(k % 7), -9.80665 * force);
        format!("{time_s:.2},{:.4},{:.4},0,{noise},0,{down:.5}\n", rate * roll_degps, rate * noise)
    };
    let rows: String = (0..3000).map(row).collect();
    let (report, _, dataset) = mapped(&[("imu.csv", format!("time_s,{names}\n{rows}"))]);
    (report, dataset)
}

fn high_degps(dataset: &Dataset) -> f64 {
    let rate = |sample: &hovernav::imu::ImuSample| {
        sample.motion.mean_rates(0.02).angular_rate_radps.norm().to_degrees()
    };
    dataset.imu.iter().map(rate).fold(0.0, f64::max)
}

#[test]
fn the_units_of_names_are_read() {
    for (unit, rate) in [
        ("deg/h", 3600.0),
        ("°/h", 3600.0),
        ("deg/hr", 3600.0),
        ("rpm", 1.0 / 6.0),
        ("0.01 deg/s", 100.0),
        ("cdeg/s", 100.0),
        ("°/s", 1.0),
        ("mdps", 1e3),
    ] {
        let names = format!("gyro_x [{unit}],gyro_y [{unit}],gyro_z [{unit}],acc_x,acc_y,acc_z");
        let (report, dataset) = flight(&names, rate, 1.0);
        let high = high_degps(&dataset);
        assert!((high - HIGH_DEGPS).abs() < 0.1, "{unit}: {high} {report}");
        assert!(!report.contains("gyro: rates reach"), "{unit}: {report}");
    }
    for unit in ["ft/s²", "ft/s^2", "ft/s2", "fps2", ""] {
        let names = format!("gyro_x,gyro_y,gyro_z,acc_x ({unit}),acc_y ({unit}),acc_z ({unit})");
        let (report, dataset) = flight(&names, 1.0, 1.0 / 0.3048);
        let down = dataset.imu[9].motion.mean_rates(0.02).specific_force_mps2.z();
        assert!((down + 9.80665).abs() < 1e-3, "{unit}: {down} {report}");
    }
}

#[test]
fn a_rate_whose_size_alone_decides_names_every_possible_unit() {
    let names = "gyro_x,gyro_y,gyro_z,acc_x,acc_y,acc_z";
    let (report, _) = flight(names, 100.0, 1.0);
    for words in ["gyro: rates reach", "read as mdeg/s (6.00", "cdeg/s (59.9", "mrad/s (34"] {
        assert!(report.contains(words), "{words}: {report}");
    }
    let (report, _) = flight(names, 1.0, 1.0);
    for words in ["read as deg/s (59.9", "mrad/s (3.44"] {
        assert!(report.contains(words), "{words}: {report}");
    }
}
