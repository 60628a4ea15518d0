//! Matrix arithmetic for the gains, without an index that could fail.

use crate::scalar::Scalar;

pub(super) fn dot<T: Scalar, const N: usize>(row: &[T; N], vector: &[T; N]) -> T {
    // −0 is the neutral element of addition, for −0 too.
    row.iter().zip(vector).fold(-T::ZERO, |sum, (&a, &b)| sum + a * b)
}

pub(super) fn times<T: Scalar, const R: usize, const C: usize>(
    matrix: &[[T; C]; R],
    vector: &[T; C],
) -> [T; R] {
    matrix.each_ref().map(|row| dot(row, vector))
}

/// `sum[i] += factor · addend[i]`.
pub(super) fn add<T: Scalar, const N: usize>(sum: &mut [T; N], addend: &[T; N], factor: T) {
    for (sum, &addend) in sum.iter_mut().zip(addend) {
        *sum += factor * addend;
    }
}

pub(super) fn difference<T: Scalar, const N: usize>(a: &[T; N], b: &[T; N]) -> [T; N] {
    let mut result = *a;
    add(&mut result, b, -T::ONE);
    result
}
