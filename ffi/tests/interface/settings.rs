//! The structures of C mirror those of the core completely, field by field.

use hovernav::autopilot::{Gains as CoreGains, HoverConfig};
use hovernav::ekf::{EstimatorConfig, Mechanisms, VehicleKind};
use hovernav::frames::Vector;
use hovernav::health::HealthLimits;
use hovernav::imu::NotchConfig;
use hovernav_c::settings::{
    Alignment, AntennaHeadingModel, AttitudeModel, AutopilotConfig, BaroModel, Config, GateModel,
    GpsModel, ImuModel, MagnetometerModel, Notch, RangeModel,
};
use hovernav_design::hover::HoverDesign;
use hovernav_model::shipped;
use serde_json::{Value, to_value};

/// Numbers in a value, at any depth.
fn numbers(value: &Value) -> usize {
    match value {
        Value::Array(values) => values.iter().map(numbers).sum(),
        Value::Object(fields) => fields.values().map(numbers).sum(),
        _ => 1,
    }
}

/// A C structure with only doubles.
fn doubles<T>() -> usize {
    size_of::<T>() / size_of::<f64>()
}

#[test]
fn no_setting_of_the_filter_is_missing() {
    let all = EstimatorConfig::default();
    let ekf = all.ekf;
    let pairs = [
        ("imu", numbers(&to_value(ekf.imu).unwrap()), doubles::<ImuModel>()),
        ("gps", numbers(&to_value(ekf.gps).unwrap()), doubles::<GpsModel>()),
        ("attitude", numbers(&to_value(ekf.attitude).unwrap()), doubles::<AttitudeModel>()),
        (
            "magnetometer",
            numbers(&to_value(ekf.magnetometer).unwrap()),
            doubles::<MagnetometerModel>(),
        ),
        ("baro", numbers(&to_value(ekf.baro).unwrap()), doubles::<BaroModel>()),
        ("gate", numbers(&to_value(ekf.gate).unwrap()), doubles::<GateModel>()),
        ("range", numbers(&to_value(all.rangefinder.model).unwrap()), doubles::<RangeModel>()),
        (
            "antenna heading",
            numbers(&to_value(all.antenna_heading).unwrap()),
            doubles::<AntennaHeadingModel>(),
        ),
        ("notch", numbers(&to_value(NotchConfig::default()).unwrap()), doubles::<Notch>()),
        // The two declinations are not read from files.
        (
            "alignment",
            numbers(&to_value(EstimatorConfig::default().alignment).unwrap()) + 2,
            doubles::<Alignment>(),
        ),
    ];
    for (name, core, c) in pairs {
        assert_eq!(core, c, "{name}: the core has {core} settings, ffi/src/settings {c}");
    }
}

#[test]
fn no_setting_of_the_autopilot_is_missing() {
    let core = HoverConfig::new(0.03, CoreGains::default());
    assert_eq!(numbers(&to_value(core).unwrap()), doubles::<AutopilotConfig>());
}

#[test]
fn a_configuration_survives_the_way_to_c_and_back() {
    let mut config = EstimatorConfig::default();
    config.ekf.imu.gap_s = 0.125;
    config.ekf.gps.delay_sigma_s = 0.0625;
    config.alignment.declination_rad = 0.01;
    config.aiding.baro = false;
    config.aiding.second_antenna = false;
    config.ekf.mechanisms = Mechanisms { rest: false, clipping: false, ..Mechanisms::ALL };
    config.vehicle_kind = Some(VehicleKind::Boat);
    config.alignment.baseline_m = Some(Vector::new(0.0, 0.75, 0.0));
    config.rangefinder.lever_arm_m = Vector::new(0.1, 0.0, 0.25);
    config.rangefinder.model.most_m = 40.0;
    config.antenna_heading.floor_rad = 0.01;
    let mut health = HealthLimits::default();
    health.age_s = 0.5;
    let mut notch = NotchConfig::at_hz(23.5).with_width_hz(3.0).with_harmonics(4);
    notch.least_hz = 5.0;
    let back = Config::of(&config, Some(notch), &health).checked().unwrap();
    assert_eq!(back.estimator, config);
    assert_eq!(back.notch, Some(notch));
    assert_eq!(Config::of(&config, None, &health).checked().unwrap().notch, None);
    assert_eq!(back.health, health);

    let mut wrong = Config::of(&config, None, &health);
    wrong.mechanisms.wheels = 2;
    let fault = wrong.checked().unwrap_err();
    let what: String = fault.what.iter().map(|&byte| char::from(byte.to_ne_bytes()[0])).collect();
    assert_eq!((what.trim_end_matches('\0'), fault.found), ("mechanisms.wheels", 2.0));

    let gains = HoverDesign::default().synthesise(&shipped::raptor60()).unwrap();
    let mut hover = HoverConfig::new(0.0303, gains);
    hover.trim.roll_rad = 0.05;
    hover.limits.lowest.pedal = -0.5;
    hover.transfer.descent_mps = 0.25;
    assert_eq!(AutopilotConfig::of(&hover).core(), hover);
}
