//! The estimator's configuration.

use std::path::Path;

use hovernav::ekf::EstimatorConfig;
use hovernav::frames::{Body, Vector};
use hovernav::imu::NotchConfig;
use hovernav::ins::HeadingSource;
use serde_json::{Value, to_value};

use super::language::{assignments, comment, number};
use super::{Form, write};

/// Writes `config`, and the notch filter ahead of the estimator, into `directory`, as `estimator` with the extension of
/// each form.
pub fn estimator(
    config: &EstimatorConfig,
    notch: Option<NotchConfig>,
    remark: &str,
    forms: &[Form],
    directory: &Path,
) -> anyhow::Result<()> {
    write(forms, directory, "estimator", |form| bytes(config, notch, remark, form))
}

pub(super) fn bytes(
    config: &EstimatorConfig,
    notch: Option<NotchConfig>,
    remark: &str,
    form: Form,
) -> anyhow::Result<Vec<u8>> {
    Ok(match form {
        Form::Rust => rust(config, notch, remark)?.into_bytes(),
        Form::C => c(config, notch, remark)?.into_bytes(),
        Form::Postcard => {
            let (alignment, ekf) = (&config.alignment, &config.ekf);
            postcard::to_allocvec(&(
                config.mounting.imu_lever_arm_m.to_array(),
                config.mounting.antenna_lever_arm_m.to_array(),
                (alignment.attitude_declination_rad, alignment.declination_rad),
                alignment,
                (ekf.imu, ekf.gps, ekf.attitude, ekf.magnetometer, ekf.baro, ekf.gate),
                config.aiding,
                (
                    config.rangefinder.lever_arm_m.to_array(),
                    config.rangefinder.beam.to_array(),
                    config.rangefinder.model,
                    alignment.baseline_m.map(Vector::to_array),
                    config.antenna_heading,
                ),
                notch,
            ))?
        }
    })
}

/// The model groups of the filter, by name.
fn groups(config: &EstimatorConfig) -> anyhow::Result<[(&'static str, Value); 6]> {
    let ekf = &config.ekf;
    Ok([
        ("imu", to_value(ekf.imu)?),
        ("gps", to_value(ekf.gps)?),
        ("attitude", to_value(ekf.attitude)?),
        ("magnetometer", to_value(ekf.magnetometer)?),
        ("baro", to_value(ekf.baro)?),
        ("gate", to_value(ekf.gate)?),
    ])
}

/// The numbers of the alignment, including the declinations.
fn alignment(place: &str, config: &EstimatorConfig) -> anyhow::Result<String> {
    let alignment = &config.alignment;
    let mut value = to_value(alignment)?;
    value["attitude_declination_rad"] = alignment.attitude_declination_rad.into();
    value["declination_rad"] = alignment.declination_rad.into();
    Ok(assignments(place, &value))
}

/// One line per setting of a notch, assigned to its field below `place`.
fn notch_lines(place: &str, notch: &NotchConfig) -> String {
    let [frequency, width, least] =
        [notch.frequency_hz, notch.width_hz, notch.least_hz].map(number);
    format!(
        "    {place}.frequency_hz = {frequency};\n    {place}.width_hz = {width};\n    \
         {place}.harmonics = {};\n    {place}.least_hz = {least};\n",
        notch.harmonics
    )
}

fn rust(
    config: &EstimatorConfig,
    notch: Option<NotchConfig>,
    remark: &str,
) -> anyhow::Result<String> {
    let vector = |vector: Vector<Body>| {
        let [x, y, z] = vector.to_array().map(number);
        format!("Vector::new({x}, {y}, {z})")
    };
    let mut lines = format!(
        "    config.mounting.imu_lever_arm_m = {};\n    config.mounting.antenna_lever_arm_m = {};\n",
        vector(config.mounting.imu_lever_arm_m),
        vector(config.mounting.antenna_lever_arm_m)
    );
    let aiding = config.aiding;
    let heading = config
        .alignment
        .heading
        .map_or_else(|| "None".to_owned(), |source| format!("Some(HeadingSource::{source:?})"));
    lines += &format!(
        "    config.aiding.attitude = {};\n    config.aiding.magnetometer = {};\n    \
         config.aiding.baro = {};\n    config.aiding.rangefinder = {};\n    \
         config.aiding.second_antenna = {};\n    config.alignment.heading = {heading};\n",
        aiding.attitude,
        aiding.magnetometer,
        aiding.baro,
        aiding.rangefinder,
        aiding.second_antenna
    );
    let baseline_m = config.alignment.baseline_m;
    let baseline_m = baseline_m.map_or("None".to_owned(), |arm| format!("Some({})", vector(arm)));
    lines += &format!(
        "    config.alignment.baseline_m = {baseline_m};\n    \
         config.rangefinder.lever_arm_m = {};\n    config.rangefinder.beam = {};\n",
        vector(config.rangefinder.lever_arm_m),
        vector(config.rangefinder.beam)
    );
    lines += &assignments("config.rangefinder.model", &to_value(config.rangefinder.model)?);
    lines += &assignments("config.antenna_heading", &to_value(config.antenna_heading)?);
    lines += &alignment("config.alignment", config)?;
    for (name, group) in groups(config)? {
        lines += &assignments(&format!("config.ekf.{name}"), &group);
    }
    // Without a configured heading source, the import is unused.
    let source =
        if config.alignment.heading.is_some() { "use hovernav::ins::HeadingSource;\n" } else { "" };
    let notch = notch.map_or_else(
        || "    None\n".to_owned(),
        |notch| {
            let lines = notch_lines("notch", &notch);
            format!("    let mut notch = NotchConfig::default();\n{lines}    Some(notch)\n")
        },
    );
    let remark = comment(remark);
    Ok(format!(
        "{remark}\n\n\
         use hovernav::ekf::EstimatorConfig;\nuse hovernav::frames::Vector;\n\
         use hovernav::imu::NotchConfig;\n{source}\n\
         /// The whole configuration.\n\
         pub fn estimator() -> EstimatorConfig {{\n    \
         let mut config = EstimatorConfig::default();\n{lines}    config\n}}\n\n\
         /// The notch filter that inertial samples pass before the estimator, for `Notch`; `None` if unused.\n\
         pub fn notch() -> Option<NotchConfig> {{\n{notch}}}\n"
    ))
}

fn c(config: &EstimatorConfig, notch: Option<NotchConfig>, remark: &str) -> anyhow::Result<String> {
    let mut lines = String::new();
    for (name, arm) in [
        ("imu_lever_arm_m", config.mounting.imu_lever_arm_m),
        ("antenna_lever_arm_m", config.mounting.antenna_lever_arm_m),
        ("rangefinder.lever_arm_m", config.rangefinder.lever_arm_m),
        ("rangefinder.beam", config.rangefinder.beam),
        ("second_antenna.baseline_m", config.alignment.baseline_m.unwrap_or_default()),
    ] {
        for (axis, value) in arm.to_array().map(number).iter().enumerate() {
            lines += &format!("    config->{name}[{axis}] = {value};\n");
        }
    }
    let aiding = config.aiding;
    for (name, used) in [
        ("attitude", aiding.attitude),
        ("magnetometer", aiding.magnetometer),
        ("baro", aiding.baro),
        ("rangefinder", aiding.rangefinder),
        ("second_antenna", aiding.second_antenna),
    ] {
        lines += &format!("    config->use_{name} = {};\n", u32::from(used));
    }
    let heading = match config.alignment.heading {
        None => "ANY",
        Some(HeadingSource::Attitude) => "ATTITUDE",
        Some(HeadingSource::SecondAntenna) => "SECOND_ANTENNA",
        Some(HeadingSource::Magnetometer) => "MAGNETOMETER",
        Some(HeadingSource::Course) => "COURSE",
        Some(HeadingSource::Unknown) => "UNKNOWN",
    };
    lines += &format!("    config->alignment.heading = HOVERNAV_HEADING_{heading};\n");
    lines += &alignment("config->alignment", config)?;
    for (name, group) in groups(config)? {
        lines += &assignments(&format!("config->{name}"), &group);
    }
    let range = to_value(config.rangefinder.model)?;
    lines += &assignments("config->rangefinder.model", &range);
    let heading = to_value(config.antenna_heading)?;
    lines += &assignments("config->second_antenna.model", &heading);
    // The default configuration has no notch.
    lines += &notch.map_or_else(String::new, |notch| notch_lines("config->notch", &notch));
    let remark = comment(remark);
    Ok(format!(
        "{remark}\n\n\
         #ifndef HOVERNAV_ESTIMATOR_H\n#define HOVERNAV_ESTIMATOR_H\n\n\
         #include <hovernav.h>\n\n\
         // Fills in the whole configuration.\n\
         static inline HovernavStatus hovernav_estimator_config(HovernavConfig *config) {{\n    \
         HovernavStatus status = hovernav_default_config(config, HOVERNAV_ABI);\n    \
         if (status != HOVERNAV_STATUS_OK)\n        return status;\n{lines}    return status;\n}}\n\n\
         #endif\n"
    ))
}
