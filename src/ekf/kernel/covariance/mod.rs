//! The covariance of the error state and the two kernels that change it.
//!
//! The whole matrix is stored, row-major. Rows are contiguous, so both kernels are sums of scaled rows, which the
//! compiler vectorises. In the rows of the parameters, the first nine columns mirror the upper triangle. A propagation
//! step changes the upper triangle and leaves this mirror stale. The next measurement renews it.
//!
//! Propagation uses the blocks of the transition that are neither zero nor one. A scalar update is Bierman's stabilised
//! form: it keeps the matrix positive where rounding makes the short form P − k vᵀ indefinite.
//!
//! # Source
//! Groves, second edition, equations 14.63 to 14.73 (error dynamics in NED); G. J. Bierman (1977),
//! *Factorization Methods for Discrete Sequential Estimation*, section V.3 (stabilised update).
mod fix_sensitivity;
mod joint;
mod propagation;
mod sensitivity;
mod update;

// The kernels, public for tests and benchmarks.
#[doc(hidden)]
pub use fix_sensitivity::{AxesSensitivity, FixSensitivity};
#[doc(hidden)]
pub use joint::{Joint, Sensitivities};
#[doc(hidden)]
pub use propagation::Relaxation;
pub use propagation::Transition;
#[doc(hidden)]
pub use sensitivity::MAX_AXES;
pub use sensitivity::Sensitivity;
pub use update::Gain;

use super::layout::{ACCEL_BIAS, BASE, GYRO_BIAS};
use crate::scalar::Scalar;

/// Covariance of the error state, in units of the states. The entries that its methods return are exactly symmetric.
#[derive(Clone, Copy, Debug)]
pub struct Covariance<T, const N: usize> {
    rows: [[T; N]; N],
    /// Whether the first nine columns of the parameters' rows mirror the upper triangle.
    mirrored: bool,
}

impl<T: Scalar, const N: usize> Covariance<T, N> {
    /// Covariance with zero in every entry.
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
    pub(in crate::ekf) const fn from_rows(rows: [[T; N]; N]) -> Self {
        Self { rows, mirrored: true }
    }

    /// Upper-triangle part of a row, from the diagonal on; empty for an absent state.
    #[cfg(feature = "alloc")]
    pub(in crate::ekf) fn upper_row(&self, state: usize) -> &[T] {
        self.rows.get(state).and_then(|row| row.get(state..)).unwrap_or_default()
    }

    /// Variance of one state; zero for an absent state.
    #[must_use]
    pub fn variance(&self, state: usize) -> f64 {
        self.entry(state, state)
    }

    /// Largest one-sigma of some states.
    pub(in crate::ekf) fn largest_sigma(&self, states: core::ops::Range<usize>) -> f64 {
        Scalar::sqrt(states.map(|state| self.variance(state)).fold(0.0, f64::max))
    }

    /// Covariance of two states; zero for an absent state.
    #[must_use]
    pub fn entry(&self, row: usize, column: usize) -> f64 {
        self.value(row, column).wide()
    }

    /// [`entry`](Self::entry) in the covariance's own number type.
    #[inline(always)]
    pub(in crate::ekf) fn value(&self, row: usize, column: usize) -> T {
        self.mirrored_value(row.min(column), row.max(column))
    }

    /// [`value`](Self::value) for a mirrored covariance or an entry above the diagonal.
    #[inline(always)]
    fn mirrored_value(&self, row: usize, column: usize) -> T {
        self.rows.get(row).and_then(|row| row.get(column)).copied().unwrap_or(T::ZERO)
    }

    /// Sets a variance and clears the state's correlations.
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

    /// Sets the covariance of two states; the whole matrix must stay positive semi-definite.
    pub fn set_cross(&mut self, a: usize, b: usize, covariance: f64) {
        for (row, column) in [(a, b), (b, a)] {
            if let Some(value) = self.rows.get_mut(row).and_then(|row| row.get_mut(column)) {
                *value = T::of(covariance);
            }
        }
    }

    /// Raises the one-sigma of a state to at least `sigma`, and keeps the covariances with other states.
    pub(in crate::ekf) fn raise_sigma(&mut self, state: usize, sigma: f64) {
        let missing = sigma * sigma - self.variance(state);
        self.add_variance(state, missing.max(0.0));
    }

    /// Adds to a variance and keeps the covariances: the state becomes uncertain without losing its relation to the
    /// others.
    pub fn add_variance(&mut self, state: usize, variance: f64) {
        if let Some(value) = self.rows.get_mut(state).and_then(|row| row.get_mut(state)) {
            *value += T::of(variance);
        }
    }

    /// Copies the covariances of the parameters with the first nine states from the upper triangle to the parameters'
    /// rows. It ends before state `end`.
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

    /// Renews the mirror if a step has made it stale.
    #[inline(never)]
    fn renew_mirror(&mut self) {
        if !self.mirrored {
            self.mirror_up_to(N);
            self.mirrored = true;
        }
    }

    /// Whether every variance is finite and not negative. A non-finite covariance elsewhere reaches a variance with the
    /// next step or measurement.
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
