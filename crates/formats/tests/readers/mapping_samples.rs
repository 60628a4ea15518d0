//! Inertial samples of foreign text: named increments, impossible fields.

use approx::assert_abs_diff_eq;
use hovernav::imu::Motion;

use crate::mapped::mapped;

/// A log of 20 s at rest at 100 Hz. Each row has the time, then the text of `row`.
fn at_rest(names: &str, row: impl Fn(u32) -> String) -> String {
    let rows = (0..2000).map(|k| format!("{:.2},{}\n", f64::from(k) * 0.01, row(k)));
    format!("t_s,{names}\n{}", rows.collect::<String>())
}

#[test]
fn columns_called_dth_and_dv_are_increments() {
    let text = at_rest("dth_x,dth_y,dth_z,dv_x,dv_y,dv_z", |k| {
        format!("{:.6},0.00001,-0.00002,0.0004,0.0002,-0.0981", 1e-6 * f64::from(k % 7))
    });
    let (report, mapping, dataset) = mapped(&[("imu.csv", text)]);
    assert_eq!(dataset.imu.len(), 2000, "{report}\n{mapping}");
    let Motion::Increments { angle_rad, velocity_mps } = dataset.imu[10].motion else {
        panic!("{report}\n{mapping}")
    };
    let (angle_rad, velocity_mps) = (angle_rad.to_array(), velocity_mps.to_array());
    assert_abs_diff_eq!(angle_rad[2], -2e-5, epsilon = 1e-12);
    assert_abs_diff_eq!(velocity_mps[2], -0.0981, epsilon = 1e-12);
}

#[test]
fn an_impossible_field_is_rejected_with_count_and_first_line() {
    let names = "gyro_x_radps,gyro_y_radps,gyro_z_radps,accel_x_mps2,accel_y_mps2,accel_z_mps2,\
                 mag_x_gauss,mag_y_gauss,mag_z_gauss";
    let text = at_rest(names, |k| {
        let north = if (100..103).contains(&k) { 3000.0 } else { 0.2 + 1e-3 * f64::from(k % 5) };
        format!("{:.6},0.0,0.0,0.0,0.1,-9.81,{north:.3},0.0,0.4", 1e-4 * f64::from(k % 7))
    });
    let (report, _, dataset) = mapped(&[("imu.csv", text)]);
    let fields = dataset.imu.iter().filter(|sample| sample.magnetic_field_gauss.is_some()).count();
    assert!((dataset.imu.len(), fields) == (2000, 1997), "{fields}\n{report}");
    let told = "3 rows, the first at line 102, magnetic field rejected: over 100 gauss";
    assert!(
        dataset.warnings.iter().any(|warning| warning.contains(told)),
        "{:?}",
        dataset.warnings
    );
}
