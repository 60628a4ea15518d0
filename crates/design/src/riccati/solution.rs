//! Result of a Riccati solver.

use nalgebra::DMatrix;

/// The stabilising solution of a Riccati equation.
#[derive(Clone, Debug, PartialEq)]
pub struct RiccatiSolution {
    /// X, n×n, symmetric.
    pub x: DMatrix<f64>,
    /// The gain K, m×n, of u = −K x.
    pub gain: DMatrix<f64>,
    /// Residual of the equation, relative to the size of its terms.
    pub residual: f64,
}
