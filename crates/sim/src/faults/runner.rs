//! One flight through the estimator, as `hovernav estimate` runs it.

use std::path::PathBuf;

use hovernav_log::{Dataset, LogError, Run, sentences};

/// Runs the estimator over `dataset` with the settings of its own manifest; the warnings are those of
/// reading it and of running.
///
/// # Errors
/// A log that `hovernav estimate` refuses, for the same reason in the same words.
pub(super) fn estimate(mut dataset: Dataset) -> Result<(Run, Vec<String>), LogError> {
    let path = PathBuf::from(&dataset.manifest.name);
    let denied = dataset.check_fitness(&path)?;
    let mut left_out = dataset.leave_out(denied);
    let config = dataset.settings()?;
    let mut run = dataset.estimate(&config, |_| {});
    let without = dataset.leave_out_denied(&config, &run);
    if !without.is_empty() {
        run = dataset.estimate(&config, |_| {});
        left_out.extend(without);
    }
    let mut warnings = std::mem::take(&mut dataset.warnings);
    warnings.extend(left_out.iter().map(ToString::to_string));
    warnings.extend(sentences(&dataset.findings(&run)));
    Ok((run, warnings))
}
