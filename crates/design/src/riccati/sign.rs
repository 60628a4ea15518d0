//! Sign function of a matrix, which gives the initial solution of the continuous equations.

use nalgebra::DMatrix;

use hovernav_model::linalg::{invert, symmetric};

/// One step of the iteration for the sign of a matrix, given its inverse. Returns the relative change.
fn sign_step(matrix: &mut DMatrix<f64>, inverse: &DMatrix<f64>, scale: f64) -> f64 {
    let (mut moved, mut size) = (0.0, 0.0);
    let (own, other) = (0.5 * scale, 0.5 / scale);
    for (value, &inverse) in matrix.iter_mut().zip(inverse) {
        let next = own * *value + other * inverse;
        moved += (next - *value) * (next - *value);
        size += next * next;
        *value = next;
    }
    (moved / size).sqrt()
}

/// Largest number of iterations. It is sufficient for any matrix whose modes are distinct from the imaginary axis in
/// double precision.
const MAX_STEPS: usize = 100;

/// The solution of AᵀE + EA + Q = 0 by the sign iteration; `None` unless A is stable.
///
/// # Source
/// Roberts, *Linear model reduction and solution of the algebraic Riccati equation by use of the sign
/// function*, 1971/1980.
/// Equation (L3) of docs/equations.md.
pub(super) fn lyapunov(a: &DMatrix<f64>, q: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = a.nrows();
    let (mut a, mut q, mut inverse) = (a.clone(), q.clone(), a.clone());
    let (mut half, mut turned) = (q.clone(), q.clone());
    let mut change = f64::INFINITY;
    for _ in 0..MAX_STEPS {
        inverse.copy_from(&a);
        let log_determinant = invert(&mut inverse)?;
        let scale = if change > 0.01 { (-log_determinant / n as f64).exp() } else { 1.0 };
        q.mul_to(&inverse, &mut half);
        inverse.tr_mul_to(&half, &mut turned);
        q.zip_apply(&turned, |q, turned| *q = 0.5 * (scale * *q + turned / scale));
        change = sign_step(&mut a, &inverse, scale);
        // Convergence is quadratic: the next step would change the matrix by the square of this change.
        if change < 1e-8 || !change.is_finite() {
            break;
        }
    }
    // The sign of a stable matrix is minus identity.
    for index in 0..n {
        a[(index, index)] += 1.0;
    }
    (a.norm() < 1e-6).then(|| symmetric(&q) * 0.5)
}

/// X from the sign of the Hamiltonian matrix [[A, −G], [−Q, −Aᵀ]].
pub(super) fn sign_solution(
    a: &DMatrix<f64>,
    g: &DMatrix<f64>,
    q: &DMatrix<f64>,
) -> Option<DMatrix<f64>> {
    let n = a.nrows();
    let Balanced { a, g, q, weight, states } = balanced(a, g, q);
    let mut z = DMatrix::zeros(2 * n, 2 * n);
    z.view_mut((0, 0), (n, n)).copy_from(&a);
    z.view_mut((0, n), (n, n)).copy_from(&-g);
    z.view_mut((n, 0), (n, n)).copy_from(&-q);
    z.view_mut((n, n), (n, n)).copy_from(&-a.transpose());
    let mut change = f64::INFINITY;
    let mut inverse = z.clone();
    for _ in 0..MAX_STEPS {
        inverse.copy_from(&z);
        let log_determinant = invert(&mut inverse)?;
        let scale = if change > 0.01 { (-log_determinant / (2 * n) as f64).exp() } else { 1.0 };
        change = sign_step(&mut z, &inverse, scale);
        if !change.is_finite() {
            return None;
        }
        // Convergence is quadratic: the next step would change the matrix by the square of this change.
        if change < 1e-8 {
            break;
        }
    }
    // [S12; S22 + I] X = −[S11 + I; S21].
    let mut left = z.columns(n, n).into_owned();
    let mut right = -z.columns(0, n).into_owned();
    for index in 0..n {
        left[(n + index, index)] += 1.0;
        right[(index, index)] -= 1.0;
    }
    let factors = left.qr();
    factors.q_tr_mul(&mut right);
    let x = factors.r().solve_upper_triangular(&right.rows(0, n).into_owned())?;
    let unscaled = DMatrix::from_fn(n, n, |row, column| {
        x[(row, column)] * weight / (states[row] * states[column])
    });
    unscaled.iter().all(|value| value.is_finite()).then(|| symmetric(&unscaled))
}

/// A balanced Hamiltonian matrix, with the scales that restore the solution X. The element of X in row i and column j
/// is weight·xᵢⱼ/(stateᵢ·stateⱼ), with x the solution of the balanced problem.
struct Balanced {
    a: DMatrix<f64>,
    g: DMatrix<f64>,
    q: DMatrix<f64>,
    weight: f64,
    states: Vec<f64>,
}

/// Scales weights and states by powers of two, which preserves the structure without rounding.
///
/// # Source
/// Benner, *Symplectic balancing of Hamiltonian matrices*, 2001.
fn balanced(a: &DMatrix<f64>, g: &DMatrix<f64>, q: &DMatrix<f64>) -> Balanced {
    let n = a.nrows();
    let (mut a, mut g, mut q) = (a.clone(), g.clone(), q.clone());
    let mut states = vec![1.0; n];
    let mut weight = even(&mut g, &mut q);
    for _ in 0..20 {
        let mut moved = false;
        for index in 0..n {
            let (mut column, mut row) = (0.0, 0.0);
            for other in (0..n).filter(|&other| other != index) {
                column += a[(other, index)].abs() + q[(other, index)].abs();
                row += a[(index, other)].abs() + g[(index, other)].abs();
            }
            let (own_q, own_g) = (q[(index, index)].abs(), g[(index, index)].abs());
            if column + own_q == 0.0 || row + own_g == 0.0 {
                continue;
            }
            let size = |f: f64| column * f + row / f + own_q * f * f + own_g / (f * f);
            let mut factor = 1.0;
            while size(2.0 * factor) < 0.95 * size(factor) {
                factor *= 2.0;
            }
            while size(0.5 * factor) < 0.95 * size(factor) {
                factor *= 0.5;
            }
            if factor != 1.0 {
                moved = true;
                states[index] *= factor;
                a.column_mut(index).scale_mut(factor);
                a.row_mut(index).scale_mut(1.0 / factor);
                q.column_mut(index).scale_mut(factor);
                q.row_mut(index).scale_mut(factor);
                g.column_mut(index).scale_mut(1.0 / factor);
                g.row_mut(index).scale_mut(1.0 / factor);
            }
        }
        if !moved {
            break;
        }
    }
    weight *= even(&mut g, &mut q);
    Balanced { a, g, q, weight, states }
}

/// Scales G and Q to similar size and returns the factor.
fn even(g: &mut DMatrix<f64>, q: &mut DMatrix<f64>) -> f64 {
    let (g_size, q_size) = (g.norm(), q.norm());
    if g_size == 0.0 || q_size == 0.0 {
        return 1.0;
    }
    let weight = (0.5 * (q_size / g_size).log2()).round().exp2();
    g.scale_mut(weight);
    q.scale_mut(1.0 / weight);
    weight
}
