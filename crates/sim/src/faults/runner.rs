//! One flight through the estimator, as `hovernav estimate` runs it.

use std::collections::BTreeMap;

use hovernav::ekf::{Notice, Verdict};
use hovernav_log::{Dataset, LogError, Run};

/// Runs the estimator over `dataset` with the settings of its own manifest; the warnings are those of
/// reading it.
pub(super) fn estimate(mut dataset: Dataset) -> Result<(Run, Vec<String>), LogError> {
    let config = dataset.settings()?;
    let run = dataset.estimate(&config, |_| {});
    Ok((run, dataset.warnings))
}

/// The warnings of reading and of running.
pub(super) fn told(mut warnings: Vec<String>, run: &Run) -> Vec<String> {
    let mut counts: BTreeMap<&'static str, usize> = BTreeMap::new();
    for notice in &run.notices {
        let words = match notice {
            Notice::GapBridged { .. } => "a gap in the inertial samples, bridged",
            Notice::CovarianceReset { .. } => "the covariance was reset",
            Notice::SampleSuspect { .. } => "inertial samples at full scale or shaken",
            Notice::SampleRefused { .. } => "an inertial sample that could not be used",
            Notice::NotUsed { reason, .. } if reason.is_fault() => {
                "a measurement that could not be used"
            }
            Notice::Updated(report)
                if report.innovations().any(|axis| axis.verdict == Verdict::Reopened) =>
            {
                "the filter had locked itself out"
            }
            _ => continue,
        };
        *counts.entry(words).or_default() += 1;
    }
    warnings.extend(counts.into_keys().map(str::to_owned));
    warnings
}
