//! A linear model as matrices in one time domain.

use std::fmt;

use nalgebra::{Complex, DMatrix, DVector};

use super::linalg::{ZeroOrderHold, complex, spectral_radius};

/// Meaning of a model's matrices: rates of change, or the state one period later.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeDomain {
    /// ẋ = A x + B u.
    Continuous,
    /// x⁺ = A x + B u, with x⁺ the state one period later.
    Discrete {
        /// Sample period, s, above zero.
        period_s: f64,
    },
}

impl TimeDomain {
    /// `"continuous"` or `"discrete"`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Continuous => "continuous",
            Self::Discrete { .. } => "discrete",
        }
    }

    /// z = jω for a continuous model, e^(jωT) for a discrete one.
    pub(super) fn variable(self, frequency_radps: f64) -> Complex<f64> {
        match self {
            Self::Continuous => Complex::new(0.0, frequency_radps),
            Self::Discrete { period_s } => Complex::from_polar(1.0, frequency_radps * period_s),
        }
    }
}

impl fmt::Display for TimeDomain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Continuous => f.write_str("continuous"),
            Self::Discrete { period_s } => write!(f, "discrete, {period_s} s"),
        }
    }
}

/// A linear time-invariant model, n states, m inputs, p outputs: ẋ or x⁺ = A x + B u, y = C x + D u.
///
/// Plain matrices: [`StateSpace`](crate::StateSpace) adds names and guarantees matching shapes and finite numbers.
///
/// ```
/// use hovernav_model::{LinearModel, TimeDomain};
/// use hovernav_model::nalgebra::{dmatrix, dvector};
///
/// // A lag of 0.5 s, its input held for 0.1 s at a time.
/// let lag = LinearModel {
///     time: TimeDomain::Continuous,
///     a: dmatrix![-2.0],
///     b: dmatrix![2.0],
///     c: dmatrix![1.0],
///     d: dmatrix![0.0],
/// };
/// let held = lag.held(0.1).unwrap();
/// let run = held.simulate(&dmatrix![1.0; 1.0; 1.0], &dvector![0.0]);
/// assert!((run[2] - (1.0 - f64::exp(-0.4))).abs() < 1e-15);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LinearModel {
    /// Whether A and B give the rate of change of the state or the state one period later.
    pub time: TimeDomain,
    /// A, n×n: 1/s for a continuous model, the transition over one period for a discrete one.
    pub a: DMatrix<f64>,
    /// B, n×m.
    pub b: DMatrix<f64>,
    /// C, p×n.
    pub c: DMatrix<f64>,
    /// D, p×m.
    pub d: DMatrix<f64>,
}

impl LinearModel {
    /// The model whose outputs are its states. `a` is n×n, `b` n×m.
    #[must_use]
    pub fn of_states(time: TimeDomain, a: DMatrix<f64>, b: DMatrix<f64>) -> Self {
        let (n, m) = (a.nrows(), b.ncols());
        Self { time, a, b, c: DMatrix::identity(n, n), d: DMatrix::zeros(n, m) }
    }

    /// Number of states, n.
    #[must_use]
    pub fn order(&self) -> usize {
        self.a.nrows()
    }

    /// Number of inputs, m.
    #[must_use]
    pub fn input_count(&self) -> usize {
        self.b.ncols()
    }

    /// Number of outputs, p.
    #[must_use]
    pub fn output_count(&self) -> usize {
        self.c.nrows()
    }

    /// Largest magnitude of the eigenvalues of A. A discrete model is stable if it is below 1. Infinite where A
    /// contains NaN or an infinity.
    #[must_use]
    pub fn spectral_radius(&self) -> f64 {
        spectral_radius(&self.a)
    }

    /// The discrete equivalent of this continuous model with inputs held constant over `period_s`, exact to rounding.
    /// `None` where a number is not finite.
    #[must_use]
    pub fn held(&self, period_s: f64) -> Option<Self> {
        let hold = ZeroOrderHold::new(self.a.clone(), self.b.clone(), period_s)?;
        let (a, b) = hold.map().clone();
        let time = TimeDomain::Discrete { period_s };
        Some(Self { time, a, b, c: self.c.clone(), d: self.d.clone() })
    }

    /// Simulated outputs (samples × p) of a discrete model, without correction by measurements. `inputs` is samples ×
    /// m, and `start` the initial state.
    ///
    /// An unstable model may overflow to infinities.
    #[must_use]
    pub fn simulate(&self, inputs: &DMatrix<f64>, start: &DVector<f64>) -> DMatrix<f64> {
        let forcing = &self.b * inputs.transpose();
        let mut states = DMatrix::zeros(self.order(), inputs.nrows());
        let mut state = start.clone();
        for (mut kept, forced) in states.column_iter_mut().zip(forcing.column_iter()) {
            kept.copy_from(&state);
            state.copy_from(&forced);
            state.gemv(1.0, &self.a, &kept, 1.0);
        }
        (&self.c * states + &self.d * inputs.transpose()).transpose()
    }

    /// C(zI − A)⁻¹B + D, p×m, at `frequency_radps`: z = jω for a continuous model, e^(jωT) for a discrete one. For a
    /// single loop these are the points of a Nyquist plot. `None` at the frequency of an undamped mode. For many
    /// frequencies [`sweep`](Self::sweep) is faster.
    ///
    /// # Source
    /// Equation (L12) of docs/equations.md.
    #[must_use]
    pub fn frequency_response(&self, frequency_radps: f64) -> Option<DMatrix<Complex<f64>>> {
        let z = self.time.variable(frequency_radps);
        let mut resolvent = complex(&-&self.a);
        for index in 0..resolvent.nrows() {
            resolvent[(index, index)] += z;
        }
        let states = resolvent.lu().solve(&complex(&self.b))?;
        let response = complex(&self.c) * states + complex(&self.d);
        response.iter().all(|value| value.is_finite()).then_some(response)
    }
}
