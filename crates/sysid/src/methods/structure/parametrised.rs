//! The parametrised model.

use nalgebra::DMatrix;

use super::terms::{Parameter, Term};
use hovernav_model::{LinearModel, TimeDomain};

/// A continuous-time state space whose entries are products of named parameters.
///
/// [`Structure::new`] describes the notation.
#[derive(Debug, Clone, PartialEq)]
pub struct Structure {
    /// Name in messages.
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
    /// Parameters, in the order of every `theta`.
    pub parameters: Vec<Parameter>,
    /// Transport delay of each input: the index of its parameter, s.
    pub(crate) delays: Vec<Option<usize>>,
    /// First-order lag of each input: the index of its time constant, s.
    pub(crate) lags: Vec<Option<usize>>,
    pub(crate) dynamics: Vec<Term>,
    pub(crate) measurement: Vec<Term>,
    pub(crate) bias_rows: Vec<usize>,
}

impl Structure {
    /// Index of the parameter `name`.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<usize> {
        self.parameters.iter().position(|parameter| parameter.name == name)
    }

    /// Initial values of the parameters.
    #[must_use]
    pub fn start(&self) -> Vec<f64> {
        self.parameters.iter().map(|parameter| parameter.start).collect()
    }

    /// The structure with a parameter's initial value changed and the parameter free or fixed.
    #[must_use]
    pub fn with(mut self, name: &str, start: f64, fixed: bool) -> Self {
        if let Some(parameter) = self.parameters.iter_mut().find(|known| known.name == name) {
            parameter.start = start;
            parameter.fixed = fixed;
        }
        self
    }

    /// Whether a parameter occurs in a denominator and so can never be 0.
    pub(crate) fn divides(&self, parameter: usize) -> bool {
        self.dynamics
            .iter()
            .chain(&self.measurement)
            .flat_map(|term| &term.factors)
            .any(|&(index, power)| index == parameter && power < 0)
    }

    /// Inputs with a delay or a lag.
    pub(crate) fn late_inputs(&self) -> Vec<usize> {
        let is_late = |&input: &usize| self.delays[input].or(self.lags[input]).is_some();
        (0..self.inputs.len()).filter(is_late).collect()
    }

    /// Number of trailing states that are output errors: driven by noise and themselves alone, without effect on other
    /// states.
    pub(crate) fn trailing_errors(&self) -> usize {
        let (n, m) = (self.states.len(), self.inputs.len());
        let noises = n + m..n + m + self.noises.len();
        let is_error = |state: usize| {
            self.dynamics.iter().all(|term| match (term.row == state, term.column == state) {
                (true, false) => noises.contains(&term.column),
                (false, true) => false,
                _ => true,
            })
        };
        (1..n).rev().take_while(|&state| is_error(state)).count()
    }

    /// States driven by noise and themselves alone: gusts, and output errors.
    pub(crate) fn disturbances(&self) -> impl Iterator<Item = usize> {
        let first = self.states.len() + self.inputs.len();
        let noises = first..first + self.noises.len();
        (0..self.states.len()).filter(move |&state| {
            let mut own = self.dynamics.iter().filter(|term| term.row == state);
            own.all(|term| term.column == state || noises.contains(&term.column))
                && self
                    .dynamics
                    .iter()
                    .any(|term| term.row == state && noises.contains(&term.column))
        })
    }

    /// Columns of the dynamics: states, inputs, noises, offsets.
    pub(crate) fn width(&self) -> usize {
        self.states.len() + self.inputs.len() + self.noises.len() + self.offsets.len()
    }

    /// [A B G E] and [C D] at the parameters `theta`.
    pub(crate) fn combined(&self, theta: &[f64]) -> (DMatrix<f64>, DMatrix<f64>) {
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

    /// The continuous model at the parameters `theta`, one for each of [`Structure::parameters`], without process
    /// noises and offsets.
    ///
    /// # Panics
    /// Where `theta` has another length.
    #[must_use]
    pub fn at(&self, theta: &[f64]) -> LinearModel {
        assert_eq!(theta.len(), self.parameters.len(), "one value per parameter");
        let (n, m) = (self.states.len(), self.inputs.len());
        let (dynamics, measurement) = self.combined(theta);
        let columns = |matrix: &DMatrix<f64>, first, count| matrix.columns(first, count).into();
        LinearModel {
            time: TimeDomain::Continuous,
            a: columns(&dynamics, 0, n),
            b: columns(&dynamics, n, m),
            c: columns(&measurement, 0, n),
            d: columns(&measurement, n, m),
        }
    }

    /// The derivative of [A B] with respect to a parameter at the parameters `theta`, n×(n + m).
    pub(crate) fn slope(&self, theta: &[f64], parameter: usize) -> DMatrix<f64> {
        let n = self.states.len();
        let mut slope = DMatrix::zeros(n, n + self.inputs.len());
        let seen = slope.ncols();
        for term in self.dynamics.iter().filter(|term| term.column < seen) {
            slope[(term.row, term.column)] += term.derivative(theta, parameter);
        }
        slope
    }

    /// Input matrix of the process noises at the parameters `theta`, states × noises.
    ///
    /// # Panics
    /// Where `theta` has another length.
    #[must_use]
    pub fn noise_input(&self, theta: &[f64]) -> DMatrix<f64> {
        assert_eq!(theta.len(), self.parameters.len(), "one value per parameter");
        let driven = self.states.len() + self.inputs.len();
        self.combined(theta).0.columns(driven, self.noises.len()).into_owned()
    }
}
