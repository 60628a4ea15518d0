//! Simultaneous parameter errors for which a loop is certainly stable, from an upper bound of the structured singular
//! value.

use nalgebra::{Complex, DMatrix};

use crate::curve::Curve;
use crate::logarithmic_frequencies;
use hovernav_model::linalg::{complex, symmetric};
use hovernav_model::{FrequencySweep, LinearModel, TimeDomain};

/// Number of frequencies before the maximum is refined.
const FREQUENCIES: usize = 240;
/// First frequency, rad/s.
const FIRST_RADPS: f64 = 0.01;
/// Largest number of improvements of the scaling.
const IMPROVED: usize = 60;
/// Relative improvement of the bound below which the iteration ends.
const CONVERGED: f64 = 1e-4;
/// Addition to the diagonal of the scaling, relative to its mean diagonal, which keeps the scaling positive definite.
const DEFINITE: f64 = 1e-8;

/// Guaranteed stability region of the parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProvenRadius {
    /// Radius of the ellipsoid of parameters, in sigma, within which every loop is stable; infinite where no parameter
    /// affects stability.
    pub sigmas: f64,
    /// Frequency that determines the bound, rad/s.
    pub frequency_radps: f64,
}

/// A stable loop x⁺ = (M + Σ ξₖ Mₖ) x with unknown ξ.
pub(super) struct UncertainLoop {
    /// Response of the loop from the rows that the parameters change to the columns through which they act.
    answer: FrequencySweep,
    /// Linear map from vec X to vec Σ MₖᵀX Mₖ, with the rows and columns of `answer`.
    moved: DMatrix<f64>,
    period_s: f64,
}

impl UncertainLoop {
    /// The loop with the transition matrix `step`, which each ξₖ changes by its matrix in `moves`. `None` where no ξₖ
    /// changes it.
    pub fn new(step: &DMatrix<f64>, moves: &[DMatrix<f64>], period_s: f64) -> Option<Self> {
        let n = step.nrows();
        let is_moved = |entries: &dyn Fn(&DMatrix<f64>) -> f64| {
            moves.iter().map(entries).fold(0.0, f64::max) > 0.0
        };
        let rows: Vec<usize> = (0..n).filter(|&row| is_moved(&|own| own.row(row).amax())).collect();
        let columns: Vec<usize> =
            (0..n).filter(|&column| is_moved(&|own| own.column(column).amax())).collect();
        if rows.is_empty() {
            return None;
        }
        // Each row is scaled so that its change is about one: units do not affect the bound, only its rounding.
        let size = |row: usize| moves.iter().map(|own| own.row(row).norm_squared()).sum::<f64>();
        let units: Vec<f64> = rows.iter().map(|&row| size(row).sqrt()).collect();
        let mut into = DMatrix::zeros(n, rows.len());
        for (column, (&row, unit)) in rows.iter().zip(&units).enumerate() {
            into[(row, column)] = *unit;
        }
        let mut out = DMatrix::zeros(columns.len(), n);
        for (row, &column) in columns.iter().enumerate() {
            out[(row, column)] = 1.0;
        }
        let mut moved = DMatrix::zeros(columns.len().pow(2), rows.len().pow(2));
        for own in moves {
            let own = own.select_rows(&rows).select_columns(&columns);
            let own = DMatrix::from_fn(columns.len(), rows.len(), |column, row| {
                own[(row, column)] / units[row]
            });
            moved += own.kronecker(&own);
        }
        let direct = DMatrix::zeros(columns.len(), rows.len());
        let time = TimeDomain::Discrete { period_s };
        let answer = LinearModel { time, a: step.clone(), b: into, c: out, d: direct };
        Some(Self { answer: answer.sweep(), moved, period_s })
    }

    /// Radius of the ball of ξ, real or complex, in which the loop stays stable.
    ///
    /// With T(z) from the rows to the columns at a frequency, the loop becomes unstable where I − Σ ξₖ MₖT is singular.
    /// Let Φ(X) = Σ (MₖT)* X MₖT. For every positive X, ‖Σ ξₖ X^½MₖT X^-½‖² is at most |ξ|² times the largest
    /// eigenvalue of X^-½ Φ(X) X^-½. The smallest such eigenvalue over all X is the spectral radius of the positive map
    /// Φ. Iterations of Φ converge to this radius, and every intermediate X gives a bound.
    ///
    /// # Source
    /// Full D scaling of one block ξᵀ ⊗ I: Packard and Doyle (1993), *The complex structured singular value*,
    /// Automatica 29(1). Spectral radius of a positive map: Evans and Høegh-Krohn (1978), J. London Math. Soc.
    /// 17(2). Equation (L24) of docs/equations.md.
    pub fn radius(&self) -> ProvenRadius {
        let nyquist = std::f64::consts::PI / self.period_s;
        let grid = logarithmic_frequencies(FIRST_RADPS, nyquist, FREQUENCIES);
        let curve = Curve::new(&grid, |frequency_radps| self.gain(frequency_radps));
        let highest = curve.peak(|gain| *gain);
        let at_zero = curve.at(0.0).unwrap_or(0.0);
        let (gain, frequency_radps) = if at_zero > highest.value {
            (at_zero, 0.0)
        } else {
            (highest.value, highest.frequency_radps)
        };
        ProvenRadius { sigmas: 1.0 / gain.max(0.0), frequency_radps }
    }

    /// The bound at a frequency: the inverse of the radius.
    fn gain(&self, frequency_radps: f64) -> Option<f64> {
        let answer = self.answer.at(frequency_radps)?;
        let rows = answer.ncols();
        let mut shape = complex(&DMatrix::identity(rows, rows));
        let mut least = f64::INFINITY;
        for _ in 0..IMPROVED {
            let next = self.map(&answer, &shape);
            let bound = relative_size(&next, &shape)?;
            let gained = least - bound;
            least = least.min(bound);
            let size = next.trace().re;
            if gained < CONVERGED * bound || !(size > 0.0 && size.is_finite()) {
                break;
            }
            shape = next / Complex::from(size / rows as f64);
            for index in 0..rows {
                shape[(index, index)] += DEFINITE;
            }
        }
        Some(least.max(0.0).sqrt()).filter(|gain| gain.is_finite())
    }

    /// The map Φ(X) = Σ (MₖT)* X MₖT.
    fn map(
        &self,
        answer: &DMatrix<Complex<f64>>,
        shape: &DMatrix<Complex<f64>>,
    ) -> DMatrix<Complex<f64>> {
        let part = |of: fn(&Complex<f64>) -> f64| {
            let flat = DMatrix::from_iterator(shape.len(), 1, shape.iter().map(of));
            &self.moved * flat
        };
        let (real, imaginary) = (part(|value| value.re), part(|value| value.im));
        let parts = real.iter().zip(&imaginary).map(|(&re, &im)| Complex::new(re, im));
        let columns = answer.nrows();
        answer.ad_mul(&(DMatrix::from_iterator(columns, columns, parts) * answer))
    }
}

/// The largest eigenvalue of X^-½ Y X^-½, with Hermitian X and Y and positive definite X.
fn relative_size(y: &DMatrix<Complex<f64>>, x: &DMatrix<Complex<f64>>) -> Option<f64> {
    let factor = x.clone().cholesky()?.unpack();
    let half = factor.solve_lower_triangular(y)?;
    let whole = factor.solve_lower_triangular(&half.adjoint())?;
    Some(largest_eigenvalue(&whole))
}

/// Largest eigenvalue of a Hermitian matrix, from the symmetric matrix of twice its size.
fn largest_eigenvalue(matrix: &DMatrix<Complex<f64>>) -> f64 {
    let n = matrix.nrows();
    let real = DMatrix::from_fn(2 * n, 2 * n, |row, column| {
        let value = matrix[(row % n, column % n)];
        match (row < n, column < n) {
            (true, false) => -value.im,
            (false, true) => value.im,
            _ => value.re,
        }
    });
    symmetric(&real).symmetric_eigenvalues().iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    fn sigmas(step: &DMatrix<f64>, moves: &[DMatrix<f64>]) -> f64 {
        UncertainLoop::new(step, moves, 0.03).unwrap().radius().sigmas
    }

    #[test]
    fn the_radius_is_exact_where_it_is_known() {
        let near = |found: f64, expected: f64| {
            assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
        };
        // 0.5 + 0.1 ξ reaches 1 at 5 sigmas.
        near(sigmas(&dmatrix![0.5], &[dmatrix![0.1]]), 5.0);
        // Two parameters together reach 1 at 1/√2 of the distance.
        near(sigmas(&dmatrix![0.5], &[dmatrix![0.1], dmatrix![0.1]]), 5.0 / 2f64.sqrt());
        // Two independent parameters: the radius is the smaller of 5 and 2 sigmas.
        let apart = [dmatrix![0.1, 0.0; 0.0, 0.0], dmatrix![0.0, 0.0; 0.0, 0.1]];
        near(sigmas(&dmatrix![0.5, 0.0; 0.0, 0.8], &apart), 2.0);
        // (z − 0.5)² = ξ, in units that differ by a thousand.
        let coupled = [dmatrix![0.0, 0.0; 1e-3, 0.0]];
        near(sigmas(&dmatrix![0.5, 1e3; 0.0, 0.5], &coupled), 0.25);
        // At the Nyquist frequency.
        near(sigmas(&dmatrix![-0.5], &[dmatrix![0.1]]), 5.0);
    }

    #[test]
    fn what_cannot_make_a_loop_unstable_has_no_radius() {
        // Only the effect of the second state on the first, without feedback.
        let found = sigmas(&dmatrix![0.5, 0.0; 0.0, 0.5], &[dmatrix![0.0, 0.1; 0.0, 0.0]]);
        assert!(found > 1e3, "{found}");
        assert!(UncertainLoop::new(&dmatrix![0.5], &[dmatrix![0.0]], 0.03).is_none());
    }
}
