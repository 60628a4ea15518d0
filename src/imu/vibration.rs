//! Strength of the vibration, measured from the inertial unit's own samples.

use crate::scalar::Scalar;

/// Running variance of the vibration, taken as white noise, per axis.
///
/// Measured on the second difference of the samples, which is zero for constant values and constant rates of change.
/// For white noise the variance of the second difference is six times that of the noise. Vibration sampled at less than
/// twice its frequency has the statistics of white noise.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Vibration<T = f64> {
    variance: [T; 3],
    seen_s: T,
}

/// Memory of the running variance, s.
const MEMORY_S: f64 = 2.0;

impl<T: Scalar> Vibration<T> {
    /// State before the first sample.
    pub const NONE: Self = Self { variance: [T::ZERO; 3], seen_s: T::ZERO };

    /// Feeds the [noise](super::noise_variance) of a sample, `interval_s` after the previous one.
    ///
    /// # Source
    /// Equation (S12) of docs/equations.md.
    pub fn push(&mut self, noise: [T; 3], interval_s: T) {
        self.seen_s = T::of(MEMORY_S).min(self.seen_s + interval_s);
        // The variance is a plain mean until the memory is filled; after that it forgets old samples exponentially.
        let weight = (interval_s / self.seen_s).min(T::ONE);
        for (variance, noise) in self.variance.iter_mut().zip(noise) {
            *variance += weight * (noise - *variance);
        }
    }

    /// Variance per axis, in the unit of the samples squared.
    #[must_use]
    pub fn variance(&self) -> [T; 3] {
        self.variance
    }
}

#[cfg(test)]
mod tests {
    use super::super::{SecondDifference, noise_variance};
    use super::*;
    use crate::frames::Vector;

    /// Final variance over `count` samples of the function `sample`.
    fn variance(count: i32, interval_s: f64, mut sample: impl FnMut(i32) -> [f64; 3]) -> [f64; 3] {
        let (mut difference, mut vibration) = (SecondDifference::NONE, Vibration::NONE);
        for k in 0..count {
            if let Some(change) = difference.push(Vector::from(sample(k))) {
                vibration.push(noise_variance(change), interval_s);
            }
        }
        vibration.variance()
    }

    #[test]
    fn steady_change_is_not_vibration() {
        let variance = variance(100, 0.01, |k| [0.1 * f64::from(k), -9.81, 3.0]);
        assert!(variance.iter().all(|&variance| variance < 1e-20));
    }

    #[test]
    fn noise_without_memory_shows_its_own_variance() {
        let mut state = 1u64;
        let [variance, ..] = variance(20_000, 0.001, |_| {
            // Uniform on ±√3 has unit variance; steps of a 64-bit congruential generator.
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let unit = (state >> 11) as f64 / (1u64 << 53) as f64;
            [(unit - 0.5) * 12f64.sqrt(), 0.0, 0.0]
        });
        assert!((variance - 1.0).abs() < 0.1);
    }
}
