//! Several logs in one call: each log in its own directory, and a table over all.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use anyhow::bail;
use hovernav_formats::RunSummary;

use super::{Arguments, estimate};
use crate::output;
use crate::summary::InWords as _;

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let root = arguments.out.clone().unwrap_or_else(|| "out".into());
    let mut taken = HashSet::new();
    let mut failed = 0;
    let width = arguments.log.iter().map(|log| output::name_of(log).chars().count()).max();
    let width = width.unwrap_or(0).clamp(4, 40);
    output::say(heads(width));
    for log in &arguments.log {
        let out = own_directory(&root, log, &mut taken);
        match estimate(arguments, log, &out) {
            Ok(summary) => output::say(row(width, &out, &summary)),
            Err(error) => {
                failed += 1;
                output::complain(format_args!("hovernav: {}", crate::in_one_line(&error)));
            }
        }
    }
    if failed > 0 {
        bail!("{failed} of {} logs could not be estimated", arguments.log.len());
    }
    Ok(())
}

/// A directory for the results of `log`: its name, numbered if another log has the same name.
fn own_directory(root: &Path, log: &Path, taken: &mut HashSet<PathBuf>) -> PathBuf {
    let name = output::name_of(log);
    let numbered = (2..).map(|number| root.join(format!("{name}-{number}")));
    let mut free = std::iter::once(root.join(&name)).chain(numbered);
    let out = free.find(|path| !taken.contains(path)).unwrap_or_else(|| root.join(name));
    taken.insert(out.clone());
    out
}

fn heads(width: usize) -> String {
    format!(
        "{:<width$} {:>9} {:>8} {:>7} {:>8} {:>13} {:>13} {:>9} verdict",
        "log", "s", "samples", "fixes", "rejected", "horizontal m", "velocity m/s", "warnings"
    )
}

fn row(width: usize, out: &Path, summary: &RunSummary) -> String {
    let name = out.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let [horizontal, velocity] = summary.row_errors();
    let error = |value: Option<f64>| value.map_or("–".into(), |value| format!("{value:.3}"));
    format!(
        "{name:<width$} {:>9.1} {:>8} {:>7} {:>8} {:>13} {:>13} {:>9} {}",
        summary.duration_s,
        summary.imu_samples,
        summary.gps_fixes_used,
        summary.gps_fixes_rejected,
        error(horizontal),
        error(velocity),
        summary.warnings.len(),
        summary.verdict.as_ref().map_or("–", |verdict| verdict.level.name())
    )
}
