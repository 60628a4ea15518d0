//! Aliased vibration: narrow tones, detected and notched out.
//!
//! A rotor's harmonics alias to spectral lines within the band of the dynamics. A predictor would count these lines as
//! process noise and give all other motion at their frequencies a low weight. Every signal of a record, including
//! inputs, passes through the same notches, so that a linear model between them stays valid.
//!
//! A pilot or an autopilot responds to noise, so the notches are causal. A zero-phase notch would make the stick depend
//! on later noise and bias the identification. A notch also removes the noise in its band. That matters for a signal
//! whose noise the predictor does not model as white, such as a velocity. If its spectrum were empty there, the
//! identified noise would be too small at high frequencies and the slow disturbances too large. The band is therefore
//! refilled with noise as large as in the neighbouring bands.

use std::f64::consts::{PI, TAU};
use std::iter::successors;

use nalgebra::{Complex, Matrix2, Vector2};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;
use rand_distr::{Distribution as _, StandardNormal};
use rustfft::algorithm::Radix4;
use rustfft::{Fft as _, FftDirection};

use crate::record::experiment::Experiment;

/// A narrow line in a spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tone {
    /// Centre frequency, Hz.
    pub frequency_hz: f64,
    /// Width, Hz.
    pub width_hz: f64,
}

/// Number of samples of one periodogram.
const SEGMENT: usize = 512;
/// Smallest ratio of a line to the median of its neighbourhood.
const PROMINENCE: f64 = 10.0;
/// Neighbourhood on either side, Hz: wide compared with a line that moves with the rotor's speed.
const NEIGHBOURHOOD_HZ: f64 = 4.0;
/// Largest width of a tone, Hz.
const WIDEST_HZ: f64 = 3.0;
/// Width of a line, Hz, above which its frequency counts as moving. Several adjacent notches then cover the line.
const MOVES_HZ: f64 = 1.0;
/// Largest width of the notches that cover a moving line, Hz, before they overlap.
const NOTCH_HZ: f64 = 0.5;

/// Finds the tones above `least_hz` in the outputs of `record`. A tone is a line ten times above the median of its
/// neighbourhood in the spectrum of any output's differences.
///
/// Empty where the record is shorter than two segments of 512 samples.
#[must_use]
pub fn find_tones(record: &Experiment, least_hz: f64) -> Vec<Tone> {
    let bin_hz = 1.0 / (SEGMENT as f64 * record.period_s);
    let mut stands_out = vec![false; SEGMENT / 2];
    for column in record.outputs.column_iter() {
        let changes: Vec<f64> =
            column.as_slice().windows(2).map(|pair| pair[1] - pair[0]).collect();
        let spectrum = spectrum(&changes);
        for (bin, marked) in stands_out.iter_mut().enumerate() {
            let usual = median_around(&spectrum, bin, bin_hz);
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
                // The notches are slightly wider than their spacing, so that nothing passes between two of them.
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

/// The record with every signal passed twice through a notch at each tone. In the outputs named `filled`, noise with a
/// fixed seed replaces the removed band. It is as large as in the neighbouring bands.
///
/// Slow motion is delayed by [`notch_delay_s`], equally in every signal.
#[must_use]
pub fn without_tones(record: &Experiment, tones: &[Tone], filled: &[&str]) -> Experiment {
    let mut clean = record.clone();
    let mut random = ChaCha8Rng::seed_from_u64(1);
    for mut column in clean.inputs.column_iter_mut() {
        notch_all(column.as_mut_slice(), tones, record.period_s);
    }
    for (name, mut column) in record.output_names.iter().zip(clean.outputs.column_iter_mut()) {
        if !filled.contains(&name.as_str()) {
            notch_all(column.as_mut_slice(), tones, record.period_s);
            continue;
        }
        let changes: Vec<f64> =
            column.as_slice().windows(2).map(|pair| pair[1] - pair[0]).collect();
        let power = spectrum(&changes);
        let mut filling = vec![0.0; column.len()];
        for tone in tones {
            let signal = column.as_mut_slice();
            notch_twice(signal, *tone, record.period_s);
            notch_twice(&mut filling, *tone, record.period_s);
            let sigma = change_sigma(&power, *tone, record.period_s);
            let noise: Vec<f64> = (0..signal.len())
                .scan(0.0, |level, _| {
                    let change: f64 = StandardNormal.sample(&mut random);
                    *level = FADING * *level + sigma * change;
                    Some(*level)
                })
                .collect();
            let mut side_by_side = noise.clone();
            notch_twice(&mut side_by_side, *tone, record.period_s);
            for ((filling, noise), side_by_side) in filling.iter_mut().zip(noise).zip(side_by_side)
            {
                *filling += noise - side_by_side;
            }
        }
        column.iter_mut().zip(filling).for_each(|(value, filling)| *value += filling);
    }
    clean
}

/// Delay of slow motion by [`without_tones`], s.
#[must_use]
pub fn notch_delay_s(tones: &[Tone], period_s: f64) -> f64 {
    let samples = tones.iter().map(|tone| {
        let (radius, cosine) = tone.poles(period_s);
        let remaining = 1.0 - 2.0 * radius * cosine + radius * radius;
        2.0 * (1.0 - 2.0 * radius * (radius - cosine) / remaining)
    });
    period_s * samples.sum::<f64>()
}

impl Tone {
    /// Radius of the poles of the tone's notch, and cosine of their angle.
    fn poles(self, period_s: f64) -> (f64, f64) {
        let radius = (1.0 - PI * self.width_hz * period_s).max(0.0);
        (radius, (TAU * self.frequency_hz * period_s).cos())
    }
}

/// Decay factor per sample of the filling noise. The decay is slow compared with any tone.
const FADING: f64 = 0.999;

/// σ of a white sequence with the power density that the differences of a signal have next to `tone`. `power` is the
/// spectrum of these differences.
fn change_sigma(power: &[f64], tone: Tone, period_s: f64) -> f64 {
    let bin_hz = 1.0 / (SEGMENT as f64 * period_s);
    median_around(power, (tone.frequency_hz / bin_hz) as usize, bin_hz).sqrt()
}

/// Median of `power` within the neighbourhood of `bin`; 0 where it is empty.
fn median_around(power: &[f64], bin: usize, bin_hz: f64) -> f64 {
    let reach = (NEIGHBOURHOOD_HZ / bin_hz).ceil() as usize;
    let around = bin.saturating_sub(reach)..(bin + reach + 1).min(power.len());
    let mut around = power.get(around).map_or_else(Vec::new, <[f64]>::to_vec);
    around.sort_by(f64::total_cmp);
    around.get(around.len() / 2).copied().unwrap_or_default()
}

fn notch_all(signal: &mut [f64], tones: &[Tone], period_s: f64) {
    tones.iter().for_each(|tone| notch_twice(signal, *tone, period_s));
}

fn notch_twice(signal: &mut [f64], tone: Tone, period_s: f64) {
    for _ in 0..2 {
        notch(signal, tone, period_s);
    }
}

/// A notch with two zeros on the unit circle and two poles of the tone's width inside it; its gain is 1 at zero
/// frequency.
fn notch(signal: &mut [f64], tone: Tone, period_s: f64) {
    let (radius, cosine) = tone.poles(period_s);
    let (late, later) = (-2.0 * radius * cosine, radius * radius);
    let gain = (1.0 + late + later) / (2.0 - 2.0 * cosine);
    // The filter starts in the steady state of the first value: a constant causes no transient. `still` removes that
    // of a tone.
    let first = signal.first().copied().unwrap_or(0.0);
    let (mut in_1, mut in_2, mut out_1, mut out_2) = (first, first, first, first);
    for value in signal.iter_mut() {
        let input = *value;
        let output = gain * (input - 2.0 * cosine * in_1 + in_2) - late * out_1 - later * out_2;
        (in_2, in_1, out_2, out_1) = (in_1, input, out_1, output);
        *value = output;
    }
    still(signal, radius, TAU * tone.frequency_hz * period_s);
}

/// Relative size of a transient below which it is neglected.
const INAUDIBLE: f64 = 1e-12;

/// Removes the initial transient of a notch with poles of `radius` at `angle`. The transient exists because the record
/// begins within the tone, and the filter starts in the steady state of a constant. It is fitted to differences, in
/// which slow motion is small.
fn still(signal: &mut [f64], radius: f64, angle: f64) {
    let turn = Complex::from_polar(radius, angle);
    let ringing = || {
        let audible = |ringing: &Complex<f64>| ringing.norm_sqr() > INAUDIBLE * INAUDIBLE;
        successors(Some(Complex::new(1.0, 0.0)), |ringing| Some(ringing * turn)).take_while(audible)
    };
    let (mut own, mut found) = (Matrix2::zeros(), Vector2::zeros());
    for (pair, ringing) in signal.windows(2).zip(ringing()) {
        let change = ringing * turn - ringing;
        let change = Vector2::new(change.re, change.im);
        own += change * change.transpose();
        found += change * (pair[1] - pair[0]);
    }
    let Some(amplitude) = own.try_inverse().map(|inverse| inverse * found) else { return };
    for (value, ringing) in signal.iter_mut().zip(ringing()) {
        *value -= amplitude.dot(&Vector2::new(ringing.re, ringing.im));
    }
}

/// Welch's mean periodogram with a Hann window and half overlap; for white noise it equals the variance.
fn spectrum(signal: &[f64]) -> Vec<f64> {
    let mut power = vec![0.0; SEGMENT / 2];
    if signal.len() < 2 * SEGMENT {
        return Vec::new();
    }
    let transform = Radix4::new(SEGMENT, FftDirection::Forward);
    let mut segments = 0.0;
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
        segments += 1.0;
    }
    // The sum of a Hann window's squares is 3/8 of its length.
    power.iter_mut().for_each(|power| *power /= 0.375 * SEGMENT as f64 * segments);
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
            // A little broadband noise: the residue of a chirp modulo one.
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
        let clean = without_tones(&record(0.05), &tones, &["y"]);
        let truth = record(0.0);
        let later = notch_delay_s(&tones, 0.03) / 0.03;
        assert!((0.0..1.0).contains(&later), "{later}");
        for sample in 200..3800 {
            let [now, before] = [0, 1].map(|back| truth.outputs[(sample - back, 0)]);
            let left = clean.outputs[(sample, 0)] - (now + later * (before - now));
            assert!(left.abs() < 0.003, "{left} at {sample}");
        }
    }

    #[test]
    fn a_record_without_tones_has_none() {
        assert_eq!(find_tones(&record(0.0), 3.0), Vec::new());
    }
}
