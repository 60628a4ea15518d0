//! The vibration spectrum of a sensor.

use std::collections::VecDeque;
use std::f64::consts::TAU;

/// Samples per segment: 0.8 Hz between spectral lines at 100 Hz.
const SEGMENT: usize = 128;
/// Largest number of averaged segments, spread over the log.
const SEGMENTS: usize = 96;

/// Amplitude spectral density of evenly spaced values, computed value by value: averaged periodograms of
/// half-overlapping segments, with a Hann window and without their mean. The discrete Fourier transform is written out,
/// because 128 points do not justify a library.
///
/// # Source
/// Welch (1967), The use of fast Fourier transform for the estimation of power spectra, *IEEE
/// Transactions on Audio and Electroacoustics* 15 (2), 70–73.
pub struct Density {
    /// Total number of values.
    count: usize,
    window: Vec<f64>,
    turns: Vec<(f64, f64)>,
    /// Number of values received.
    seen: usize,
    /// The most recent values.
    recent: VecDeque<f64>,
    /// Index of the next segment.
    segment: usize,
    /// Number of segments used.
    used: u32,
    power: Vec<f64>,
}

impl Density {
    /// An empty density for a series of `count` values.
    pub fn of(count: usize) -> Self {
        let angle = |i: usize| TAU * i as f64 / SEGMENT as f64;
        Self {
            count,
            window: (0..SEGMENT).map(|i| 0.5 - 0.5 * angle(i).cos()).collect(),
            turns: (0..SEGMENT).map(|i| angle(i).sin_cos()).collect(),
            seen: 0,
            recent: VecDeque::with_capacity(SEGMENT),
            segment: 0,
            used: 0,
            power: vec![0.0; SEGMENT / 2],
        }
    }

    /// Index of the first value of a segment; `None` beyond the last segment.
    fn start(&self, segment: usize) -> Option<usize> {
        let last_start = self.count.checked_sub(SEGMENT)?;
        let segments = (2 * last_start / SEGMENT + 1).min(SEGMENTS);
        (segment < segments).then(|| segment * last_start / (segments - 1).max(1))
    }

    pub fn push(&mut self, value: f64) {
        if self.recent.len() == SEGMENT {
            self.recent.pop_front();
        }
        self.recent.push_back(value);
        self.seen += 1;
        if self.start(self.segment).is_some_and(|start| start + SEGMENT == self.seen) {
            self.segment += 1;
            self.add();
        }
    }

    /// Adds the power of the most recent segment.
    fn add(&mut self) {
        let Some(windowed) = windowed(self.recent.make_contiguous(), &self.window) else { return };
        self.used += 1;
        for (line, power) in self.power.iter_mut().enumerate() {
            let (mut re, mut im) = (0.0, 0.0);
            for (index, value) in windowed.iter().enumerate() {
                let (sin, cos) = self.turns[line * index % SEGMENT];
                re += value * cos;
                im -= value * sin;
            }
            *power += re * re + im * im;
        }
    }

    /// Frequency, Hz, and density, unit/√Hz. `None` without a complete segment of finite values, or for an invalid
    /// interval.
    pub fn finish(&self, interval_s: f64) -> Option<Vec<(f64, f64)>> {
        if self.used == 0 || !(interval_s.is_finite() && interval_s > 0.0) {
            return None;
        }
        let window_power: f64 = self.window.iter().map(|weight| weight * weight).sum();
        // One-sided: the power at negative frequencies is added.
        let scale = 2.0 * interval_s / (window_power * f64::from(self.used));
        let step_hz = 1.0 / (interval_s * SEGMENT as f64);
        let lines = self.power.iter().enumerate().skip(1);
        Some(lines.map(|(line, power)| (line as f64 * step_hz, (scale * power).sqrt())).collect())
    }
}

/// A segment minus its mean, with the window applied; `None` if a sample is not finite.
fn windowed(segment: &[f64], window: &[f64]) -> Option<Vec<f64>> {
    let mean = segment.iter().sum::<f64>() / segment.len() as f64;
    mean.is_finite().then(|| {
        segment.iter().zip(window).map(|(value, weight)| (value - mean) * weight).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    fn density(values: &[f64], interval_s: f64) -> Option<Vec<(f64, f64)>> {
        let mut density = Density::of(values.len());
        values.iter().for_each(|value| density.push(*value));
        density.finish(interval_s)
    }

    #[test]
    fn a_sine_stands_at_its_frequency_with_its_power() {
        let rate_hz = 128.0;
        let values: Vec<f64> =
            (0..4096).map(|i| 3.0 * (TAU * 20.0 * f64::from(i) / rate_hz).sin() + 9.81).collect();
        let lines = density(&values, 1.0 / rate_hz).unwrap();
        let peak = lines.iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        assert!((peak.0 - 20.0).abs() < 0.01, "{peak:?}");
        let variance: f64 = lines.iter().map(|(_, density)| density * density).sum();
        assert_abs_diff_eq!(variance, 4.5, epsilon = 0.1);
    }

    #[test]
    fn what_has_no_spectrum_gets_none() {
        assert_eq!(density(&[0.0; 100], 0.01), None);
        assert_eq!(density(&[f64::NAN; 500], 0.01), None);
        assert_eq!(density(&[0.0; 500], 0.0), None);
    }
}
