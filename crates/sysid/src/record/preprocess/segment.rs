//! Excited segments of a record, and filtering of a whole record.

use std::ops::Range;

use nalgebra::DMatrix;

use super::{LowPass, PreprocessError};
use crate::record::experiment::Experiment;

/// The experiment with every signal, including inputs, through the same zero-phase filter. The relation between inputs
/// and outputs stays unchanged.
///
/// # Errors
/// [`PreprocessError::TooShort`], see [`LowPass::zero_phase`].
pub fn filtered(experiment: &Experiment, filter: &LowPass) -> Result<Experiment, PreprocessError> {
    let through = |signals: &DMatrix<f64>| -> Result<DMatrix<f64>, PreprocessError> {
        let mut smooth = signals.clone();
        for mut column in smooth.column_iter_mut() {
            let values = filter.zero_phase(column.as_slice())?;
            column.copy_from_slice(&values);
        }
        Ok(smooth)
    };
    let mut smooth = experiment.clone();
    smooth.inputs = through(&experiment.inputs)?;
    smooth.outputs = through(&experiment.outputs)?;
    Ok(smooth)
}

/// Definition of a manoeuvre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SegmentSettings {
    /// Smallest deviation of an input from its median that counts as movement, as a fraction of its largest deviation.
    pub threshold: f64,
    /// Quiet time kept before a manoeuvre, for the trim, s.
    pub before_s: f64,
    /// Time kept after the last movement, until the response has decayed, s.
    pub after_s: f64,
}

impl Default for SegmentSettings {
    fn default() -> Self {
        Self { threshold: 0.25, before_s: 1.0, after_s: 3.0 }
    }
}

/// The rows in which an input moves, with the time before and after; overlapping segments are merged.
///
/// Deviations are from each input's own median, which rare manoeuvres do not change.
#[must_use]
pub fn excited_segments(experiment: &Experiment, settings: &SegmentSettings) -> Vec<Range<usize>> {
    let samples = experiment.samples();
    let rows = |seconds: f64| (seconds.max(0.0) / experiment.period_s).round() as usize;
    let (before, after) = (rows(settings.before_s), rows(settings.after_s));
    let deviations: Vec<(Vec<f64>, f64)> = experiment
        .inputs
        .column_iter()
        .map(|input| {
            let mut sorted: Vec<f64> = input.iter().copied().collect();
            sorted.sort_by(f64::total_cmp);
            let median = sorted[samples / 2];
            let away: Vec<f64> = input.iter().map(|value| (value - median).abs()).collect();
            let largest = away.iter().copied().fold(0.0, f64::max);
            (away, settings.threshold * largest)
        })
        .filter(|(_, least)| *least > 0.0)
        .collect();
    let mut segments: Vec<Range<usize>> = Vec::new();
    for sample in 0..samples {
        if deviations.iter().all(|(away, least)| away[sample] <= *least) {
            continue;
        }
        let (start, end) = (sample.saturating_sub(before), (sample + 1 + after).min(samples));
        match segments.last_mut() {
            Some(last) if start <= last.end => last.end = end,
            _ => segments.push(start..end),
        }
    }
    segments
}
