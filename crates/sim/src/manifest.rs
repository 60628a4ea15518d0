//! Manifest of simulated sensors.

use hovernav::earth::STANDARD_GRAVITY_MPS2;
use hovernav_dataset::Manifest;

use super::dmu::DmuConfig;
use super::gps::GpsConfig;

/// The manifest of a dataset recorded by `dmu` and `gps` on `vehicle`, a description in words.
#[must_use]
pub fn sensor_manifest(vehicle: String, dmu: &DmuConfig, gps: &GpsConfig) -> Manifest {
    let mut manifest = Manifest {
        name: "simulated".into(),
        vehicle,
        kind: "simulated".into(),
        time: "seconds, one clock for all files".into(),
        ..Manifest::default()
    };
    let imu = &mut manifest.imu;
    imu.rate_hz = Some(dmu.rate_hz);
    imu.lever_arm_m = dmu.lever_arm_m;
    imu.angle_random_walk_deg_per_sqrt_h = Some(dmu.gyro.angle_random_walk_deg_per_sqrt_h);
    imu.velocity_random_walk_mps_per_sqrt_h =
        Some(dmu.accelerometer.velocity_random_walk_mps_per_sqrt_h);
    imu.gyro_bias_sigma_degps = Some(dmu.gyro.turn_on_bias_sigma_degps);
    imu.accel_bias_sigma_mps2 = Some(dmu.accelerometer.turn_on_bias_sigma_mps2);
    imu.gyro_range_degps = Some(dmu.gyro.range_degps);
    imu.accel_range_g = Some(dmu.accelerometer.range_mps2 / STANDARD_GRAVITY_MPS2);
    // Rounded to whole degrees, as on a chart.
    let declination_deg = dmu.magnetometer.map_or(0.0, |field| field.declination_deg().round());
    imu.magnetic_declination_deg = Some(declination_deg);
    manifest.gps.rate_hz = Some(gps.rate_hz);
    manifest.gps.antenna_lever_arm_m = gps.lever_arm_m;
    manifest.gps.latency_s = gps.assumed_latency_s;
    manifest
}
