//! Strongest vibration lines in the spectrum of an inertial unit.

use std::f64::consts::TAU;

use serde::Serialize;

use crate::rates::{AXES, Rates};
use hovernav_dataset::statistics::quantile;

/// A line in the vibration spectrum.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VibrationLine {
    /// Sensor axis: `gyro x` to `accelerometer z`.
    pub axis: &'static str,
    /// Frequency, Hz, as sampled: a vibration above half the sample rate appears at its alias.
    pub frequency_hz: f64,
    /// Amplitude, in `unit`.
    pub amplitude: f64,
    /// Unit of the amplitude: rad/s or m/s².
    pub unit: &'static str,
}

/// Number of samples in a segment of the spectrum.
const LENGTH: usize = 256;
/// Largest number of segments of the spectrum.
const SEGMENTS: usize = 32;
/// Smallest ratio of a line's power to that of its neighbourhood.
const ABOVE: f64 = 8.0;
/// Number of bins in the neighbourhood of a line.
const NEAR: usize = 12;
/// Largest number of lines of each triad.
const MAX_LINES: usize = 3;
/// Lowest frequency of a vibration line, Hz: lower ones are motion of the vehicle.
const SLOWEST_HZ: f64 = 3.0;

/// Strongest lines of gyros and of accelerometers, each for its strongest axis.
///
/// # Source
/// Averaged periodograms of segments with a Hann window: P. D. Welch (1967), The use of fast Fourier
/// transform for the estimation of power spectra, *IEEE Transactions on Audio and Electroacoustics* 15
/// (2), 70–73.
pub(crate) fn vibration_lines(rates: &[Rates]) -> Vec<VibrationLine> {
    let mut intervals: Vec<f64> = rates.iter().skip(1).map(|at| at.interval_s).collect();
    let Some(interval_s) = quantile(&mut intervals, 0.5).filter(|interval| *interval > 0.0) else {
        return Vec::new();
    };
    let whole = |part: &&[Rates]| part[1..].iter().all(|at| at.interval_s < 1.6 * interval_s);
    let segments: Vec<&[Rates]> = rates.chunks_exact(LENGTH).filter(whole).collect();
    let every = segments.len().div_ceil(SEGMENTS).max(1);
    let segments: Vec<&[Rates]> = segments.into_iter().step_by(every).collect();
    if segments.is_empty() {
        return Vec::new();
    }
    let waves: Vec<(f64, f64)> =
        (0..LENGTH).map(|k| (TAU * k as f64 / LENGTH as f64).sin_cos()).collect();
    let mut found: [Vec<VibrationLine>; 2] = Default::default();
    for (axis, name) in AXES.into_iter().enumerate() {
        let power = power(&segments, |at| at.six()[axis], &waves);
        let slowest = (SLOWEST_HZ * interval_s * LENGTH as f64).ceil() as usize;
        for bin in slowest.max(2)..power.len().saturating_sub(2) {
            let is_top = (bin - 2..=bin + 2).all(|other| power[other] <= power[bin]);
            let (from, to) = (bin.saturating_sub(NEAR).max(1), (bin + NEAR).min(power.len() - 1));
            let mut near = power[from..=to].to_vec();
            let floor = quantile(&mut near, 0.5).unwrap_or(f64::INFINITY);
            if !is_top || power[bin] < ABOVE * floor {
                continue;
            }
            // A Hann window spreads a line over three bins.
            let strength: f64 = power[bin - 1..=bin + 1].iter().sum();
            let (frequency_hz, amplitude) =
                (bin as f64 / (LENGTH as f64 * interval_s), (2.0 * strength / 1.5).sqrt());
            let unit = if axis < 3 { "rad/s" } else { "m/s²" };
            let lines = &mut found[axis / 3];
            let bin_hz = 1.0 / (LENGTH as f64 * interval_s);
            let line = VibrationLine { axis: name, frequency_hz, amplitude, unit };
            let same =
                lines.iter_mut().find(|l| (l.frequency_hz - frequency_hz).abs() < 2.5 * bin_hz);
            match same {
                Some(known) if known.amplitude < amplitude => *known = line,
                Some(_) => {}
                None => lines.push(line),
            }
        }
    }
    for lines in &mut found {
        lines.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
        lines.truncate(MAX_LINES);
    }
    found.concat()
}

/// Mean power of the segments at each frequency from 0 to half the rate. A sine of amplitude a has a²/2, spread over
/// three bins.
fn power(segments: &[&[Rates]], of: impl Fn(&Rates) -> f64, waves: &[(f64, f64)]) -> Vec<f64> {
    let mut power = vec![0.0; LENGTH / 2 + 1];
    for segment in segments {
        let mean = segment.iter().map(&of).sum::<f64>() / LENGTH as f64;
        let windowed: Vec<f64> = segment
            .iter()
            .zip(waves)
            .map(|(at, (_, cosine))| (of(at) - mean) * (1.0 - cosine))
            .collect();
        for (bin, power) in power.iter_mut().enumerate() {
            let (mut real, mut imaginary) = (0.0, 0.0);
            for (k, value) in windowed.iter().enumerate() {
                let (sine, cosine) = waves[bin * k % LENGTH];
                real += value * cosine;
                imaginary += value * sine;
            }
            let scale = 2.0 / ((LENGTH * LENGTH) as f64 * segments.len() as f64);
            *power += (real * real + imaginary * imaginary) * scale;
        }
    }
    power
}

#[cfg(test)]
mod tests {
    use super::*;
    use hovernav::imu::ImuAxes;
    use hovernav::time::Time;

    #[test]
    fn a_line_is_found_at_its_frequency_and_amplitude() {
        let mut state = 1u64;
        let rates: Vec<Rates> = (0..4000)
            .map(|k| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                let noise = (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
                let time_s = 0.01 * f64::from(k);
                let line = 2.0 * (TAU * 21.3 * time_s).sin();
                Rates {
                    time: Time::ZERO + time_s,
                    interval_s: 0.01,
                    turn_radps: [0.1 * noise; 3],
                    force_mps2: [noise, noise, line + noise - 9.8],
                    clipped: ImuAxes::NONE,
                }
            })
            .collect();
        let lines = vibration_lines(&rates);
        let [line] = &lines[..] else { panic!("{lines:?}") };
        assert_eq!((line.axis, line.unit), ("accelerometer z", "m/s²"));
        assert!((line.frequency_hz - 21.3).abs() < 0.3, "{line:?}");
        assert!((line.amplitude / 2.0 - 1.0).abs() < 0.15, "{line:?}");
    }
}
