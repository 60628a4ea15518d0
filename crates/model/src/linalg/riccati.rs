//! The discrete algebraic Riccati equation by doubling.

use nalgebra::DMatrix;

use super::symmetrise;

/// The stabilising solution X of X = AᵀX(I + GX)⁻¹A + H. With G = BR⁻¹Bᵀ and H = Q it is the cost to go of the optimal
/// regulator. With Aᵀ for A, Cᵀ for B and noise covariances for Q and R, X is the covariance of the predicted state.
/// `None` where the iteration does not converge.
///
/// `a`, `g` and `h` are n×n, `g` and `h` symmetric. The iteration ends when a step changes X by less than `tolerance`
/// of its largest element. Convergence is quadratic.
///
/// # Source
/// Structure-preserving doubling: Chu, Fan, Lin and Wang (2004), *Int. J. Control* 77(8).
/// Equation (L17) of docs/equations.md.
#[must_use]
pub fn dare_by_doubling(
    mut a: DMatrix<f64>,
    mut g: DMatrix<f64>,
    mut h: DMatrix<f64>,
    tolerance: f64,
) -> Option<DMatrix<f64>> {
    /// Largest number of doublings.
    const MAX_STEPS: usize = 60;
    let identity = DMatrix::identity(a.nrows(), a.nrows());
    for _ in 0..MAX_STEPS {
        let inverse = (&identity + &g * &h).try_inverse()?;
        let a_inverse = &a * &inverse;
        let added = a.transpose() * &h * &inverse * &a;
        g += &a_inverse * &g * a.transpose();
        a = a_inverse * a;
        h += &added;
        symmetrise(&mut g);
        symmetrise(&mut h);
        let size = added.amax();
        if !size.is_finite() {
            return None;
        }
        if size <= tolerance * h.amax() {
            return Some(h);
        }
    }
    None
}
