//! Resampling of experiments and signals.

use nalgebra::DMatrix;

use super::{LowPass, PreprocessError, filtered};
use crate::record::experiment::Experiment;

/// Order of the anti-alias filter before decimation.
const ALIAS_ORDER: usize = 8;
/// Cut-off of the anti-alias filter, as a fraction of half the new sample rate.
const ALIAS_PART: f64 = 0.8;

/// The experiment at another sample period.
///
/// For a longer period every signal is first low-passed, without phase shift, at 0.8 of half the new sample rate.
/// Values between samples come from local cubics (Catmull–Rom).
///
/// # Errors
/// [`PreprocessError::Period`] where the period is not positive and finite, or [`PreprocessError::TooShort`] where the
/// record is too short to filter.
pub fn resample(experiment: &Experiment, period_s: f64) -> Result<Experiment, PreprocessError> {
    if !(period_s > 0.0 && period_s.is_finite()) {
        return Err(PreprocessError::Period { period_s });
    }
    let thinned;
    let source = if period_s > experiment.period_s {
        let cutoff_hz = ALIAS_PART * 0.5 / period_s;
        let filter = LowPass::butterworth(ALIAS_ORDER, cutoff_hz, experiment.period_s)?;
        thinned = filtered(experiment, &filter)?;
        &thinned
    } else {
        experiment
    };
    let last = (source.samples() - 1) as f64;
    let step = period_s / experiment.period_s;
    // A small margin, so that a whole ratio keeps its last sample.
    let samples = (last / step + 1e-9) as usize + 1;
    let moved = |signals: &DMatrix<f64>| {
        DMatrix::from_fn(samples, signals.ncols(), |sample, column| {
            let at = (sample as f64 * step).min(last);
            let before = (at as usize).min(signals.nrows().saturating_sub(2));
            let value = |offset: isize| prolonged(signals, column, before as isize + offset);
            cubic([value(-1), value(0), value(1), value(2)], at - before as f64)
        })
    };
    Ok(Experiment::new(
        source.name.clone(),
        period_s,
        source.input_names.clone(),
        source.output_names.clone(),
        moved(&source.inputs),
        moved(&source.outputs),
    )?)
}

/// The value at `row`. One row past either end it is extrapolated by the parabola through the three nearest values.
fn prolonged(signals: &DMatrix<f64>, column: usize, row: isize) -> f64 {
    let last = signals.nrows() - 1;
    let value = |row: usize| signals[(row.min(last), column)];
    if row >= 0 && row as usize <= last {
        value(row as usize)
    } else if row < 0 {
        3.0 * (value(0) - value(1)) + value(2)
    } else {
        3.0 * (value(last) - value(last.saturating_sub(1))) + value(last.saturating_sub(2))
    }
}

/// Catmull–Rom cubic between the middle two of four values, at the fraction `part` of the interval.
fn cubic([a, b, c, d]: [f64; 4], part: f64) -> f64 {
    let (slope_b, slope_c) = (0.5 * (c - a), 0.5 * (d - b));
    hermite([b, c], [slope_b, slope_c], part)
}

/// Cubic with these end values and end slopes, at the fraction `part` of the interval, 0 to 1.
fn hermite([start, end]: [f64; 2], [rise, fall]: [f64; 2], part: f64) -> f64 {
    let (square, cube) = (part * part, part * part * part);
    (2.0 * cube - 3.0 * square + 1.0) * start
        + (cube - 2.0 * square + part) * rise
        + (3.0 * square - 2.0 * cube) * end
        + (cube - square) * fall
}

/// Resamples a signal with any sample times on a uniform grid from the first time on.
///
/// Values between samples come from local cubics. Their slope at a sample is that of the parabola through it and its
/// neighbours.
///
/// # Errors
/// [`PreprocessError`] for different lengths, fewer than two samples, or a gap longer than `longest_gap_s`. Also for
/// times that do not increase, or values that are not finite.
pub fn uniform(
    times_s: &[f64],
    values: &[f64],
    period_s: f64,
    longest_gap_s: f64,
) -> Result<Vec<f64>, PreprocessError> {
    if !(period_s > 0.0 && period_s.is_finite()) {
        return Err(PreprocessError::Period { period_s });
    }
    let samples = times_s.len().min(values.len());
    if samples < 2 || times_s.len() != values.len() {
        return Err(PreprocessError::TooShort { what: "interpolation", samples, needed: 1 });
    }
    for sample in 0..samples {
        let (time_s, value) = (times_s[sample], values[sample]);
        let rises = sample == 0 || time_s > times_s[sample - 1];
        if !(rises && time_s.is_finite() && value.is_finite()) {
            return Err(PreprocessError::Sample { sample, time_s, value });
        }
        if sample > 0 && time_s - times_s[sample - 1] > longest_gap_s {
            return Err(PreprocessError::Gap {
                from_s: times_s[sample - 1],
                gap_s: time_s - times_s[sample - 1],
                longest_s: longest_gap_s,
            });
        }
    }
    let chord =
        |from: usize| (values[from + 1] - values[from]) / (times_s[from + 1] - times_s[from]);
    let slope = |at: usize| match at {
        0 => chord(0),
        _ if at == samples - 1 => chord(at - 1),
        _ => {
            let (before, after) = (times_s[at] - times_s[at - 1], times_s[at + 1] - times_s[at]);
            (chord(at - 1) * after + chord(at) * before) / (before + after)
        }
    };
    let count = ((times_s[samples - 1] - times_s[0]) / period_s + 1e-9) as usize + 1;
    let mut from = 0;
    Ok((0..count)
        .map(|index| {
            let time_s = (times_s[0] + index as f64 * period_s).min(times_s[samples - 1]);
            while from + 2 < samples && times_s[from + 1] <= time_s {
                from += 1;
            }
            let width = times_s[from + 1] - times_s[from];
            hermite(
                [values[from], values[from + 1]],
                [slope(from) * width, slope(from + 1) * width],
                (time_s - times_s[from]) / width,
            )
        })
        .collect())
}
