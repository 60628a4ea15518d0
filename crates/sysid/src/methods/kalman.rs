//! Covariance of the steady-state Kalman predictor.

use nalgebra::{Cholesky, DMatrix};

use hovernav_model::linalg::dare_by_doubling;

/// The stabilising solution P, n×n, of P = Φ(P − P Cᵀ(C P Cᵀ + R)⁻¹ C P)Φᵀ + Q: the covariance of the
/// predicted state. `None` where doubling does not converge, or R is not positive definite.
///
/// # Source
/// Equation (I9) of docs/equations.md.
pub(super) fn predicted_covariance(
    phi: &DMatrix<f64>,
    c: &DMatrix<f64>,
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
) -> Option<DMatrix<f64>> {
    let information = c.transpose() * Cholesky::new(r.clone())?.solve(c);
    dare_by_doubling(phi.transpose(), information, q.clone(), 1e-14)
}
