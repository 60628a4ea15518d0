//! The steady Kalman predictor: its covariance, and how that moves.

use nalgebra::{Cholesky, DMatrix};

/// The stabilising solution P of P = Φ(P − P Cᵀ(C P Cᵀ + R)⁻¹ C P)Φᵀ + Q: the covariance of the
/// predicted state. `None` where doubling does not converge, or R is not positive definite.
///
/// # Source
/// Structure-preserving doubling: Chu, Fan, Lin and Wang (2004), *Int. J. Control* 77(8).
pub(super) fn predicted_covariance(
    phi: &DMatrix<f64>,
    c: &DMatrix<f64>,
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
) -> Option<DMatrix<f64>> {
    let n = phi.nrows();
    let identity = DMatrix::identity(n, n);
    let mut a = phi.transpose();
    let mut g = c.transpose() * Cholesky::new(r.clone())?.solve(c);
    let mut h = q.clone();
    for _ in 0..60 {
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
        if size <= 1e-14 * h.amax() {
            return Some(h);
        }
    }
    None
}

/// Solves X = F X Fᵀ + V for many V with one F.
pub(super) struct Lyapunov {
    powers: Vec<DMatrix<f64>>,
}

impl Lyapunov {
    /// `None` where `f` is not stable.
    pub fn new(f: &DMatrix<f64>) -> Option<Self> {
        let mut powers = vec![f.clone()];
        while powers.len() < 30 {
            let last = &powers[powers.len() - 1];
            let next = last * last;
            let size = next.amax();
            if size < 1e-9 {
                return Some(Self { powers });
            }
            if !size.is_finite() {
                return None;
            }
            powers.push(next);
        }
        None
    }

    /// X for one symmetric `v`.
    pub fn solve(&self, mut v: DMatrix<f64>) -> DMatrix<f64> {
        for power in &self.powers {
            let carried = power * &v * power.transpose();
            v += carried;
        }
        v
    }
}

fn symmetrise(matrix: &mut DMatrix<f64>) {
    for column in 0..matrix.ncols() {
        for row in 0..column {
            let mean = 0.5 * (matrix[(row, column)] + matrix[(column, row)]);
            matrix[(row, column)] = mean;
            matrix[(column, row)] = mean;
        }
    }
}
