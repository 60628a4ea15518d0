//! The algebraic Riccati equations of optimal control.
//!
//! A structure-preserving iteration gives a start, Newton's rule finishes it. Its residual is worked
//! out in twice the working precision, so the result is right to rounding wherever the equation
//! itself is not singular to rounding.

use nalgebra::DMatrix;

use super::error::DesignError;
use super::exact::Exact;
use super::linalg::{
    check, check_symmetric, inverse, invert, lyapunov, sign_step, stein, symmetric,
};
use super::reachability::unstabilisable_mode;
use hovernav_model::{TimeDomain, eigenvalues};

/// The stabilising solution of a Riccati equation.
#[derive(Clone, Debug, PartialEq)]
pub struct RiccatiSolution {
    /// X, n×n, symmetric.
    pub x: DMatrix<f64>,
    /// The gain K, m×n, of u = −K x.
    pub gain: DMatrix<f64>,
    /// What is left of the equation, relative to the size of its terms.
    pub residual: f64,
}

/// A problem, continuous or discrete, with what Newton's rule asks of it.
struct Equation<'a> {
    a: &'a DMatrix<f64>,
    b: &'a DMatrix<f64>,
    q: &'a DMatrix<f64>,
    r: &'a DMatrix<f64>,
    s: &'a DMatrix<f64>,
    discrete: bool,
    r_inverse: Option<DMatrix<f64>>,
}

/// A point on the way to the solution.
struct Iterate {
    x: DMatrix<f64>,
    gain: DMatrix<f64>,
    closed: DMatrix<f64>,
    residual: DMatrix<f64>,
    remaining: f64,
}

const MOST_STEPS: usize = 60;
/// A solution with more than this left of its equation is none.
const LARGEST_RESIDUAL: f64 = 1e-7;

/// Solves AᵀX + XA − XBR⁻¹BᵀX + Q = 0 for the X that makes A − BK stable, K = R⁻¹BᵀX.
///
/// `a` is n×n, `b` n×m, `q` n×n symmetric (it may be indefinite: the equation does not mind), `r` m×m
/// symmetric and invertible.
///
/// The start is the sign of the balanced Hamiltonian matrix, with determinantal scaling.
///
/// # Errors
/// [`DesignError`] for shapes that disagree, NaN, weights that are not symmetric, a singular `r`, a
/// mode that no input can stabilise, and where no stabilising solution exists.
///
/// # Source
/// Byers, *Solving the algebraic Riccati equation with the matrix sign function*, 1987; Kleinman 1968
/// for Newton's rule.
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
        // Any stabilising gain will do for Newton's rule to start from.
        let x = sign_solution(a, &(b * b.transpose()), &DMatrix::identity(n, n))?;
        equation.descended(b.tr_mul(&x))
    });
    solution.ok_or_else(|| equation.reason())
}

/// Solves X = AᵀXA − (AᵀXB + S)(R + BᵀXB)⁻¹(BᵀXA + Sᵀ) + Q for the X that makes A − BK stable,
/// K = (R + BᵀXB)⁻¹(BᵀXA + Sᵀ).
///
/// Shapes as in [`care`], `s` n×m, zero where none is given. `r` may be singular as long as R + BᵀXB
/// is not.
///
/// The start is the structured doubling algorithm; where R is singular to rounding, Newton's rule
/// from the gain of a regular problem.
///
/// # Errors
/// As [`care`].
///
/// # Source
/// Chu, Fan, Lin and Wang, *Structure-preserving algorithms for periodic discrete-time algebraic
/// Riccati equations*, 2004; Hewer 1971 for Newton's rule.
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
    let solution = well_inverted(r)
        .and_then(|r_inverse| {
            let weighted = b * &r_inverse;
            let own = a - &weighted * s.transpose();
            let cost = q - s * &r_inverse * s.transpose();
            doubled(own, symmetric(&(weighted * b.transpose())), symmetric(&cost))
        })
        .and_then(|x| equation.refined(x))
        .or_else(|| {
            let (q, r) = (DMatrix::identity(n, n), DMatrix::identity(m, m));
            let regular =
                Equation { a, b, q: &q, r: &r, s: &none, discrete: true, r_inverse: None };
            let x = doubled(a.clone(), b * b.transpose(), q.clone())?;
            equation.descended(regular.gain(&x)?)
        });
    solution.ok_or_else(|| equation.reason())
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

/// The inverse of a matrix that has one to at least a few digits.
fn well_inverted(r: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let mut inverse = r.clone();
    invert(&mut inverse)?;
    (r.norm() * inverse.norm() < 1e12).then_some(inverse)
}

impl Equation<'_> {
    /// The gain that X asks for.
    fn gain(&self, x: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        match &self.r_inverse {
            Some(r_inverse) => Some(r_inverse * self.b.tr_mul(x)),
            None => {
                let onto = x * self.b;
                let mut weight = self.r + self.b.tr_mul(&onto);
                invert(&mut weight)?;
                Some(weight * (onto.tr_mul(self.a) + self.s.transpose()))
            }
        }
    }

    /// Q + KᵀRK − SK − KᵀSᵀ: the cost of a gain over one step or instant.
    fn cost(&self, gain: &Exact) -> Exact {
        let (m, n) = gain.high.shape();
        let weighted = Exact::zeros(m, n).plus_product(1.0, self.r, gain);
        let cost = Exact::of(self.q.clone()).plus_product(1.0, &gain.high, &weighted);
        if self.s.amax() == 0.0 {
            return cost;
        }
        let across = Exact::zeros(n, n).plus_product(1.0, &self.s.transpose(), gain);
        cost.plus(-1.0, &across).plus(-1.0, &across.transpose())
    }

    /// X with its gain and what it leaves of the equation.
    ///
    /// Written around the gain, the residual feels an error of the gain only in second order: that
    /// makes doubled precision in the rest worth having.
    fn iterate(&self, x: DMatrix<f64>) -> Option<Iterate> {
        let gain = self.gain(&x)?;
        let (m, n) = gain.shape();
        let exact_gain = Exact::of(gain.clone());
        let closed = Exact::of(self.a.clone()).plus_product(-1.0, &self.b.transpose(), &exact_gain);
        let through = Exact::zeros(n, n).plus_product(1.0, &x, &closed);
        let cost = self.cost(&exact_gain);
        let residual = if self.discrete {
            // (A − BK)ᵀ(X(A − BK)) − X.
            let onto_inputs = Exact::zeros(m, n).plus_product(1.0, self.b, &through);
            cost.plus_product(1.0, self.a, &through)
                .plus_product(-1.0, &gain, &onto_inputs)
                .plus(-1.0, &Exact::of(x.clone()))
        } else {
            cost.plus(1.0, &through).plus(1.0, &through.transpose())
        };
        let residual = symmetric(&residual.high);
        let remaining = residual.norm();
        let closed = closed.high;
        remaining.is_finite().then_some(Iterate { x, gain, closed, residual, remaining })
    }

    /// Newton's correction of an iterate; `None` unless its closed loop is stable.
    fn correction(&self, at: &Iterate) -> Option<DMatrix<f64>> {
        if self.discrete {
            stein(&at.closed, &at.residual)
        } else {
            lyapunov(&at.closed, &at.residual)
        }
    }

    /// Newton's rule from a start that is nearly there, as long as it gains.
    fn refined(&self, start: DMatrix<f64>) -> Option<RiccatiSolution> {
        let mut best = self.iterate(start)?;
        for _ in 0..MOST_STEPS {
            let correction = self.correction(&best)?;
            // Once the correction is this small, its square is below rounding.
            let small = correction.norm() <= 1e-12 * best.x.norm();
            let next = self.iterate(&best.x + &correction);
            match next {
                Some(next) if next.remaining < best.remaining => best = next,
                _ => break,
            }
            if small {
                break;
            }
        }
        self.finished(best)
    }

    /// Newton's rule from a gain that stabilises, all the way.
    ///
    /// Where no stabilising solution exists it creeps towards one on the border of stability; that is
    /// no solution.
    fn descended(&self, mut gain: DMatrix<f64>) -> Option<RiccatiSolution> {
        let mut before: Option<DMatrix<f64>> = None;
        for _ in 0..MOST_STEPS {
            let closed = self.a - self.b * &gain;
            let cost = symmetric(&self.cost(&Exact::of(gain)).high);
            let x = if self.discrete { stein(&closed, &cost)? } else { lyapunov(&closed, &cost)? };
            gain = self.gain(&x)?;
            let settled = before.is_some_and(|old| (&x - old).norm() <= 1e-10 * x.norm());
            if settled {
                let solution = self.refined(x)?;
                return self.is_inside(&solution.gain).then_some(solution);
            }
            before = Some(x);
        }
        None
    }

    /// Whether the closed loop is stable by more than rounding and slow convergence can feign.
    fn is_inside(&self, gain: &DMatrix<f64>) -> bool {
        let closed = self.a - self.b * gain;
        let border = if self.discrete { 1.0 - 1e-8 } else { -1e-8 * closed.norm() };
        eigenvalues(&closed).is_ok_and(|poles| {
            poles.iter().all(|pole| if self.discrete { pole.norm() } else { pole.re } < border)
        })
    }

    fn finished(&self, last: Iterate) -> Option<RiccatiSolution> {
        let onto = last.x.norm() * self.a.norm();
        let terms = if self.discrete {
            last.x.norm() + onto * self.a.norm() + self.q.norm()
        } else {
            2.0 * onto + self.q.norm()
        };
        let residual = if terms > 0.0 { last.remaining / terms } else { 0.0 };
        let Iterate { x, gain, .. } = last;
        (residual <= LARGEST_RESIDUAL).then_some(RiccatiSolution { x, gain, residual })
    }

    /// Why there is no solution.
    fn reason(&self) -> DesignError {
        let time = match self.discrete {
            true => TimeDomain::Discrete { period_s: 1.0 },
            false => TimeDomain::Continuous,
        };
        match unstabilisable_mode(self.a, self.b, time) {
            Ok(Some((mode, singular_value))) => {
                DesignError::NotStabilisable { re: mode.re, im: mode.im, singular_value }
            }
            Ok(None) => DesignError::NoStabilisingSolution {
                reason: "the closed loop would keep a mode on the border of stability: one that the \
                         weights do not see, or weights that are too indefinite",
            },
            Err(error) => error,
        }
    }
}

/// X from the sign of the Hamiltonian matrix [[A, −G], [−Q, −Aᵀ]].
fn sign_solution(a: &DMatrix<f64>, g: &DMatrix<f64>, q: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = a.nrows();
    let Balanced { a, g, q, weight, states } = balanced(a, g, q);
    let mut z = DMatrix::zeros(2 * n, 2 * n);
    z.view_mut((0, 0), (n, n)).copy_from(&a);
    z.view_mut((0, n), (n, n)).copy_from(&-g);
    z.view_mut((n, 0), (n, n)).copy_from(&-q);
    z.view_mut((n, n), (n, n)).copy_from(&-a.transpose());
    let mut change = f64::INFINITY;
    let mut inverse = z.clone();
    for _ in 0..MOST_STEPS {
        inverse.copy_from(&z);
        let log_determinant = invert(&mut inverse)?;
        let scale = if change > 0.01 { (-log_determinant / (2 * n) as f64).exp() } else { 1.0 };
        change = sign_step(&mut z, &inverse, scale);
        if !change.is_finite() {
            return None;
        }
        // Convergence is quadratic: the next step would move by the square of this.
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

/// A Hamiltonian matrix of even size throughout, and how to go back: X = weight·x/(state·state).
struct Balanced {
    a: DMatrix<f64>,
    g: DMatrix<f64>,
    q: DMatrix<f64>,
    weight: f64,
    states: Vec<f64>,
}

/// Scales weights and states by powers of two, which keep the structure and cost no rounding.
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

/// Makes G and Q of like size, and gives the factor between.
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

/// X of the discrete equation with A, G = BR⁻¹Bᵀ and Q, by structured doubling.
fn doubled(mut a: DMatrix<f64>, mut g: DMatrix<f64>, mut h: DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = a.nrows();
    for _ in 0..MOST_STEPS {
        let mut between = &g * &h;
        for index in 0..n {
            between[(index, index)] += 1.0;
        }
        invert(&mut between)?;
        let onto_a = &between * &a;
        let onto_g = between * &g;
        let further = symmetric(&(a.tr_mul(&h) * &onto_a));
        g += symmetric(&(&a * onto_g * a.transpose()));
        a = &a * onto_a;
        let (moved, size) = (further.norm(), h.norm());
        h += further;
        if !h.norm().is_finite() || !a.norm().is_finite() {
            return None;
        }
        if moved <= 1e-10 * size {
            break;
        }
    }
    Some(h)
}
