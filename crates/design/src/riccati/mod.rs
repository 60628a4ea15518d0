//! The algebraic Riccati equations of optimal control.
//!
//! A structure-preserving iteration gives an initial solution, and Newton's method refines it. The residual is computed
//! in twice the working precision. The result is therefore accurate to rounding unless the equation itself is nearly
//! singular.

mod newton;
mod sign;
mod solution;

pub use solution::RiccatiSolution;

use nalgebra::DMatrix;

use super::arguments::{check, check_symmetric, inverse};
use super::error::DesignError;
use hovernav_model::linalg::{dare_by_doubling, invert, symmetric};
use newton::Equation;
use sign::sign_solution;

/// Largest change in the last iteration of an initial solution, relative to its largest element. Newton's method
/// refines this solution.
const START_TOLERANCE: f64 = 1e-10;

/// Solves AᵀX + XA − XBR⁻¹BᵀX + Q = 0 for the X that makes A − BK stable, K = R⁻¹BᵀX.
///
/// `a` is n×n, `b` n×m, `q` n×n symmetric (it may be indefinite), `r` m×m symmetric and invertible.
///
/// The initial solution comes from the sign of the balanced Hamiltonian matrix, with determinantal scaling.
///
/// # Errors
/// [`DesignError`] for inconsistent shapes, NaN, weights that are not symmetric, or a singular `r`. Also for a mode
/// that no input can stabilise, or a problem without a stabilising solution.
///
/// # Source
/// Byers, *Solving the algebraic Riccati equation with the matrix sign function*, 1987; Kleinman 1968 for Newton's
/// method. Equation (L1) of docs/equations.md.
pub fn care(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
) -> Result<RiccatiSolution, DesignError> {
    let (n, m) = (a.nrows(), b.ncols());
    let s = DMatrix::zeros(n, m);
    check_problem(a, b, q, r, &s)?;
    let r_inverse = inverse(r, "R")?;
    let g = b * &r_inverse * b.transpose();
    let equation = Equation { a, b, q, r, s: &s, discrete: false, r_inverse: Some(r_inverse) };
    let start = sign_solution(a, &symmetric(&g), q);
    let solution = start.and_then(|x| equation.refined(x)).or_else(|| {
        // Newton's method can start from any stabilising gain.
        let x = sign_solution(a, &(b * b.transpose()), &DMatrix::identity(n, n))?;
        equation.descended(b.tr_mul(&x))
    });
    solution.ok_or_else(|| equation.reason())
}

/// Solves X = AᵀXA − (AᵀXB + S)(R + BᵀXB)⁻¹(BᵀXA + Sᵀ) + Q for the X that makes A − BK stable,
/// K = (R + BᵀXB)⁻¹(BᵀXA + Sᵀ).
///
/// Shapes as in [`care`], `s` n×m, zero if omitted. `r` may be singular if R + BᵀXB is not.
///
/// The initial solution comes from the structured doubling algorithm. Where R is singular to rounding, it comes from
/// Newton's method, started at the gain of a regular problem. Where the cost is too indefinite for Newton's method, it
/// comes from doubling about a multiple of the identity.
///
/// # Errors
/// As [`care`].
///
/// # Source
/// Chu, Fan, Lin and Wang, *Structure-preserving algorithms for periodic discrete-time algebraic Riccati equations*,
/// 2004; Hewer 1971 for Newton's method. Equation (L2) of docs/equations.md.
pub fn dare(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
    s: Option<&DMatrix<f64>>,
) -> Result<RiccatiSolution, DesignError> {
    let (n, m) = (a.nrows(), b.ncols());
    let none = DMatrix::zeros(n, m);
    let s = s.unwrap_or(&none);
    check_problem(a, b, q, r, s)?;
    let equation = Equation { a, b, q, r, s, discrete: true, r_inverse: None };
    let solution = doubled(&equation)
        .and_then(|x| equation.refined(x))
        .or_else(|| {
            let (q, r) = (DMatrix::identity(n, n), DMatrix::identity(m, m));
            let regular =
                Equation { a, b, q: &q, r: &r, s: &none, discrete: true, r_inverse: None };
            let x = dare_by_doubling(a.clone(), b * b.transpose(), q.clone(), START_TOLERANCE)?;
            equation.descended(regular.gain(&x)?)
        })
        .or_else(|| {
            SHIFTS.into_iter().find_map(|shift| {
                let solution = equation.refined(doubled_about(&equation, shift)?)?;
                equation.is_inside(&solution.gain).then_some(solution)
            })
        });
    solution.ok_or_else(|| equation.reason())
}

/// The solution by structured doubling; `None` where R is singular to rounding or the iteration does not converge.
fn doubled(equation: &Equation<'_>) -> Option<DMatrix<f64>> {
    let Equation { a, b, q, r, s, .. } = equation;
    let r_inverse = well_inverted(r)?;
    let weighted = *b * &r_inverse;
    let own = *a - &weighted * s.transpose();
    let cost = *q - *s * &r_inverse * s.transpose();
    let g = symmetric(&(weighted * b.transpose()));
    dare_by_doubling(own, g, symmetric(&cost), START_TOLERANCE)
}

/// Multiples of the identity that [`doubled_about`] tries, in units of |R|/|B|², or of 1 where R is zero.
const SHIFTS: [f64; 4] = [1.0, -1.0, 7.0, -7.0];

/// The solution X₀ + Y, with X₀ a multiple of the identity. Y solves an equation of the same kind with R + BᵀX₀B, which
/// is regular even if R is not.
///
/// # Source
/// Equation (L18) of docs/equations.md.
fn doubled_about(equation: &Equation<'_>, shift: f64) -> Option<DMatrix<f64>> {
    let Equation { a, b, q, r, s, .. } = equation;
    let n = a.nrows();
    let size = if r.amax() > 0.0 { r.norm() / b.norm_squared() } else { 1.0 };
    let about = DMatrix::identity(n, n) * (shift * size);
    let onto = &about * *b;
    let q = symmetric(&(*q + a.transpose() * &about * *a - &about));
    let (r, s) = (symmetric(&(*r + b.tr_mul(&onto))), *s + a.tr_mul(&onto));
    let shifted = Equation { q: &q, r: &r, s: &s, r_inverse: None, ..*equation };
    Some(about + doubled(&shifted)?)
}

fn check_problem(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
    s: &DMatrix<f64>,
) -> Result<(), DesignError> {
    let (n, m) = (a.nrows(), b.ncols());
    check("A", a, n, n)?;
    check("B", b, n, m)?;
    check_symmetric("Q", q, n)?;
    check_symmetric("R", r, m)?;
    check("S", s, n, m)
}

/// The inverse of a matrix, if it is accurate to at least a few digits.
fn well_inverted(r: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let mut inverse = r.clone();
    invert(&mut inverse)?;
    (r.norm() * inverse.norm() < 1e12).then_some(inverse)
}
