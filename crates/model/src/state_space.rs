//! A linear model with names, units and a time domain.

use nalgebra::DMatrix;

use super::error::ModelError;
use super::linear::{LinearModel, TimeDomain};
use super::parameter::{Parameter, Slope, check_covariance, check_parameters};
use super::signal::{Signal, check_names, position};
use super::verdict::Verdict;

/// A linear time-invariant model, n states, m inputs, p outputs: ẋ or x⁺ = A x + B u, y = C x + D u.
///
/// Every number is finite, and every shape matches the names.
#[derive(Clone, Debug, PartialEq)]
pub struct StateSpace {
    name: String,
    source: String,
    linear: LinearModel,
    states: Vec<Signal>,
    inputs: Vec<Signal>,
    outputs: Vec<Signal>,
    parameters: Vec<Parameter>,
    covariance: Option<DMatrix<f64>>,
    slopes: Vec<Slope>,
    verdict: Option<Verdict>,
    trim_speed_mps: f64,
}

impl StateSpace {
    /// A model whose outputs are its states. `a` is n×n, `b` n×m.
    ///
    /// # Errors
    /// [`ModelError`] for empty or repeated names, shapes that do not match the names, numbers that are not finite, or
    /// an invalid sample period.
    pub fn new(
        name: &str,
        time: TimeDomain,
        states: Vec<Signal>,
        inputs: Vec<Signal>,
        a: DMatrix<f64>,
        b: DMatrix<f64>,
    ) -> Result<Self, ModelError> {
        if let TimeDomain::Discrete { period_s } = time
            && !(period_s > 0.0 && period_s.is_finite())
        {
            return Err(ModelError::Period { period_s });
        }
        check_names("states", &states)?;
        check_names("inputs", &inputs)?;
        let (n, m) = (states.len(), inputs.len());
        check_matrix("A", &a, n, n)?;
        check_matrix("B", &b, n, m)?;
        Ok(Self {
            name: name.into(),
            source: String::new(),
            linear: LinearModel::of_states(time, a, b),
            outputs: states.clone(),
            states,
            inputs,
            parameters: Vec::new(),
            covariance: None,
            slopes: Vec::new(),
            verdict: None,
            trim_speed_mps: 0.0,
        })
    }

    /// The model with another name.
    #[must_use]
    pub fn named(mut self, name: &str) -> Self {
        self.name = name.into();
        self
    }

    /// The model with a note on the source of its numbers.
    #[must_use]
    pub fn with_source(mut self, source: &str) -> Self {
        self.source = source.into();
        self
    }

    /// The model with the verdict of its author.
    #[must_use]
    pub fn with_verdict(mut self, verdict: Verdict) -> Self {
        self.verdict = Some(verdict);
        self
    }

    /// The model with the forward speed of its trim, m/s: states and inputs are deviations from steady flight at this
    /// speed. Without it a model is about hover.
    ///
    /// # Errors
    /// [`ModelError::Speed`] for a speed that is not finite.
    pub fn with_trim_speed(mut self, trim_speed_mps: f64) -> Result<Self, ModelError> {
        if !trim_speed_mps.is_finite() {
            return Err(ModelError::Speed { found: trim_speed_mps.to_string() });
        }
        self.trim_speed_mps = trim_speed_mps;
        Ok(self)
    }

    /// The model with the kinematics of a trim that moves with `velocity_mps` (u, v, w): this velocity turns with the
    /// body. Only the equations in `rows`, a choice of u, v and w, change. The trim speed is the forward velocity u.
    ///
    /// # Errors
    /// [`ModelError::Speed`] for a velocity that is not finite.
    ///
    /// # Source
    /// Linear terms of velocity and rate of equation (I25) of docs/equations.md. The terms of gravity about a tilted
    /// trim are omitted.
    pub fn in_motion(mut self, velocity_mps: [f64; 3], rows: &[&str]) -> Result<Self, ModelError> {
        let [u, v, w] = velocity_mps;
        let turning = [
            ("u", "r", v),
            ("u", "q", -w),
            ("v", "p", w),
            ("v", "r", -u),
            ("w", "q", u),
            ("w", "p", -v),
        ];
        for (row, rate, per_rate) in turning.into_iter().filter(|(row, ..)| rows.contains(row)) {
            if let (Ok(row), Ok(rate)) = (self.state(row), self.state(rate)) {
                self.linear.a[(row, rate)] += per_rate;
            }
        }
        self.with_trim_speed(u)
    }

    /// The model with p outputs y = C x + D u: `c` is p×n, `d` p×m.
    ///
    /// # Errors
    /// As [`StateSpace::new`].
    pub fn with_outputs(
        mut self,
        outputs: Vec<Signal>,
        c: DMatrix<f64>,
        d: DMatrix<f64>,
    ) -> Result<Self, ModelError> {
        check_names("outputs", &outputs)?;
        check_matrix("C", &c, outputs.len(), self.states.len())?;
        check_matrix("D", &d, outputs.len(), self.inputs.len())?;
        (self.outputs, self.linear.c, self.linear.d) = (outputs, c, d);
        Ok(self)
    }

    /// The model with the parameters from which it was computed. Their covariance, if known, has the same order.
    ///
    /// # Errors
    /// As [`StateSpace::new`]. Also [`ModelError::Parameter`] for a value that is not finite, an impossible stick delay
    /// or servo lag, or an invalid covariance. A covariance is invalid if it is not symmetric, contains a variance
    /// below zero or a correlation beyond 1, or is not positive semidefinite.
    pub fn with_parameters(
        mut self,
        parameters: Vec<Parameter>,
        covariance: Option<DMatrix<f64>>,
    ) -> Result<Self, ModelError> {
        check_parameters(&parameters)?;
        if let Some(covariance) = &covariance {
            check_matrix("covariance", covariance, parameters.len(), parameters.len())?;
            check_covariance(&parameters, covariance)?;
        }
        (self.parameters, self.covariance) = (parameters, covariance);
        Ok(self)
    }

    /// The model with the derivatives of its matrices with respect to its parameters.
    ///
    /// # Errors
    /// [`ModelError::Slope`] for an unknown parameter, row or column, a number that is not finite, and a duplicate
    /// slope.
    pub fn with_slopes(mut self, slopes: Vec<Slope>) -> Result<Self, ModelError> {
        let mut seen = std::collections::HashSet::new();
        for (index, slope) in slopes.iter().enumerate() {
            let rejected = |what: &'static str, found: &str, expected: &'static str| {
                Err(ModelError::Slope { index: index + 1, what, found: found.to_owned(), expected })
            };
            let Slope { parameter, row, column, slope: value } = slope;
            if !self.parameters.iter().any(|known| known.name == *parameter) {
                return rejected("parameter", parameter, "one of the parameters");
            }
            if self.state(row).is_err() {
                return rejected("row", row, "one of the states");
            }
            if self.state(column).is_err() && self.input(column).is_err() {
                return rejected("column", column, "one of the states or inputs");
            }
            if !value.is_finite() {
                return rejected("slope", &value.to_string(), "a finite number");
            }
            if !seen.insert((parameter, row, column)) {
                return rejected("parameter", parameter, "each parameter once per row and column");
            }
        }
        self.slopes = slopes;
        Ok(self)
    }

    /// The model with `by` added to its parameters, in their order and units. A and B change in proportion to the
    /// slopes, to first order.
    ///
    /// # Errors
    /// [`ModelError::Shape`] where `by` and the parameters differ in length, [`ModelError::NotFinite`] where a matrix
    /// does not stay finite.
    pub fn moved(&self, by: &[f64]) -> Result<Self, ModelError> {
        let count = self.parameters.len();
        if by.len() != count {
            let (rows, columns, matrix) = (by.len(), 1, "changes of the parameters");
            let (expected_rows, expected_columns) = (count, 1);
            return Err(ModelError::Shape {
                matrix,
                rows,
                columns,
                expected_rows,
                expected_columns,
            });
        }
        let mut moved = self.clone();
        for (parameter, by) in moved.parameters.iter_mut().zip(by) {
            parameter.value += by;
        }
        for Slope { parameter, row, column, slope } in &self.slopes {
            let by: f64 = self
                .parameters
                .iter()
                .zip(by)
                .filter(|(known, _)| known.name == *parameter)
                .map(|(_, by)| by)
                .sum();
            let row = self.state(row)?;
            if let Ok(column) = self.state(column) {
                moved.linear.a[(row, column)] += slope * by;
            } else {
                moved.linear.b[(row, self.input(column)?)] += slope * by;
            }
        }
        let (n, m) = (self.states.len(), self.inputs.len());
        check_matrix("A", &moved.linear.a, n, n)?;
        check_matrix("B", &moved.linear.b, n, m)?;
        Ok(moved)
    }

    /// Name of the model.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Forward speed of the trim, m/s; 0 for a model about hover.
    #[must_use]
    pub const fn trim_speed_mps(&self) -> f64 {
        self.trim_speed_mps
    }

    /// Source of the numbers.
    #[must_use]
    pub fn source(&self) -> &str {
        &self.source
    }

    /// Verdict of the model's author, if any.
    #[must_use]
    pub fn verdict(&self) -> Option<&Verdict> {
        self.verdict.as_ref()
    }

    /// The matrices with their time domain.
    #[must_use]
    pub fn linear(&self) -> &LinearModel {
        &self.linear
    }

    /// Continuous or discrete.
    #[must_use]
    pub fn time(&self) -> TimeDomain {
        self.linear.time
    }

    /// Names and units of the n states.
    #[must_use]
    pub fn states(&self) -> &[Signal] {
        &self.states
    }

    /// Names and units of the m inputs.
    #[must_use]
    pub fn inputs(&self) -> &[Signal] {
        &self.inputs
    }

    /// Names and units of the p outputs.
    #[must_use]
    pub fn outputs(&self) -> &[Signal] {
        &self.outputs
    }

    /// A, n×n.
    #[must_use]
    pub fn a(&self) -> &DMatrix<f64> {
        &self.linear.a
    }

    /// B, n×m.
    #[must_use]
    pub fn b(&self) -> &DMatrix<f64> {
        &self.linear.b
    }

    /// C, p×n.
    #[must_use]
    pub fn c(&self) -> &DMatrix<f64> {
        &self.linear.c
    }

    /// D, p×m.
    #[must_use]
    pub fn d(&self) -> &DMatrix<f64> {
        &self.linear.d
    }

    /// Parameters from which the matrices were computed; empty if unknown.
    #[must_use]
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// Covariance of the parameters, in their order, where known.
    #[must_use]
    pub fn covariance(&self) -> Option<&DMatrix<f64>> {
        self.covariance.as_ref()
    }

    /// Derivatives of A and B with respect to the parameters; empty if unknown.
    #[must_use]
    pub fn slopes(&self) -> &[Slope] {
        &self.slopes
    }

    /// Rejects a model that is not continuous.
    ///
    /// # Errors
    /// [`ModelError::TimeDomain`].
    pub fn require_continuous(&self) -> Result<(), ModelError> {
        match self.time() {
            TimeDomain::Continuous => Ok(()),
            TimeDomain::Discrete { .. } => {
                Err(ModelError::TimeDomain { found: "discrete", expected: "a continuous model" })
            }
        }
    }

    /// The sample period of a discrete model, s.
    ///
    /// # Errors
    /// [`ModelError::TimeDomain`] for a continuous model.
    pub fn require_discrete(&self) -> Result<f64, ModelError> {
        match self.time() {
            TimeDomain::Discrete { period_s } => Ok(period_s),
            TimeDomain::Continuous => {
                Err(ModelError::TimeDomain { found: "continuous", expected: "a discrete model" })
            }
        }
    }

    /// Index of the state `name`.
    ///
    /// # Errors
    /// [`ModelError::Unknown`].
    pub fn state(&self, name: &str) -> Result<usize, ModelError> {
        position("states", &self.states, name)
    }

    /// Index of the input `name`.
    ///
    /// # Errors
    /// [`ModelError::Unknown`].
    pub fn input(&self, name: &str) -> Result<usize, ModelError> {
        position("inputs", &self.inputs, name)
    }

    /// The model of the requested states and inputs only, in the requested order. All other states and inputs are fixed
    /// at zero. Its outputs are its states. Parameters and covariance are omitted.
    ///
    /// # Errors
    /// [`ModelError::Unknown`] for a name the model does not have, [`ModelError::Name`] for a name requested twice.
    pub fn subsystem(&self, states: &[&str], inputs: &[&str]) -> Result<Self, ModelError> {
        let rows = states.iter().map(|name| self.state(name)).collect::<Result<Vec<_>, _>>()?;
        let columns = inputs.iter().map(|name| self.input(name)).collect::<Result<Vec<_>, _>>()?;
        let kept = Self::new(
            &self.name,
            self.time(),
            rows.iter().map(|&row| self.states[row].clone()).collect(),
            columns.iter().map(|&column| self.inputs[column].clone()).collect(),
            self.linear.a.select_rows(&rows).select_columns(&rows),
            self.linear.b.select_rows(&rows).select_columns(&columns),
        )?;
        kept.with_source(&self.source).with_trim_speed(self.trim_speed_mps)
    }

    /// The model between this one and `other`. Every element of A and B, and the trim speed, are at the fraction
    /// `share` of the way to `other`. Outputs are the states; parameters and covariance are omitted. `None` for models
    /// of different states, inputs, units or time domains; their order may differ.
    #[must_use]
    pub fn between(&self, other: &Self, share: f64) -> Option<Self> {
        let is_same = |own: &[Signal], others: &[Signal]| {
            own.len() == others.len() && own.iter().all(|signal| others.contains(signal))
        };
        let comparable = self.time() == other.time()
            && is_same(&self.states, &other.states)
            && is_same(&self.inputs, &other.inputs);
        if !comparable {
            return None;
        }
        let names =
            |list: &'_ [Signal]| list.iter().map(|own| own.name.clone()).collect::<Vec<_>>();
        let (states, inputs) = (names(&self.states), names(&self.inputs));
        let states: Vec<&str> = states.iter().map(String::as_str).collect();
        let inputs: Vec<&str> = inputs.iter().map(String::as_str).collect();
        let mut model = self.subsystem(&states, &inputs).ok()?;
        let other = other.subsystem(&states, &inputs).ok()?;
        model.linear.a += (&other.linear.a - &self.linear.a) * share;
        model.linear.b += (&other.linear.b - &self.linear.b) * share;
        model.trim_speed_mps += share * (other.trim_speed_mps - self.trim_speed_mps);
        Some(model)
    }

    /// The slow model in which the states `fast` follow the others without delay (residualisation). For example, a
    /// hybrid model without its flapping states is the quasi-steady model. Its outputs are the remaining states;
    /// parameters and covariance are omitted.
    ///
    /// # Errors
    /// [`ModelError::Unknown`], and [`ModelError::NoSteadyValue`] where the fast states have no steady state.
    ///
    /// # Source
    /// Equation (L15) of docs/equations.md.
    pub fn residualised(&self, fast: &[&str]) -> Result<Self, ModelError> {
        let removed = fast.iter().map(|name| self.state(name)).collect::<Result<Vec<_>, _>>()?;
        if removed.is_empty() {
            return Ok(self.clone());
        }
        let kept: Vec<usize> =
            (0..self.states.len()).filter(|row| !removed.contains(row)).collect();
        let block = |rows: &[usize], columns: &[usize]| {
            self.linear.a.select_rows(rows).select_columns(columns)
        };
        // 0 = A21 x1 + A22 x2 + B2 u for a continuous model. For a discrete model the left side is x2.
        let own = match self.time() {
            TimeDomain::Continuous => -block(&removed, &removed),
            TimeDomain::Discrete { .. } => {
                DMatrix::identity(removed.len(), removed.len()) - block(&removed, &removed)
            }
        };
        let no_steady_value = || ModelError::NoSteadyValue { states: fast.join(", ") };
        let own = own.lu();
        let from_states = own.solve(&block(&removed, &kept)).ok_or_else(no_steady_value)?;
        let from_inputs =
            own.solve(&self.linear.b.select_rows(&removed)).ok_or_else(no_steady_value)?;
        let onto = block(&kept, &removed);
        let left = Self::new(
            &self.name,
            self.time(),
            kept.iter().map(|&row| self.states[row].clone()).collect(),
            self.inputs.clone(),
            block(&kept, &kept) + &onto * from_states,
            self.linear.b.select_rows(&kept) + onto * from_inputs,
        )?;
        left.with_source(&self.source).with_trim_speed(self.trim_speed_mps)
    }
}

fn check_matrix(
    matrix: &'static str,
    values: &DMatrix<f64>,
    expected_rows: usize,
    expected_columns: usize,
) -> Result<(), ModelError> {
    let (rows, columns) = values.shape();
    if (rows, columns) != (expected_rows, expected_columns) {
        return Err(ModelError::Shape { matrix, rows, columns, expected_rows, expected_columns });
    }
    for column in 0..columns {
        for row in 0..rows {
            let value = values[(row, column)];
            if !value.is_finite() {
                let (row, column) = (row + 1, column + 1);
                return Err(ModelError::NotFinite { matrix, row, column, value });
            }
        }
    }
    Ok(())
}
