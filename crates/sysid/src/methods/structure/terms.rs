//! Parameters, and their products.

/// A named parameter of a [`Structure`](super::Structure).
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Name in the equations.
    pub name: String,
    /// Unit, for output.
    pub unit: String,
    /// Initial value of the search.
    pub start: f64,
    /// Smallest allowed value.
    pub lower: f64,
    /// Largest allowed value.
    pub upper: f64,
    /// Whether the value is fixed.
    pub fixed: bool,
    /// Whether the model is invalid without it: it is never dropped.
    pub needed: bool,
    /// Prior value and one sigma, known before any flight. The prior counts as one more measurement.
    pub prior: Option<(f64, f64)>,
}

impl Parameter {
    /// A free parameter without limits.
    #[must_use]
    pub fn new(name: &str, unit: &str, start: f64) -> Self {
        Self {
            name: name.to_owned(),
            unit: unit.to_owned(),
            start,
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            fixed: false,
            needed: false,
            prior: None,
        }
    }

    /// The parameter with limits.
    #[must_use]
    pub fn within(self, lower: f64, upper: f64) -> Self {
        Self { lower, upper, ..self }
    }

    /// The parameter, marked as never to be dropped.
    #[must_use]
    pub fn needed(self) -> Self {
        Self { needed: true, ..self }
    }

    /// The parameter with the prior `value` and one `sigma`, never to be dropped.
    ///
    /// # Source
    /// Maine and Iliff (1981), NASA RP-1077 and Iliff and Maine's MMLE3: a priori weighting.
    #[must_use]
    pub fn expected(self, value: f64, sigma: f64) -> Self {
        Self { prior: Some((value, sigma)), needed: true, ..self }
    }

    /// The parameter with a fixed value.
    #[must_use]
    pub fn held(self) -> Self {
        Self { fixed: true, ..self }
    }
}

/// One product of an equation: coefficient · Π θᵢ^powerᵢ · signal.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Term {
    /// Row of the state or of the output it adds to.
    pub row: usize,
    /// Column among states, inputs, noises and offsets, in that order; outputs depend on the first two only.
    pub column: usize,
    pub coefficient: f64,
    pub factors: Vec<(usize, i32)>,
}

impl Term {
    /// A term of one signal with the coefficient 1 and no parameters.
    pub fn plain(row: usize, column: usize) -> Self {
        Self { row, column, coefficient: 1.0, factors: Vec::new() }
    }

    /// The value at the parameters `theta`.
    pub fn value(&self, theta: &[f64]) -> f64 {
        self.factors
            .iter()
            .fold(self.coefficient, |product, &(index, power)| product * theta[index].powi(power))
    }

    /// The derivative with respect to parameter `parameter`, 0 where it does not appear.
    pub fn derivative(&self, theta: &[f64], parameter: usize) -> f64 {
        let Some(&(_, power)) = self.factors.iter().find(|(index, _)| *index == parameter) else {
            return 0.0;
        };
        let others = self.factors.iter().filter(|(index, _)| *index != parameter);
        let rest = others
            .fold(self.coefficient, |product, &(index, power)| product * theta[index].powi(power));
        rest * f64::from(power) * theta[parameter].powi(power - 1)
    }
}
