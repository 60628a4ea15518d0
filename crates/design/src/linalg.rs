//! The matrix work under the Riccati solvers.

use nalgebra::{Complex, DMatrix};

use super::error::DesignError;

/// Inverts a square matrix in its place, by Gauss-Jordan elimination with row pivoting, and gives the
/// natural logarithm of its determinant's size; `None` where it is singular or not finite.
pub(super) fn invert(matrix: &mut DMatrix<f64>) -> Option<f64> {
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

/// The inverse of a small matrix.
pub(super) fn inverse(
    matrix: &DMatrix<f64>,
    name: &'static str,
) -> Result<DMatrix<f64>, DesignError> {
    let mut inverse = matrix.clone();
    invert(&mut inverse).ok_or(DesignError::Singular { matrix: name })?;
    Ok(inverse)
}

/// The symmetric part.
pub(super) fn symmetric(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    (matrix + matrix.transpose()) * 0.5
}

/// One step of the iteration for the sign of a matrix, given its inverse; gives how far it moved,
/// relative.
pub(super) fn sign_step(matrix: &mut DMatrix<f64>, inverse: &DMatrix<f64>, scale: f64) -> f64 {
    let (mut moved, mut size) = (0.0, 0.0);
    let (own, other) = (0.5 * scale, 0.5 / scale);
    for (value, &inverse) in matrix.iter_mut().zip(inverse) {
        let next = own * *value + other * inverse;
        moved += (next - *value) * (next - *value);
        size += next * next;
        *value = next;
    }
    (moved / size).sqrt()
}

/// Enough for the matrix sign of anything whose modes are apart from the axis in double precision.
const MOST_STEPS: usize = 100;

/// The solution of AᵀE + EA + Q = 0 by the sign iteration; `None` unless A is stable.
///
/// # Source
/// Roberts, *Linear model reduction and solution of the algebraic Riccati equation by use of the sign
/// function*, 1971/1980.
pub(super) fn lyapunov(a: &DMatrix<f64>, q: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = a.nrows();
    let (mut a, mut q, mut inverse) = (a.clone(), q.clone(), a.clone());
    let (mut half, mut turned) = (q.clone(), q.clone());
    let mut change = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        inverse.copy_from(&a);
        let log_determinant = invert(&mut inverse)?;
        let scale = if change > 0.01 { (-log_determinant / n as f64).exp() } else { 1.0 };
        q.mul_to(&inverse, &mut half);
        inverse.tr_mul_to(&half, &mut turned);
        q.zip_apply(&turned, |q, turned| *q = 0.5 * (scale * *q + turned / scale));
        change = sign_step(&mut a, &inverse, scale);
        // Convergence is quadratic: the next step would move by the square of this.
        if change < 1e-8 || !change.is_finite() {
            break;
        }
    }
    // The sign of a stable matrix is minus identity.
    for index in 0..n {
        a[(index, index)] += 1.0;
    }
    (a.norm() < 1e-6).then(|| symmetric(&q) * 0.5)
}

/// The solution of E = AᵀEA + Q by doubling; `None` unless A is stable.
///
/// # Source
/// Smith, *Matrix equation XA + BX = C*, 1968, squared.
pub(super) fn stein(a: &DMatrix<f64>, q: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let (mut a, mut e) = (a.clone(), q.clone());
    for _ in 0..MOST_STEPS {
        let further = a.tr_mul(&e) * &a;
        let (size, whole) = (further.norm(), e.norm());
        e += further;
        a = &a * &a;
        let left = a.norm();
        if !left.is_finite() || !size.is_finite() {
            return None;
        }
        if left < 0.5 && size <= 1e-17 * whole {
            return Some(symmetric(&e));
        }
    }
    None
}

/// Refuses a matrix of the wrong shape, or with NaN or infinities in it.
pub(super) fn check(
    matrix: &'static str,
    values: &DMatrix<f64>,
    expected_rows: usize,
    expected_columns: usize,
) -> Result<(), DesignError> {
    let (rows, columns) = values.shape();
    if (rows, columns) != (expected_rows, expected_columns) {
        return Err(DesignError::Shape { matrix, rows, columns, expected_rows, expected_columns });
    }
    if values.iter().any(|value| !value.is_finite()) {
        return Err(DesignError::NotFinite { matrix });
    }
    Ok(())
}

/// As [`check`], and refuses what is not symmetric to rounding.
pub(super) fn check_symmetric(
    matrix: &'static str,
    values: &DMatrix<f64>,
    size: usize,
) -> Result<(), DesignError> {
    check(matrix, values, size, size)?;
    let scale = values.amax();
    for column in 0..size {
        for row in 0..column {
            if (values[(row, column)] - values[(column, row)]).abs() > 1e-10 * scale {
                return Err(DesignError::NotSymmetric { matrix });
            }
        }
    }
    Ok(())
}

/// As [`check_symmetric`], and refuses eigenvalues below zero, or at zero too where `strictly`.
pub(super) fn check_definite(
    matrix: &'static str,
    values: &DMatrix<f64>,
    size: usize,
    strictly: bool,
) -> Result<(), DesignError> {
    check_symmetric(matrix, values, size)?;
    let eigenvalues = symmetric(values).symmetric_eigenvalues();
    let eigenvalue = eigenvalues.iter().copied().fold(f64::INFINITY, f64::min);
    let rounding = 1e-12 * values.norm();
    if strictly && eigenvalue <= 0.0 {
        return Err(DesignError::NotDefinite { matrix, eigenvalue, bound: "at or below 0" });
    }
    if eigenvalue < -rounding {
        return Err(DesignError::NotDefinite { matrix, eigenvalue, bound: "below 0" });
    }
    Ok(())
}

/// Matrices side by side.
pub(super) fn beside(left: &DMatrix<f64>, right: &DMatrix<f64>) -> DMatrix<f64> {
    let mut both = DMatrix::zeros(left.nrows(), left.ncols() + right.ncols());
    both.columns_mut(0, left.ncols()).copy_from(left);
    both.columns_mut(left.ncols(), right.ncols()).copy_from(right);
    both
}

/// The matrix in complex numbers.
pub(super) fn complex(matrix: &DMatrix<f64>) -> DMatrix<Complex<f64>> {
    matrix.map(|value| Complex::new(value, 0.0))
}
