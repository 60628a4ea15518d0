//! Estimation of one flight, as by `hovernav estimate`.

use std::path::PathBuf;

use hovernav_log::{Dataset, LogError, Run, sentences};

/// Runs the estimator on `dataset` with the settings of its own manifest. The warnings are those of reading and of the
/// run.
///
/// # Errors
/// The error of `hovernav estimate` for a log that it rejects.
pub(super) fn estimate(mut dataset: Dataset) -> Result<(Run, Vec<String>), LogError> {
    let path = PathBuf::from(&dataset.manifest.name);
    let denied = dataset.check_fitness(&path)?;
    let mut ignored = dataset.ignore(denied);
    let config = dataset.settings()?;
    let mut run = dataset.estimate(&config, |_| {});
    let without = dataset.ignore_inconsistent(&config, &run);
    if !without.is_empty() {
        run = dataset.estimate(&config, |_| {});
        ignored.extend(without);
    }
    let mut warnings = std::mem::take(&mut dataset.warnings);
    warnings.extend(ignored.iter().map(ToString::to_string));
    warnings.extend(sentences(&dataset.findings(&run)));
    Ok((run, warnings))
}
