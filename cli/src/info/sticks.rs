//! Movement of the sticks in `hovernav info`, and the models that the log can identify.

use std::fmt::Write as _;

use hovernav::time::Time;
use hovernav_dataset::{Dataset, LogError};
use hovernav_sysid::helicopter::{Activity, StickActivity};

/// Shortest interval of the rows, s: a long log at 400 Hz would take too much memory.
const MIN_S: f64 = 0.009;

/// The movement of the sticks of `dataset`; `None` without sticks.
///
/// # Errors
/// A file of sticks that can no longer be read.
pub fn activity(dataset: &Dataset) -> Result<Option<Activity>, LogError> {
    let mut controls: Vec<(Time, [f64; 4])> = Vec::new();
    let keep = |time: Time, sticks| {
        if controls.last().is_none_or(|last| time - last.0 > MIN_S) {
            controls.push((time, sticks));
        }
    };
    dataset.each_control(keep)?;
    Ok((!controls.is_empty()).then(|| Activity::of(&controls, !dataset.fixes.is_empty())))
}

/// One line per stick, and the models.
pub fn in_words(activity: &Activity) -> String {
    let mut text = format!(
        "\nsticks          {:>8}  {:>8}  {:>14}  {:>11}\n",
        "travel", "moved, s", "band, Hz", "test points"
    );
    for StickActivity { stick, travel, moved_s, band_hz, test_points } in &activity.sticks {
        let band = band_hz.map_or_else(
            || if *moved_s > 0.0 { "unknown" } else { "does not move" }.to_owned(),
            |[first, last]| format!("{first:.2} to {last:.2}"),
        );
        let _ = writeln!(
            text,
            "  {stick:<12}  {travel:>8.3}  {moved_s:>8.0}  {band:>14}  {test_points:>11}"
        );
    }
    let models = match &activity.models[..] {
        [] => "none".to_owned(),
        models => models.join(", "),
    };
    let _ = writeln!(text, "  identify      {models}");
    text
}
