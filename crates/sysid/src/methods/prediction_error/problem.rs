//! Likelihood of a set of records as a function of the parameters, with each record's own unknowns eliminated.

use std::cell::RefCell;
use std::rc::Rc;

use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;

use super::own_rows::OwnRows;
use super::predictor::Predictor;
use super::sweep::{Forcing, Normal, Pass, Record};
use crate::methods::least_squares::{Cost, Quadratic};
use crate::methods::structure::Structure;

/// −ln L = ½ Σ νᵀ S⁻¹ ν + N/2 ln det S without its constant, as a function of the free parameters.
///
/// The innovations are linear in a record's x0, offsets and biases, so these are eliminated exactly. The information is
/// the Schur complement over them (Golub and Pereyra, 1973).
pub(super) struct Problem<'a> {
    pub structure: &'a Structure,
    pub records: &'a [Record],
    pub period_s: f64,
    pub innovations: bool,
    /// The whole parameter vector; the search replaces its free entries.
    pub base: Vec<f64>,
    pub free: Vec<usize>,
    /// Lower and upper limit of each entry of the whole parameter vector.
    pub lower: Vec<f64>,
    pub upper: Vec<f64>,
    /// Weight of each parameter's prior: the factor by which the likelihood overstates the information of the flight on
    /// it. Empty for weight 1.
    pub prior_weight: Vec<f64>,
    /// The records' own values of the last evaluation, and its point: the next evaluation starts there.
    pub own: RefCell<Own>,
}

/// Own values of all records at one set of parameters.
#[derive(Default)]
pub(super) struct Own {
    pub values: Vec<Vec<f64>>,
    /// Steady-state quantities used for the solution.
    pub at: Option<Rc<Steady>>,
}

/// Quantities that are the same for every record at one set of parameters.
pub(super) struct Steady {
    /// The whole parameter vector.
    pub theta: Vec<f64>,
    pub predictor: Predictor,
    pub own_rows: OwnRows,
}

/// Results at the end of a search.
pub(super) struct Passed {
    pub own: Vec<Vec<f64>>,
    pub normals: Vec<Normal>,
}

impl Problem<'_> {
    /// Each free entry with a prior: its index, the prior value, one sigma, and its weight.
    pub fn priors(&self) -> impl Iterator<Item = (usize, f64, f64, f64)> {
        self.free.iter().enumerate().filter_map(|(place, &index)| {
            let (value, sigma) = self.structure.parameters.get(index)?.prior?;
            Some((place, value, sigma, self.prior_weight.get(index).copied().unwrap_or(1.0)))
        })
    }

    /// The whole parameter vector with `theta` in its free entries.
    pub fn whole(&self, theta: &[f64]) -> Vec<f64> {
        let mut whole = self.base.clone();
        for (&index, &value) in self.free.iter().zip(theta) {
            whole[index] = value;
        }
        whole
    }

    pub fn samples(&self) -> usize {
        self.records.iter().map(|record| record.samples).sum()
    }

    /// Initial values of all records' own values, before the first evaluation.
    pub fn guesses(structure: &Structure, records: &[Record]) -> Own {
        let values = records.iter().map(|record| Self::guess(structure, record)).collect();
        Own { values, at: None }
    }

    /// Initial values of a record's own values: the measurements at the start of the record.
    pub fn guess(structure: &Structure, record: &Record) -> Vec<f64> {
        let n = structure.states.len();
        let mut own = vec![0.0; n + structure.offsets.len() + structure.biases.len()];
        for (state, value) in structure.states.iter().zip(&mut own) {
            if let Some(output) = structure.outputs.iter().position(|output| output == state) {
                *value = record.outputs[output];
            }
        }
        own
    }

    /// Indices of a record's `own` values to solve for. Output errors start at 0: their initial values cannot be
    /// separated from the motion, and their size is known.
    fn solved(structure: &Structure) -> Vec<usize> {
        let n = structure.states.len();
        let all = n + structure.offsets.len() + structure.biases.len();
        (0..n - structure.trailing_errors()).chain(n..all).collect()
    }

    /// Sensitivities of the innovations to the own values of `records` that are solved for.
    pub fn own_rows(structure: &Structure, predictor: &Predictor, records: &[Record]) -> OwnRows {
        let lengths = records.iter().map(|record| record.samples);
        OwnRows::new(structure, predictor, Self::solved(structure), lengths)
    }

    /// ½ νᵀS⁻¹ν, minimised over the record's own unknowns, which are written to `own`.
    pub fn solve_own(
        structure: &Structure,
        predictor: &Predictor,
        own_rows: &OwnRows,
        inputs: &(Vec<f64>, Vec<f64>),
        record: &Record,
        own: &mut [f64],
    ) -> Option<f64> {
        let pass = Pass {
            structure,
            predictor,
            forcing: None,
            record,
            inputs,
            own,
            own_rows,
            keep: false,
        };
        let normal = pass.run();
        let step = solve(&normal.information, &normal.gradient)?;
        let saved = 0.5 * normal.gradient.dot(&step);
        for (&place, step) in own_rows.columns.iter().zip(step.iter()) {
            own[place] -= step;
        }
        Some(normal.half_squares - saved)
    }

    /// Quantities at `theta` that are the same for every record.
    fn steady(&self, theta: Vec<f64>) -> Option<Rc<Steady>> {
        let predictor = Predictor::new(self.structure, &theta, self.period_s, self.innovations)?;
        let own_rows = Self::own_rows(self.structure, &predictor, self.records);
        Some(Rc::new(Steady { theta, predictor, own_rows }))
    }

    /// One pass over every record with all columns at `theta`.
    pub fn pass(&self, theta: &[f64], keep: bool) -> Option<(Rc<Steady>, Forced, Passed)> {
        let whole = self.whole(theta);
        let mut own = self.own.borrow_mut();
        let solved_with = own.at.take().filter(|solved| solved.theta == whole);
        let solved = solved_with.is_some();
        let shared = solved_with.or_else(|| self.steady(whole))?;
        let Steady { theta, predictor, own_rows } = &*shared;
        let derivatives =
            predictor.derivatives(self.structure, theta, &self.free, self.innovations)?;
        let forcing = Forcing::new(predictor, &derivatives, self.structure.offsets.len());
        let (structure, period_s) = (self.structure, self.period_s);
        let normals = side_by_side(self.records, &mut own.values, |record, own| {
            let inputs = record.late(structure, theta, period_s);
            if !solved {
                Self::solve_own(structure, predictor, own_rows, &inputs, record, own)?;
            }
            let pass = Pass {
                structure,
                predictor,
                forcing: Some(&forcing),
                record,
                inputs: &inputs,
                own,
                own_rows,
                keep,
            };
            Some(pass.run())
        })?;
        own.at = Some(Rc::clone(&shared));
        let spreads = derivatives.into_iter().map(|change| change.whitened_innovations).collect();
        Some((shared, Forced { spreads }, Passed { own: own.values.clone(), normals }))
    }

    /// Cost, gradient and information of the free parameters from the passes' normal equations.
    ///
    /// # Source
    /// Equations (I10) and (I13) of docs/equations.md.
    pub fn gather(
        &self,
        theta: &[f64],
        predictor: &Predictor,
        forced: &Forced,
        passed: &Passed,
    ) -> Option<Quadratic> {
        let count = self.free.len();
        let samples = self.samples() as f64;
        let p = self.structure.outputs.len();
        let mut cost = 0.5 * samples * predictor.log_determinant;
        let mut gradient = DVector::zeros(count);
        let mut information = DMatrix::zeros(count, count);
        let mut scatter = DMatrix::zeros(p, p);
        for normal in &passed.normals {
            cost += normal.half_squares;
            scatter += &normal.scatter;
            let own = normal.gradient.len() - count;
            let across = normal.information.view((0, count), (count, own)).into_owned();
            let inner = normal.information.view((count, count), (own, own)).into_owned();
            let eliminate = solve_many(&inner, &across.transpose())?;
            gradient += normal.gradient.rows(0, count)
                - eliminate.tr_mul(&normal.gradient.rows(count, own));
            information += normal.information.view((0, 0), (count, count)) - across * eliminate;
        }
        for (row, spread) in forced.spreads.iter().enumerate() {
            gradient[row] += 0.5 * (samples * spread.trace() - spread.dot(&scatter));
            for (column, other) in forced.spreads.iter().enumerate() {
                information[(row, column)] += 0.5 * samples * spread.dot(other);
            }
        }
        for (place, value, sigma, weight) in self.priors() {
            let off = (theta[place] - value) / sigma;
            cost += 0.5 * weight * off * off;
            gradient[place] += weight * off / sigma;
            information[(place, place)] += weight / (sigma * sigma);
        }
        cost.is_finite().then_some(Quadratic { cost, gradient, information })
    }
}

/// Runs `work` on each record with its own values, in order.
fn side_by_side<T: Send>(
    records: &[Record],
    own: &mut [Vec<f64>],
    work: impl Fn(&Record, &mut Vec<f64>) -> Option<T> + Sync,
) -> Option<Vec<T>> {
    records.par_iter().zip(own).map(|(record, own)| work(record, own)).collect()
}

/// L⁻¹ dS L⁻ᵀ of each free parameter.
pub(super) struct Forced {
    pub spreads: Vec<DMatrix<f64>>,
}

impl Cost for Problem<'_> {
    fn cost(&self, theta: &[f64]) -> Option<f64> {
        let shared = self.steady(self.whole(theta))?;
        let Steady { theta: whole, predictor, own_rows } = &*shared;
        let mut cost = 0.5 * self.samples() as f64 * predictor.log_determinant;
        let mut own = self.own.borrow_mut();
        let mut trial = own.values.clone();
        let (structure, period_s) = (self.structure, self.period_s);
        let costs = side_by_side(self.records, &mut trial, |record, own| {
            let inputs = record.late(structure, whole, period_s);
            Self::solve_own(structure, predictor, own_rows, &inputs, record, own)
        })?;
        cost += costs.iter().sum::<f64>();
        for (place, value, sigma, weight) in self.priors() {
            cost += 0.5 * weight * ((theta[place] - value) / sigma).powi(2);
        }
        if cost.is_finite() {
            *own = Own { values: trial, at: Some(shared) };
        }
        Some(cost)
    }

    fn quadratic(&self, theta: &[f64]) -> Option<Quadratic> {
        let (steady, forced, passed) = self.pass(theta, false)?;
        self.gather(theta, &steady.predictor, &forced, &passed)
    }
}

/// Solves with a positive semidefinite matrix. The solution is 0 for entries without information.
pub(super) fn solve(matrix: &DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    solve_many(matrix, &DMatrix::from_column_slice(right.len(), 1, right.as_slice()))
        .map(|solved| solved.column(0).into_owned())
}

pub(super) fn solve_many(matrix: &DMatrix<f64>, right: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    if matrix.is_empty() {
        return Some(DMatrix::zeros(matrix.ncols(), right.ncols()));
    }
    // Scaled to a unit diagonal, so that the regularisation is the same for a rate and a velocity.
    let scale = matrix.diagonal().map(|value| if value > 0.0 { value.sqrt().recip() } else { 0.0 });
    let mut scaled = matrix.clone();
    for column in 0..scaled.ncols() {
        for row in 0..scaled.nrows() {
            scaled[(row, column)] *= scale[row] * scale[column];
        }
        scaled[(column, column)] += if scale[column] > 0.0 { 1e-10 } else { 1.0 };
    }
    let mut side = right.clone();
    for (row, factor) in scale.iter().enumerate() {
        side.row_mut(row).scale_mut(*factor);
    }
    let mut solved = Cholesky::new(scaled)?.solve(&side);
    for (row, factor) in scale.iter().enumerate() {
        solved.row_mut(row).scale_mut(*factor);
    }
    solved.iter().all(|value| value.is_finite()).then_some(solved)
}
