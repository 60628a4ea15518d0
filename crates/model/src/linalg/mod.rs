//! Matrix equations that design and identification share.
//!
//! | function | solves |
//! |---|---|
//! | [`eigenvalues`], [`spectral_radius`] | det(λI − A) = 0 |
//! | [`ZeroOrderHold`], [`exponential`] | ẋ = A x + B u over a period with held u |
//! | [`dare_by_doubling`] | X = AᵀX(I + GX)⁻¹A + H |
//! | [`Stein`] | X = F X Fᵀ + V |
//! | [`least_squares`] | min ‖A X − B‖ |
//! | [`gram`] | Aᵀ A |

mod eigenvalues;
mod gram;
mod hold;
mod least_squares;
mod riccati;
mod stein;

pub use eigenvalues::{eigenvalues, spectral_radius};
pub use gram::{add_gram, gram};
pub use hold::{HoldDerivatives, ZeroOrderHold, exponential};
pub use least_squares::least_squares;
pub use riccati::dare_by_doubling;
pub use stein::Stein;

use nalgebra::{Complex, DMatrix};

/// Inverts a square matrix in place by Gauss-Jordan elimination with row pivoting. Returns the natural logarithm of the
/// determinant's magnitude; `None` where the matrix is singular or not finite.
pub fn invert(matrix: &mut DMatrix<f64>) -> Option<f64> {
    let n = matrix.nrows();
    let mut log_determinant = 0.0;
    let mut swaps = Vec::with_capacity(n);
    let mut pivot_column = vec![0.0; n];
    let values = matrix.as_mut_slice();
    for k in 0..n {
        let column = &values[k * n..(k + 1) * n];
        let p = (k..n).max_by(|&i, &j| column[i].abs().total_cmp(&column[j].abs()))?;
        swaps.push(p);
        pivot_column.copy_from_slice(column);
        pivot_column.swap(k, p);
        let pivot = pivot_column[k];
        if pivot == 0.0 || !pivot.is_finite() {
            return None;
        }
        log_determinant += pivot.abs().ln();
        for (j, column) in values.chunks_exact_mut(n).enumerate() {
            if j == k {
                for (value, &factor) in column.iter_mut().zip(&pivot_column) {
                    *value = -factor / pivot;
                }
                column[k] = 1.0 / pivot;
            } else {
                column.swap(k, p);
                let scaled = column[k] / pivot;
                for (value, &factor) in column.iter_mut().zip(&pivot_column) {
                    *value -= scaled * factor;
                }
                column[k] = scaled;
            }
        }
    }
    for (k, &p) in swaps.iter().enumerate().rev() {
        for row in 0..n {
            values.swap(k * n + row, p * n + row);
        }
    }
    Some(log_determinant)
}

/// Symmetric part of a square matrix.
#[must_use]
pub fn symmetric(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    (matrix + matrix.transpose()) * 0.5
}

/// Replaces a square matrix by its symmetric part.
pub fn symmetrise(matrix: &mut DMatrix<f64>) {
    for column in 0..matrix.ncols() {
        for row in 0..column {
            let mean = 0.5 * (matrix[(row, column)] + matrix[(column, row)]);
            matrix[(row, column)] = mean;
            matrix[(column, row)] = mean;
        }
    }
}

/// Matrix of two matrices in adjacent columns, `left` first.
#[must_use]
pub fn side_by_side(left: &DMatrix<f64>, right: &DMatrix<f64>) -> DMatrix<f64> {
    let mut both = DMatrix::zeros(left.nrows(), left.ncols() + right.ncols());
    both.columns_mut(0, left.ncols()).copy_from(left);
    both.columns_mut(left.ncols(), right.ncols()).copy_from(right);
    both
}

/// The matrix as complex numbers.
#[must_use]
pub fn complex(matrix: &DMatrix<f64>) -> DMatrix<Complex<f64>> {
    matrix.map(|value| Complex::new(value, 0.0))
}
