//! Stein's equation, the discrete Lyapunov equation, by doubling.

use nalgebra::DMatrix;

/// Solves X = F X Fᵀ + V for many V with one F, whose spectral radius is below 1 − 1e-8.
///
/// # Source
/// Smith (1968), *Matrix equation XA + BX = C*, SIAM J. Appl. Math. 16(1), squared.
#[derive(Clone, Debug)]
pub struct Stein {
    /// F, F², F⁴, … as far as they are significant.
    powers: Vec<DMatrix<f64>>,
}

/// Largest number of squarings of F: enough for a spectral radius of 1 − 1e-8.
const MAX_SQUARINGS: usize = 30;
/// Magnitude of a power of F below which it is negligible. Powers enter squared, so its contribution is below rounding.
const NEGLIGIBLE: f64 = 1e-9;

impl Stein {
    /// The equation of `f`, n×n; `None` where its spectral radius is not below 1 − 1e-8.
    #[must_use]
    pub fn new(f: &DMatrix<f64>) -> Option<Self> {
        let mut powers = vec![f.clone()];
        while powers.len() < MAX_SQUARINGS {
            let last = &powers[powers.len() - 1];
            let next = last * last;
            let size = next.amax();
            if size < NEGLIGIBLE {
                return Some(Self { powers });
            }
            if !size.is_finite() {
                return None;
            }
            powers.push(next);
        }
        None
    }

    /// X, n×n, for one symmetric `v`, n×n.
    ///
    /// # Source
    /// Equation (L4) of docs/equations.md.
    #[must_use]
    pub fn solve(&self, mut v: DMatrix<f64>) -> DMatrix<f64> {
        for power in &self.powers {
            let carried = power * &v * power.transpose();
            v += carried;
        }
        v
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    #[test]
    fn the_solution_satisfies_its_equation_near_the_edge_of_stability_too() {
        for radius in [0.1, 0.9, 1.0 - 1e-6] {
            let f = dmatrix![radius, 0.3; 0.0, 0.5 * radius];
            let v = dmatrix![1.0, 0.2; 0.2, 2.0];
            let x = Stein::new(&f).unwrap().solve(v.clone());
            let left = (&f * &x * f.transpose() + v - &x).amax();
            assert!(left < 1e-13 * x.amax(), "{radius}: {left}");
        }
        assert!(Stein::new(&dmatrix![1.001]).is_none());
    }
}
