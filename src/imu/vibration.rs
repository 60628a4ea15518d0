//! How strongly the unit shakes, measured from its own samples.

use super::second_difference::SecondDifference;
use crate::frames::{Body, Vector};
use crate::scalar::Scalar;

/// Running strength of what changes from sample to sample, per axis.
///
/// Measured on the second difference of the samples, which is blind to steady values and to steady
/// change; for noise without memory its variance is six times that of the noise. Vibration sampled
/// below twice its frequency looks just like that.
#[derive(Clone, Copy, Debug, Default)]
pub struct Vibration<T = f64> {
    difference: SecondDifference<T>,
    variance: [T; 3],
    seen_s: T,
}

/// Memory of the running variance, s.
const MEMORY_S: f64 = 2.0;

impl<T: Scalar> Vibration<T> {
    /// Nothing measured yet.
    pub const NONE: Self =
        Self { difference: SecondDifference::NONE, variance: [T::ZERO; 3], seen_s: T::ZERO };

    /// Takes in the next sample, `interval_s` after the one before.
    ///
    /// # Source
    /// Equation (S12) of docs/equations.md.
    pub fn push(&mut self, sample: Vector<Body, T>, interval_s: T) {
        let Some(difference) = self.difference.push(sample) else { return };
        self.seen_s = T::of(MEMORY_S).min(self.seen_s + interval_s);
        // A plain mean until the memory is filled, then exponential forgetting.
        let weight = (interval_s / self.seen_s).min(T::ONE);
        for (variance, change) in self.variance.iter_mut().zip(difference) {
            *variance += weight * (change * change / T::of(6.0) - *variance);
        }
    }

    /// Forgets the last two samples, after a gap.
    pub fn interrupt(&mut self) {
        self.difference.interrupt();
    }

    /// Variance per axis, in the unit of the samples squared.
    #[must_use]
    pub fn variance(&self) -> [T; 3] {
        self.variance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steady_change_is_not_vibration() {
        let mut vibration = Vibration::<f64>::default();
        for k in 0..100 {
            vibration.push(Vector::new(0.1 * f64::from(k), -9.81, 3.0), 0.01);
        }
        assert!(vibration.variance().iter().all(|&variance| variance < 1e-20));
    }

    #[test]
    fn noise_without_memory_shows_its_own_variance() {
        let mut vibration = Vibration::<f64>::default();
        let mut state = 1u64;
        for _ in 0..20_000 {
            // Uniform on ±√3 has unit variance; steps of a 64-bit congruential generator.
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let unit = (state >> 11) as f64 / (1u64 << 53) as f64;
            vibration.push(Vector::new((unit - 0.5) * 12f64.sqrt(), 0.0, 0.0), 0.001);
        }
        assert!((vibration.variance()[0] - 1.0).abs() < 0.1);
    }
}
