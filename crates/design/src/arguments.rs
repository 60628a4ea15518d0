//! Checks of the matrices of a design problem.

use nalgebra::DMatrix;

use super::error::DesignError;
use hovernav_model::linalg::{invert, symmetric};

/// The inverse of a small matrix.
pub(super) fn inverse(
    matrix: &DMatrix<f64>,
    name: &'static str,
) -> Result<DMatrix<f64>, DesignError> {
    let mut inverse = matrix.clone();
    invert(&mut inverse).ok_or(DesignError::Singular { matrix: name })?;
    Ok(inverse)
}

/// Rejects a matrix of the wrong shape, or with NaN or infinities.
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

/// As [`check`], and rejects a matrix that is not symmetric to rounding.
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

/// As [`check_symmetric`], and rejects eigenvalues below zero. With `strictly` it also rejects eigenvalues of zero.
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
