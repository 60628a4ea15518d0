//! Optimal gains.

use nalgebra::{Complex, DMatrix};

use super::arguments::{check, check_definite, inverse};
use super::discretize::{Hold, zero_order_hold};
use super::error::DesignError;
use super::riccati::{care, dare};
use hovernav_model::linalg::eigenvalues;
use hovernav_model::{StateSpace, TimeDomain};

/// A state feedback u = −K x with its properties.
#[derive(Clone, Debug, PartialEq)]
pub struct Regulator {
    /// The model for which the gain was computed. For a sampled design it is the discrete model, including delayed
    /// inputs as states.
    pub model: StateSpace,
    /// K, one row per input, one column per state of [`model`](Self::model).
    pub gain: DMatrix<f64>,
    /// X: the cost to go from state x is xᵀXx.
    pub cost: DMatrix<f64>,
    /// Eigenvalues of A − BK.
    pub poles: Vec<Complex<f64>>,
    /// Relative residual of the Riccati equation.
    pub residual: f64,
}

/// The gain that minimises ∫ xᵀQx + uᵀRu dt for a continuous model.
///
/// # Errors
/// [`DesignError`] for a discrete model, an indefinite Q, an R that is not positive, NaN, inconsistent shapes, or an
/// unstabilisable mode.
///
/// ```
/// use hovernav_design::lqr;
/// use hovernav_model::{hover, shipped};
/// use nalgebra::{DMatrix, DVector};
///
/// let yaw = hover::yaw(&shipped::thesis())?;
/// let q = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 100.0]));
/// let regulator = lqr(&yaw, &q, &DMatrix::identity(2, 2))?;
/// assert!((regulator.gain[(1, 0)] - -2.0576).abs() < 5e-5);
/// # Ok::<(), hovernav_design::DesignError>(())
/// ```
pub fn lqr(
    model: &StateSpace,
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
) -> Result<Regulator, DesignError> {
    model.require_continuous()?;
    check_definite("Q", q, model.states().len(), false)?;
    check_definite("R", r, model.inputs().len(), true)?;
    let solution = care(model.a(), model.b(), q, r)?;
    Regulator::new(model.clone(), solution.gain, solution.x, solution.residual)
}

/// The gain that minimises Σ xᵀQx + uᵀRu over the steps of a discrete model.
///
/// # Errors
/// As [`lqr`], for a continuous model.
pub fn discrete_lqr(
    model: &StateSpace,
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
) -> Result<Regulator, DesignError> {
    model.require_discrete()?;
    check_definite("Q", q, model.states().len(), false)?;
    check_definite("R", r, model.inputs().len(), true)?;
    let solution = dare(model.a(), model.b(), q, r, None)?;
    Regulator::new(model.clone(), solution.gain, solution.x, solution.residual)
}

/// The gain at `period_s` for held inputs with a delay of `delay_s`. It minimises the continuous cost ∫ xᵀQx + uᵀRu dt,
/// including the motion between samples.
///
/// With a delay the gain also feeds back the delayed inputs that have not acted yet; see [`zero_order_hold`] for their
/// order.
///
/// # Errors
/// As [`lqr`] and [`zero_order_hold`].
///
/// # Source
/// Franklin, Powell, Workman, section 9.4; the integrals by Van Loan.
pub fn sampled_lqr(
    model: &StateSpace,
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
    period_s: f64,
    delay_s: f64,
) -> Result<Regulator, DesignError> {
    let (n, m) = (model.states().len(), model.inputs().len());
    model.require_continuous()?;
    check_definite("Q", q, n, false)?;
    check_definite("R", r, m, true)?;
    let sampled = zero_order_hold(model, period_s, delay_s)?;
    let size = sampled.states().len();
    let cost = Hold::new(model, period_s, delay_s)?.cost(q, r)?;
    let solution = dare(
        sampled.a(),
        sampled.b(),
        &cost.view((0, 0), (size, size)).into_owned(),
        &cost.view((size, size), (m, m)).into_owned(),
        Some(&cost.view((0, size), (size, m)).into_owned()),
    )?;
    Regulator::new(sampled, solution.gain, solution.x, solution.residual)
}

impl Regulator {
    fn new(
        model: StateSpace,
        gain: DMatrix<f64>,
        cost: DMatrix<f64>,
        residual: f64,
    ) -> Result<Self, DesignError> {
        let poles = eigenvalues(&(model.a() - model.b() * &gain))?;
        Ok(Self { model, gain, cost, poles, residual })
    }
}

/// The steady-state Kalman gain L, n×p, and the covariance P of the error of the estimated state.
///
/// `process`, n×n, is the noise on ẋ: its density for a continuous model, its covariance per step for a discrete model.
/// `measurement`, p×p, is the density or covariance of the noise on y. For a continuous model L corrects ẋ̂ by L(y −
/// Cx̂), and P is the covariance for x̂. For a discrete model L corrects the predicted state, and P is the covariance
/// for this prediction.
///
/// # Errors
/// [`DesignError`] as [`lqr`], with inputs and outputs exchanged: an undamped mode that is not observable is rejected.
///
/// # Source
/// Equation (L10) of docs/equations.md.
pub fn kalman(
    model: &StateSpace,
    process: &DMatrix<f64>,
    measurement: &DMatrix<f64>,
) -> Result<(DMatrix<f64>, DMatrix<f64>), DesignError> {
    check("process", process, model.states().len(), model.states().len())?;
    check_definite("process", process, model.states().len(), false)?;
    check_definite("measurement", measurement, model.outputs().len(), true)?;
    let (a, c) = (model.a().transpose(), model.c().transpose());
    match model.time() {
        TimeDomain::Continuous => {
            let solution = care(&a, &c, process, measurement)?;
            Ok((solution.gain.transpose(), solution.x))
        }
        TimeDomain::Discrete { .. } => {
            let p = dare(&a, &c, process, measurement, None)?.x;
            let onto = &p * &c;
            let spread = model.c() * &onto + measurement;
            Ok((onto * inverse(&spread, "CPCᵀ + V")?, p))
        }
    }
}
