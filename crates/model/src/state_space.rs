//! A linear model that knows its names, units and time domain.

use nalgebra::DMatrix;

use super::error::ModelError;
use super::linear::{LinearModel, TimeDomain};
use super::signal::{Signal, check_names, check_unique, position};
use super::verdict::Verdict;

/// A parameter from which the matrices were filled.
#[derive(Clone, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(deny_unknown_fields)]
pub struct Parameter {
    /// Name, as `Lp`.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Unit.
    pub unit: String,
}

/// A linear time-invariant model, n states, m inputs, p outputs: ẋ or x⁺ = A x + B u, y = C x + D u.
///
/// Every number is finite, every shape agrees with the names: a value of this type is a model.
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
    verdict: Option<Verdict>,
}

impl StateSpace {
    /// A model whose outputs are its states. `a` is n×n, `b` n×m.
    ///
    /// # Errors
    /// [`ModelError`] where names are empty or repeated, shapes disagree with the names, a number is
    /// not finite, or the sample period is not above zero.
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
            verdict: None,
        })
    }

    /// The same model with a note of where its numbers come from.
    #[must_use]
    pub fn with_source(mut self, source: &str) -> Self {
        self.source = source.into();
        self
    }

    /// The same model with what whoever made it says of it.
    #[must_use]
    pub fn with_verdict(mut self, verdict: Verdict) -> Self {
        self.verdict = Some(verdict);
        self
    }

    /// The same model with p outputs y = C x + D u: `c` is p×n, `d` p×m.
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

    /// The same model with the parameters that fill it and their covariance, square in the order of
    /// the parameters, where it is known.
    ///
    /// # Errors
    /// As [`StateSpace::new`], and [`ModelError::Parameter`] for a value that is not finite, a delay or servo lag
    /// of a stick that none has, a variance below zero, a covariance that is not symmetric or a correlation
    /// beyond 1.
    pub fn with_parameters(
        mut self,
        parameters: Vec<Parameter>,
        covariance: Option<DMatrix<f64>>,
    ) -> Result<Self, ModelError> {
        let refused = |parameter: &Parameter, reason| ModelError::Parameter {
            name: parameter.name.clone(),
            reason,
        };
        check_unique("parameters", parameters.iter().map(|parameter| parameter.name.as_str()))?;
        if let Some(parameter) = parameters.iter().find(|parameter| !parameter.value.is_finite()) {
            return Err(refused(parameter, "found a value that is not finite, expected a number"));
        }
        for parameter in &parameters {
            let found = parameter.value;
            match parameter.name.split_once('_') {
                Some(("tau", "lat" | "lon" | "col" | "ped")) if !(-0.05..=1.0).contains(&found) => {
                    return Err(refused(parameter, "found a stick's delay outside -0.05 to 1 s"));
                }
                Some(("lag", _)) if !(0.0..=1.0).contains(&found) => {
                    return Err(refused(parameter, "found a servo's lag outside 0 to 1 s"));
                }
                _ => {}
            }
        }
        if let Some(covariance) = &covariance {
            check_matrix("covariance", covariance, parameters.len(), parameters.len())?;
            for (row, parameter) in parameters.iter().enumerate() {
                if covariance[(row, row)] < 0.0 {
                    return Err(refused(parameter, "found a variance below 0"));
                }
                for column in 0..row {
                    let [above, below] = [covariance[(column, row)], covariance[(row, column)]];
                    let scale = (covariance[(row, row)] * covariance[(column, column)]).sqrt();
                    // Written so that a NaN is refused too.
                    let even = (above - below).abs() <= 1e-9 * scale;
                    if !even {
                        return Err(refused(parameter, "found a covariance that is not symmetric"));
                    }
                    if above.abs() > (1.0 + 1e-6) * scale {
                        return Err(refused(parameter, "found a correlation beyond 1"));
                    }
                }
            }
        }
        (self.parameters, self.covariance) = (parameters, covariance);
        Ok(self)
    }

    /// What the model is called.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Where its numbers come from.
    #[must_use]
    pub fn source(&self) -> &str {
        &self.source
    }

    /// What whoever made it says of it, where told.
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

    /// The parameters that fill the matrices, where told.
    #[must_use]
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// Covariance of the parameters, in their order, where known.
    #[must_use]
    pub fn covariance(&self) -> Option<&DMatrix<f64>> {
        self.covariance.as_ref()
    }

    /// Refuses a model that is not continuous.
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
    /// [`ModelError::TimeDomain`] for a continuous one.
    pub fn require_discrete(&self) -> Result<f64, ModelError> {
        match self.time() {
            TimeDomain::Discrete { period_s } => Ok(period_s),
            TimeDomain::Continuous => {
                Err(ModelError::TimeDomain { found: "continuous", expected: "a discrete model" })
            }
        }
    }

    /// Where the state `name` stands.
    ///
    /// # Errors
    /// [`ModelError::Unknown`].
    pub fn state(&self, name: &str) -> Result<usize, ModelError> {
        position("states", &self.states, name)
    }

    /// Where the input `name` stands.
    ///
    /// # Errors
    /// [`ModelError::Unknown`].
    pub fn input(&self, name: &str) -> Result<usize, ModelError> {
        position("inputs", &self.inputs, name)
    }

    /// The model of some states and inputs alone, in the order asked for, all others held at zero;
    /// its outputs are its states. Parameters and covariance stay behind.
    ///
    /// # Errors
    /// [`ModelError::Unknown`] for a name the model does not have, [`ModelError::Name`] for one asked
    /// for twice.
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
        Ok(kept.with_source(&self.source))
    }

    /// The slow model that is left when the states `fast` follow the others without delay
    /// (residualisation): flapping taken out of a hybrid model leaves the quasi-steady one. Outputs
    /// become the states left; parameters and covariance stay behind.
    ///
    /// # Errors
    /// [`ModelError::Unknown`], and [`ModelError::NoSteadyValue`] where the fast states have none.
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
        // 0 = A21 x1 + A22 x2 + B2 u, or x2 = the same.
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
        Ok(left.with_source(&self.source))
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
