//! The parts of a record worth fitting, and the whole of it filtered.

use std::ops::Range;

use nalgebra::DMatrix;

use super::{LowPass, PreprocessError};
use crate::record::experiment::Experiment;

/// The experiment with every signal, inputs too, through the same zero-phase filter: what is common
/// to both sides leaves their relation as it was.
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

/// What counts as a manoeuvre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SegmentSettings {
    /// Deviation of an input from its median that counts, as a part of its largest deviation.
    pub threshold: f64,
    /// Quiet time kept before, to know the trim, s.
    pub before_s: f64,
    /// Time kept after the last movement, for the response to end, s.
    pub after_s: f64,
}

impl Default for SegmentSettings {
    fn default() -> Self {
        Self { threshold: 0.25, before_s: 1.0, after_s: 3.0 }
    }
}

/// The rows in which some input moves, with the time before and after; what overlaps is one.
///
/// Each input is measured against its own median, which rare manoeuvres do not move.
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
