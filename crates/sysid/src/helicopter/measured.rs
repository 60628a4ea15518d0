//! The flight's frequency responses, and the fit of a model's parameters to them.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use nalgebra::DMatrix;

use super::bandwidth::{bandwidth_hz, moving};
use super::flight::{FlightRecord, INJECTED};
use super::outputs::{OUTPUTS, Output};
use super::responder::Responder;
use super::side_by_side::{PairCost, SideBySide};
use super::stretches;
use crate::methods::frequency::{
    Band, FrequencyError, FrequencyResponse, ResponseFit, ResponseFitSettings, ResponseSettings,
    Responses, fit_response, joint_response, response_costs,
};
use crate::methods::prediction_error::Identified;
use crate::methods::structure::Structure;
use crate::record::{Experiment, STICKS, TestPoint};

/// Lowest frequency that a test point of ten seconds contains, Hz.
const FIRST_HZ: f64 = 0.15;
/// Highest frequency that a step still excites, Hz.
const LAST_HZ: f64 = 4.0;
/// Highest excited frequency, Hz, above which a lag is separable from a delay.
const LAG_HZ: f64 = 8.0;
/// Number of frequencies of the spectra.
const SPECTRAL_POINTS: usize = 160;
/// Number of frequencies of the fit.
const FIT_POINTS: usize = 32;
/// Smallest number of coherent frequencies at which a response is fitted.
const MIN_POINTS: usize = 8;
/// Fraction of a stick's power at neighbouring frequencies below which a frequency is not fitted.
const GAP: f64 = 0.1;
/// Largest uncertainty of a parameter, as a fraction of its value, with which it is identifiable from the responses.
/// Applies to Cramér–Rao bound and insensitivity.
const UNIDENTIFIED: f64 = 1.0;
/// Largest uncertainty of a delay, s, with which it is identifiable from the responses. Applies to Cramér–Rao bound and
/// insensitivity.
const UNIDENTIFIED_DELAY_S: f64 = 0.03;
/// Cramér–Rao bound, as a fraction of the prior's sigma, above which the responses add no information to the prior.
const PRIOR: f64 = 0.9;
/// Response of an output to a stick, as a fraction of its largest response to any stick, below which it is rounding.
const ROUNDING: f64 = 1e-12;
/// Relative decrease of the cost below which the search stops.
const MIN_DECREASE: f64 = 1e-4;

/// Excitation from which the responses are computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Basis {
    /// The sticks themselves, over the test points. Valid where no feedback moves the sticks against gusts.
    Sticks,
    /// The movement injected in addition to a controller's, over all flight in the condition.
    Injected,
}

impl Basis {
    /// Smallest coherence of a frequency point to fit. For sticks it is Tischler and Remple's 0.6, because feedback is
    /// coherent too. Low coherence of injected movement means that gusts dominate, and the fit already weights such
    /// points down. In wind, steps of 1.5 s rarely reach a higher coherence.
    const fn min_coherence(self) -> f64 {
        match self {
            Self::Sticks => 0.6,
            Self::Injected => 0.4,
        }
    }

    /// Name of the basis in files and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sticks => "sticks",
            Self::Injected => "injected",
        }
    }
}

/// The flight's frequency responses, and how they are fitted.
#[derive(Debug, Clone)]
pub(super) struct Measured {
    pub basis: Basis,
    /// Responses at every frequency of the spectra.
    pub all: FrequencyResponse,
    /// The responses at the frequencies of the fit.
    fitted: FrequencyResponse,
    /// Sample period of the responses, s.
    period_s: f64,
    /// Whether the flight excites frequencies at which lags are separable from delays.
    has_lags: bool,
}

/// A model fitted to the responses.
pub(super) struct Fitted {
    /// Index of each of `parameters` in the structure.
    pub places: Vec<usize>,
    /// Parameters identifiable from the responses, with their values in the initial model and in the fit.
    pub parameters: Vec<SideBySide>,
    /// Parameters not identifiable from the responses. They are fixed at their initial values, or their bound is hardly
    /// below the sigma of the prior.
    pub untold: Vec<String>,
    /// Costs of every response that was coherent at enough frequencies.
    pub costs: Vec<PairCost>,
    /// Mean cost of the initial model, and of the fit.
    pub mean_cost: (f64, f64),
    /// Whether the fit converged.
    pub converged: bool,
    /// Responses of the initial model at every frequency of the spectra.
    pub modelled: Responses,
}

impl Fitted {
    /// Whether the parameter at index `place` of `structure` is the delay of a stick with a fixed lag. Up to 4 Hz only
    /// the sum of delay and lag is known. The bound of the delay is then valid for this lag only.
    pub fn depends_on_lag(&self, structure: &Structure, place: usize) -> bool {
        let pairs = structure.delays.iter().zip(&structure.lags);
        let mut lags =
            pairs.filter(|(delay, _)| **delay == Some(place)).filter_map(|(_, lag)| *lag);
        lags.any(|lag| !self.places.contains(&lag))
    }
}

impl Measured {
    /// The responses of the outputs of `structure` to its sticks. The data are the test points or all flight in
    /// its condition, without the test points `held_back`.
    ///
    /// # Errors
    /// [`FrequencyError`] where no stick moved independently.
    pub fn of(
        structure: &Structure,
        points: &[TestPoint],
        held_back: &[&TestPoint],
        record: &FlightRecord,
    ) -> Result<Self, FrequencyError> {
        let all = &record.experiment;
        let injected = moving(all, &INJECTED);
        let has_test = |stick: &&str| {
            let place = STICKS.iter().position(|own| own == stick);
            place.is_some_and(|place| injected.contains(&INJECTED[place]))
        };
        let mut sticks = moving(all, &structure.inputs_of_pilot().collect::<Vec<_>>());
        let tested: Vec<&str> = sticks.iter().copied().filter(has_test).collect();
        let basis = if tested.is_empty() { Basis::Sticks } else { Basis::Injected };
        let own = &structure.outputs;
        let outputs: Vec<&Output> =
            OUTPUTS.iter().filter(|output| own.iter().any(|known| known == output.state)).collect();
        let output_names: Vec<String> = outputs.iter().map(|one| one.name.to_owned()).collect();
        if outputs.is_empty() {
            let reason = "the model has neither rates nor velocities".to_owned();
            return Err(FrequencyError::Experiments { reason });
        }
        let (pieces, references) = match basis {
            Basis::Sticks => {
                let used = points.iter().filter(|point| !held_back.contains(point));
                (used.filter_map(|point| record.cut(point).ok()).collect(), &[][..])
            }
            Basis::Injected => {
                sticks = tested;
                (stretches::stretches(record, held_back).unwrap_or_default(), &injected[..])
            }
        };
        let inputs = [references, &sticks].concat();
        let input_names: Vec<String> = inputs.iter().map(|&name| name.to_owned()).collect();
        let pieces: Vec<Experiment> = pieces
            .iter()
            .filter_map(|piece: &Experiment| {
                let moved: Option<Vec<_>> =
                    inputs.iter().map(|name| piece.signal(name).ok()).collect();
                let seen: Option<Vec<_>> = outputs.iter().map(|one| one.measured(piece)).collect();
                let (inputs, outputs) = (moved?, seen?);
                Some(Experiment {
                    name: piece.name.clone(),
                    period_s: piece.period_s,
                    input_names: input_names.clone(),
                    output_names: output_names.clone(),
                    inputs: DMatrix::from_columns(&inputs),
                    outputs: DMatrix::from_columns(&outputs),
                    is_smooth: piece.is_smooth,
                })
            })
            .map(|piece| piece.detrended())
            .collect();
        let longest_s = pieces.iter().map(Experiment::duration_s).fold(0.0, f64::max);
        let last_hz = LAST_HZ.max(bandwidth_hz(all)).min(0.4 / all.period_s);
        let band = Band { first_hz: FIRST_HZ, last_hz, points: SPECTRAL_POINTS };
        let settings = ResponseSettings::composite(band, 2.0 * longest_s);
        let all = joint_response(&pieces, references, &settings)?;
        let fitted = all.clone().without_gaps(GAP).logarithmic(FIT_POINTS);
        let period_s = record.experiment.period_s;
        Ok(Self { basis, all, fitted, period_s, has_lags: last_hz > LAG_HZ })
    }

    /// The responses that `part` of the structure models.
    pub fn of_part(&self, part: &Structure) -> Self {
        let is_own = |name: &str| {
            let state = OUTPUTS.iter().find(|output| output.name == name).map(|own| own.state);
            state.is_some_and(|state| part.outputs.iter().any(|own| own == state))
        };
        let is_stick = |name: &str| part.inputs_of_pilot().any(|own| own == name);
        let select = |of: &FrequencyResponse| of.selected(is_own, is_stick);
        Self { all: select(&self.all), fitted: select(&self.fitted), ..self.clone() }
    }

    fn settings(&self, structure: &Structure, free: &[usize]) -> ResponseFitSettings {
        ResponseFitSettings {
            min_coherence: self.basis.min_coherence(),
            min_points: MIN_POINTS,
            min_decrease: MIN_DECREASE,
            lower: free.iter().map(|&one| structure.parameters[one].lower).collect(),
            upper: free.iter().map(|&one| structure.parameters[one].upper).collect(),
            ..ResponseFitSettings::default()
        }
    }

    /// The free parameters of `identified` fitted to the responses, from its values.
    ///
    /// # Errors
    /// [`FrequencyError`] where too few points are coherent.
    pub fn fit(&self, identified: &Identified) -> Result<Fitted, FrequencyError> {
        let structure = &identified.structure;
        let model = Responder::new(identified, &self.fitted, self.period_s);
        let start = identified.values();
        let mut measured = self.fitted.clone();
        let radps: Vec<f64> = self.all.frequencies_hz.iter().map(|hz| TAU * hz).collect();
        let (outputs, inputs) = (measured.output_names.len(), measured.input_names.len());
        let modelled = model.at(&start, &radps).ok_or(FrequencyError::Start { outputs, inputs })?;
        // A stick without effect on an output has a response of rounding errors, and zero at some frequencies.
        let largest =
            |at: (usize, usize)| modelled.iter().map(|own| own[at].norm()).fold(0.0, f64::max);
        let of_output =
            |output| (0..inputs).map(|input| largest((output, input))).fold(0.0, f64::max);
        measured.ignore(|at| largest(at) <= ROUNDING * of_output(at.0));
        let lags: BTreeSet<usize> = structure.lags.iter().flatten().copied().collect();
        let mut free: Vec<usize> = identified
            .free_parameters()
            .filter(|own| self.has_lags || !lags.contains(own))
            .collect();
        if free.is_empty() {
            let reason = "the model has no free parameter besides lags".to_owned();
            return Err(FrequencyError::Experiments { reason });
        }
        let mut untold = Vec::new();
        let mut values = start.clone();
        // The first fit has no priors. Its misfit gives the unit in which the next fits weight the priors.
        let mut unit = None;
        let fit = loop {
            let own: Vec<f64> = free.iter().map(|&one| values[one]).collect();
            let mut settings = self.settings(structure, &free);
            let priors = free.iter().enumerate().filter_map(|(place, &one)| {
                let (value, sigma) = structure.parameters[one].prior?;
                Some((place, value, sigma / unit?))
            });
            settings.known = priors.collect();
            let fit = fit_response(&measured, &own, &settings, |theta, radps| {
                model.at(&with(&values, &free, theta), radps)
            })?;
            if unit.replace(fit.unit).is_none() {
                continue;
            }
            values = with(&values, &free, &fit.parameters);
            let drowned = least_determined(identified, &free, &fit);
            if drowned.is_empty() || drowned.len() == free.len() {
                break fit;
            }
            free.retain(|parameter| !drowned.contains(parameter));
            for &parameter in &drowned {
                values[parameter] = start[parameter];
                untold.push(structure.parameters[parameter].name.clone());
            }
        };
        let bounds = self.bounds(identified, &measured, &values, &free, fit.unit)?;
        let settings = self.settings(structure, &[]);
        let costs =
            response_costs(&measured, &start, &settings, |theta, radps| model.at(theta, radps))?;
        let (mut places, mut parameters) = (Vec::new(), Vec::new());
        for (&one, (&value, &bound)) in free.iter().zip(fit.parameters.iter().zip(&bounds)) {
            let estimate = &identified.estimates.list[one];
            let prior = structure.parameters[one].prior;
            if prior.is_some_and(|(_, sigma)| bound > PRIOR * sigma) {
                untold.push(estimate.name.clone());
                continue;
            }
            let (name, unit) = (estimate.name.clone(), estimate.unit.clone());
            let time = (estimate.value, estimate.bound);
            places.push(one);
            parameters.push(SideBySide { name, unit, time, frequency: (value, bound) });
        }
        Ok(Fitted {
            parameters,
            places,
            untold,
            costs: pairs(&measured, &costs.each, &fit),
            mean_cost: (costs.mean, fit.costs.mean),
            converged: fit.converged,
            modelled,
        })
    }
}

impl Measured {
    /// Bounds of the parameters `free` at the fitted `values`. A parameter that the fit has fixed is known from the time
    /// domain alone, with its bound there. This bound widens those of the parameters that can replace it.
    fn bounds(
        &self,
        identified: &Identified,
        measured: &FrequencyResponse,
        values: &[f64],
        free: &[usize],
        unit: f64,
    ) -> Result<Vec<f64>, FrequencyError> {
        let structure = &identified.structure;
        let fixed = identified.free_parameters().filter(|own| !free.contains(own));
        let all: Vec<usize> = free.iter().copied().chain(fixed).collect();
        let known = all.iter().enumerate().filter_map(|(place, &one)| {
            let time = (values[one], identified.estimates.list[one].bound);
            let is_fixed = place >= free.len();
            let (value, sigma) = if is_fixed { time } else { structure.parameters[one].prior? };
            (sigma > 0.0).then_some((place, value, sigma / unit))
        });
        let settings = ResponseFitSettings {
            known: known.collect(),
            iterations: 1,
            ..self.settings(structure, &all)
        };
        let model = Responder::new(identified, measured, self.period_s);
        let own: Vec<f64> = all.iter().map(|&one| values[one]).collect();
        let fit = fit_response(measured, &own, &settings, |theta, radps| {
            model.at(&with(values, &all, theta), radps)
        })?;
        Ok(fit.bounds)
    }
}

/// `values` with `theta` at the indices `free`.
fn with(values: &[f64], free: &[usize], theta: &[f64]) -> Vec<f64> {
    let mut all = values.to_vec();
    free.iter().zip(theta).for_each(|(&place, value)| all[place] = *value);
    all
}

/// Parameters of `free` that are not identifiable from the responses: the first of three groups that is not empty. The
/// first group is on a limit of its range, which distorts the others; delays are exempt. The second has too large an
/// insensitivity. The third is the parameter with the widest bound, if this is too wide. Parameters with a prior are
/// exempt from the last two groups.
fn least_determined(identified: &Identified, free: &[usize], fit: &ResponseFit) -> Vec<usize> {
    let is_on_limit = |(parameter, value): (&usize, &f64)| {
        let own = &identified.structure.parameters[*parameter];
        let is_delay = identified.structure.delays.contains(&Some(*parameter));
        (!is_delay && (*value <= own.lower || *value >= own.upper)).then_some(*parameter)
    };
    let on_limit: Vec<usize> = free.iter().zip(&fit.parameters).filter_map(is_on_limit).collect();
    if !on_limit.is_empty() {
        return on_limit;
    }
    let checks = |spread: &[f64]| -> Vec<(usize, f64)> {
        let own = free.iter().zip(fit.parameters.iter().zip(spread));
        let own = own.filter(|(one, _)| identified.structure.parameters[**one].prior.is_none());
        let checks = own.map(|(&parameter, (value, spread))| {
            let is_delay = identified.structure.delays.contains(&Some(parameter));
            let relative_bound =
                spread / if is_delay { UNIDENTIFIED_DELAY_S } else { UNIDENTIFIED * value.abs() };
            (parameter, if relative_bound.is_nan() { f64::INFINITY } else { relative_bound })
        });
        checks.filter(|(_, relative_bound)| *relative_bound > 1.0).collect()
    };
    let unseen = checks(&fit.insensitivities);
    if !unseen.is_empty() {
        return unseen.into_iter().map(|(parameter, _)| parameter).collect();
    }
    let worst = checks(&fit.bounds).into_iter().max_by(|one, other| one.1.total_cmp(&other.1));
    worst.map(|(parameter, _)| parameter).into_iter().collect()
}

/// Costs of every response with coherent points, in the order of the sticks.
fn pairs(measured: &FrequencyResponse, time: &DMatrix<f64>, fit: &ResponseFit) -> Vec<PairCost> {
    let mut pairs = Vec::new();
    for (input, stick) in measured.input_names.iter().enumerate() {
        for (output, name) in measured.output_names.iter().enumerate() {
            let points = fit.costs.points[(output, input)];
            if points > 0 {
                let (time, frequency) = (time[(output, input)], fit.costs.each[(output, input)]);
                let (stick, output) = (stick.clone(), name.clone());
                pairs.push(PairCost { stick, output, points, time, frequency });
            }
        }
    }
    pairs.sort_by_key(|pair| STICKS.iter().position(|stick| *stick == pair.stick));
    pairs
}
