//! Configurations that `fly` rejects, each with its key, found and expected values, in plain words.

use approx::assert_abs_diff_eq;
use hovernav::autopilot::{Gains, HoverConfig, StickLimits, Trim};
use hovernav::controls::Sticks;
use hovernav_record::{FlyConfig, write_autopilot};

const SENSORS: &str = "[dmu]\nport = 'a'\n[receiver]\nport = 'b'\n";
const AUTOPILOT: &str =
    "[servo.capture]\nserial = { port = 'c' }\n[autopilot]\nfile = 'autopilot.toml'\n";

/// An autopilot with collective in hover.
fn hover() -> HoverConfig {
    let mut gains = Gains::default();
    gains.heave.tracking_time_s = 1.0;
    let sticks = Sticks { collective: 0.3, ..Sticks::NEUTRAL };
    HoverConfig::new(1.0 / 33.0, gains).with_trim(Trim { sticks, ..Trim::default() })
}

/// Result of loading sensors, autopilot and `text`, with the autopilot's file `hover`.
fn loaded(text: &str, hover: &HoverConfig) -> Result<FlyConfig, String> {
    let directory = tempfile::tempdir().unwrap();
    write_autopilot(hover, &directory.path().join("autopilot.toml"), "").unwrap();
    let text = format!("{SENSORS}{AUTOPILOT}{text}");
    let words = |error: hovernav_record::FlyConfigError| error.to_string();
    let mut config = FlyConfig::parse(&text, "fly.toml".as_ref()).map_err(words)?;
    config.load_autopilot(directory.path()).map_err(words)?;
    Ok(config)
}

fn refused(text: &str) -> String {
    loaded(text, &hover()).err().unwrap_or_else(|| panic!("{text}: it is taken"))
}

#[test]
fn a_servo_that_goes_one_way_only_is_not_for_the_autopilot_to_move() {
    for channel in ["lateral", "longitudinal", "collective", "pedal"] {
        for (trim, end) in [("1.0", "min_ms = 1"), ("2.0", "max_ms = 2"), ("1.02", "min_ms = 1")] {
            let text = format!("[servo.channels.{channel}]\ntrim_ms = {trim}\n");
            let error = refused(&text);
            let key = format!("[servo.channels.{channel}] trim_ms: found ");
            assert!(error.starts_with(&key) && error.contains(end), "{error}");
            assert!(error.contains("expected at least 0.05 ms between them"), "{error}");
            // Without an autopilot such a servo is permitted.
            FlyConfig::parse(&format!("{SENSORS}{text}"), "fly.toml".as_ref()).unwrap();
        }
    }
    loaded("[servo.channels.throttle]\ntrim_ms = 1.0\n", &hover()).unwrap();
}

#[test]
fn a_servo_that_ends_at_hover_trim_is_refused_and_one_that_ends_early_bounds_the_autopilot() {
    let error = refused("[servo.channels.collective]\nmax_ms = 1.65\n");
    let key = "[servo.channels.collective] min_ms, max_ms: found 1 to 1.65 ms";
    assert!(error.starts_with(key) && error.contains("expected 0.01 of full stick"), "{error}");

    let config = loaded("[servo.channels.pedal]\nmax_ms = 1.8\n", &hover()).unwrap();
    let limits = config.autopilot.unwrap().flown.unwrap().limits;
    assert_abs_diff_eq!(limits.highest.pedal, 0.6, epsilon = 1e-9);
    let rest = Sticks { pedal: 1.0, ..limits.highest };
    assert_eq!(
        (rest, limits.lowest),
        (Sticks::from_array([1.0; 4]), Sticks::from_array([-1.0; 4]))
    );

    let error = refused("[servo.swashplate]\nhighest_collective = 0.3\n");
    assert!(
        error.starts_with("[servo.swashplate] highest_collective: found 0.3, expected"),
        "{error}"
    );
    let config = loaded("[servo.swashplate]\nhighest_collective = 0.5\n", &hover()).unwrap();
    assert_eq!(config.autopilot.unwrap().flown.unwrap().limits.highest.collective, 0.5);
}

#[test]
fn mixing_that_does_not_come_to_the_autopilots_limits_about_hover_trim_is_refused() {
    let plate = |gains: &str| format!("[servo.swashplate]\nkind = 'ccpm120'\n{gains}");
    loaded(&plate(""), &hover()).unwrap();
    // Each control alone reaches its limit, but full forward cyclic at hover collective does not.
    let steep = plate("longitudinal = 1.0\n");
    FlyConfig::parse(&format!("{SENSORS}{steep}"), "fly.toml".as_ref()).unwrap();
    let error = refused(&steep);
    for part in
        ["[servo.swashplate] longitudinal: found", "servo longitudinal", "expected 1 to 2 ms"]
    {
        assert!(error.contains(part), "{error}");
    }
    let (lowest, highest) = (Sticks::from_array([-0.5; 4]), Sticks::from_array([0.5; 4]));
    let limits = StickLimits { lowest, highest, ..StickLimits::default() };
    loaded(&steep, &hover().with_limits(limits)).unwrap();
    // A control that does not reach its limit even alone is rejected for pilots too.
    let short = format!("{SENSORS}{}[servo.channels.lateral]\nmax_ms = 1.6\n", plate(""));
    let error = FlyConfig::parse(&short, "fly.toml".as_ref()).unwrap_err().to_string();
    assert!(
        error.contains("[servo] swashplate: lateral: ") && error.contains("expected"),
        "{error}"
    );
}

#[test]
fn a_key_without_an_effect_is_refused() {
    let error = refused("pilot = 'override'\noverride_travel = 0.7\n");
    assert!(error.starts_with("[autopilot] override_travel: found 0.7 with pilot"), "{error}");
    let error = refused("pilot = 'override'\n[autopilot.steering]\nspeed_mps = 1.0\n");
    assert!(error.starts_with("[autopilot] steering: found values with pilot"), "{error}");
    loaded("pilot = 'steer'\n[autopilot.steering]\nspeed_mps = 1.0\n", &hover()).unwrap();
    let config = loaded("pilot = 'steer'\noverride_travel = 0.7\n", &hover()).unwrap();
    assert_eq!(config.autopilot.unwrap().flown.unwrap().transfer.override_travel, 0.7);
    let config = loaded("pilot = 'steer'\n", &hover()).unwrap();
    assert_eq!(config.autopilot.unwrap().flown.unwrap().transfer.override_travel, 0.8);
}

/// A number out of its range gives the same form of sentence for every key.
#[test]
fn every_number_out_of_its_range_is_reported_in_one_form() {
    for (section, key, range) in [
        ("navigation.imu", "gyro_range_degps", "10 to 10000 °/s"),
        ("navigation.imu", "rate_hz", "1 to 10000 Hz"),
        ("navigation.gps", "latency_s", "0 to 2 s"),
        ("navigation.imu.notch", "width_hz", "0.05 to 1000 Hz"),
        ("navigation.filter.gate", "sigmas", "2 to 50 one-sigmas"),
        ("servo.channels.pedal", "trim_ms", "0.5 to 2.5 ms"),
        ("receiver.limits", "max_jump_m", "1 to 10000 m"),
        ("autopilot.ready", "speed_mps", "0.1 to 20 m/s"),
    ] {
        for (number, told) in [
            ("nan", "NaN"),
            ("inf", "inf"),
            ("-1.0", "-1"),
            ("1e300", "1e300"),
            ("-1e-300", "-1e-300"),
        ] {
            let error = refused(&format!("[{section}]\n{key} = {number}\n"));
            let expected = format!("[{section}] {key}: found {told}, expected {range}");
            assert_eq!(error, expected);
        }
    }
    for arm in ["navigation.imu]\nlever_arm_m", "navigation.gps]\nantenna_lever_arm_m"] {
        let error = refused(&format!("[{arm} = [0.0, nan, 0.0]\n"));
        let key = arm.replace(']', "] ").replace('\n', "");
        assert_eq!(error, format!("[{key}: found NaN, expected -20 to 20 m"));
    }
    let error = refused("[navigation.filter.imu]\ngyro_bias_time_s = inf\n");
    assert!(error.contains("found inf, expected 1 to 10000000 s; write 10000000 for"), "{error}");
}

#[test]
fn a_value_of_another_kind_is_reported_in_plain_words() {
    for (text, told) in [
        ("[dmu]\nrate_hz = 'fast'\n", "[dmu] rate_hz: found \"fast\", expected a number"),
        ("[dmu]\nport = 3\n", "[dmu] port: found 3, expected a path in quotes"),
        ("[dmu]\nbaud = 9600.5\n", "[dmu] baud: found 9600.5, expected a whole number from 0 to"),
        ("[dmu]\nmode = 3\n", "[dmu] mode: found 3, expected a name in quotes"),
        ("dmu = 3\n", "dmu: found 3, expected a table"),
        (
            "[navigation.imu]\nlever_arm_m = [0.0, 0.0]\n",
            "[navigation.imu] lever_arm_m: found 2 elements, expected a list of 3",
        ),
        (
            "[navigation.imu]\nlever_arm_m = [0.0, 'x', 0.0]\n",
            "[navigation.imu] lever_arm_m: found \"x\", expected a number",
        ),
        (
            "[navigation.imu]\naccel_is_gravity = 1\n",
            "[navigation.imu] accel_is_gravity: found 1, expected true or false",
        ),
        ("[telemetry]\nport = 'd'\nudp = 3\n", "[telemetry] udp: found 3, expected text in quotes"),
        (
            "[servo.swashplate]\nkind = 'h4'\n",
            "[servo.swashplate] kind: found \"h4\", expected \"h1\", \"ccpm90\", \"ccpm120\"",
        ),
    ] {
        let error = FlyConfig::parse(text, "fly.toml".as_ref()).unwrap_err().to_string();
        assert!(error.starts_with("fly.toml:") && error.contains(told), "{text}: {error}");
    }
}

#[test]
fn angles_of_a_mounting_are_brought_to_their_principal_values() {
    for (found, meant) in [
        ("0, 0, 270", [0.0, 0.0, -90.0]),
        ("-270, 0, 360", [90.0, 0.0, 0.0]),
        ("0, 135, 0", [-180.0, 45.0, -180.0]),
        ("10, 270, 20", [10.0, -90.0, 20.0]),
        ("180, -90, -180", [180.0, -90.0, -180.0]),
    ] {
        let text = format!("{SENSORS}[navigation.imu]\nmounting_deg = [{found}]\n");
        let config = FlyConfig::parse(&text, "fly.toml".as_ref()).unwrap();
        let taken = config.navigation.imu.mounting_deg;
        let turned = |[roll, pitch, yaw]: [f64; 3]| {
            let angles = hovernav::frames::EulerAngles::from_degrees(roll, pitch, yaw);
            hovernav::frames::Rotation::<hovernav::frames::Body, hovernav::frames::Ned>::from_euler(
                angles,
            )
            .quaternion()
        };
        let raw: Vec<f64> = found.split(", ").map(|angle| angle.parse().unwrap()).collect();
        let same = turned(taken).dot(turned([raw[0], raw[1], raw[2]])).abs();
        assert!((same - 1.0).abs() < 1e-12, "{found}: {taken:?}");
        let near = taken.iter().zip(meant).all(|(taken, meant)| (taken - meant).abs() < 1e-9);
        assert!(near || found == "0, 135, 0", "{found}: {taken:?}, expected {meant:?}");
    }
    let error = refused("[navigation.imu]\nmounting_deg = [0.0, 400.0, 0.0]\n");
    assert!(error.contains("mounting_deg: found 400, expected -360 to 360 °"), "{error}");
}

#[test]
fn a_flight_before_the_design_says_what_to_run_first() {
    let directory = tempfile::tempdir().unwrap();
    let mut config =
        FlyConfig::parse(&format!("{SENSORS}{AUTOPILOT}"), "fly.toml".as_ref()).unwrap();
    let error = config.load_autopilot(directory.path()).unwrap_err().to_string();
    assert!(error.starts_with("[autopilot] file: found no file"), "{error}");
    assert!(
        error.contains("autopilot.toml") && error.contains("run `hovernav design` first"),
        "{error}"
    );
}

#[test]
fn numbers_that_would_switch_a_check_off_are_refused_with_their_key() {
    let good = "[dmu]\nport = 'a'\n[receiver]\nport = 'b'\n";
    FlyConfig::parse(good, "fly.toml".as_ref()).unwrap();
    for (text, key) in [
        ("[receiver.limits]\nmax_jump_m = nan\n", "max_jump_m"),
        ("[receiver.limits]\nmax_ground_speed_mps = inf\n", "max_ground_speed_mps"),
        ("[servo.signal]\nstale_after_s = 1e9\n", "stale_after_s"),
        ("[servo]\nhold_s = nan\n", "hold_s"),
        ("[navigation.imu]\ngyro_range_degps = 1e9\n", "gyro_range_degps"),
        ("[mavlink]\nport = 'c'\nspeaker = { system_id = 0 }\n", "system_id"),
        ("[mavlink]\nport = 'c'\nspeaker = { gate_sigmas = 0 }\n", "gate_sigmas"),
        ("[mavlink]\nport = 'c'\nspeaker = { rates = { attitude_hz = nan } }\n", "attitude_hz"),
        ("[site]\nlatitude_deg = 91\nlongitude_deg = 0\n", "latitude_deg"),
        ("[telemetry]\nport = 'd'\nbaud = 5\n", "baud"),
        ("[servo.capture]\nserial = { port = 'c', baud = 5 }\n", "baud"),
        ("[mavlink]\nport = 'c'\nspeaker = { component_id = 0 }\n", "component_id"),
        (
            "[servo.capture]\nserial = { port = 'c' }\n[autopilot]\nfile = 'a'\n\
             geofence = { radius_m = 50, height_m = 50 }\n\
             [site]\nlatitude_deg = 1\nlongitude_deg = 2\n",
            "[site] height_m",
        ),
        ("[telemetry]\nport = 'd'\nudp = 'ground:14551'\n", "udp"),
        ("[telemetry]\nudp = 'ground'\n", "udp"),
        ("[telemetry]\nudp = 'ground:0'\n", "udp"),
        ("[mavlink]\nbaud = 9600\n", "port"),
    ] {
        let error = FlyConfig::parse(&format!("{good}{text}"), "fly.toml".as_ref())
            .expect_err(text)
            .to_string();
        assert!(error.contains(key) && error.contains("expected"), "{text}: {error}");
    }
}
