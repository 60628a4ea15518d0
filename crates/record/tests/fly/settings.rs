//! `fly` rejects every number with which a flight is dangerous. Each numeric key of its configuration and of the
//! autopilot's file is tested with each extreme value.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use hovernav::autopilot::{Gains, HoverConfig};
use hovernav::ekf::EstimatorConfig;
use hovernav_record::{FlyConfig, MavlinkConfig, write_autopilot};
use toml::{Table, Value};

/// Values that no sensor, filter or vehicle has, except for an occasional 0.
const EXTREMES: [f64; 8] =
    [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -1.0, 1e300, -1e300, 1e-300];
/// Extreme integers, for the same purpose.
const WHOLE_EXTREMES: [i64; 4] = [0, -1, i64::MAX, i64::MIN];

/// Keys that neither example contains.
const REST: &str = "
    [dmu]
    latency_s = 0.01
    [receiver]
    geoid_separation_m = 8.0
    [servo.capture.gpio]
    chip = '/dev/gpiochip0'
    lines = { throttle = 4, collective = 5, longitudinal = 6, lateral = 12, pedal = 13 }
    aux = 7
    [servo.channels.lateral]
    failsafe_ms = 1.5
    [servo.swashplate]
    kind = 'ccpm120'
    [autopilot]
    pilot = 'steer'
    [autopilot.excitation]
    inputs = [
        { stick = 'pedal', kind = '3211', amplitude = 0.12, length_s = 0.5, times = 3 },
        { stick = 'lateral', kind = 'sweep', length_s = 60.0, first_hz = 0.1, last_hz = 3.0 },
    ]
    [navigation.imu]
    rate_hz = 33.0
    angle_random_walk_deg_per_sqrt_h = 1.7
    velocity_random_walk_mps_per_sqrt_h = 3.0
    gyro_bias_sigma_degps = 0.3
    accel_bias_sigma_mps2 = 0.05
    magnetic_declination_deg = 0.3
    mounting_deg = [0.0, 0.0, 0.0]
    notch = { frequency_hz = 12.0, width_hz = 4.0, harmonics = 1, least_hz = 6.0 }
    [navigation.gps]
    rate_hz = 1.0
    [navigation.second_antenna]
    lever_arm_m = [0.5, 0.0, 0.0]
";

fn table(text: &str) -> Table {
    text.parse().unwrap()
}

fn text(value: &Value) -> String {
    toml::to_string(value).unwrap()
}

/// `base` with the keys of `over`, which replace those of `base`.
fn merge(base: &mut Table, over: Table) {
    for (key, value) in over {
        match (base.get_mut(&key), value) {
            (Some(Value::Table(base)), Value::Table(over)) => merge(base, over),
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
}

/// An example, extended by every key that it does not contain.
fn whole(example: &str) -> Table {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    let mut fly = table(&std::fs::read_to_string(directory.join(example)).unwrap());
    let spelled = FlyConfig::parse(&text(&Value::Table(fly.clone())), example.as_ref()).unwrap();
    let mut every = table(&spelled.to_toml().unwrap());
    merge(&mut every, fly.clone());
    merge(&mut every, table(REST));
    fly = every;
    // Only one source of the pilot's pulses is permitted.
    let both = fly["servo"]["capture"].as_table_mut().unwrap();
    both.remove("serial");
    let defaults = EstimatorConfig::default();
    let value = |value: Result<Value, toml::ser::Error>| value.unwrap();
    let mut navigation = Table::new();
    navigation.insert("alignment".into(), value(Value::try_from(defaults.alignment)));
    let ekf = defaults.ekf;
    let filter = [
        ("imu", Value::try_from(ekf.imu)),
        ("gps", Value::try_from(ekf.gps)),
        ("attitude", Value::try_from(ekf.attitude)),
        ("magnetometer", Value::try_from(ekf.magnetometer)),
        ("baro", Value::try_from(ekf.baro)),
        ("gate", Value::try_from(ekf.gate)),
    ];
    let filter: Table = filter.into_iter().map(|(name, own)| (name.into(), value(own))).collect();
    navigation.insert("filter".into(), Value::Table(filter));
    let model = |name: &str, own| {
        (name.to_owned(), Value::Table([("model".into(), own)].into_iter().collect()))
    };
    let range = value(Value::try_from(defaults.rangefinder.model));
    let (name, mut section) = model("rangefinder", range);
    merge(section.as_table_mut().unwrap(), table("lever_arm_m = [0, 0, 0]\nbeam = [0, 0.1, 1]"));
    navigation.insert(name, section);
    let (name, section) = model("second_antenna", value(Value::try_from(defaults.antenna_heading)));
    navigation.insert(name, section);
    let mut rest = Table::new();
    rest.insert("navigation".into(), Value::Table(navigation));
    let speaker = value(Value::try_from(MavlinkConfig::default()));
    let speaks: Table = [("speaker".to_owned(), speaker)].into_iter().collect();
    if fly.contains_key("mavlink") {
        rest.insert("mavlink".into(), Value::Table(speaks));
    }
    let mut autopilot =
        table("file = 'autopilot.toml'\ngeofence = { radius_m = 60, height_m = 100 }");
    if let Some(own) = fly.get("autopilot").and_then(Value::as_table) {
        let mut own = own.clone();
        own.remove("model");
        merge(&mut own, autopilot);
        autopilot = own;
    }
    fly.insert("autopilot".into(), Value::Table(autopilot));
    merge(&mut fly, rest);
    // Written out in full, including the autopilot's keys.
    let spelled = FlyConfig::parse(&text(&Value::Table(fly.clone())), example.as_ref()).unwrap();
    table(&spelled.to_toml().unwrap())
}

fn spelled(value: &Value) -> String {
    match value {
        Value::Float(number) => format!("{number:?}"),
        other => other.to_string(),
    }
}

/// Path of every number in `value`.
fn numbers(value: &Value, at: &mut Vec<String>, found: &mut Vec<Vec<String>>) {
    let mut below = |key: String, value: &Value| {
        at.push(key);
        numbers(value, at, found);
        at.pop();
    };
    match value {
        Value::Float(_) | Value::Integer(_) => found.push(at.clone()),
        Value::Table(table) => table.iter().for_each(|(key, value)| below(key.clone(), value)),
        Value::Array(values) => {
            values.iter().enumerate().for_each(|(index, value)| below(index.to_string(), value));
        }
        _ => {}
    }
}

fn place<'a>(value: &'a mut Value, path: &[String]) -> &'a mut Value {
    path.iter().fold(value, |value, key| match value {
        Value::Array(values) => &mut values[key.parse::<usize>().unwrap()],
        table => &mut table[key.as_str()],
    })
}

/// Tests every number of `whole` with every extreme value. Returns the number of tests, the values that `flies`
/// accepted, by key, and refusals that do not name the key or the found value.
fn sweep(
    whole: Table,
    flies: impl Fn(&str) -> Result<(), String>,
) -> (usize, BTreeMap<String, BTreeSet<String>>, Vec<String>) {
    let mut whole = Value::Table(whole);
    flies(&text(&whole)).unwrap();
    let mut paths = Vec::new();
    numbers(&whole, &mut Vec::new(), &mut paths);
    let (mut tried, mut taken, mut unclear) = (0, BTreeMap::<_, BTreeSet<_>>::new(), Vec::new());
    for path in &paths {
        let good = place(&mut whole, path).clone();
        let key = path.join(".");
        // The first elements represent a long array.
        if path.iter().any(|key| key.parse::<usize>().is_ok_and(|index| index > 2)) {
            continue;
        }
        let mut keys = path.iter().rev().filter(|key| key.parse::<usize>().is_err());
        let names = [keys.next().unwrap(), keys.next().unwrap_or(&path[0])];
        let extremes = EXTREMES.map(Value::Float).into_iter();
        for extreme in extremes.chain(WHOLE_EXTREMES.map(Value::Integer)) {
            *place(&mut whole, path) = extreme.clone();
            tried += 1;
            match flies(&text(&whole)) {
                Ok(()) => {
                    // One element represents an array.
                    let key = path.iter().filter(|key| key.parse::<usize>().is_err());
                    let key = key.map(String::as_str).collect::<Vec<_>>().join(".");
                    let taken = taken.entry(key).or_default();
                    taken.insert(spelled(&extreme).trim_end_matches(".0").to_owned());
                }
                // An error about the wrong kind of value has a line instead of a key.
                Err(why)
                    if (names.iter().any(|name| why.contains(name.as_str()))
                        || why.starts_with("fly.toml:"))
                        && why.contains("expected") => {}
                Err(why) => unclear.push(format!("{key} = {}: {why}", spelled(&extreme))),
            }
        }
        *place(&mut whole, path) = good;
    }
    (tried, taken, unclear)
}

fn autopilot(directory: &Path) -> Table {
    let path = directory.join("autopilot.toml");
    let config = HoverConfig::new(1.0 / 33.0, gains());
    write_autopilot(&config, &path, "").unwrap();
    table(&std::fs::read_to_string(path).unwrap())
}

fn gains() -> Gains {
    let mut gains = Gains::default();
    gains.heave.tracking_time_s = 1.0;
    gains
}

/// All checks of `fly` before the first byte is read.
fn accepted(text: &str, directory: &Path) -> Result<(), String> {
    let words = |error: hovernav_record::FlyConfigError| error.to_string();
    let mut config = FlyConfig::parse(text, "fly.toml".as_ref()).map_err(words)?;
    config.settle(1_770_000_000).map_err(words)?;
    config.load_autopilot(directory).map_err(words)
}

/// Accepted extreme values, with the reason why they are harmless.
const HARMLESS: [(&str, &[&str], &[&str]); 9] = [
    (
        "a position on a vehicle or on Earth, or an angle of the compass",
        &["0", "-1", "1e-300"],
        &[
            "navigation.gps.antenna_lever_arm_m",
            "navigation.imu.lever_arm_m",
            "navigation.imu.magnetic_declination_deg",
            "navigation.imu.mounting_deg",
            "navigation.rangefinder.beam",
            "navigation.rangefinder.lever_arm_m",
            "navigation.second_antenna.lever_arm_m",
            "receiver.geoid_separation_m",
            "servo.swashplate.phase_deg",
            "site.height_m",
            "site.latitude_deg",
            "site.longitude_deg",
        ],
    ),
    (
        "a waiting time of zero",
        &["0", "1e-300"],
        &[
            "autopilot.failsafe.pilot_lost_hold_s",
            "dmu.latency_s",
            "navigation.gps.latency_s",
            "servo.hold_s",
        ],
    ),
    (
        "every sample is used, or propagated separately",
        &["0", "1e-300"],
        &[
            "navigation.filter.attitude.interval_s",
            "navigation.filter.imu.accel_vibration_time_s",
            "navigation.filter.imu.covariance_interval_s",
            "navigation.filter.magnetometer.interval_s",
            "navigation.second_antenna.model.interval_s",
        ],
    ),
    (
        "an error source that is absent, while others have a minimum",
        &["0", "1e-300"],
        &[
            "navigation.filter.gps.delay_sigma_s",
            "navigation.filter.gps.learning_rate",
            "navigation.filter.gps.position_latency_sigma_s",
            "navigation.filter.gps.position_wander_share",
            "navigation.filter.gps.velocity_smoothing_s",
            "navigation.filter.gps.velocity_wander_share",
            "navigation.filter.imu.accel_vibration_share",
            "navigation.filter.imu.gyro_vibration_share",
            "navigation.filter.imu.net_turn_error_share",
            "navigation.filter.imu.turn_error_share",
            "navigation.rangefinder.model.noise_share",
            "navigation.second_antenna.model.wander_share",
        ],
    ),
    (
        "a limit that is absent, or that permits everything",
        &["0", "1e-300"],
        &[
            "autopilot.switch.hysteresis_ms",
            "navigation.imu.notch.least_hz",
            "navigation.rangefinder.model.least_m",
            "navigation.rangefinder.model.least_quality",
            "servo.signal.failsafe_throttle_ms",
        ],
    ),
    (
        "accuracy of a reference for scores, which no flight has",
        &["0", "1e-300"],
        &[
            "navigation.reference.attitude_sigma_deg",
            "navigation.reference.position_sigma_m",
            "navigation.reference.skip_s",
            "navigation.reference.velocity_sigma_mps",
        ],
    ),
    (
        "a test input without amplitude",
        &["0", "1e-300"],
        &["autopilot.excitation.inputs.amplitude"],
    ),
    (
        "0 has a special meaning: never, unknown, unchanged, the first",
        &["0"],
        &[
            "mavlink.speaker.rates.attitude_hz",
            "mavlink.speaker.rates.estimator_status_hz",
            "mavlink.speaker.rates.global_position_hz",
            "mavlink.speaker.rates.gps_raw_hz",
            "mavlink.speaker.rates.heartbeat_hz",
            "mavlink.speaker.rates.highres_imu_hz",
            "mavlink.speaker.rates.local_position_hz",
            "mavlink.speaker.rates.servo_output_hz",
            "navigation.filter.imu.accel_range_mps2",
            "navigation.filter.imu.gyro_range_radps",
            "navigation.imu.notch.frequency_hz",
            "receiver.limits.min_satellites",
            "receiver.rate_hz",
            "servo.capture.gpio.aux",
            "servo.capture.gpio.lines.collective",
            "servo.capture.gpio.lines.lateral",
            "servo.capture.gpio.lines.longitudinal",
            "servo.capture.gpio.lines.pedal",
            "servo.capture.gpio.lines.throttle",
            "servo.output.collective.chip",
            "servo.output.collective.output",
            "servo.output.lateral.chip",
            "servo.output.lateral.output",
            "servo.output.longitudinal.chip",
            "servo.output.longitudinal.output",
            "servo.output.pedal.chip",
            "servo.output.pedal.output",
            "servo.output.throttle.chip",
            "servo.output.throttle.output",
        ],
    ),
    (
        "the opposite direction, or the end of the range",
        &["-1"],
        &[
            "autopilot.steering.signs.collective",
            "autopilot.steering.signs.lateral",
            "autopilot.steering.signs.longitudinal",
            "autopilot.steering.signs.pedal",
            "servo.swashplate.collective",
            "servo.swashplate.lateral",
            "servo.swashplate.longitudinal",
            "servo.swashplate.lowest_collective",
        ],
    ),
];

fn harmless(key: &str, value: &str) -> bool {
    HARMLESS.iter().any(|(_, values, keys)| values.contains(&value) && keys.contains(&key))
}

/// Accepted values in `taken` that are not listed as harmless.
fn dangerous(
    taken: BTreeMap<String, BTreeSet<String>>,
    listed: impl Fn(&str, &str) -> bool,
) -> Vec<String> {
    let all = taken.iter().flat_map(|(key, values)| values.iter().map(move |value| (key, value)));
    all.filter(|(key, value)| !listed(key, value))
        .map(|(key, value)| format!("{key} = {value}"))
        .collect()
}

#[test]
fn no_extreme_number_of_a_flights_configuration_is_flown_with() {
    let directory = tempfile::tempdir().unwrap();
    autopilot(directory.path());
    for example in ["fly.toml", "loop.toml"] {
        let (tried, taken, unclear) =
            sweep(whole(example), |text| accepted(text, directory.path()));
        assert!(tried > 2000, "{example}: {tried}");
        assert_eq!(dangerous(taken, harmless), [""; 0], "{example}: of {tried}");
        assert_eq!(unclear, [""; 0], "{example}");
    }
}

#[test]
fn no_extreme_number_of_an_autopilots_file_is_flown_with() {
    let directory = tempfile::tempdir().unwrap();
    let good = autopilot(directory.path());
    let fly = text(&Value::Table(whole("loop.toml")));
    let (tried, taken, unclear) = sweep(good, |text| {
        std::fs::write(directory.path().join("autopilot.toml"), text).unwrap();
        accepted(&fly, directory.path())
    });
    assert!(tried > 1000, "{tried}");
    let plain = [
        "health.recovery_s",
        "transfer.patience_s",
        "trim.pitch_rad",
        "trim.roll_rad",
        "trim.sticks.collective",
        "trim.sticks.lateral",
        "trim.sticks.longitudinal",
        "trim.sticks.pedal",
    ];
    // Accepted here: the check of the gains with the vehicle's model tests gains of 0 and gains of 1 with the opposite
    // sign.
    let gain = |key: &str, value: &str| {
        (key.starts_with("gains.") && ["0", "-1", "1e-300"].contains(&value))
            || (plain.contains(&key) && ["0", "1e-300"].contains(&value))
            || (key.starts_with("limits.lowest.") && value == "-1")
    };
    assert_eq!(dangerous(taken, gain), [""; 0], "of {tried}");
    assert_eq!(unclear, [""; 0]);
}
