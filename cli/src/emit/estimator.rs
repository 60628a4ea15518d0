//! The estimator's configuration.

use std::path::Path;

use hovernav::ekf::EstimatorConfig;
use hovernav::frames::{Body, Vector};
use hovernav::imu::NotchConfig;
use hovernav::ins::AlignmentConfig;
use serde_json::to_value;

use super::language::{Language, assignments, comment, number, upper_snake};
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
            let EstimatorConfig {
                vehicle_kind,
                mounting,
                alignment,
                ekf,
                aiding,
                rangefinder,
                antenna_heading,
            } = config;
            postcard::to_allocvec(&(
                mounting.imu_lever_arm_m.to_array(),
                mounting.antenna_lever_arm_m.to_array(),
                (alignment.attitude_declination_rad, alignment.declination_rad),
                alignment,
                ekf,
                aiding,
                (
                    rangefinder.lever_arm_m.to_array(),
                    rangefinder.beam.to_array(),
                    rangefinder.model,
                    alignment.baseline_m.map(Vector::to_array),
                    antenna_heading,
                ),
                (vehicle_kind, notch),
            ))?
        }
    })
}

/// Assignments of the alignment's settings, including the declinations, which serialization omits.
fn alignment(
    language: Language,
    before: &str,
    alignment: &AlignmentConfig,
) -> anyhow::Result<String> {
    let mut value = to_value(alignment)?;
    value["attitude_declination_rad"] = alignment.attitude_declination_rad.into();
    value["declination_rad"] = alignment.declination_rad.into();
    Ok(assignments(language, before, &value))
}

/// One line per setting of a notch, assigned to its field of the structure `place`.
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
    let EstimatorConfig {
        vehicle_kind,
        mounting,
        alignment: start,
        ekf,
        aiding,
        rangefinder,
        antenna_heading,
    } = config;
    let named = |kind: Option<&str>| kind.map_or("None".to_owned(), |kind| format!("Some({kind})"));
    let kind = vehicle_kind.map(|kind| format!("hovernav::ekf::VehicleKind::{kind:?}"));
    let heading = start.heading.map(|source| format!("hovernav::ins::HeadingSource::{source:?}"));
    let baseline_m = start.baseline_m.map(vector);
    let mut lines = String::new();
    for (field, value) in [
        ("vehicle_kind", named(kind.as_deref())),
        ("mounting.imu_lever_arm_m", vector(mounting.imu_lever_arm_m)),
        ("mounting.antenna_lever_arm_m", vector(mounting.antenna_lever_arm_m)),
        ("alignment.heading", named(heading.as_deref())),
        ("alignment.baseline_m", named(baseline_m.as_deref())),
        ("rangefinder.lever_arm_m", vector(rangefinder.lever_arm_m)),
        ("rangefinder.beam", vector(rangefinder.beam)),
    ] {
        lines += &format!("    config.{field} = {value};\n");
    }
    lines += &alignment(Language::Rust, "config.alignment.", start)?;
    for (group, value) in [
        ("ekf", to_value(ekf)?),
        ("aiding", to_value(aiding)?),
        ("rangefinder.model", to_value(rangefinder.model)?),
        ("antenna_heading", to_value(antenna_heading)?),
    ] {
        lines += &assignments(Language::Rust, &format!("config.{group}."), &value);
    }
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
         use hovernav::imu::NotchConfig;\n\n\
         /// The whole configuration.\n\
         pub fn estimator() -> EstimatorConfig {{\n    \
         let mut config = EstimatorConfig::default();\n{lines}    config\n}}\n\n\
         /// The notch filter that inertial samples pass before the estimator, for `Notch`; `None` if unused.\n\
         pub fn notch() -> Option<NotchConfig> {{\n{notch}}}\n"
    ))
}

fn c(config: &EstimatorConfig, notch: Option<NotchConfig>, remark: &str) -> anyhow::Result<String> {
    let EstimatorConfig {
        vehicle_kind,
        mounting,
        alignment: start,
        ekf,
        aiding,
        rangefinder,
        antenna_heading,
    } = config;
    let mut lines = String::new();
    for (name, arm) in [
        ("imu_lever_arm_m", mounting.imu_lever_arm_m),
        ("antenna_lever_arm_m", mounting.antenna_lever_arm_m),
        ("rangefinder.lever_arm_m", rangefinder.lever_arm_m),
        ("rangefinder.beam", rangefinder.beam),
        ("second_antenna.baseline_m", start.baseline_m.unwrap_or_default()),
    ] {
        for (axis, value) in arm.to_array().map(number).iter().enumerate() {
            lines += &format!("    config->{name}[{axis}] = {value};\n");
        }
    }
    lines += &assignments(Language::C, "config->use_", &to_value(aiding)?);
    let kind = vehicle_kind.map_or("UNSTATED".to_owned(), |kind| upper_snake(&format!("{kind:?}")));
    lines += &format!("    config->vehicle_kind = HOVERNAV_VEHICLE_{kind};\n");
    let heading = start.heading.map_or("ANY".to_owned(), |at| upper_snake(&format!("{at:?}")));
    lines += &format!("    config->alignment.heading = HOVERNAV_HEADING_{heading};\n");
    lines += &alignment(Language::C, "config->alignment.", start)?;
    for (before, group) in [
        ("config->", to_value(ekf)?),
        ("config->rangefinder.model.", to_value(rangefinder.model)?),
        ("config->second_antenna.model.", to_value(antenna_heading)?),
    ] {
        lines += &assignments(Language::C, before, &group);
    }
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
