//! The autopilot's configuration.
#![cfg_attr(not(feature = "lab"), allow(dead_code, reason = "only `design` makes one"))]

use std::path::Path;

use hovernav::autopilot::{Gains, HoverConfig};
use serde_json::Value;

use super::language::{Language, assignments, comment, literal, number};
use super::{Form, write};

/// Writes `config` into `directory`, as `autopilot` with the extension of each form.
pub fn autopilot(
    config: &HoverConfig,
    remark: &str,
    forms: &[Form],
    directory: &Path,
) -> anyhow::Result<()> {
    write(forms, directory, "autopilot", |form| bytes(config, remark, form))
}

pub(super) fn bytes(config: &HoverConfig, remark: &str, form: Form) -> anyhow::Result<Vec<u8>> {
    Ok(match form {
        Form::Rust => rust(config, remark)?.into_bytes(),
        Form::C => c(config, remark)?.into_bytes(),
        Form::Postcard => postcard::to_allocvec(config)?,
    })
}

/// All fields except gains and period, each assigned to its field, whose name follows `before`.
fn rest(language: Language, before: &str, config: &HoverConfig) -> anyhow::Result<String> {
    let mut value = serde_json::to_value(config)?;
    if let Value::Object(fields) = &mut value {
        fields.remove("gains");
        fields.remove("period_s");
    }
    Ok(assignments(language, before, &value))
}

/// The gains as a Rust literal, in the order of the field names.
fn rust_gains(gains: &Gains) -> anyhow::Result<String> {
    let value = serde_json::to_value(gains)?;
    let mut text = String::new();
    for (key, group) in value.as_object().into_iter().flatten() {
        let Value::Object(fields) = group else {
            text += &format!("    {key}: {},\n", literal(Language::Rust, group));
            continue;
        };
        let name = if key == "heave" { "PidGains" } else { "RegulatorGains" };
        text += &format!("    {key}: {name} {{\n");
        for (key, value) in fields {
            text += &format!("        {key}: {},\n", literal(Language::Rust, value));
        }
        text += "    },\n";
    }
    Ok(text)
}

/// Fields of HovernavGains, in the order of hovernav.h, as in the two lists below.
pub(super) const GAINS: [&str; 5] =
    ["heave", "yaw", "pedal_per_collective", "roll_pitch", "attitude"];
/// Fields of HovernavPidGains.
pub(super) const PID_GAINS: [&str; 5] =
    ["proportional", "integral_per_s", "derivative_s", "derivative_filter_s", "tracking_time_s"];
/// Fields of HovernavYawGains, HovernavRollPitchGains and HovernavAttitudeGains.
pub(super) const REGULATOR_GAINS: [&str; 8] = [
    "measured",
    "hidden",
    "pending",
    "integral_per_s",
    "hidden_from_hidden",
    "hidden_from_measured",
    "hidden_from_pending",
    "tracking_time_s",
];

/// The gains as a C literal, in the order of the structure and without field names: C++ has designated initialisers
/// only since C++20, and only in order.
fn c_gains(gains: &Gains) -> anyhow::Result<String> {
    let value = serde_json::to_value(gains)?;
    let mut text = String::new();
    for key in GAINS {
        let group = &value[key];
        if !group.is_object() {
            text += &format!("    {}, // {key}\n", literal(Language::C, group));
            continue;
        }
        let fields = if key == "heave" { &PID_GAINS[..] } else { &REGULATOR_GAINS[..] };
        text += &format!("    {{\n        // {key}\n");
        for field in fields {
            text += &format!("        {}, // {field}\n", literal(Language::C, &group[field]));
        }
        text += "    },\n";
    }
    Ok(text)
}

fn rust(config: &HoverConfig, remark: &str) -> anyhow::Result<String> {
    let (period, gains) = (number(config.period_s), rust_gains(&config.gains)?);
    let remark = comment(remark);
    let rest = rest(Language::Rust, "config.", config)?;
    Ok(format!(
        "{remark}\n\n\
         use hovernav::autopilot::{{Gains, HoverConfig, PidGains, RegulatorGains}};\n\n\
         /// The loop's period, s.\n\
         pub const PERIOD_S: f64 = {period};\n\n\
         /// Every gain, designed for that period.\n\
         pub const GAINS: Gains = Gains {{\n{gains}}};\n\n\
         /// The whole configuration.\n\
         pub fn autopilot() -> HoverConfig {{\n    \
         let mut config = HoverConfig::new(PERIOD_S, GAINS);\n{rest}    config\n}}\n"
    ))
}

fn c(config: &HoverConfig, remark: &str) -> anyhow::Result<String> {
    let (period, gains) = (number(config.period_s), c_gains(&config.gains)?);
    let remark = comment(remark);
    let rest = rest(Language::C, "config->", config)?;
    Ok(format!(
        "{remark}\n\n\
         #ifndef HOVERNAV_AUTOPILOT_H\n#define HOVERNAV_AUTOPILOT_H\n\n\
         #include <hovernav.h>\n\n\
         // Every gain, designed for the period below.\n\
         static const HovernavGains hovernav_autopilot_gains = {{\n{gains}}};\n\n\
         // Fills in the whole configuration.\n\
         static inline HovernavStatus hovernav_autopilot_config(HovernavAutopilotConfig *config) {{\n    \
         HovernavStatus status = hovernav_default_autopilot_config(config, {period},\n        \
         &hovernav_autopilot_gains, HOVERNAV_ABI);\n    \
         if (status != HOVERNAV_STATUS_OK)\n        return status;\n{rest}    return status;\n}}\n\n\
         #endif\n"
    ))
}
