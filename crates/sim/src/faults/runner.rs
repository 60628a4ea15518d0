//! Estimation of one flight, as by `hovernav estimate`.

use std::path::PathBuf;

use hovernav_dataset::{Dataset, LogError};
use hovernav_findings::{check_fitness, findings, ignore, ignore_inconsistent, sentences};
use hovernav_replay::Run;

/// Runs the estimator on `dataset` with the settings of its own manifest. The warnings are those of reading and of the
/// run.
///
/// # Errors
/// The error of `hovernav estimate` for a log that it rejects.
pub(super) fn estimate(mut dataset: Dataset) -> Result<(Run, Vec<String>), LogError> {
    let path = PathBuf::from(&dataset.manifest.name);
    let denied = check_fitness(&dataset, &path)?;
    let mut ignored = ignore(&mut dataset, denied);
    let config = dataset.settings()?;
    let mut run = hovernav_replay::estimate(&dataset, &config, |_| {});
    let without = ignore_inconsistent(&mut dataset, &config, &run);
    if !without.is_empty() {
        run = hovernav_replay::estimate(&dataset, &config, |_| {});
        ignored.extend(without);
    }
    let mut warnings = std::mem::take(&mut dataset.warnings);
    warnings.extend(ignored.iter().map(ToString::to_string));
    warnings.extend(sentences(&findings(&dataset, &run)));
    Ok((run, warnings))
}
