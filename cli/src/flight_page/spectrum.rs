//! The spectrum of a vibrating sensor.

use std::f64::consts::TAU;

/// Samples of one segment: at 100 Hz lines 0.8 Hz apart.
const SEGMENT: usize = 128;
/// Segments averaged at most, spread over the log.
const SEGMENTS: usize = 96;

/// Frequency, Hz, and amplitude spectral density, unit/√Hz, of evenly spaced `values`: periodograms of
/// half overlapping segments, Hann window, mean and slope removed, averaged. `None` of fewer samples
/// than one segment has. The transform is spelt out: 128 points need no library of their own.
///
/// # Source
/// Welch (1967), The use of fast Fourier transform for the estimation of power spectra, *IEEE
/// Transactions on Audio and Electroacoustics* 15 (2), 70–73.
pub fn density(values: &[f64], interval_s: f64) -> Option<Vec<(f64, f64)>> {
    let last_start = values.len().checked_sub(SEGMENT)?;
    if !(interval_s.is_finite() && interval_s > 0.0) {
        return None;
    }
    let count = (2 * last_start / SEGMENT + 1).min(SEGMENTS);
    let window: Vec<f64> =
        (0..SEGMENT).map(|i| 0.5 - 0.5 * (TAU * i as f64 / SEGMENT as f64).cos()).collect();
    let window_power: f64 = window.iter().map(|weight| weight * weight).sum();
    let turns: Vec<(f64, f64)> =
        (0..SEGMENT).map(|i| (TAU * i as f64 / SEGMENT as f64).sin_cos()).collect();
    let mut power = vec![0.0; SEGMENT / 2];
    let mut used = 0;
    for segment in 0..count {
        let start = segment * last_start / (count - 1).max(1);
        let Some(windowed) = windowed(&values[start..start + SEGMENT], &window) else { continue };
        used += 1;
        for (line, power) in power.iter_mut().enumerate() {
            let (mut re, mut im) = (0.0, 0.0);
            for (index, value) in windowed.iter().enumerate() {
                let (sin, cos) = turns[line * index % SEGMENT];
                re += value * cos;
                im -= value * sin;
            }
            *power += re * re + im * im;
        }
    }
    // One-sided: what stands at negative frequencies counts too.
    let scale = 2.0 * interval_s / (window_power * f64::from(used.max(1)));
    let step_hz = 1.0 / (interval_s * SEGMENT as f64);
    let lines = power.iter().enumerate().skip(1);
    let lines = lines.map(|(line, power)| (line as f64 * step_hz, (scale * power).sqrt()));
    (used > 0).then(|| lines.collect())
}

/// A segment less its mean, weighted; `None` where a sample is not finite.
fn windowed(segment: &[f64], window: &[f64]) -> Option<Vec<f64>> {
    let mean = segment.iter().sum::<f64>() / segment.len() as f64;
    mean.is_finite().then(|| {
        segment.iter().zip(window).map(|(value, weight)| (value - mean) * weight).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sine_stands_at_its_frequency_with_its_power() {
        let rate_hz = 128.0;
        let values: Vec<f64> =
            (0..4096).map(|i| 3.0 * (TAU * 20.0 * f64::from(i) / rate_hz).sin() + 9.81).collect();
        let lines = density(&values, 1.0 / rate_hz).unwrap();
        let peak = lines.iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        assert!((peak.0 - 20.0).abs() < 0.01, "{peak:?}");
        let variance: f64 = lines.iter().map(|(_, density)| density * density).sum();
        assert!((variance - 4.5).abs() < 0.1, "{variance}");
    }

    #[test]
    fn what_has_no_spectrum_gets_none() {
        assert_eq!(density(&[0.0; 100], 0.01), None);
        assert_eq!(density(&[f64::NAN; 500], 0.01), None);
        assert_eq!(density(&[0.0; 500], 0.0), None);
    }
}
