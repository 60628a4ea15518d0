//! The little matrix arithmetic that gains need, without an index that could fail.

pub(super) fn dot<const N: usize>(row: &[f64; N], vector: &[f64; N]) -> f64 {
    row.iter().zip(vector).map(|(a, b)| a * b).sum()
}

pub(super) fn times<const R: usize, const C: usize>(
    matrix: &[[f64; C]; R],
    vector: &[f64; C],
) -> [f64; R] {
    matrix.each_ref().map(|row| dot(row, vector))
}

/// `sum[i] += factor · addend[i]`.
pub(super) fn add<const N: usize>(sum: &mut [f64; N], addend: &[f64; N], factor: f64) {
    for (sum, addend) in sum.iter_mut().zip(addend) {
        *sum += factor * addend;
    }
}

pub(super) fn difference<const N: usize>(a: &[f64; N], b: &[f64; N]) -> [f64; N] {
    let mut result = *a;
    add(&mut result, b, -1.0);
    result
}
