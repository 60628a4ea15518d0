//! Damped least squares after Levenberg and Marquardt, between gradient descent and Gauss–Newton.

use nalgebra::{Cholesky, DMatrix, DVector};

/// Gauss–Newton approximation of a cost at one point.
#[derive(Debug, Clone)]
pub struct Quadratic {
    /// Cost at the point: half the sum of squares, or a negative log-likelihood.
    pub cost: f64,
    /// Gradient of the cost.
    pub gradient: DVector<f64>,
    /// JᵀJ, or Fisher's information: symmetric, positive semidefinite.
    pub information: DMatrix<f64>,
}

/// A cost to minimise.
pub trait Cost {
    /// The cost at `theta`; `None` where it does not exist.
    fn cost(&self, theta: &[f64]) -> Option<f64>;
    /// The cost at `theta` with gradient and information; `None` where it does not exist.
    fn quadratic(&self, theta: &[f64]) -> Option<Quadratic>;
}

/// Stopping criteria.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Largest number of linearisations.
    pub iterations: usize,
    /// The search stops where a full Gauss–Newton step predicts a smaller decrease of the cost than this.
    pub min_decrease: f64,
}

impl Default for Limits {
    /// 100 iterations and a decrease of 5e-3: for a log-likelihood, a tenth of a bound.
    fn default() -> Self {
        Self { iterations: 100, min_decrease: 5e-3 }
    }
}

/// Result of the search.
#[derive(Debug, Clone)]
pub struct Minimum {
    /// Parameters at the end.
    pub theta: Vec<f64>,
    /// Quadratic approximation of the cost there.
    pub at: Quadratic,
    /// Number of linearisations.
    pub iterations: usize,
    /// Whether the search converged: no further decrease was predicted.
    pub converged: bool,
    /// For each parameter whether it ended on a bound with the gradient pointing outwards.
    pub on_bound: Vec<bool>,
}

/// Minimises `problem` from `start` between `lower` and `upper`.
///
/// A parameter on a bound is left unchanged if its gradient points outwards; a step past a bound ends on it. Damping
/// multiplies the information's diagonal, so the scale of a parameter does not matter. `None` where the cost does not
/// exist at the start.
///
/// # Source
/// Marquardt (1963), *J. SIAM* 11(2); the damping schedule is Nielsen's, IMM-REP-1999-05. Equation (I14) of
/// docs/equations.md.
///
/// # Panics
/// Where the lengths differ.
pub fn minimise(
    problem: &impl Cost,
    start: &[f64],
    lower: &[f64],
    upper: &[f64],
    limits: Limits,
) -> Option<Minimum> {
    assert!(start.len() == lower.len() && start.len() == upper.len(), "one bound per parameter");
    let clamp = |value: f64, index: usize| value.max(lower[index]).min(upper[index]);
    let mut theta: Vec<f64> = (0..start.len()).map(|index| clamp(start[index], index)).collect();
    let mut at = problem.quadratic(&theta)?;
    let (mut damping, mut growth) = (1e-4, 2.0);
    let mut iterations = 1;
    loop {
        let on_bound: Vec<bool> = (0..theta.len())
            .map(|index| {
                (theta[index] <= lower[index] && at.gradient[index] > 0.0)
                    || (theta[index] >= upper[index] && at.gradient[index] < 0.0)
            })
            .collect();
        let free: Vec<usize> = (0..theta.len()).filter(|&index| !on_bound[index]).collect();
        let done = |theta, at, converged| {
            Some(Minimum { theta, at, iterations, converged, on_bound: on_bound.clone() })
        };
        let promise = step(&at, &free, 0.0)
            .or_else(|| step(&at, &free, 1e-9))
            .map_or(f64::INFINITY, |step| -0.5 * at.gradient.dot(&step));
        if promise < limits.min_decrease {
            return done(theta, at, true);
        }
        if iterations >= limits.iterations {
            return done(theta, at, false);
        }
        loop {
            if damping > 1e12 {
                return done(theta, at, false);
            }
            if let Some(step) = step(&at, &free, damping) {
                let trial: Vec<f64> = (0..theta.len())
                    .map(|index| clamp(theta[index] + step[index], index))
                    .collect();
                let moved = DVector::from_iterator(
                    theta.len(),
                    trial.iter().zip(&theta).map(|(new, old)| new - old),
                );
                let expected =
                    -(at.gradient.dot(&moved) + 0.5 * moved.dot(&(&at.information * &moved)));
                let ratio = problem
                    .cost(&trial)
                    .filter(|cost| cost.is_finite())
                    .map_or(-1.0, |cost| (at.cost - cost) / expected);
                if expected > 0.0
                    && ratio > 1e-4
                    && let Some(next) = problem.quadratic(&trial)
                {
                    damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).max(1.0 / 10.0);
                    growth = 2.0;
                    (theta, at) = (trial, next);
                    iterations += 1;
                    break;
                }
            }
            damping *= growth;
            growth *= 2.0;
        }
    }
}

/// The damped step on the free parameters, 0 on the others.
fn step(at: &Quadratic, free: &[usize], damping: f64) -> Option<DVector<f64>> {
    let mut matrix = at.information.select_rows(free).select_columns(free);
    let smallest = 1e-14 * matrix.diagonal().amax();
    for index in 0..free.len() {
        matrix[(index, index)] += damping * matrix[(index, index)].max(smallest);
    }
    let solved = Cholesky::new(matrix)?.solve(&at.gradient.select_rows(free));
    let mut step = DVector::zeros(at.gradient.len());
    for (&index, value) in free.iter().zip(solved.iter()) {
        step[index] = -value;
    }
    step.iter().all(|value| value.is_finite()).then_some(step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    /// Rosenbrock's valley as least squares: residuals 10 (y − x²) and 1 − x.
    struct Valley;

    impl Cost for Valley {
        fn cost(&self, theta: &[f64]) -> Option<f64> {
            self.quadratic(theta).map(|at| at.cost)
        }

        fn quadratic(&self, theta: &[f64]) -> Option<Quadratic> {
            let (x, y) = (theta[0], theta[1]);
            let residual = DVector::from_vec(vec![10.0 * (y - x * x), 1.0 - x]);
            let slope = DMatrix::from_row_slice(2, 2, &[-20.0 * x, 10.0, -1.0, 0.0]);
            Some(Quadratic {
                cost: 0.5 * residual.norm_squared(),
                gradient: slope.tr_mul(&residual),
                information: slope.tr_mul(&slope),
            })
        }
    }

    const FREE: [f64; 2] = [f64::INFINITY; 2];

    #[test]
    fn a_curved_valley_is_followed_to_its_end() {
        let limits = Limits { min_decrease: 1e-20, ..Limits::default() };
        let found = minimise(&Valley, &[-1.2, 1.0], &FREE.map(|b| -b), &FREE, limits).unwrap();
        assert!(found.converged && found.iterations < 40, "{}", found.iterations);
        assert_abs_diff_eq!(found.theta[0], 1.0, epsilon = 1e-8);
        assert_abs_diff_eq!(found.theta[1], 1.0, epsilon = 1e-8);
    }

    #[test]
    fn a_bound_in_the_way_holds_and_is_reported() {
        let limits = Limits { min_decrease: 1e-20, ..Limits::default() };
        let found =
            minimise(&Valley, &[-1.2, 1.0], &FREE.map(|b| -b), &[0.5, f64::INFINITY], limits)
                .unwrap();
        assert_eq!(found.theta[0], 0.5);
        assert_eq!(found.on_bound, [true, false]);
        assert_abs_diff_eq!(found.theta[1], 0.25, epsilon = 1e-8);
    }
}
