//! Settings of the autopilot: numbers within range are read back unchanged, in double and in single precision.

use hovernav::autopilot::*;

use crate::autopilot::config;

#[test]
fn every_gain_that_is_no_number_is_refused_by_name() {
    let with = |change: fn(&mut HoverConfig)| {
        let mut config = config();
        change(&mut config);
        HoverAutopilot::new(config).map(|_| ()).unwrap_err()
    };
    let refused = with(|c| c.gains.roll_pitch.measured[1][3] = f64::NAN);
    assert_eq!(refused.what, "gains.roll_pitch");
    assert!(refused.to_string().contains("found NaN, expected a finite number"), "{refused}");
    assert_eq!(with(|c| c.gains.heave.proportional = f64::INFINITY).what, "gains.heave");
    assert_eq!(with(|c| c.gains.yaw.integral_per_s[0][1] = f64::NAN).what, "gains.yaw");
    assert_eq!(with(|c| c.limits.rate_per_s.pedal = 0.0).what, "limits.rate_per_s");
    assert_eq!(with(|c| c.period_s = 0.0).what, "period_s");
    assert_eq!(with(|c| c.guidance.speed_mps = 1e3).what, "guidance.speed_mps");
}

#[test]
fn the_configuration_survives_toml() {
    let config = config();
    let text = toml::to_string(&config).unwrap();
    let back: HoverConfig = toml::from_str(&text).unwrap();
    assert_eq!(config, back);
}

#[test]
fn limits_in_single_precision_are_those_that_were_written() {
    // These limits are not exact in single precision; two of their nearest numbers exceed the allowed range.
    let mut config = config();
    config.guidance.speed_mps = 2.3;
    config.transfer.fade_s = 0.01;
    config.health.dead_reckoning_s = 0.1;
    let mut autopilot = HoverAutopilot::new(config.cast::<f32>()).unwrap();
    let forward = |forward_mps| SetPoint::Velocity {
        forward_mps,
        right_mps: 0.0,
        down_mps: 0.0,
        yaw_rate_radps: 0.0,
    };
    assert_eq!(autopilot.set(forward(2.3)), Ok(()));
    assert_eq!(autopilot.set(forward(2.301)), Err(SetPointError::TooFast));
    // A value beyond the range of single precision is rejected.
    config.gains.heave.proportional = 1e300;
    assert_eq!(HoverAutopilot::new(config.cast::<f32>()).unwrap_err().what, "gains.heave");
    assert!(HoverAutopilot::new(config).is_ok());
}
