//! The stabilised update by one scalar measurement.
#![expect(
    clippy::indexing_slicing,
    reason = "every index is below the number of states, which is the bound of its loop"
)]

use super::{Covariance, Sensitivity};
use crate::scalar::Scalar;

/// Result of a scalar update, for the log and the smoother.
#[derive(Clone, Copy, Debug)]
pub struct Gain<T, const N: usize> {
    /// Kalman gain, state units per measurement unit.
    pub gain: [T; N],
    /// Innovation variance H P Hᵀ + R.
    pub innovation_variance: T,
}

impl<T: Scalar, const N: usize> Covariance<T, N> {
    /// P Hᵀ and H P Hᵀ of a scalar measurement.
    #[must_use]
    pub fn project(&mut self, sensitivity: &Sensitivity<T>) -> ([T; N], T) {
        self.renew_mirror();
        let mut projected = [T::ZERO; N];
        self.project_on(sensitivity, &mut projected);
        let variance = sensitivity.dot(&projected);
        (projected, variance)
    }

    /// P Hᵀ of a scalar measurement, for a mirrored P. Sums four rows at a time, which saves memory traffic for the
    /// sum.
    #[inline(always)]
    pub(super) fn project_on(&self, sensitivity: &Sensitivity<T>, projected: &mut [T; N]) {
        let row = |state: u8| self.rows.get(usize::from(state));
        for (place, ([a, b, c, d], &[by_a, by_b, by_c, by_d])) in sensitivity.fours().enumerate() {
            let [Some(a), Some(b), Some(c), Some(d)] = [row(*a), row(*b), row(*c), row(*d)] else {
                continue;
            };
            let rows = a.iter().zip(b).zip(c).zip(d);
            for (sum, (((&a, &b), &c), &d)) in projected.iter_mut().zip(rows) {
                let before = if place == 0 { T::ZERO } else { *sum };
                *sum = before + by_a * a + by_b * b + by_c * c + by_d * d;
            }
        }
    }

    /// Fuses one scalar measurement of variance `noise`, given its [`project`](Self::project)ion. Returns the gain for
    /// the correction of the state.
    ///
    /// With v = P Hᵀ, gain k and P̄ = P − k vᵀ, Bierman's form is P = P̄ − (P̄ Hᵀ − R k) kᵀ. The second term cancels
    /// the rounding error of the first. Both are applied in one pass.
    ///
    /// # Source
    /// Equations (K6) and (K7) of docs/equations.md.
    pub fn update(
        &mut self,
        sensitivity: &Sensitivity<T>,
        projected: &[T; N],
        variance: T,
        noise: T,
    ) -> Gain<T, N> {
        let innovation_variance = variance + noise;
        let inverse = T::ONE / innovation_variance;
        let gain = projected.map(|value| value * inverse);
        let mut excess = [T::ZERO; N];
        for (state, derivative) in sensitivity.terms() {
            if let (Some(row), Some(&seen)) = (self.rows.get(state), projected.get(state)) {
                for ((value, &p), &k) in excess.iter_mut().zip(row).zip(&gain) {
                    *value += derivative * (p - k * seen);
                }
            }
        }
        for (value, &k) in excess.iter_mut().zip(&gain) {
            *value -= noise * k;
        }
        self.subtract(&gain, projected, &excess);
        Gain { gain, innovation_variance }
    }

    /// P ← P − k vᵀ − e kᵀ, in this order of rounding: upper triangle, and its mirror.
    fn subtract(&mut self, gain: &[T; N], projected: &[T; N], excess: &[T; N]) {
        let p = &mut self.rows;
        for above in 0..N / 2 {
            let i = 2 * above;
            for left in above..N / 2 {
                let j = 2 * left;
                // Always false for an even `N`: the check removes bounds checks when optimising for size.
                if i + 1 >= N || j + 1 >= N {
                    break;
                }
                let less =
                    |r: usize, c: usize| p[r][c] - gain[r] * projected[c] - excess[r] * gain[c];
                let block = [[less(i, j), less(i, j + 1)], [less(i + 1, j), less(i + 1, j + 1)]];
                (p[j][i], p[j][i + 1]) = (block[0][0], block[1][0]);
                (p[j + 1][i], p[j + 1][i + 1]) = (block[0][1], block[1][1]);
                (p[i][j], p[i][j + 1]) = (block[0][0], block[0][1]);
                (p[i + 1][j], p[i + 1][j + 1]) = (block[1][0], block[1][1]);
            }
            p[i + 1][i] = p[i][i + 1];
        }
    }
}
