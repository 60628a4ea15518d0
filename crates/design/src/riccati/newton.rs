//! Newton's method for a Riccati equation, with its residual in twice the working precision.

use nalgebra::DMatrix;

use super::sign::lyapunov;
use super::solution::RiccatiSolution;
use crate::double_double::DoubleDouble;
use crate::error::DesignError;
use crate::reachability::unstabilisable_mode;
use hovernav_model::TimeDomain;
use hovernav_model::linalg::{Stein, eigenvalues, invert, symmetric};

/// A continuous or discrete Riccati equation, with auxiliary matrices for Newton's method.
pub(super) struct Equation<'a> {
    pub a: &'a DMatrix<f64>,
    pub b: &'a DMatrix<f64>,
    pub q: &'a DMatrix<f64>,
    pub r: &'a DMatrix<f64>,
    pub s: &'a DMatrix<f64>,
    pub discrete: bool,
    pub r_inverse: Option<DMatrix<f64>>,
}

/// An intermediate solution.
struct Iterate {
    x: DMatrix<f64>,
    gain: DMatrix<f64>,
    closed: DMatrix<f64>,
    residual: DMatrix<f64>,
    remaining: f64,
}

/// Largest number of Newton steps.
const MAX_STEPS: usize = 60;
/// Largest relative residual of a valid solution.
const LARGEST_RESIDUAL: f64 = 1e-7;

impl Equation<'_> {
    /// The gain that corresponds to X.
    pub fn gain(&self, x: &DMatrix<f64>) -> Option<DMatrix<f64>> {
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

    /// Q + KᵀRK − SK − KᵀSᵀ: the cost of a gain per step or per unit time.
    fn cost(&self, gain: &DoubleDouble) -> DoubleDouble {
        let (m, n) = gain.high.shape();
        let weighted = DoubleDouble::zeros(m, n).plus_product(1.0, self.r, gain);
        let cost = DoubleDouble::of(self.q.clone()).plus_product(1.0, &gain.high, &weighted);
        if self.s.amax() == 0.0 {
            return cost;
        }
        let across = DoubleDouble::zeros(n, n).plus_product(1.0, &self.s.transpose(), gain);
        cost.plus(-1.0, &across).plus(-1.0, &across.transpose())
    }

    /// X with its gain and residual.
    ///
    /// Written in terms of the gain, the residual depends on an error of the gain only to second order. Doubled
    /// precision of the other terms is therefore sufficient.
    fn iterate(&self, x: DMatrix<f64>) -> Option<Iterate> {
        let gain = self.gain(&x)?;
        let (m, n) = gain.shape();
        let exact_gain = DoubleDouble::of(gain.clone());
        let closed =
            DoubleDouble::of(self.a.clone()).plus_product(-1.0, &self.b.transpose(), &exact_gain);
        let through = DoubleDouble::zeros(n, n).plus_product(1.0, &x, &closed);
        let cost = self.cost(&exact_gain);
        let residual = if self.discrete {
            // (A − BK)ᵀ(X(A − BK)) − X.
            let onto_inputs = DoubleDouble::zeros(m, n).plus_product(1.0, self.b, &through);
            cost.plus_product(1.0, self.a, &through)
                .plus_product(-1.0, &gain, &onto_inputs)
                .plus(-1.0, &DoubleDouble::of(x.clone()))
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
            stein(&at.closed, at.residual.clone())
        } else {
            lyapunov(&at.closed, &at.residual)
        }
    }

    /// Newton's method from an approximate solution, as long as each step improves the solution.
    pub fn refined(&self, start: DMatrix<f64>) -> Option<RiccatiSolution> {
        let mut best = self.iterate(start)?;
        for _ in 0..MAX_STEPS {
            let correction = self.correction(&best)?;
            // The square of so small a correction is below rounding.
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

    /// Newton's method from a stabilising gain, until convergence.
    ///
    /// Where no stabilising solution exists, the iteration converges slowly to a solution on the border of stability,
    /// which is rejected.
    pub fn descended(&self, mut gain: DMatrix<f64>) -> Option<RiccatiSolution> {
        let mut before: Option<DMatrix<f64>> = None;
        for _ in 0..MAX_STEPS {
            let closed = self.a - self.b * &gain;
            let cost = symmetric(&self.cost(&DoubleDouble::of(gain)).high);
            let x = if self.discrete { stein(&closed, cost)? } else { lyapunov(&closed, &cost)? };
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

    /// Whether the closed loop is stable by more than the errors of rounding and slow convergence.
    pub fn is_inside(&self, gain: &DMatrix<f64>) -> bool {
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

    /// Reason for the missing solution.
    pub fn reason(&self) -> DesignError {
        let time = match self.discrete {
            true => TimeDomain::Discrete { period_s: 1.0 },
            false => TimeDomain::Continuous,
        };
        match unstabilisable_mode(self.a, self.b, time) {
            Ok(Some((mode, singular_value))) => {
                DesignError::NotStabilisable { re: mode.re, im: mode.im, singular_value }
            }
            Ok(None) => DesignError::NoStabilisingSolution {
                reason: "the closed loop would keep a mode on the border of stability: the weights do not \
                     include it, or they are too indefinite",
            },
            Err(error) => error,
        }
    }
}

/// The solution of E = AᵀEA + Q; `None` unless A is stable.
fn stein(a: &DMatrix<f64>, q: DMatrix<f64>) -> Option<DMatrix<f64>> {
    Some(symmetric(&Stein::new(&a.transpose())?.solve(q)))
}
