//! Vibration that sampling has folded into the band: narrow tones, found and notched out.
//!
//! A rotor's harmonics alias to lines among the dynamics. A predictor takes them for process noise
//! and doubts everything else at that frequency. Every signal of a record, inputs included, goes
//! through the same notches, so that what a linear model says between them stays true.

use std::f64::consts::{PI, TAU};

use crate::record::experiment::Experiment;

/// A narrow line in a spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tone {
    /// Its middle, Hz.
    pub frequency_hz: f64,
    /// Its width, Hz.
    pub width_hz: f64,
}

/// Samples of one periodogram.
const SEGMENT: usize = 512;
/// How far above its neighbourhood's median a line stands.
const PROMINENCE: f64 = 10.0;
/// Neighbourhood to either side, Hz: wide against a line that moves with the rotor's speed.
const NEIGHBOURHOOD_HZ: f64 = 4.0;
/// Widest line that is a tone, Hz.
const WIDEST_HZ: f64 = 3.0;
/// A line wider than this moves, Hz, and is covered by several notches side by side, each no wider than
/// the second.
const MOVES_HZ: f64 = 1.0;
const NOTCH_HZ: f64 = 0.5;

/// Finds the tones above `least_hz` in the outputs of `record`: lines ten times above the median of
/// their neighbourhood in the spectrum of any output's differences.
///
/// None where the record is shorter than two segments of 512 samples.
#[must_use]
pub fn find_tones(record: &Experiment, least_hz: f64) -> Vec<Tone> {
    let bin_hz = 1.0 / (SEGMENT as f64 * record.period_s);
    let reach = (NEIGHBOURHOOD_HZ / bin_hz).ceil() as usize;
    let mut stands_out = vec![false; SEGMENT / 2];
    for column in record.outputs.column_iter() {
        let changes: Vec<f64> =
            column.as_slice().windows(2).map(|pair| pair[1] - pair[0]).collect();
        let spectrum = spectrum(&changes);
        for (bin, marked) in stands_out.iter_mut().enumerate() {
            let around = bin.saturating_sub(reach)..(bin + reach + 1).min(spectrum.len());
            let mut around = spectrum.get(around).map_or_else(Vec::new, <[f64]>::to_vec);
            around.sort_by(f64::total_cmp);
            let usual = around.get(around.len() / 2).copied().unwrap_or(f64::INFINITY);
            *marked |= bin as f64 * bin_hz >= least_hz
                && spectrum.get(bin).is_some_and(|power| *power > PROMINENCE * usual);
        }
    }
    let mut tones = Vec::new();
    let mut bin = 0;
    while bin < stands_out.len() {
        let first = bin;
        while stands_out.get(bin) == Some(&true) {
            bin += 1;
        }
        if bin > first {
            let width_hz = (bin - first + 1) as f64 * bin_hz;
            let middle_hz = 0.5 * (first + bin - 1) as f64 * bin_hz;
            if width_hz <= WIDEST_HZ {
                let count = if width_hz > MOVES_HZ { (width_hz / NOTCH_HZ).ceil() } else { 1.0 };
                let apart_hz = width_hz / count;
                let lowest_hz = middle_hz - 0.5 * (count - 1.0) * apart_hz;
                // A little wider than they are apart, so that nothing passes between two.
                let width_hz = if count > 1.0 { 1.25 * apart_hz } else { width_hz };
                tones.extend((0..count as usize).map(|notch| {
                    let frequency_hz = lowest_hz + notch as f64 * apart_hz;
                    Tone { frequency_hz, width_hz }
                }));
            }
        }
        bin += 1;
    }
    tones
}

/// The record with every signal through a notch at each tone, forward and backward: no phase.
#[must_use]
pub fn without_tones(record: &Experiment, tones: &[Tone]) -> Experiment {
    let mut clean = record.clone();
    let columns = clean.inputs.column_iter_mut().chain(clean.outputs.column_iter_mut());
    for mut column in columns {
        let mean = column.mean();
        let mut signal: Vec<f64> = column.iter().map(|value| value - mean).collect();
        for tone in tones {
            for _ in 0..2 {
                notch(&mut signal, *tone, record.period_s);
                signal.reverse();
            }
        }
        for (value, filtered) in column.iter_mut().zip(signal) {
            *value = filtered + mean;
        }
    }
    clean
}

/// Two zeros on the unit circle, two poles of the tone's width inside: 1 at zero frequency.
fn notch(signal: &mut [f64], tone: Tone, period_s: f64) {
    let cosine = (TAU * tone.frequency_hz * period_s).cos();
    let radius = (1.0 - PI * tone.width_hz * period_s).max(0.0);
    let (late, later) = (-2.0 * radius * cosine, radius * radius);
    let gain = (1.0 + late + later) / (2.0 - 2.0 * cosine);
    // At rest at the first value, so that nothing rings there.
    let first = signal.first().copied().unwrap_or(0.0);
    let (mut in_1, mut in_2, mut out_1, mut out_2) = (first, first, first, first);
    for value in signal {
        let input = *value;
        let output = gain * (input - 2.0 * cosine * in_1 + in_2) - late * out_1 - later * out_2;
        (in_2, in_1, out_2, out_1) = (in_1, input, out_1, output);
        *value = output;
    }
}

/// Welch's mean periodogram, Hann window, halves overlapping; its scale is of no matter here.
fn spectrum(signal: &[f64]) -> Vec<f64> {
    let mut power = vec![0.0; SEGMENT / 2];
    if signal.len() < 2 * SEGMENT {
        return Vec::new();
    }
    let mut planner = rustfft::FftPlanner::new();
    let transform = planner.plan_fft_forward(SEGMENT);
    for start in (0..=signal.len() - SEGMENT).step_by(SEGMENT / 2) {
        let mut piece: Vec<rustfft::num_complex::Complex<f64>> = (0..SEGMENT)
            .map(|sample| {
                let window = 0.5 - 0.5 * (TAU * sample as f64 / SEGMENT as f64).cos();
                (window * signal[start + sample]).into()
            })
            .collect();
        transform.process(&mut piece);
        for (power, value) in power.iter_mut().zip(&piece) {
            *power += value.norm_sqr();
        }
    }
    power
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;

    /// A slow wave with a tone on it.
    fn record(tone: f64) -> Experiment {
        let outputs = DMatrix::from_fn(4000, 1, |sample, _| {
            let time_s = sample as f64 * 0.03;
            // A little broadband noise: a chirp's residue modulo one.
            let noise = (time_s * time_s * 91.7).fract() - 0.5;
            time_s.sin() + 0.001 * noise + tone * (TAU * 6.3 * time_s).sin()
        });
        let names = (vec!["s".to_owned()], vec!["y".to_owned()]);
        Experiment::new("tone", 0.03, names.0, names.1, DMatrix::zeros(4000, 1), outputs)
            .expect("finite")
    }

    #[test]
    fn a_tone_is_found_and_leaves_without_a_trace_on_what_is_slow() {
        let tones = find_tones(&record(0.05), 3.0);
        assert_eq!(tones.len(), 1, "{tones:?}");
        assert!((tones[0].frequency_hz - 6.3).abs() < 0.1, "{tones:?}");
        let clean = without_tones(&record(0.05), &tones);
        let truth = record(0.0);
        for sample in 200..3800 {
            let left = clean.outputs[(sample, 0)] - truth.outputs[(sample, 0)];
            assert!(left.abs() < 0.003, "{left} at {sample}");
        }
    }

    #[test]
    fn a_record_without_tones_has_none() {
        assert_eq!(find_tones(&record(0.0), 3.0), Vec::new());
    }
}
