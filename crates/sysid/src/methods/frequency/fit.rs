//! A model's parameters from frequency responses, weighted by their coherence.

use std::f64::consts::{PI, TAU};

use nalgebra::{Complex, DMatrix, DVector};

use super::{FrequencyError, FrequencyResponse};
use crate::methods::least_squares::{Cost, Limits, Quadratic, minimise};

/// Frequency responses of a model, one matrix of outputs × inputs per frequency.
pub type Responses = Vec<DMatrix<Complex<f64>>>;

/// Weights and stopping criteria.
#[derive(Debug, Clone, PartialEq)]
pub struct ResponseFitSettings {
    /// Points of lower coherence are ignored.
    pub min_coherence: f64,
    /// Responses with fewer coherent points are ignored.
    pub min_points: usize,
    /// Lower bounds of the parameters; empty for no bounds.
    pub lower: Vec<f64>,
    /// Upper bounds of the parameters; empty for no bounds.
    pub upper: Vec<f64>,
    /// Priors of parameters: index, value, and one sigma in units of the fit's [`unit`](ResponseFit::unit).
    pub known: Vec<(usize, f64, f64)>,
    /// Largest number of linearisations.
    pub iterations: usize,
    /// The search stops where the predicted decrease of the next step is below this fraction of the initial cost.
    pub min_decrease: f64,
}

impl Default for ResponseFitSettings {
    /// Points of coherence 0.6 and above, no bounds, 100 iterations.
    fn default() -> Self {
        Self {
            min_coherence: 0.6,
            min_points: 1,
            lower: vec![],
            upper: vec![],
            known: vec![],
            iterations: 100,
            min_decrease: 1e-9,
        }
    }
}

/// Parameters that fit the responses best, and their uncertainty.
#[derive(Debug, Clone, PartialEq)]
pub struct ResponseFit {
    /// The parameters.
    pub parameters: Vec<f64>,
    /// Standard deviations: Cramér–Rao bounds, scaled by the remaining misfit and doubled (Tischler & Remple, section
    /// 11.3). Neighbouring frequencies come from the same windows and are not independent. Infinite for a parameter
    /// without effect on the responses.
    pub bounds: Vec<f64>,
    /// Insensitivities: change of one parameter, with all others fixed, that raises the cost by the same amount for
    /// each parameter. Never above the bound.
    pub insensitivities: Vec<f64>,
    /// Bound of a parameter on which a single residual depends, with a slope of 1: twice the standard deviation of the
    /// residuals.
    pub unit: f64,
    /// Costs of the remaining misfit.
    pub costs: ResponseCosts,
    /// Whether the search converged.
    pub converged: bool,
}

/// Misfit between a model's responses and the measured ones.
#[derive(Debug, Clone, PartialEq)]
pub struct ResponseCosts {
    /// Tischler & Remple's J of each response, outputs × inputs; NaN where too few points were coherent. Below 50 the
    /// model is hardly distinguishable from the vehicle; below 100 it is good for most uses.
    pub each: DMatrix<f64>,
    /// Mean cost.
    pub mean: f64,
    /// Number of points used of each response.
    pub points: DMatrix<usize>,
}

/// Weight of a squared phase error, dB²/°²: an error of 7.57° counts as much as an error of 1 dB.
pub(crate) const PHASE_WEIGHT: f64 = 0.017_45;

/// Fits `model` to `measured` by damped least squares from `start`.
///
/// `model` returns the responses at parameters θ and frequencies ω in rad/s, each outputs × inputs, as
/// [`FrequencyResponse::responses`]; `None` where θ is not admissible. The cost of each response is J = 20/n Σ Wγ [(Δ
/// dB)² + 0.01745 (Δ°)²] with Wγ = (1.58 (1 − exp(−γ²)))². The fit minimises the mean of J over all responses.
///
/// # Errors
/// [`FrequencyError::TooFewPoints`] where too few points are coherent, [`FrequencyError::Start`] where the model does
/// not exist at the start.
///
/// # Source
/// Tischler & Remple, section 11.2, eqs. 11.4 to 11.6.
/// Equation (I21) of docs/equations.md.
pub fn fit_response(
    measured: &FrequencyResponse,
    start: &[f64],
    settings: &ResponseFitSettings,
    model: impl Fn(&[f64], &[f64]) -> Option<Responses>,
) -> Result<ResponseFit, FrequencyError> {
    let misfit = Misfit::of(measured, settings, start.len(), model)?;
    let reject = || misfit.rejection();
    let before = misfit.cost(start).ok_or_else(reject)?;
    let or = |bounds: &[f64], default: f64| {
        if bounds.is_empty() { vec![default; start.len()] } else { bounds.to_vec() }
    };
    let end = minimise(
        &misfit,
        start,
        &or(&settings.lower, f64::NEG_INFINITY),
        &or(&settings.upper, f64::INFINITY),
        Limits { iterations: settings.iterations, min_decrease: settings.min_decrease * before },
    )
    .ok_or_else(reject)?;

    let residuals = misfit.residuals(&end.theta).ok_or_else(reject)?;
    let freedom = residuals.len().saturating_sub(start.len()).max(1) as f64;
    let variance = residuals.norm_squared() / freedom;
    let doubled = |variances: Vec<f64>| -> Vec<f64> {
        variances.iter().map(|own| 2.0 * (variance * own).sqrt()).collect()
    };
    let information = &end.at.information;
    let bounds = doubled(variances(information));
    let insensitivities = doubled(information.diagonal().iter().map(|own| own.recip()).collect());
    let costs = misfit.costs(&residuals);
    Ok(ResponseFit {
        parameters: end.theta,
        bounds,
        insensitivities,
        unit: 2.0 * variance.sqrt(),
        costs,
        converged: end.converged,
    })
}

/// Diagonal of the inverse of `information`: infinite for a parameter without information, very large for parameters
/// that cannot be separated.
fn variances(information: &DMatrix<f64>) -> Vec<f64> {
    const MIN: f64 = 1e-12;
    let sizes = information.diagonal().map(f64::sqrt);
    let unit = DMatrix::from_fn(sizes.len(), sizes.len(), |row, column| {
        let size = sizes[row] * sizes[column];
        match (size > 0.0, row == column) {
            (true, _) => information[(row, column)] / size,
            (false, is_own) => f64::from(u8::from(is_own)),
        }
    });
    let axes = unit.symmetric_eigen();
    let along = |row: usize| -> f64 {
        let parts = axes.eigenvectors.row(row);
        parts.iter().zip(&axes.eigenvalues).map(|(part, own)| part * part / own.max(MIN)).sum()
    };
    (0..sizes.len()).map(|row| along(row) / sizes[row].powi(2)).collect()
}

/// Misfit of `model` at `theta` to `measured`, by the costs of [`fit_response`].
///
/// # Errors
/// As [`fit_response`].
pub fn response_costs(
    measured: &FrequencyResponse,
    theta: &[f64],
    settings: &ResponseFitSettings,
    model: impl Fn(&[f64], &[f64]) -> Option<Responses>,
) -> Result<ResponseCosts, FrequencyError> {
    let misfit = Misfit::of(measured, settings, 0, model)?;
    let residuals = misfit.residuals(theta).ok_or_else(|| misfit.rejection())?;
    Ok(misfit.costs(&residuals))
}

/// One coherent point of one response.
struct Point {
    at: usize,
    output: usize,
    input: usize,
    magnitude_db: f64,
    phase_rad: f64,
    /// Factor on the point's residuals: the square root of the point's weight in the cost.
    weight: f64,
}

fn coherent_points(measured: &FrequencyResponse, settings: &ResponseFitSettings) -> Vec<Point> {
    let mut all = Vec::new();
    for output in 0..measured.output_names.len() {
        for input in 0..measured.input_names.len() {
            let first = all.len();
            for (at, response) in measured.responses.iter().enumerate() {
                let value = response[(output, input)];
                let coherence = measured.coherence[at][(output, input)];
                if coherence >= settings.min_coherence && value.norm() > 0.0 {
                    let weight = 1.58 * (1.0 - (-coherence).exp());
                    let magnitude_db = 20.0 * value.norm().log10();
                    all.push(Point {
                        at,
                        output,
                        input,
                        magnitude_db,
                        phase_rad: value.arg(),
                        weight,
                    });
                }
            }
            if all.len() - first < settings.min_points {
                all.truncate(first);
            }
            let scale = (20.0 / (all.len() - first).max(1) as f64).sqrt();
            all[first..].iter_mut().for_each(|point| point.weight *= scale);
        }
    }
    let share = 1.0 / (responses(&all) as f64).sqrt();
    all.iter_mut().for_each(|point| point.weight *= share);
    all
}

/// Number of responses with at least one point.
fn responses(points: &[Point]) -> usize {
    points
        .chunk_by(|one, other| (one.output, one.input) == (other.output, other.input))
        .count()
        .max(1)
}

struct Misfit<M> {
    frequencies_radps: Vec<f64>,
    shape: (usize, usize),
    points: Vec<Point>,
    /// Smallest assumed size of each parameter for the step of the derivative: a small fraction of the search range, in
    /// the parameter's unit.
    sizes: Vec<f64>,
    known: Vec<(usize, f64, f64)>,
    model: M,
}

impl<M: Fn(&[f64], &[f64]) -> Option<Responses>> Misfit<M> {
    fn of(
        measured: &FrequencyResponse,
        settings: &ResponseFitSettings,
        parameters: usize,
        model: M,
    ) -> Result<Self, FrequencyError> {
        let points = coherent_points(measured, settings);
        if points.len() * 2 <= parameters {
            let (points, least) = (points.len(), settings.min_coherence);
            return Err(FrequencyError::TooFewPoints { points, least, parameters });
        }
        let frequencies_radps = measured.frequencies_hz.iter().map(|hz| TAU * hz).collect();
        let shape = (measured.output_names.len(), measured.input_names.len());
        let size = |(lower, upper): (&f64, &f64)| match upper - lower {
            range if range.is_finite() && range > 0.0 => 1e-5 * range,
            _ => 1e-3,
        };
        let mut sizes: Vec<f64> = settings.lower.iter().zip(&settings.upper).map(size).collect();
        sizes.resize(parameters.max(sizes.len()), 1e-3);
        let known = settings.known.clone();
        Ok(Self { frequencies_radps, shape, points, sizes, known, model })
    }

    fn rejection(&self) -> FrequencyError {
        FrequencyError::Start { outputs: self.shape.0, inputs: self.shape.1 }
    }

    /// Cost of each response from its `residuals`.
    fn costs(&self, residuals: &DVector<f64>) -> ResponseCosts {
        let (outputs, inputs) = self.shape;
        let mut each = DMatrix::from_element(outputs, inputs, f64::NAN);
        let mut points = DMatrix::zeros(outputs, inputs);
        let responses = responses(&self.points) as f64;
        for (point, pair) in self.points.iter().zip(residuals.as_slice().chunks_exact(2)) {
            let at = (point.output, point.input);
            let own = responses * (pair[0] * pair[0] + pair[1] * pair[1]);
            each[at] = if points[at] == 0 { own } else { each[at] + own };
            points[at] += 1;
        }
        let mean = residuals.rows(0, 2 * self.points.len()).norm_squared();
        ResponseCosts { each, mean, points }
    }

    /// Weighted error in magnitude and phase of each point, in turn, then that of each parameter with a prior.
    fn residuals(&self, theta: &[f64]) -> Option<DVector<f64>> {
        let modelled = (self.model)(theta, &self.frequencies_radps)
            .filter(|all| all.iter().all(|one| one.shape() == self.shape))?;
        let mut residuals = Vec::with_capacity(2 * self.points.len());
        for point in &self.points {
            let value = modelled[point.at][(point.output, point.input)];
            let magnitude_db = 20.0 * value.norm().log10() - point.magnitude_db;
            // The phase error is wrapped to the nearest equivalent angle.
            let phase = (value.arg() - point.phase_rad + PI).rem_euclid(TAU) - PI;
            residuals.push(point.weight * magnitude_db);
            residuals.push(point.weight * PHASE_WEIGHT.sqrt() * phase.to_degrees());
        }
        let known = self.known.iter();
        residuals.extend(known.map(|&(place, value, sigma)| (theta[place] - value) / sigma));
        residuals.iter().all(|value| value.is_finite()).then(|| DVector::from_vec(residuals))
    }

    /// The residuals' derivative by central differences.
    fn jacobian(&self, theta: &[f64]) -> Option<DMatrix<f64>> {
        let mut columns = Vec::with_capacity(theta.len());
        for index in 0..theta.len() {
            let reach = 1e-5 * theta[index].abs().max(self.sizes[index]);
            let side = |reach: f64| {
                let mut moved = theta.to_vec();
                moved[index] += reach;
                self.residuals(&moved)
            };
            let mut change = side(reach)? - side(-reach)?;
            // The change of a phase error that passes half a turn must not contain a whole turn.
            for (point, pair) in self.points.iter().zip(change.as_mut_slice().chunks_exact_mut(2)) {
                let turn = point.weight * PHASE_WEIGHT.sqrt() * 360.0;
                pair[1] -= turn * (pair[1] / turn).round();
            }
            columns.push(change / (2.0 * reach));
        }
        Some(DMatrix::from_columns(&columns))
    }
}

impl<M: Fn(&[f64], &[f64]) -> Option<Responses>> Cost for Misfit<M> {
    fn cost(&self, theta: &[f64]) -> Option<f64> {
        Some(0.5 * self.residuals(theta)?.norm_squared())
    }

    fn quadratic(&self, theta: &[f64]) -> Option<Quadratic> {
        let residuals = self.residuals(theta)?;
        let jacobian = self.jacobian(theta)?;
        Some(Quadratic {
            cost: 0.5 * residuals.norm_squared(),
            gradient: jacobian.tr_mul(&residuals),
            information: jacobian.tr_mul(&jacobian),
        })
    }
}
