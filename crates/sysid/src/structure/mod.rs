//! A continuous-time state space whose entries are products of named parameters.
//!
//! A [`Structure`] is written as the equations stand in a book, and knows its own derivatives:
//!
//! ```
//! use hovernav_sysid::structure::{Parameter, Structure};
//!
//! let heave = Structure::new(
//!     "heave",
//!     vec![
//!         Parameter::new("Zw", "1/s", -0.5).within(-5.0, 0.5),
//!         Parameter::new("Zcol", "m/s²", -10.0),
//!     ],
//!     "inputs  collective
//!      noise   n_w
//!      outputs w
//!      offsets w
//!      w' = Zw*w + Zcol*collective + n_w",
//! )?;
//! assert_eq!(heave.at(&[-0.6, -14.0]).b[(0, 0)], -14.0);
//! # Ok::<(), hovernav_sysid::structure::StructureError>(())
//! ```

mod equations;

use nalgebra::DMatrix;
use thiserror::Error;

/// Why a text is not a [`Structure`].
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum StructureError {
    /// A line is neither an equation nor a list of names.
    #[error("{structure}, line {line}: found `{found}`, expected {expected}")]
    Line {
        /// The structure's name.
        structure: String,
        /// The line, from 1.
        line: usize,
        /// What stands there.
        found: String,
        /// What should.
        expected: &'static str,
    },
    /// A parameter's start lies outside its own bounds, or is not finite.
    #[error("{structure}: parameter `{parameter}` does not start inside its bounds")]
    Bounds {
        /// The structure's name.
        structure: String,
        /// The parameter.
        parameter: String,
    },
    /// A parameter no equation uses.
    #[error("{structure}: no equation uses the parameter `{parameter}`")]
    Unused {
        /// The structure's name.
        structure: String,
        /// The parameter.
        parameter: String,
    },
    /// Nothing to identify.
    #[error("{structure}: it needs a state and an output")]
    Empty {
        /// The structure's name.
        structure: String,
    },
}

/// A named parameter of a [`Structure`].
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// The name it has in the equations.
    pub name: String,
    /// Its unit, for print.
    pub unit: String,
    /// Where the search starts.
    pub start: f64,
    /// Smallest value allowed.
    pub lower: f64,
    /// Largest value allowed.
    pub upper: f64,
    /// Whether it stays at its start.
    pub fixed: bool,
}

impl Parameter {
    /// A free parameter without bounds.
    #[must_use]
    pub fn new(name: &str, unit: &str, start: f64) -> Self {
        Self {
            name: name.to_owned(),
            unit: unit.to_owned(),
            start,
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            fixed: false,
        }
    }

    /// The same with bounds.
    #[must_use]
    pub fn within(self, lower: f64, upper: f64) -> Self {
        Self { lower, upper, ..self }
    }

    /// The same, not to be estimated.
    #[must_use]
    pub fn held(self) -> Self {
        Self { fixed: true, ..self }
    }
}

/// One product of an equation: coefficient · Π θᵢ^powerᵢ · signal.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Term {
    /// Row of the state or of the output it adds to.
    pub row: usize,
    /// Column among states, inputs, noises, offsets in that order; an output sees only the first two.
    pub column: usize,
    coefficient: f64,
    factors: Vec<(usize, i32)>,
}

impl Term {
    /// One signal as it is.
    fn plain(row: usize, column: usize) -> Self {
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

/// The matrices of a [`Structure`] at one set of parameters: ẋ = A x + B u + G n + E o,
/// y = C x + D u, continuous in time.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrices {
    /// States × states, 1/s.
    pub a: DMatrix<f64>,
    /// States × inputs.
    pub b: DMatrix<f64>,
    /// States × process noises.
    pub g: DMatrix<f64>,
    /// States × offsets: the constant forcing of each experiment.
    pub e: DMatrix<f64>,
    /// Outputs × states.
    pub c: DMatrix<f64>,
    /// Outputs × inputs.
    pub d: DMatrix<f64>,
}

/// A continuous-time state space whose entries are products of named parameters.
///
/// See [`Structure::new`] for how it is written.
#[derive(Debug, Clone, PartialEq)]
pub struct Structure {
    /// What messages call it.
    pub name: String,
    /// States, in the order of their equations.
    pub states: Vec<String>,
    /// Inputs.
    pub inputs: Vec<String>,
    /// Outputs.
    pub outputs: Vec<String>,
    /// Process noises: unmeasured inputs, white from sample to sample and held between.
    pub noises: Vec<String>,
    /// States with a constant forcing of their own in each experiment (trim, mean wind).
    pub offsets: Vec<String>,
    /// Outputs with a constant bias of their own in each experiment.
    pub biases: Vec<String>,
    /// Parameters, in the order `theta` has everywhere.
    pub parameters: Vec<Parameter>,
    /// Transport delay of each input: the index of its parameter, s.
    pub(super) delays: Vec<Option<usize>>,
    pub(super) dynamics: Vec<Term>,
    pub(super) measurement: Vec<Term>,
    pub(super) bias_rows: Vec<usize>,
}

impl Structure {
    /// A structure from its equations, one a line, empty lines apart.
    ///
    /// | line | says |
    /// |---|---|
    /// | `inputs a b …` | the inputs, by the names the experiments have |
    /// | `noise n …` | process noises, optional |
    /// | `outputs y …` | the outputs; a name without an equation is the state of that name |
    /// | `offsets x …` | states with a constant forcing per experiment, optional |
    /// | `biases y …` | outputs with a constant bias per experiment, optional |
    /// | `delay a tau` | parameter `tau`, s, delays input `a`, optional |
    /// | `x' = …` | a state's equation |
    /// | `y = …` | an output's equation |
    ///
    /// A right-hand side is a sum of products of numbers and parameters (`*` and `/`) with exactly one
    /// state, input or noise in each: `b' = -b/tau - p + Blat/tau*lat`. An equation may be `0`.
    ///
    /// # Errors
    /// [`StructureError`] with the line and what was found.
    pub fn new(
        name: &str,
        parameters: Vec<Parameter>,
        equations: &str,
    ) -> Result<Self, StructureError> {
        equations::parse(name, parameters, equations)
    }

    /// Index of the parameter `name`.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<usize> {
        self.parameters.iter().position(|parameter| parameter.name == name)
    }

    /// The parameters' starts.
    #[must_use]
    pub fn start(&self) -> Vec<f64> {
        self.parameters.iter().map(|parameter| parameter.start).collect()
    }

    /// The same structure with a parameter's start moved and the parameter free or fixed.
    #[must_use]
    pub fn with(mut self, name: &str, start: f64, fixed: bool) -> Self {
        if let Some(parameter) = self.parameters.iter_mut().find(|known| known.name == name) {
            parameter.start = start;
            parameter.fixed = fixed;
        }
        self
    }

    /// Whether a parameter stands in a denominator, and so can never be 0.
    pub(super) fn divides(&self, parameter: usize) -> bool {
        self.dynamics
            .iter()
            .chain(&self.measurement)
            .flat_map(|term| &term.factors)
            .any(|&(index, power)| index == parameter && power < 0)
    }

    /// Columns of the dynamics: states, inputs, noises, offsets.
    pub(super) fn width(&self) -> usize {
        self.states.len() + self.inputs.len() + self.noises.len() + self.offsets.len()
    }

    /// [A B G E] and [C D] at the parameters `theta`.
    pub(super) fn combined(&self, theta: &[f64]) -> (DMatrix<f64>, DMatrix<f64>) {
        let mut dynamics = DMatrix::zeros(self.states.len(), self.width());
        for term in &self.dynamics {
            dynamics[(term.row, term.column)] += term.value(theta);
        }
        let seen = self.states.len() + self.inputs.len();
        let mut measurement = DMatrix::zeros(self.outputs.len(), seen);
        for term in &self.measurement {
            measurement[(term.row, term.column)] += term.value(theta);
        }
        (dynamics, measurement)
    }

    /// The matrices at the parameters `theta`, one for each of [`Structure::parameters`].
    ///
    /// # Panics
    /// Where `theta` has another length.
    #[must_use]
    pub fn at(&self, theta: &[f64]) -> Matrices {
        assert_eq!(theta.len(), self.parameters.len(), "one value per parameter");
        let (n, m) = (self.states.len(), self.inputs.len());
        let (dynamics, measurement) = self.combined(theta);
        let columns = |matrix: &DMatrix<f64>, first, count| matrix.columns(first, count).into();
        let q = self.noises.len();
        Matrices {
            a: columns(&dynamics, 0, n),
            b: columns(&dynamics, n, m),
            g: columns(&dynamics, n + m, q),
            e: columns(&dynamics, n + m + q, self.offsets.len()),
            c: columns(&measurement, 0, n),
            d: columns(&measurement, n, m),
        }
    }
}
