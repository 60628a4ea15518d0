//! Uncertainty of the on-axis response to each stick, as estimated from the flight.

use std::f64::consts::{LN_10, TAU};

use nalgebra::{Complex, DMatrix};

use super::identify::Identification;
use crate::methods::frequency::PHASE_WEIGHT;
use crate::methods::prediction_error::Identified;
use crate::record::STICKS;

/// Each stick and its main output.
const ON_AXIS: [(&str, &str); 4] =
    [("lateral", "p"), ("longitudinal", "q"), ("collective", "w"), ("pedal", "r")];
/// First frequency, rad/s, at which responses are compared: the lowest at which a hover is flown.
const FIRST_RADPS: f64 = 0.5;
/// Last frequency, rad/s, at which responses are compared: the highest at which a hover is flown.
const LAST_RADPS: f64 = 12.0;
/// Number of frequencies at which responses are compared.
const POINTS: usize = 30;
/// Smallest number of frequencies in a band.
const MIN_POINTS: usize = 8;
/// Largest cost at which model and vehicle agree: Tischler and Remple, section 11.2.
pub(super) const COST: f64 = 100.0;
/// Number of sigma that a normal error exceeds on one side with 10 % probability.
const ONE_IN_TEN: f64 = 1.2816;
/// Step of the central differences, as a fraction of a parameter's bound.
const STEP: f64 = 0.02;

/// Uncertainty of the response of an output to its own stick, as a cost J.
#[derive(Debug, Clone, PartialEq)]
pub struct ResponseUncertainty {
    /// The stick.
    pub stick: &'static str,
    /// Main output of the stick.
    pub output: &'static str,
    /// Cost J due to the bounds of the parameters; exceeded with 10 % probability.
    pub within_bounds: f64,
    /// Lowest frequency, rad/s, from which on the cost J is at most 100 with at least 90 % probability; `None` without
    /// one.
    pub known_from_radps: Option<f64>,
    /// Cost J between the models with and without a stabiliser bar; `None` unless both were searched and the flight
    /// does not clearly favour one.
    pub between_structures: Option<f64>,
}

impl ResponseUncertainty {
    /// Total cost J: costs are squares, and those of independent errors add up.
    #[must_use]
    pub fn cost(&self) -> f64 {
        self.within_bounds + self.between_structures.unwrap_or(0.0)
    }
}

impl Identification {
    /// Response uncertainty of each axis with its own stick.
    ///
    /// # Source
    /// The cost J: Tischler and Remple, section 11.2. Under the parameters' covariance it is a quadratic form of normal
    /// errors. Equation (I30) of docs/equations.md.
    #[must_use]
    pub fn response_uncertainties(&self) -> Vec<ResponseUncertainty> {
        let found = &self.identified;
        let values = found.values();
        let uncertainty = |(stick, output): (&'static str, &'static str)| {
            let axis = Axis::of(found, stick, output)?;
            let own = axis.response(&values)?;
            let between_structures = self.passed_over.as_ref().and_then(|other| {
                let other_axis = Axis::of(other, stick, output)?;
                Some(cost(&own, &other_axis.response(&other.values())?))
            });
            let spread = axis.spread(&values);
            let from = |first: usize| {
                spread.as_ref().and_then(|spread| spread.from(first)).unwrap_or(f64::INFINITY)
            };
            let known_from = (0..POINTS - MIN_POINTS).find(|&first| from(first) <= COST);
            Some(ResponseUncertainty {
                stick,
                output,
                within_bounds: from(0),
                known_from_radps: known_from.map(radps_of),
                between_structures,
            })
        };
        ON_AXIS.into_iter().filter_map(uncertainty).collect()
    }
}

/// On-axis response of a model to one stick, with delay and lag.
struct Axis<'a> {
    found: &'a Identified,
    kept: Vec<usize>,
    /// Index of the output among the kept states, and of the stick among the pilot's sticks.
    place: (usize, usize),
    /// Indices of the delay and lag parameters.
    late: [Option<usize>; 2],
}

impl<'a> Axis<'a> {
    /// The response of `output` to `stick`; `None` where the model lacks one of them.
    fn of(found: &'a Identified, stick: &str, output: &str) -> Option<Self> {
        let structure = &found.structure;
        let kept = found.vehicle_states();
        let row = kept.iter().position(|&state| structure.states[state] == output)?;
        let mut sticks = structure.inputs.iter().filter(|input| STICKS.contains(&input.as_str()));
        let column = sticks.position(|own| own == stick)?;
        let input = structure.inputs.iter().position(|own| own == stick)?;
        let late = [structure.delays[input], structure.lags[input]];
        Some(Self { found, kept, place: (row, column), late })
    }

    /// Response from 0.5 to 12 rad/s; `None` where it cannot be computed or is zero.
    fn response(&self, values: &[f64]) -> Option<Vec<Complex<f64>>> {
        let model = self.found.vehicle_at(values, &self.kept);
        let [delay_s, lag_s] = self.late.map(|of| of.map_or(0.0, |own| values[own]));
        let at = |point: usize| {
            let radps = radps_of(point);
            let answer = model.frequency_response(radps)?[self.place];
            let late =
                Complex::from_polar(1.0, -radps * delay_s) / Complex::new(1.0, radps * lag_s);
            Some(answer * late).filter(|answer| answer.norm() > 0.0)
        };
        (0..POINTS).map(at).collect()
    }

    /// Sensitivity and covariance of the response.
    fn spread(&self, values: &[f64]) -> Option<Spread> {
        let estimates = &self.found.estimates;
        let free: Vec<usize> = self.found.free_parameters().collect();
        let covariance = DMatrix::from_fn(free.len(), free.len(), |row, column| {
            let place = |own: usize| estimates.free.iter().position(|&index| index == own);
            match (place(free[row]), place(free[column])) {
                (Some(row), Some(column)) => estimates.covariance[(row, column)],
                _ => 0.0,
            }
        });
        let mut slopes = DMatrix::zeros(2 * POINTS, free.len());
        for (column, &parameter) in free.iter().enumerate() {
            let step = STEP * estimates.list[parameter].bound;
            if !(step > 0.0 && step.is_finite()) {
                continue;
            }
            let side = |by: f64| {
                let mut moved = values.to_vec();
                moved[parameter] += by;
                self.response(&moved)
            };
            let (above, below) = (side(step)?, side(-step)?);
            for (point, (above, below)) in above.iter().zip(&below).enumerate() {
                let [magnitude, phase] = apart(*above, *below);
                slopes[(2 * point, column)] = magnitude / (2.0 * step);
                slopes[(2 * point + 1, column)] = phase / (2.0 * step);
            }
        }
        Some(Spread { slopes, covariance })
    }
}

/// Sensitivity of a response to the parameters, and their covariance.
struct Spread {
    /// Change of the response with each parameter. The rows contain dB and weighted degrees for each frequency in turn.
    slopes: DMatrix<f64>,
    covariance: DMatrix<f64>,
}

impl Spread {
    /// Cost over the frequencies from `first` on that is exceeded with 10 % probability; `None` where it is not finite.
    ///
    /// # Source
    /// A weighted sum of squares has nearly the distribution of a scaled χ² of the same mean and variance
    /// (Satterthwaite, Biometrics Bulletin 2, 1946). Its quantile is after Wilson and Hilferty, PNAS 17, 1931.
    fn from(&self, first: usize) -> Option<f64> {
        let slopes = self.slopes.rows(2 * first, 2 * (POINTS - first));
        let each = 20.0 / (POINTS - first) as f64;
        let form = slopes.tr_mul(&slopes) * &self.covariance * each;
        let mean = form.trace();
        let freedom = mean * mean / (&form * &form).trace();
        let part = 2.0 / (9.0 * freedom);
        let cost = mean * (1.0 - part + ONE_IN_TEN * part.sqrt()).powi(3);
        Some(cost).filter(|cost| cost.is_finite())
    }
}

/// Frequency of a point, rad/s.
fn radps_of(point: usize) -> f64 {
    FIRST_RADPS * (LAST_RADPS / FIRST_RADPS).powf(point as f64 / (POINTS - 1) as f64)
}

/// Difference of two responses at a frequency, in dB and in weighted degrees.
fn apart(one: Complex<f64>, other: Complex<f64>) -> [f64; 2] {
    let ratio = (one / other).ln();
    [20.0 / LN_10 * ratio.re, PHASE_WEIGHT.sqrt() * 360.0 / TAU * ratio.im]
}

/// Cost J of one response against another.
fn cost(one: &[Complex<f64>], other: &[Complex<f64>]) -> f64 {
    let squares = one.iter().zip(other).flat_map(|(one, other)| apart(*one, *other));
    20.0 / POINTS as f64 * squares.map(|part| part * part).sum::<f64>()
}
