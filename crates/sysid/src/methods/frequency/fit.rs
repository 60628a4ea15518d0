//! A model's parameters from frequency responses, weighted by their coherence.

use std::f64::consts::{PI, TAU};

use nalgebra::{Complex, DMatrix, DVector};

use super::{FrequencyError, FrequencyResponse};
use crate::methods::least_squares::{Cost, Limits, Quadratic, minimise};

/// How to weigh and where to stop.
#[derive(Debug, Clone, PartialEq)]
pub struct ResponseFitSettings {
    /// Points of less coherence are left out.
    pub least_coherence: f64,
    /// Lower bounds of the parameters; empty for none.
    pub lower: Vec<f64>,
    /// Upper bounds of the parameters; empty for none.
    pub upper: Vec<f64>,
    /// Most linearisations.
    pub iterations: usize,
}

impl Default for ResponseFitSettings {
    /// Coherence of 0.6 and above, no bounds, 100 iterations.
    fn default() -> Self {
        Self { least_coherence: 0.6, lower: vec![], upper: vec![], iterations: 100 }
    }
}

/// Parameters that fit the responses best, and how well.
#[derive(Debug, Clone, PartialEq)]
pub struct ResponseFit {
    /// The parameters.
    pub parameters: Vec<f64>,
    /// Their standard deviations: Cramér and Rao's bounds, scaled by the misfit that remains and
    /// doubled, since neighbouring frequencies share their windows and are not independent (Tischler
    /// & Remple, section 11.3). Infinite where the responses say nothing of a parameter.
    pub bounds: Vec<f64>,
    /// Tischler & Remple's J of each response, outputs × inputs; NaN where no point was coherent.
    /// Below 50 a model is hardly told from the vehicle, below 100 it is good for most uses.
    pub costs: DMatrix<f64>,
    /// Their mean.
    pub cost: f64,
    /// Points used, all responses together.
    pub points: usize,
    /// Whether nothing was left to gain.
    pub converged: bool,
}

/// 7.57° of phase weigh as much as 1 dB of magnitude.
const PHASE_WEIGHT: f64 = 0.017_45;

/// Fits `model` to `measured` by damped least squares from `start`.
///
/// `model` gives for parameters θ and a frequency ω in rad/s the responses, outputs × inputs, as
/// [`FrequencyResponse::responses`]; `None` where θ is not admissible. The cost of each response is
/// J = 20/n Σ Wγ [(Δ dB)² + 0.01745 (Δ°)²] with Wγ = (1.58 (1 − exp(−γ²)))², its mean over all
/// responses is minimised.
///
/// # Errors
/// [`FrequencyError::TooFewPoints`] where too little is coherent, [`FrequencyError::Start`] where
/// the model does not exist at the start.
///
/// # Source
/// Tischler & Remple, section 11.2, eqs. 11.4 to 11.6.
/// Equation (I21) of docs/equations.md.
pub fn fit_response(
    measured: &FrequencyResponse,
    start: &[f64],
    settings: &ResponseFitSettings,
    model: impl Fn(&[f64], f64) -> Option<DMatrix<Complex<f64>>>,
) -> Result<ResponseFit, FrequencyError> {
    let (outputs, inputs) = (measured.output_names.len(), measured.input_names.len());
    let points = coherent_points(measured, settings.least_coherence);
    if points.len() * 2 <= start.len() {
        return Err(FrequencyError::TooFewPoints {
            points: points.len(),
            least: settings.least_coherence,
            parameters: start.len(),
        });
    }
    let misfit = Misfit {
        frequencies_hz: &measured.frequencies_hz,
        shape: (outputs, inputs),
        points,
        model,
    };
    let refuse = || FrequencyError::Start { outputs, inputs };
    let before = misfit.cost(start).ok_or_else(refuse)?;
    let or = |bounds: &[f64], default: f64| {
        if bounds.is_empty() { vec![default; start.len()] } else { bounds.to_vec() }
    };
    let end = minimise(
        &misfit,
        start,
        &or(&settings.lower, f64::NEG_INFINITY),
        &or(&settings.upper, f64::INFINITY),
        Limits { iterations: settings.iterations, least_decrease: 1e-9 * before },
    )
    .ok_or_else(refuse)?;

    let residuals = misfit.residuals(&end.theta).ok_or_else(refuse)?;
    let mut costs = DMatrix::from_element(outputs, inputs, f64::NAN);
    let responses = misfit.responses() as f64;
    for (point, pair) in misfit.points.iter().zip(residuals.as_slice().chunks_exact(2)) {
        let cost: &mut f64 = &mut costs[(point.output, point.input)];
        let own = responses * (pair[0] * pair[0] + pair[1] * pair[1]);
        *cost = if cost.is_nan() { own } else { *cost + own };
    }
    let freedom = (residuals.len() - start.len()).max(1) as f64;
    let variance = residuals.norm_squared() / freedom;
    let bounds = match end.at.information.clone().try_inverse() {
        Some(inverse) => inverse
            .diagonal()
            .iter()
            .map(|&own| if own >= 0.0 { 2.0 * (variance * own).sqrt() } else { f64::INFINITY })
            .collect(),
        None => vec![f64::INFINITY; start.len()],
    };
    Ok(ResponseFit {
        parameters: end.theta,
        bounds,
        costs,
        cost: residuals.norm_squared(),
        points: misfit.points.len(),
        converged: end.converged,
    })
}

/// One coherent point of one response.
struct Point {
    at: usize,
    output: usize,
    input: usize,
    magnitude_db: f64,
    phase_rad: f64,
    /// Square root of its weight in the mean cost.
    weight: f64,
}

fn coherent_points(measured: &FrequencyResponse, least: f64) -> Vec<Point> {
    let mut all = Vec::new();
    for output in 0..measured.output_names.len() {
        for input in 0..measured.input_names.len() {
            let first = all.len();
            for (at, response) in measured.responses.iter().enumerate() {
                let value = response[(output, input)];
                let coherence = measured.coherence[at][(output, input)];
                if coherence >= least && value.norm() > 0.0 {
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
            let scale = (20.0 / (all.len() - first).max(1) as f64).sqrt();
            all[first..].iter_mut().for_each(|point| point.weight *= scale);
        }
    }
    let share = 1.0 / (responses(&all) as f64).sqrt();
    all.iter_mut().for_each(|point| point.weight *= share);
    all
}

/// How many responses have a point at all.
fn responses(points: &[Point]) -> usize {
    points
        .chunk_by(|one, other| (one.output, one.input) == (other.output, other.input))
        .count()
        .max(1)
}

struct Misfit<'a, M> {
    frequencies_hz: &'a [f64],
    shape: (usize, usize),
    points: Vec<Point>,
    model: M,
}

impl<M: Fn(&[f64], f64) -> Option<DMatrix<Complex<f64>>>> Misfit<'_, M> {
    fn responses(&self) -> usize {
        responses(&self.points)
    }

    /// Weighted error in magnitude and phase of each point, in turn.
    fn residuals(&self, theta: &[f64]) -> Option<DVector<f64>> {
        let modelled = self
            .frequencies_hz
            .iter()
            .map(|frequency_hz| {
                (self.model)(theta, TAU * frequency_hz).filter(|m| m.shape() == self.shape)
            })
            .collect::<Option<Vec<_>>>()?;
        let mut residuals = Vec::with_capacity(2 * self.points.len());
        for point in &self.points {
            let value = modelled[point.at][(point.output, point.input)];
            let magnitude_db = 20.0 * value.norm().log10() - point.magnitude_db;
            // The nearest way round the circle.
            let phase = (value.arg() - point.phase_rad + PI).rem_euclid(TAU) - PI;
            residuals.push(point.weight * magnitude_db);
            residuals.push(point.weight * PHASE_WEIGHT.sqrt() * phase.to_degrees());
        }
        residuals.iter().all(|value| value.is_finite()).then(|| DVector::from_vec(residuals))
    }

    /// The residuals' derivative by central differences.
    fn jacobian(&self, theta: &[f64]) -> Option<DMatrix<f64>> {
        let mut columns = Vec::with_capacity(theta.len());
        for index in 0..theta.len() {
            let reach = 1e-5 * theta[index].abs().max(1e-3);
            let side = |reach: f64| {
                let mut moved = theta.to_vec();
                moved[index] += reach;
                self.residuals(&moved)
            };
            let mut change = side(reach)? - side(-reach)?;
            // A phase error that passes half a turn has not jumped by a whole one.
            for (point, pair) in self.points.iter().zip(change.as_mut_slice().chunks_exact_mut(2)) {
                let turn = point.weight * PHASE_WEIGHT.sqrt() * 360.0;
                pair[1] -= turn * (pair[1] / turn).round();
            }
            columns.push(change / (2.0 * reach));
        }
        Some(DMatrix::from_columns(&columns))
    }
}

impl<M: Fn(&[f64], f64) -> Option<DMatrix<Complex<f64>>>> Cost for Misfit<'_, M> {
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
