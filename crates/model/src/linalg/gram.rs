//! Products of a tall matrix with itself.

use nalgebra::DMatrix;

/// Rows multiplied at a time: as many as fit in a cache with some hundred columns.
const BLOCK: usize = 256;

/// `a`ᵀ `a`, columns × columns. A matrix too tall for the cache is read once, instead of once per column.
#[must_use]
pub fn gram(a: &DMatrix<f64>) -> DMatrix<f64> {
    let mut squares = DMatrix::zeros(a.ncols(), a.ncols());
    add_gram(&mut squares, a);
    squares
}

/// Adds `a`ᵀ `a` to `squares`, columns × columns.
///
/// # Panics
/// Where `squares` has another size.
pub fn add_gram(squares: &mut DMatrix<f64>, a: &DMatrix<f64>) {
    for first in (0..a.nrows()).step_by(BLOCK) {
        let block = a.rows(first, BLOCK.min(a.nrows() - first));
        squares.gemm(1.0, &block.transpose(), &block, 1.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn blocks_add_up_to_the_whole() {
        for rows in [0, 1, BLOCK, 2 * BLOCK + 3] {
            let a = DMatrix::from_fn(rows, 3, |row, column| ((row * 7 + column * 5) % 11) as f64);
            assert_abs_diff_eq!(gram(&a), a.tr_mul(&a), epsilon = 1e-9 * rows.max(1) as f64);
        }
    }
}
