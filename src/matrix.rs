//! Arithmetic of small matrices, row by row, without an index that could fail.

use crate::scalar::Scalar;

pub(crate) fn square<T: Scalar>(value: T) -> T {
    value * value
}

/// Inner product, summed from the first element on.
pub(crate) fn dot<T: Scalar, const N: usize>(row: &[T; N], vector: &[T; N]) -> T {
    // −0 is the neutral element of addition, for −0 too.
    row.iter().zip(vector).fold(-T::ZERO, |sum, (&a, &b)| sum + a * b)
}

pub(crate) fn times<T: Scalar, const R: usize, const C: usize>(
    matrix: &[[T; C]; R],
    vector: &[T; C],
) -> [T; R] {
    matrix.each_ref().map(|row| dot(row, vector))
}

/// `sum[i] += factor · addend[i]`.
#[inline(always)]
pub(crate) fn add_scaled<T: Scalar, const N: usize>(sum: &mut [T; N], factor: T, addend: &[T; N]) {
    for (sum, &addend) in sum.iter_mut().zip(addend) {
        *sum += factor * addend;
    }
}

pub(crate) fn difference<T: Scalar, const N: usize>(a: &[T; N], b: &[T; N]) -> [T; N] {
    let mut result = *a;
    add_scaled(&mut result, -T::ONE, b);
    result
}

/// Sum of scaled rows.
pub(crate) fn combined<T: Scalar, const K: usize, const C: usize>(
    factors: [T; K],
    rows: [&[T; C]; K],
) -> [T; C] {
    let mut sum = [-T::ZERO; C];
    for (factor, row) in factors.into_iter().zip(rows) {
        add_scaled(&mut sum, factor, row);
    }
    sum
}

/// Product of two matrices.
pub(crate) fn product<T: Scalar, const R: usize, const K: usize, const C: usize>(
    a: &[[T; K]; R],
    b: &[[T; C]; K],
) -> [[T; C]; R] {
    a.map(|row| combined(row, b.each_ref()))
}

/// Vector product.
pub(crate) fn cross<T: Scalar>([a, b, c]: [T; 3], [x, y, z]: [T; 3]) -> [T; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

/// [v ×]: the matrix whose product with w is v × w.
pub(crate) fn skew<T: Scalar>([x, y, z]: [T; 3]) -> [[T; 3]; 3] {
    [[T::ZERO, -z, y], [z, T::ZERO, -x], [-y, x, T::ZERO]]
}
