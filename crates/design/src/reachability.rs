//! Controllability and observability of a model.

use nalgebra::{Complex, DMatrix};

use super::error::DesignError;
use hovernav_model::linalg::{complex, eigenvalues, exponential, side_by_side, symmetric};
use hovernav_model::{StateSpace, TimeDomain};

/// Reachability of the states from the inputs or, from [`observability`], observability of the states in the outputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Reachability {
    /// Dimension of the reachable space: rank of [B, AB, A²B, …].
    pub rank: usize,
    /// Number of states.
    pub states: usize,
    /// Each mode with the smallest singular value of [λI − A, B]: zero for an uncontrollable mode (Popov, Belevitch,
    /// Hautus).
    pub modes: Vec<(Complex<f64>, f64)>,
    /// Gramian over the horizon: xᵀW⁻¹x is the least input energy that reaches x from rest.
    pub gramian: DMatrix<f64>,
    /// Eigenvalues of the Gramian in falling order.
    pub gramian_eigenvalues: Vec<f64>,
}

impl Reachability {
    /// Whether every state is reachable.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.rank == self.states
    }
}

/// Relative size below which a singular value counts as zero.
const RANK_TOLERANCE: f64 = 1e-11;

/// Reachability of the states of `model` from its inputs. The Gramian is over `horizon_s`, also for unstable models.
///
/// # Errors
/// [`DesignError::Range`] for a horizon that is not above zero.
pub fn reachability(model: &StateSpace, horizon_s: f64) -> Result<Reachability, DesignError> {
    analysed(model.a(), model.b(), model.time(), horizon_s)
}

/// Observability of the states of `model` from its outputs: [`reachability`] of the dual model.
///
/// # Errors
/// As [`reachability`].
pub fn observability(model: &StateSpace, horizon_s: f64) -> Result<Reachability, DesignError> {
    analysed(&model.a().transpose(), &model.c().transpose(), model.time(), horizon_s)
}

/// Reachability of the states of the pair (A, B).
///
/// # Source
/// Equation (L11) of docs/equations.md.
fn analysed(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    time: TimeDomain,
    horizon_s: f64,
) -> Result<Reachability, DesignError> {
    if !(horizon_s > 0.0 && horizon_s.is_finite()) {
        let expected = "a number above 0";
        return Err(DesignError::Range { name: "horizon_s", value: horizon_s, expected });
    }
    let modes =
        eigenvalues(a)?.into_iter().map(|mode| (mode, pencil_distance(a, b, mode))).collect();
    let gramian = gramian(a, b, time, horizon_s);
    if gramian.iter().any(|value| !value.is_finite()) {
        let expected = "one over which the unstable modes stay finite";
        return Err(DesignError::Range { name: "horizon_s", value: horizon_s, expected });
    }
    let mut gramian_eigenvalues: Vec<f64> =
        gramian.symmetric_eigenvalues().iter().copied().collect();
    gramian_eigenvalues.sort_by(|one, other| other.total_cmp(one));
    let (rank, states) = (rank(a, b), a.nrows());
    Ok(Reachability { rank, states, modes, gramian, gramian_eigenvalues })
}

/// Dimension of the space spanned by B, AB, A²B, …. An orthonormal basis is built block by block, so that powers of A
/// neither overflow nor vanish.
fn rank(a: &DMatrix<f64>, b: &DMatrix<f64>) -> usize {
    let n = a.nrows();
    let mut basis = DMatrix::zeros(n, 0);
    let mut block = b.clone();
    let mut scale = b.norm();
    while basis.ncols() < n && block.ncols() > 0 && scale > 0.0 {
        for _ in 0..2 {
            block = &block - &basis * basis.tr_mul(&block);
        }
        let parts = block.svd(true, false);
        let directions = parts.u.unwrap_or_else(|| DMatrix::zeros(n, 0));
        let found: Vec<usize> = (0..parts.singular_values.len())
            .filter(|&index| parts.singular_values[index] > RANK_TOLERANCE * scale)
            .collect();
        let new = directions.select_columns(&found);
        basis = side_by_side(&basis, &new);
        block = a * new;
        scale = a.norm();
    }
    basis.ncols().min(n)
}

/// Smallest singular value of [λI − A, B].
fn pencil_distance(a: &DMatrix<f64>, b: &DMatrix<f64>, mode: Complex<f64>) -> f64 {
    let n = a.nrows();
    let mut pencil = DMatrix::zeros(n, n + b.ncols());
    pencil.columns_mut(0, n).copy_from(&complex(&-a));
    for index in 0..n {
        pencil[(index, index)] += mode;
    }
    pencil.columns_mut(n, b.ncols()).copy_from(&complex(b));
    pencil.singular_values().iter().copied().fold(f64::INFINITY, f64::min)
}

/// First mode that is both undamped and uncontrollable, with its smallest singular value of [λI − A, B].
pub(super) fn unstabilisable_mode(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    time: TimeDomain,
) -> Result<Option<(Complex<f64>, f64)>, DesignError> {
    let scale = a.norm() + b.norm();
    for mode in eigenvalues(a)? {
        let dies_away = match time {
            TimeDomain::Continuous => mode.re < -1e-9 * scale,
            TimeDomain::Discrete { .. } => mode.norm() < 1.0 - 1e-9,
        };
        if !dies_away {
            let distance = pencil_distance(a, b, mode);
            // Double eigenvalues are accurate to about half the digits.
            if distance <= 1e-9 * scale {
                return Ok(Some((mode, distance)));
            }
        }
    }
    Ok(None)
}

/// ∫ e^(At)BBᵀe^(Aᵀt) dt over the horizon, or Σ AᵏBBᵀAᵀᵏ over its steps.
pub(super) fn gramian(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    time: TimeDomain,
    horizon_s: f64,
) -> DMatrix<f64> {
    let n = a.nrows();
    let spread = b * b.transpose();
    match time {
        TimeDomain::Continuous => {
            // The horizon is doubled from a short time, for which the exponential is well conditioned.
            let mut doublings = 0;
            let mut short_s = horizon_s;
            while short_s * a.norm() > 1.0 && doublings < 60 {
                short_s *= 0.5;
                doublings += 1;
            }
            let mut whole = DMatrix::zeros(2 * n, 2 * n);
            whole.view_mut((0, 0), (n, n)).copy_from(&-a);
            whole.view_mut((0, n), (n, n)).copy_from(&spread);
            whole.view_mut((n, n), (n, n)).copy_from(&a.transpose());
            let whole = exponential(&whole, short_s);
            let mut step = whole.view((n, n), (n, n)).transpose();
            let mut gramian = &step * whole.view((0, n), (n, n));
            for _ in 0..doublings {
                gramian = &gramian + &step * &gramian * step.transpose();
                step = &step * &step;
            }
            symmetric(&gramian)
        }
        TimeDomain::Discrete { period_s } => {
            let steps = (horizon_s / period_s).ceil().clamp(1.0, 1e6) as usize;
            let mut gramian = DMatrix::zeros(n, n);
            for _ in 0..steps {
                let further = a * &gramian * a.transpose() + &spread;
                let moved = (&further - &gramian).norm();
                let settled = moved <= f64::EPSILON * further.norm();
                gramian = further;
                if settled {
                    break;
                }
            }
            symmetric(&gramian)
        }
    }
}
