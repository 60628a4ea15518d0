//! The autopilot's configuration.
#![cfg_attr(not(feature = "lab"), allow(dead_code, reason = "only `design` makes one"))]

use std::path::Path;

use hovernav::autopilot::{Gains, HoverConfig};
use serde_json::Value;

use super::language::{Language, assignments, literal, number};
use super::{Form, write};

/// Writes `config` into `directory`, as `autopilot` with the ending of each form.
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

/// Everything but gains and period, each number assigned to its place below `place`.
fn rest(place: &str, config: &HoverConfig) -> anyhow::Result<String> {
    let mut value = serde_json::to_value(config)?;
    if let Value::Object(fields) = &mut value {
        fields.remove("gains");
        fields.remove("period_s");
    }
    Ok(assignments(place, &value))
}

/// The gains as a literal, in the order of their fields' names.
fn gains(language: Language, gains: &Gains) -> anyhow::Result<String> {
    let value = serde_json::to_value(gains)?;
    let mut text = String::new();
    let rust = language == Language::Rust;
    let assign = |key: &str| if rust { format!("{key}: ") } else { format!(".{key} = ") };
    for (key, group) in value.as_object().into_iter().flatten() {
        let Value::Object(fields) = group else {
            text += &format!("    {}{},\n", assign(key), literal(language, group));
            continue;
        };
        let name = match (rust, key.as_str()) {
            (false, _) => "",
            (true, "heave") => "PidGains ",
            (true, _) => "RegulatorGains ",
        };
        text += &format!("    {}{name}{{\n", assign(key));
        for (key, value) in fields {
            text += &format!("        {}{},\n", assign(key), literal(language, value));
        }
        text += "    },\n";
    }
    Ok(text)
}

fn rust(config: &HoverConfig, remark: &str) -> anyhow::Result<String> {
    let (period, gains) = (number(config.period_s), gains(Language::Rust, &config.gains)?);
    let rest = rest("config", config)?;
    Ok(format!(
        "// {remark}\n\n\
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
    let (period, gains) = (number(config.period_s), gains(Language::C, &config.gains)?);
    let rest = rest("(*config)", config)?.replace("(*config).", "config->");
    Ok(format!(
        "// {remark}\n\n\
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
