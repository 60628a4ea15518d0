use hovernav::autopilot::{Gains, HoverConfig};
use hovernav::ekf::{
    Aiding, AntennaHeadingModel, EkfConfig, EstimatorConfig, RangeModel, VehicleKind,
};
use hovernav::frames::Vector;
use hovernav::imu::NotchConfig;
use hovernav::ins::{AlignmentConfig, HeadingSource};

use super::Form;
use super::autopilot::{GAINS, PID_GAINS, REGULATOR_GAINS};

fn hover() -> HoverConfig {
    let mut gains = Gains::default();
    gains.heave.tracking_time_s = 1.0;
    gains.roll_pitch.measured[1][3] = -0.1;
    let mut config = HoverConfig::new(0.1 / 3.0, gains);
    config.trim.roll_rad = 0.3 / 7.0;
    config
}

fn estimator() -> EstimatorConfig {
    let mut config = EstimatorConfig::default();
    config.mounting.imu_lever_arm_m = Vector::new(0.1, -0.2, 0.3);
    config.alignment.heading = Some(HeadingSource::Course);
    config.alignment.declination_rad = 1.0 / 3.0;
    config.ekf.gate.sigmas = 4.5;
    config.aiding.baro = false;
    config.ekf.mechanisms.wheels = false;
    config.vehicle_kind = Some(VehicleKind::FixedWing);
    config
}

fn notch() -> NotchConfig {
    NotchConfig::at_hz(70.0 / 3.0).with_harmonics(2)
}

fn text(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).unwrap()
}

type Arm = [f64; 3];
type Aids = (Arm, Arm, RangeModel, Option<Arm>, AntennaHeadingModel);
type Kinds = (Option<VehicleKind>, Option<NotchConfig>);
type Parts = (Arm, Arm, (f64, f64), AlignmentConfig, EkfConfig, Aiding, Aids, Kinds);

/// Reads `estimator.postcard`: for programs to copy, as docs/embedded.md states.
fn read(bytes: &[u8]) -> Result<(EstimatorConfig, Option<NotchConfig>), postcard::Error> {
    let (imu_arm_m, antenna_arm_m, declinations_rad, alignment, ekf, aiding, aids, kinds): Parts =
        postcard::from_bytes(bytes)?;
    let (vehicle_kind, notch) = kinds;
    let mut config =
        EstimatorConfig { vehicle_kind, alignment, ekf, aiding, ..EstimatorConfig::default() };
    config.mounting.imu_lever_arm_m = Vector::from(imu_arm_m);
    config.mounting.antenna_lever_arm_m = Vector::from(antenna_arm_m);
    (config.alignment.attitude_declination_rad, config.alignment.declination_rad) =
        declinations_rad;
    let (lever_arm_m, beam, range, baseline_m, antenna_heading) = aids;
    config.rangefinder.lever_arm_m = Vector::from(lever_arm_m);
    config.rangefinder.beam = Vector::from(beam);
    config.rangefinder.model = range;
    config.alignment.baseline_m = baseline_m.map(Vector::from);
    config.antenna_heading = antenna_heading;
    Ok((config, notch))
}

#[test]
fn postcard_reads_back_as_the_same_configuration() {
    let bytes = super::autopilot::bytes(&hover(), "", Form::Postcard).unwrap();
    assert_eq!(postcard::from_bytes::<HoverConfig>(&bytes).unwrap(), hover());

    let bytes = super::estimator::bytes(&estimator(), Some(notch()), "", Form::Postcard).unwrap();
    assert_eq!(read(&bytes).unwrap(), (estimator(), Some(notch())));
}

#[test]
fn numbers_keep_every_bit_in_rust_and_c() {
    for form in [Form::Rust, Form::C] {
        let hover = text(super::autopilot::bytes(&hover(), "By nobody.", form).unwrap());
        for number in ["0.03333333333333333", "-0.1", "0.04285714285714286"] {
            assert!(hover.contains(number), "{number}: {hover}");
        }
        let estimator =
            text(super::estimator::bytes(&estimator(), Some(notch()), "", form).unwrap());
        let [on, off, kind] = match form {
            Form::C => ["1", "0", "vehicle_kind = HOVERNAV_VEHICLE_FIXED_WING;"],
            _ => ["true", "false", "vehicle_kind = Some(hovernav::ekf::VehicleKind::FixedWing);"],
        };
        let [on, off] = [format!("mechanisms.rest = {on};"), format!("mechanisms.wheels = {off};")];
        for expected in ["0.3333333333333333", "gate.sigmas = 4.5;", &on, &off, kind] {
            assert!(estimator.contains(expected), "{expected}: {estimator}");
        }
    }
}

#[test]
fn the_notch_before_the_estimator_is_reported_whole() {
    let told = |notch| text(super::estimator::bytes(&estimator(), notch, "", Form::Rust).unwrap());
    let with = told(Some(notch()));
    for line in [
        "pub fn notch() -> Option<NotchConfig> {",
        "    notch.frequency_hz = 23.333333333333332;",
        "    notch.width_hz = 4.0;",
        "    notch.harmonics = 2;",
        "    notch.least_hz = 6.0;",
        "    Some(notch)",
    ] {
        assert!(with.lines().any(|found| found == line), "{line}: {with}");
    }
    assert!(told(None).ends_with("pub fn notch() -> Option<NotchConfig> {\n    None\n}\n"));

    let told = |notch| text(super::estimator::bytes(&estimator(), notch, "", Form::C).unwrap());
    let with = told(Some(notch()));
    for line in [
        "    config->notch.frequency_hz = 23.333333333333332;",
        "    config->notch.width_hz = 4.0;",
        "    config->notch.harmonics = 2;",
        "    config->notch.least_hz = 6.0;",
    ] {
        assert!(with.lines().any(|found| found == line), "{line}: {with}");
    }
    assert!(!told(None).contains("notch"));
}

const HEADER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../ffi/include");

#[test]
fn gains_in_c_come_in_the_order_of_the_header() {
    let header = std::fs::read_to_string(format!("{HEADER}/hovernav.h")).unwrap();
    for (structure, fields) in [
        ("HovernavGains", &GAINS[..]),
        ("HovernavPidGains", &PID_GAINS[..]),
        ("HovernavYawGains", &REGULATOR_GAINS[..]),
        ("HovernavRollPitchGains", &REGULATOR_GAINS[..]),
        ("HovernavAttitudeGains", &REGULATOR_GAINS[..]),
    ] {
        let (_, body) = header.split_once(&format!("typedef struct {structure} {{")).unwrap();
        let (body, _) = body.split_once('}').unwrap();
        let declared: Vec<&str> = body
            .lines()
            .filter_map(|line| line.trim().strip_suffix(';')?.rsplit(' ').next())
            .map(|name| name.split('[').next().unwrap())
            .collect();
        assert_eq!(declared, fields, "{structure}");
    }
}

#[test]
fn headers_are_c_and_cpp_whatever_they_are_made_of() {
    let place = tempfile::tempdir().unwrap();
    let remark = "By\n#error a name of two lines";
    for (name, bytes) in [
        ("autopilot", super::autopilot::bytes(&hover(), remark, Form::C).unwrap()),
        (
            "estimator",
            super::estimator::bytes(&estimator(), Some(notch()), remark, Form::C).unwrap(),
        ),
    ] {
        let header = place.path().join(format!("{name}.h"));
        std::fs::write(&header, bytes).unwrap();
        for (compiler, language, standard) in
            [("gcc", "c", "c99"), ("g++", "c++", "c++11"), ("g++", "c++", "c++20")]
        {
            if !hovernav_testing::installed(compiler) {
                continue;
            }
            let program = place.path().join("program");
            let text = format!("#include \"{name}.h\"\nint main(void) {{ return 0; }}\n");
            std::fs::write(&program, text).unwrap();
            let built = std::process::Command::new(compiler)
                .args(["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only"])
                .args([&format!("-std={standard}"), &format!("-I{HEADER}"), "-x", language])
                .arg(&program)
                .output()
                .unwrap();
            let errors = String::from_utf8_lossy(&built.stderr);
            assert!(built.status.success(), "{name}, {standard}: {errors}");
        }
    }
}
