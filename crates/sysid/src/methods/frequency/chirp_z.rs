//! The chirp-z transform: a spectrum on any band of frequencies.

use std::f64::consts::TAU;
use std::fmt;

use nalgebra::Complex;
use rustfft::algorithm::Radix4;
use rustfft::{Fft, FftDirection};

/// X(k) = Σₙ x(n) exp(−j 2π (first + k·step) n), frequencies in cycles per sample.
///
/// The transform gives any number of arbitrarily close frequencies from any number of samples, at the cost of three
/// fast Fourier transforms.
///
/// Source: L. Rabiner, R. Schafer & C. Rader (1969), "The chirp z-transform algorithm", *IEEE Trans.
/// Audio and Electroacoustics* 17(2); the convolution is Bluestein's.
pub struct ChirpZ {
    /// Phasor of first·n + ½·step·n² turns for each sample n.
    before: Vec<Complex<f64>>,
    /// Phasor of ½·step·k² turns for each frequency k, multiplied by the scale of the transforms.
    after: Vec<Complex<f64>>,
    kernel: Vec<Complex<f64>>,
    forward: Radix4<f64>,
    inverse: Radix4<f64>,
}

impl fmt::Debug for ChirpZ {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ChirpZ({} samples to {} frequencies)", self.before.len(), self.after.len())
    }
}

impl ChirpZ {
    /// A transform of `samples` samples to `points` frequencies from `first` on, `step` apart, in
    /// cycles per sample.
    #[must_use]
    pub fn new(samples: usize, first: f64, step: f64, points: usize) -> Self {
        let length = (samples + points).next_power_of_two();
        let [forward, inverse] = [FftDirection::Forward, FftDirection::Inverse]
            .map(|direction| Radix4::new(length, direction));
        // Taking the fraction of a turn before the sine keeps long records exact.
        let phasor = |turns: f64| Complex::from_polar(1.0, -TAU * turns.fract());
        let chirp = |index: usize| 0.5 * step * (index as f64) * (index as f64);
        let mut kernel = vec![Complex::new(0.0, 0.0); length];
        for index in 0..samples.max(points) {
            let value = phasor(-chirp(index));
            if index < points {
                kernel[index] = value;
            }
            if index > 0 && index < samples {
                kernel[length - index] = value;
            }
        }
        forward.process(&mut kernel);
        let scale = 1.0 / length as f64;
        Self {
            before: (0..samples).map(|n| phasor((first * n as f64).fract() + chirp(n))).collect(),
            after: (0..points).map(|k| phasor(chirp(k)) * scale).collect(),
            kernel,
            forward,
            inverse,
        }
    }

    /// The transform of `signal`, one value per frequency. Samples beyond the transform's length are
    /// ignored, missing ones count as zero.
    ///
    /// # Source
    /// Equation (I17) of docs/equations.md.
    #[must_use]
    pub fn transform(&self, signal: &[f64]) -> Vec<Complex<f64>> {
        let mut buffer = vec![Complex::new(0.0, 0.0); self.kernel.len()];
        for ((slot, value), phasor) in buffer.iter_mut().zip(signal).zip(&self.before) {
            *slot = phasor * value;
        }
        self.forward.process(&mut buffer);
        for (value, kernel) in buffer.iter_mut().zip(&self.kernel) {
            *value *= kernel;
        }
        self.inverse.process(&mut buffer);
        buffer.iter().zip(&self.after).map(|(value, phasor)| value * phasor).collect()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use rustfft::algorithm::Dft;

    use super::*;

    fn sum(signal: &[f64], frequency: f64) -> Complex<f64> {
        let turned = |(n, x): (usize, &f64)| {
            Complex::from_polar(1.0, -TAU * (frequency * n as f64).fract()) * *x
        };
        signal.iter().enumerate().map(turned).sum()
    }

    #[test]
    fn it_equals_the_sum_it_stands_for() {
        let signal: Vec<f64> =
            (0..997).map(|n| (0.3 * f64::from(n)).sin() + 0.01 * f64::from(n)).collect();
        for (first, step, points) in [(0.01, 1.3e-4, 61), (0.0, 1.0 / 997.0, 997), (0.3, -2e-3, 40)]
        {
            let fast = ChirpZ::new(signal.len(), first, step, points).transform(&signal);
            let size: f64 = signal.iter().map(|value| value.abs()).sum();
            for (k, value) in fast.iter().enumerate() {
                let slow = sum(&signal, first + step * k as f64);
                assert!((value - slow).norm() < 1e-12 * size, "{k}: {value} {slow}");
            }
        }
    }

    proptest! {
        #[test]
        fn any_signal_on_any_band_is_transformed_as_by_the_sum(
            signal in prop::collection::vec(-1e3..1e3, 1..300),
            first in -1.0..1.0,
            step in -0.02..0.02,
            points in 1..120_usize,
        ) {
            let fast = ChirpZ::new(signal.len(), first, step, points).transform(&signal);
            let size: f64 = signal.iter().map(|value: &f64| value.abs()).sum();
            prop_assert_eq!(fast.len(), points);
            for (k, value) in fast.iter().enumerate() {
                let slow = sum(&signal, first + step * k as f64);
                prop_assert!((value - slow).norm() < 1e-11 * size, "{}: {} {}", k, value, slow);
            }
        }

        #[test]
        fn on_the_whole_circle_it_is_the_discrete_fourier_transform(
            signal in prop::collection::vec(-1e3..1e3, 1..300),
        ) {
            let count = signal.len();
            let mut fourier: Vec<_> = signal.iter().map(|&value| Complex::from(value)).collect();
            Dft::new(count, FftDirection::Forward).process(&mut fourier);
            let chirp = ChirpZ::new(count, 0.0, (count as f64).recip(), count).transform(&signal);
            let size: f64 = signal.iter().map(|value: &f64| value.abs()).sum();
            for (one, other) in chirp.iter().zip(&fourier) {
                prop_assert!((one - other).norm() < 1e-11 * size, "{} {}", one, other);
            }
        }
    }
}
