//! Faults of `dataset.toml`: an antenna lever arm with an error or with the opposite sign.

use std::f64::consts::TAU;

use hovernav_dataset::Manifest;

use super::catalogue::Kind;
use super::fault::Fault;
use crate::noise::Noise;

const SECTION: &str = "[gps]";
const KEY: &str = "antenna_lever_arm_m";

/// Manifest `text`, parsed as `manifest`, with `fault` applied. `None` where it is not a fault of the set-up, or the
/// fault is the sign of a zero lever arm.
pub(super) fn make(
    text: &str,
    manifest: &Manifest,
    fault: &Fault,
    noise: &mut Noise,
) -> Option<String> {
    let arm = manifest.gps.antenna_lever_arm_m.to_array();
    let wrong = match fault.kind {
        Kind::LeverArm => {
            let (sin, cos) = (TAU * noise.uniform()).sin_cos();
            [arm[0] + fault.number * cos, arm[1] + fault.number * sin, arm[2]]
        }
        Kind::LeverSign if arm != [0.0; 3] => arm.map(|component| -component),
        _ => return None,
    };
    Some(with_lever_arm(text, wrong))
}

/// The manifest `text` with another lever arm of the antenna, and every other line unchanged.
fn with_lever_arm(text: &str, arm: [f64; 3]) -> String {
    let line = format!("{KEY} = {arm:?}\n");
    let mut out = String::new();
    let (mut inside, mut written) = (false, false);
    for old in text.split_inclusive('\n') {
        let trimmed = old.trim();
        if trimmed.starts_with('[') {
            inside = trimmed.starts_with(SECTION);
        }
        if inside && trimmed.starts_with(KEY) {
            continue;
        }
        out.push_str(old);
        if inside && trimmed.starts_with(SECTION) {
            if !out.ends_with('\n') {
                out.push('\n');
            }
            out.push_str(&line);
            written = true;
        }
    }
    if !written {
        if !out.is_empty() && !out.ends_with('\n') {
            out.push('\n');
        }
        out.push_str(&format!("\n{SECTION}\n{line}"));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_lever_arm_changes() {
        let text =
            "# a note\n[gps]\nrate_hz = 1.0\nantenna_lever_arm_m = [1, 0, 0] # x\n[solution]\n";
        let expected =
            "# a note\n[gps]\nantenna_lever_arm_m = [-1.0, 0.5, 0.0]\nrate_hz = 1.0\n[solution]\n";
        assert_eq!(with_lever_arm(text, [-1.0, 0.5, 0.0]), expected);
        let bare = with_lever_arm("name = 'x'", [0.0, 1.0, 0.0]);
        assert_eq!(bare, "name = 'x'\n\n[gps]\nantenna_lever_arm_m = [0.0, 1.0, 0.0]\n");
    }
}
