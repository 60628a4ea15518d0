//! Discretisation of continuous models.

use nalgebra::DMatrix;

use super::error::DesignError;
use hovernav_model::linalg::{exponential, side_by_side, symmetric};
use hovernav_model::{Signal, StateSpace, TimeDomain};

/// The exact discrete model of `model` behind a zero-order hold at `period_s`, with its inputs delayed by `delay_s`.
///
/// The delay may be any number of periods, also a fraction of one. Delayed inputs that have not acted yet become states
/// after those of the model, with names such as `lateral_1_ago`.
///
/// # Errors
/// [`DesignError::Range`] for a period that is not above zero or a delay below zero, and
/// [`ModelError::TimeDomain`](hovernav_model::ModelError::TimeDomain) for a discrete model.
///
/// # Source
/// Franklin, Powell, Workman, *Digital control of dynamic systems*, section 4.3; the integral by Van
/// Loan, *Computing integrals involving the matrix exponential*, 1978.
pub fn zero_order_hold(
    model: &StateSpace,
    period_s: f64,
    delay_s: f64,
) -> Result<StateSpace, DesignError> {
    let hold = Hold::new(model, period_s, delay_s)?;
    let (a, b) = hold.transition()?;
    let mut states = model.states().to_vec();
    for ago in 1..=hold.stages {
        for input in model.inputs() {
            states.push(Signal::new(&format!("{}_{ago}_ago", input.name), &input.unit));
        }
    }
    // At the start of a period the previous input still acts.
    let at_start = if hold.early_s > 0.0 { hold.early() } else { hold.late() };
    let n = model.states().len();
    let acting = at_start.rows(n, model.inputs().len());
    let mut outputs = model.d() * acting;
    for column in 0..n {
        let mut onto = outputs.column_mut(column);
        onto += model.c().column(column);
    }
    let size = a.nrows();
    let time = TimeDomain::Discrete { period_s };
    let held = StateSpace::new(model.name(), time, states, model.inputs().to_vec(), a, b)?
        .with_source(model.source())
        .with_outputs(
            model.outputs().to_vec(),
            outputs.columns(0, size).into_owned(),
            outputs.columns(size, model.inputs().len()).into_owned(),
        )?;
    Ok(held)
}

/// A model with held and delayed inputs over one period. First the older input acts, then the newer. The extended state
/// consists of the model's state and the stored past inputs.
pub(super) struct Hold<'a> {
    model: &'a StateSpace,
    period_s: f64,
    /// Time for which the older input acts, s.
    pub early_s: f64,
    /// Age of the newer input, periods.
    whole: usize,
    /// Number of past inputs to store.
    pub stages: usize,
}

impl<'a> Hold<'a> {
    pub fn new(model: &'a StateSpace, period_s: f64, delay_s: f64) -> Result<Self, DesignError> {
        model.require_continuous()?;
        if !(period_s > 0.0 && period_s.is_finite()) {
            let expected = "a number above 0";
            return Err(DesignError::Range { name: "period_s", value: period_s, expected });
        }
        let periods = delay_s / period_s;
        if !(0.0..=1000.0).contains(&periods) {
            let expected = "a number from 0 to 1000 periods";
            return Err(DesignError::Range { name: "delay_s", value: delay_s, expected });
        }
        let nearest = periods.round();
        let (whole, part) = if (periods - nearest).abs() < 1e-9 {
            (nearest, 0.0)
        } else {
            (periods.floor(), periods - periods.floor())
        };
        let whole = whole as usize;
        let stages = whole + usize::from(part > 0.0);
        Ok(Self { model, period_s, early_s: part * period_s, whole, stages })
    }

    fn sizes(&self) -> (usize, usize) {
        (self.model.states().len(), self.model.inputs().len())
    }

    /// Matrix that selects the model's state and the input that is `stage` periods old, n + m. It acts on the extended
    /// state and the new input.
    fn pick(&self, stage: usize) -> DMatrix<f64> {
        let (n, m) = self.sizes();
        let whole = n + self.stages * m;
        let mut pick = DMatrix::zeros(n + m, whole + m);
        pick.view_mut((0, 0), (n, n)).fill_with_identity();
        let from = if stage == 0 { whole } else { n + (stage - 1) * m };
        pick.view_mut((n, from), (m, m)).fill_with_identity();
        pick
    }

    /// Matrix that selects the state at the start of the period and the older input.
    pub fn early(&self) -> DMatrix<f64> {
        self.pick(self.whole + 1)
    }

    /// Matrix that selects the state at the start of the period and the newer input.
    fn late(&self) -> DMatrix<f64> {
        self.pick(self.whole)
    }

    /// Matrix that gives the state at the time the newer input starts to act, and this input.
    fn late_from_its_start(&self) -> Result<DMatrix<f64>, DesignError> {
        let mut late = self.late();
        if self.early_s > 0.0 {
            let (n, _) = self.sizes();
            let moved = held(self.model, self.early_s)? * self.early();
            late.rows_mut(0, n).copy_from(&moved);
        }
        Ok(late)
    }

    /// A and B of the discrete model with the extended state.
    ///
    /// # Source
    /// Equation (L6) of docs/equations.md.
    pub fn transition(&self) -> Result<(DMatrix<f64>, DMatrix<f64>), DesignError> {
        let (n, m) = self.sizes();
        let size = n + self.stages * m;
        let through = held(self.model, self.period_s - self.early_s)?;
        let end = through * self.late_from_its_start()?;
        let mut both = DMatrix::zeros(size, size + m);
        both.rows_mut(0, n).copy_from(&end);
        if self.stages > 0 {
            both.view_mut((n, size), (m, m)).fill_with_identity();
            let older = (self.stages - 1) * m;
            both.view_mut((n + m, n), (older, older)).fill_with_identity();
        }
        Ok((both.columns(0, size).into_owned(), both.columns(size, m).into_owned()))
    }

    /// The continuous cost xᵀQx + uᵀRu over one period, as a quadratic form of the extended state and the new input.
    pub fn cost(&self, q: &DMatrix<f64>, r: &DMatrix<f64>) -> Result<DMatrix<f64>, DesignError> {
        let late = self.late_from_its_start()?;
        let form = integral(self.model, q, r, self.period_s - self.early_s);
        let mut cost = late.tr_mul(&form) * &late;
        if self.early_s > 0.0 {
            let early = self.early();
            cost += early.tr_mul(&integral(self.model, q, r, self.early_s)) * &early;
        }
        Ok(cost)
    }
}

/// [Φ Γ], n×(n + m): transition of the state and the held input over `time_s`.
fn held(model: &StateSpace, time_s: f64) -> Result<DMatrix<f64>, DesignError> {
    let held = model.linear().held(time_s).ok_or(DesignError::NotFinite { matrix: "AT" })?;
    Ok(side_by_side(&held.a, &held.b))
}

/// The matrix [A B; 0 0], the generator of the state and the held input.
fn generator(model: &StateSpace) -> DMatrix<f64> {
    let (n, m) = (model.states().len(), model.inputs().len());
    let mut generator = DMatrix::zeros(n + m, n + m);
    generator.view_mut((0, 0), (n, n)).copy_from(model.a());
    generator.view_mut((0, n), (n, m)).copy_from(model.b());
    generator
}

/// The cost of state and held input over `time_s`, as a quadratic form of both, by Van Loan.
///
/// # Source
/// Equation (L7) of docs/equations.md.
fn integral(model: &StateSpace, q: &DMatrix<f64>, r: &DMatrix<f64>, time_s: f64) -> DMatrix<f64> {
    let generator = generator(model);
    let (n, size) = (q.nrows(), generator.nrows());
    let mut whole = DMatrix::zeros(2 * size, 2 * size);
    whole.view_mut((0, 0), (size, size)).copy_from(&-generator.transpose());
    whole.view_mut((0, size), (n, n)).copy_from(q);
    whole.view_mut((n, size + n), (size - n, size - n)).copy_from(r);
    whole.view_mut((size, size), (size, size)).copy_from(&generator);
    let whole = exponential(&whole, time_s);
    let form = whole.view((size, size), (size, size)).tr_mul(&whole.view((0, size), (size, size)));
    symmetric(&form)
}
