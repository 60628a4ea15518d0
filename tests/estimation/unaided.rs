//! A flight plan with an IMU at 50 Hz, without attitude, magnetic field or vibration.

use hovernav::ekf::layout::Layout;
use hovernav::ekf::{Estimator, EstimatorConfig, VehicleKind};
use hovernav_sim::{DmuConfig, FlightPlan, GpsConfig, Recording, fly};

/// Recorded sensor data, and an estimator with the sensor mounting but no data yet.
pub fn flown_unaided<L: Layout<N>, const N: usize>(
    plan: &FlightPlan,
    gps: &GpsConfig,
    seed: u64,
) -> (Recording, Box<Estimator<L, N>>) {
    driven_unaided(plan, gps, seed, None)
}

/// [`flown_unaided`] with a vehicle of the declared `kind`.
pub fn driven_unaided<L: Layout<N>, const N: usize>(
    plan: &FlightPlan,
    gps: &GpsConfig,
    seed: u64,
    kind: Option<VehicleKind>,
) -> (Recording, Box<Estimator<L, N>>) {
    let dmu = DmuConfig {
        rate_hz: 50.0,
        attitude: None,
        magnetometer: None,
        vibration: Vec::new(),
        ..DmuConfig::default()
    };
    let recording = fly(&plan.build().unwrap(), &dmu, gps, seed).unwrap();
    let mut config = EstimatorConfig::default();
    config.vehicle_kind = kind;
    config.mounting.imu_lever_arm_m = dmu.lever_arm_m;
    config.mounting.antenna_lever_arm_m = gps.lever_arm_m;
    (recording, Box::new(Estimator::with_layout(config)))
}
