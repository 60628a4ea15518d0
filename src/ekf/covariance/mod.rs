//! The covariance of the error state and the two kernels that move it.
//!
//! Stored whole, row-major: rows are contiguous, so both kernels are sums of scaled rows that the compiler
//! turns into vector instructions. What stands left of the parameters' own block is the mirror of the rows
//! above it; a step changes those and leaves the mirror as it was, for the next measurement to renew, which
//! is the next to look at it. Propagation uses the blocks of the
//! transition that are not zero or one; a scalar update is Bierman's stabilised form, which keeps
//! the matrix positive where the short form P − k vᵀ loses that to rounding.
//!
//! # Source
//! Groves, second edition, equations 14.63 to 14.73 (error dynamics in NED); G. J. Bierman (1977),
//! *Factorization Methods for Discrete Sequential Estimation*, section V.3 (stabilised update).
mod fix_sensitivity;
mod joint;
mod propagation;
mod sensitivity;
mod update;

pub use fix_sensitivity::{AxesSensitivity, FixSensitivity};
pub use joint::{Joint, Sensitivities};
pub use propagation::{Relaxation, Transition};
pub use sensitivity::{MOST, Sensitivity};
pub use update::Gain;

use super::layout::{ACCEL_BIAS, BASE, GYRO_BIAS};
use super::scalar::Scalar;

/// Covariance of the error state, units those of the states; always exactly symmetric.
#[derive(Clone, Copy, Debug)]
pub struct Covariance<T, const N: usize> {
    rows: [[T; N]; N],
    /// Whether what stands left of the parameters is the mirror of what stands above them.
    mirrored: bool,
}

#[inline(always)]
fn add_scaled<T: Scalar, const N: usize>(row: &mut [T; N], factor: T, other: &[T; N]) {
    for (value, &term) in row.iter_mut().zip(other) {
        *value += factor * term;
    }
}

impl<T: Scalar, const N: usize> Covariance<T, N> {
    /// All zero.
    #[must_use]
    pub const fn zero() -> Self {
        Self { rows: [[T::ZERO; N]; N], mirrored: true }
    }

    /// Sets every entry to zero.
    pub fn clear(&mut self) {
        self.rows.as_flattened_mut().fill(T::ZERO);
    }

    /// A covariance of given rows, which must be symmetric.
    #[cfg(feature = "alloc")]
    pub(super) const fn from_rows(rows: [[T; N]; N]) -> Self {
        Self { rows, mirrored: true }
    }

    /// The upper triangle's part of a row, from the diagonal on; empty for a state that is not there.
    #[cfg(feature = "alloc")]
    pub(super) fn upper_row(&self, state: usize) -> &[T] {
        self.rows.get(state).and_then(|row| row.get(state..)).unwrap_or_default()
    }

    /// Variance of one state; zero for a state that is not there.
    #[must_use]
    pub fn variance(&self, state: usize) -> f64 {
        self.entry(state, state)
    }

    /// Covariance of two states; zero for a state that is not there.
    #[must_use]
    pub fn entry(&self, row: usize, column: usize) -> f64 {
        self.value(row, column).wide()
    }

    /// [`entry`](Self::entry), in the covariance's own numbers.
    #[inline(always)]
    pub(super) fn value(&self, row: usize, column: usize) -> T {
        self.mirrored_value(row.min(column), row.max(column))
    }

    /// [`value`](Self::value) of a covariance that is mirrored, or above the diagonal.
    #[inline(always)]
    fn mirrored_value(&self, row: usize, column: usize) -> T {
        self.rows.get(row).and_then(|row| row.get(column)).copied().unwrap_or(T::ZERO)
    }

    /// Sets a variance and forgets the state's correlations.
    pub fn set_variance(&mut self, state: usize, variance: f64) {
        for row in &mut self.rows {
            if let Some(value) = row.get_mut(state) {
                *value = T::ZERO;
            }
        }
        if let Some(row) = self.rows.get_mut(state) {
            *row = [T::ZERO; N];
            if let Some(value) = row.get_mut(state) {
                *value = T::of(variance);
            }
        }
    }

    /// Sets the covariance of two states, which must leave the whole positive semi-definite.
    pub fn set_cross(&mut self, a: usize, b: usize, covariance: f64) {
        for (row, column) in [(a, b), (b, a)] {
            if let Some(value) = self.rows.get_mut(row).and_then(|row| row.get_mut(column)) {
                *value = T::of(covariance);
            }
        }
    }

    /// Adds to a variance, keeping the correlations: reopens a state without forgetting how it
    /// hangs together with the others.
    pub fn add_variance(&mut self, state: usize, variance: f64) {
        if let Some(value) = self.rows.get_mut(state).and_then(|row| row.get_mut(state)) {
            *value += T::of(variance);
        }
    }

    /// Mirrors what stands above the states from the first parameter up to `end`.
    #[inline(always)]
    fn mirror_up_to(&mut self, end: usize) {
        let (rows, parameter_rows) = self.rows.split_at_mut(GYRO_BIAS);
        for (state, mirror) in (GYRO_BIAS..end.min(N)).zip(parameter_rows) {
            let column: [T; GYRO_BIAS] = core::array::from_fn(|above| {
                rows.get(above).and_then(|row| row.get(state)).copied().unwrap_or(T::ZERO)
            });
            if let Some(mirror) = mirror.first_chunk_mut() {
                *mirror = column;
            }
        }
    }

    /// Renews the mirror, where a step has left it behind.
    #[inline(never)]
    fn renew_mirror(&mut self) {
        if !self.mirrored {
            self.mirror_up_to(N);
            self.mirrored = true;
        }
    }

    /// The 3×3 block at two states' starts, row by row.
    #[must_use]
    pub fn block(&self, row: usize, column: usize) -> [[T; 3]; 3] {
        let mut block = [[T::ZERO; 3]; 3];
        for (i, line) in block.iter_mut().enumerate() {
            for (j, value) in line.iter_mut().enumerate() {
                *value = self.value(row + i, column + j);
            }
        }
        block
    }

    /// Whether every variance is finite and none negative. What is not finite elsewhere comes to a
    /// variance with the next step or measurement.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        self.rows.iter().enumerate().all(|(state, row)| {
            row.get(state).is_some_and(|&variance| variance >= T::ZERO && variance <= T::MAX)
        })
    }
}

impl<T: Scalar, const N: usize> PartialEq for Covariance<T, N> {
    fn eq(&self, other: &Self) -> bool {
        (0..N).all(|row| (row..N).all(|column| self.value(row, column) == other.value(row, column)))
    }
}

const _: () = assert!(BASE == ACCEL_BIAS + 3);

#[cfg(test)]
mod tests;
