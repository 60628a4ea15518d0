//! Eigenvalues of real matrices.

use nalgebra::{Complex, DMatrix, linalg::Schur};

use crate::error::ModelError;

/// Eigenvalues of a square matrix of finite numbers, in no order.
///
/// # Errors
/// [`ModelError::Eigenvalues`] where the computation does not converge.
pub fn eigenvalues(matrix: &DMatrix<f64>) -> Result<Vec<Complex<f64>>, ModelError> {
    let size = matrix.nrows();
    let rejected = || ModelError::Eigenvalues { size };
    if size == 0 {
        return Ok(Vec::new());
    }
    if matrix.iter().any(|value| !value.is_finite()) {
        return Err(rejected());
    }
    let matrix = balanced(matrix);
    let size_of_matrix = matrix.amax();
    // The algorithm deflates an eigenvalue once its coupling is small relative to its size. For eigenvalues at zero,
    // which delays cause, this may never happen. With a shift away from zero they converge, to within a few rounding
    // errors.
    let attempts = [(0.0, 1.0), (0.7, 1.0), (0.7, 16.0), (-0.4, 64.0), (0.23, 64.0), (-1.3, 256.0)];
    let found = attempts.into_iter().find_map(|(shift, roundings)| {
        let shift = shift * size_of_matrix;
        let shifted = &matrix + DMatrix::identity(size, size) * shift;
        let schur = Schur::try_new(shifted, roundings * f64::EPSILON, 100 * size)?;
        let shift = Complex::new(shift, 0.0);
        Some(schur.complex_eigenvalues().iter().map(|value| value - shift).collect())
    });
    found.ok_or_else(rejected)
}

/// A similar matrix with rows and columns of similar size, scaled by powers of two without rounding.
///
/// # Source
/// Parlett and Reinsch, *Balancing a matrix for calculation of eigenvalues and eigenvectors*, 1969.
fn balanced(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let mut balanced = matrix.clone();
    let size = balanced.nrows();
    let mut moved = true;
    let mut sweeps = 0;
    while moved && sweeps < 100 {
        moved = false;
        sweeps += 1;
        for index in 0..size {
            let (mut column, mut row) = (0.0, 0.0);
            for other in (0..size).filter(|&other| other != index) {
                column += balanced[(other, index)].abs();
                row += balanced[(index, other)].abs();
            }
            if column == 0.0 || row == 0.0 {
                continue;
            }
            let factor = (0.5 * (row / column).log2()).round().clamp(-500.0, 500.0).exp2();
            if column * factor + row / factor < 0.95 * (column + row) {
                moved = true;
                balanced.row_mut(index).scale_mut(1.0 / factor);
                balanced.column_mut(index).scale_mut(factor);
            }
        }
    }
    balanced
}

/// Largest magnitude of the eigenvalues of a square matrix; infinite where a number is not finite. The one-step map x⁺
/// = A x is stable if it is below 1.
#[must_use]
pub fn spectral_radius(a: &DMatrix<f64>) -> f64 {
    if a.iter().any(|value| !value.is_finite()) {
        return f64::INFINITY;
    }
    a.complex_eigenvalues().iter().map(|pole| pole.norm()).fold(0.0, f64::max)
}
