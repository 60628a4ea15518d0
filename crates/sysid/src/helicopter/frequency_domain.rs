//! Identification of the same helicopter from the same flight in the frequency domain, as a cross-check.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix, DVector};

use super::flight::{FlightRecord, GRAVITY_MPS2, INJECTED};
use super::identify::Identification;
use super::stretches;
use crate::methods::frequency::{
    Band, FrequencyError, FrequencyResponse, ResponseFit, ResponseFitSettings, ResponseSettings,
    Responses, fit_response, joint_response, response_costs,
};
use crate::methods::prediction_error::Identified;
use crate::record::{Experiment, STICKS};

/// Outputs of the responses: rates, and the accelerations that accelerometers at the centre of gravity measure.
///
/// Attitude and velocity are their integrals and add no information. Their initial values, however, last through a
/// window of some seconds.
const OUTPUTS: [Output; 6] = [
    Output { name: "p", state: "p", felt: None },
    Output { name: "q", state: "q", felt: None },
    Output { name: "r", state: "r", felt: None },
    Output { name: "ax", state: "u", felt: Some(("ku", "theta", GRAVITY_MPS2)) },
    Output { name: "ay", state: "v", felt: Some(("kv", "phi", -GRAVITY_MPS2)) },
    Output { name: "az", state: "w", felt: Some(("kw", "theta", 0.0)) },
];

/// An output of the responses.
struct Output {
    name: &'static str,
    state: &'static str,
    /// For an acceleration: the kinematic term to subtract from the state's rate of change, and the tilt to add, times
    /// gravity.
    felt: Option<(&'static str, &'static str, f64)>,
}

impl Output {
    /// The output in the record; `None` where a signal is missing.
    fn measured(&self, piece: &Experiment) -> Option<DVector<f64>> {
        let state = piece.signal(self.state).ok()?;
        let Some((kinematic, tilt, gravity_mps2)) = self.felt else { return Some(state) };
        let (kinematic, tilt) = (piece.signal(kinematic).ok()?, piece.signal(tilt).ok()?);
        let last = state.len().checked_sub(1)?;
        Some(DVector::from_fn(state.len(), |sample, _| {
            let (before, after) = (sample.max(1) - 1, (sample + 1).min(last));
            let rate = (state[after] - state[before]) / (2.0 * piece.period_s);
            rate - kinematic[sample] + gravity_mps2 * tilt[sample]
        }))
    }
}

/// Lowest frequency that a test point of ten seconds contains and highest that a step still excites, Hz.
const FIRST_HZ: f64 = 0.15;
const LAST_HZ: f64 = 4.0;
/// Number of frequencies of the spectra, and of the fit.
const SPECTRAL_POINTS: usize = 160;
const FIT_POINTS: usize = 32;
/// Smallest number of coherent frequencies at which a response is fitted.
const LEAST_POINTS: usize = 8;
/// Frequencies are not fitted where a stick has less than this part of the power at neighbouring frequencies.
const GAP: f64 = 0.1;
/// Smallest usable span of a stick, and of the movement injected on it, as a part of full travel.
const LEAST_MOVE: f64 = 0.02;
/// A parameter is not identifiable from the responses when its bound exceeds this part of its value; for a delay, s.
const UNTOLD: f64 = 1.0;
const UNTOLD_DELAY_S: f64 = 0.03;
/// The search stops when the relative decrease of the cost falls below this.
const LEAST_DECREASE: f64 = 1e-4;
/// Largest difference between the two methods that chance explains, in sigma.
const APART: f64 = 3.0;

/// Excitation from which the responses are computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Basis {
    /// The sticks themselves, over the test points. Valid where no feedback moves the sticks against gusts.
    Sticks,
    /// The movement injected on top of a controller's, over all flight near a hover.
    Injected,
}

impl Basis {
    /// Smallest coherence of a frequency point to fit. For sticks it is Tischler and Remple's 0.6, because feedback is
    /// coherent too. Low coherence of injected movement means that gusts dominate, and the fit already weights such
    /// points down. In wind, steps of 1.5 s rarely reach more.
    const fn least_coherence(self) -> f64 {
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

/// One parameter as identified by both methods.
#[derive(Debug, Clone, PartialEq)]
pub struct SideBySide {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Value and bound, one sigma, in the time domain.
    pub time: (f64, f64),
    /// Value and bound, one sigma, in the frequency domain.
    pub frequency: (f64, f64),
}

impl SideBySide {
    /// Difference of the two values, in sigma of both together.
    #[must_use]
    pub fn apart(&self) -> f64 {
        (self.time.0 - self.frequency.0).abs() / self.time.1.hypot(self.frequency.1)
    }

    /// Whether the difference is larger than chance allows.
    #[must_use]
    pub fn disagrees(&self) -> bool {
        self.apart() > APART
    }
}

/// Cost J of both models against the flight's response of one output to one stick.
#[derive(Debug, Clone, PartialEq)]
pub struct PairCost {
    /// The stick.
    pub stick: String,
    /// The output.
    pub output: String,
    /// Number of coherent frequencies.
    pub points: usize,
    /// Cost J of the model identified in the time domain.
    pub time: f64,
    /// Cost J of the model fitted to the responses.
    pub frequency: f64,
}

/// Identification of a flight in the frequency domain.
#[derive(Debug, Clone, PartialEq)]
pub struct FrequencyDomain {
    /// Excitation from which the responses are computed.
    pub basis: Basis,
    /// The flight's responses of all outputs to all sticks that moved, conditioned on the other sticks.
    pub measured: FrequencyResponse,
    /// Responses of the model identified in the time domain, at the same frequencies.
    pub modelled: Responses,
    /// Parameters identifiable from the responses, by both methods.
    pub parameters: Vec<SideBySide>,
    /// Parameters not identifiable from the responses, fixed at their time-domain values.
    pub untold: Vec<String>,
    /// Costs of every response that was coherent at enough frequencies.
    pub costs: Vec<PairCost>,
    /// Mean cost of the time-domain model, and of the model fitted to the responses.
    pub mean_cost: (f64, f64),
    /// Whether the fit converged.
    pub converged: bool,
}

impl FrequencyDomain {
    /// Fits the equations of `found` to the frequency responses of `record`, the flight that `found` comes from.
    ///
    /// The fit starts at the time-domain values and uses the responses alone. Servo lags are fixed, because up to 4 Hz
    /// they are equivalent to delays. Parameters that are not identifiable from the responses are fixed one by one, the
    /// least identifiable first.
    ///
    /// # Errors
    /// [`FrequencyError`] where no stick moved independently, or no output responds to one coherently.
    ///
    /// # Source
    /// Tischler & Remple, chapters 9 to 12.
    pub fn of(found: &Identification, record: &FlightRecord) -> Result<Self, FrequencyError> {
        let identified = &found.identified;
        let clean = record.without_tones(&found.tones, &[]);
        let (basis, measured) = measured(found, &clean)?;
        let model = Responder::new(identified, &measured, record.experiment.period_s);
        let start = identified.values();
        let (all, measured) =
            (measured.clone(), measured.without_gaps(GAP).logarithmic(FIT_POINTS));
        let radps: Vec<f64> = all.frequencies_hz.iter().map(|hz| TAU * hz).collect();
        let (outputs, inputs) = (measured.output_names.len(), measured.input_names.len());
        let modelled = model.at(&start, &radps).ok_or(FrequencyError::Start { outputs, inputs })?;
        let settings = |free: &[usize]| ResponseFitSettings {
            least_coherence: basis.least_coherence(),
            least_points: LEAST_POINTS,
            least_decrease: LEAST_DECREASE,
            lower: free.iter().map(|&one| identified.structure.parameters[one].lower).collect(),
            upper: free.iter().map(|&one| identified.structure.parameters[one].upper).collect(),
            ..ResponseFitSettings::default()
        };
        let lags: BTreeSet<usize> = identified.structure.lags.iter().flatten().copied().collect();
        let mut free: Vec<usize> =
            identified.free_parameters().filter(|own| !lags.contains(own)).collect();
        let mut untold = Vec::new();
        let mut values = start.clone();
        let fit = loop {
            let own: Vec<f64> = free.iter().map(|&one| values[one]).collect();
            let fit = fit_response(&measured, &own, &settings(&free), |theta, radps| {
                model.at(&with(&values, &free, theta), radps)
            })?;
            values = with(&values, &free, &fit.parameters);
            let drowned = least_told(identified, &free, &fit);
            if drowned.is_empty() || drowned.len() == free.len() {
                break fit;
            }
            free.retain(|parameter| !drowned.contains(parameter));
            for &parameter in &drowned {
                values[parameter] = start[parameter];
                untold.push(identified.structure.parameters[parameter].name.clone());
            }
        };
        let costs = response_costs(&measured, &start, &settings(&[]), |theta, radps| {
            model.at(theta, radps)
        })?;
        let parameters = free.iter().zip(fit.parameters.iter().zip(&fit.bounds));
        let parameters = parameters.map(|(&one, (&value, &bound))| {
            let estimate = &identified.estimates.list[one];
            let (name, unit) = (estimate.name.clone(), estimate.unit.clone());
            let time = (estimate.value, estimate.bound);
            SideBySide { name, unit, time, frequency: (value, bound) }
        });
        Ok(Self {
            basis,
            parameters: parameters.collect(),
            untold,
            costs: pairs(&measured, &costs.each, &fit),
            mean_cost: (costs.mean, fit.costs.mean),
            converged: fit.converged,
            measured: all,
            modelled,
        })
    }
}

impl FrequencyDomain {
    /// One sentence for each parameter whose two values differ by more than chance allows.
    pub fn disagreements(&self) -> impl Iterator<Item = String> {
        self.parameters.iter().filter(|own| own.disagrees()).map(|own| {
            let SideBySide { name, unit, time, frequency } = own;
            format!(
                "{name} is {:.3} ± {:.3} {unit} in the time domain and {:.3} ± {:.3} in the frequency domain, \
                 {:.1} sigma apart",
                time.0,
                time.1,
                frequency.0,
                frequency.1,
                own.apart()
            )
        })
    }
}

/// The flight's frequency responses, and their basis.
fn measured(
    found: &Identification,
    record: &FlightRecord,
) -> Result<(Basis, FrequencyResponse), FrequencyError> {
    let all = &record.experiment;
    let moves =
        |name: &str| all.signal(name).is_ok_and(|values| values.max() - values.min() >= LEAST_MOVE);
    let sticks: Vec<&str> =
        found.identified.structure.inputs_of_pilot().filter(|stick| moves(stick)).collect();
    let injected: Vec<&str> = INJECTED.into_iter().filter(|name| moves(name)).collect();
    let own = &found.identified.structure.outputs;
    let outputs: Vec<&Output> =
        OUTPUTS.iter().filter(|output| own.iter().any(|known| known == output.state)).collect();
    let output_names: Vec<String> = outputs.iter().map(|one| one.name.to_owned()).collect();
    let basis = if injected.len() < sticks.len() || sticks.is_empty() {
        Basis::Sticks
    } else {
        Basis::Injected
    };
    let pieces = match basis {
        Basis::Sticks => {
            found.test_points.iter().filter_map(|point| record.cut(point).ok()).collect()
        }
        Basis::Injected => stretches::stretches(record, &[]).unwrap_or_default(),
    };
    let references = if basis == Basis::Injected { &injected[..] } else { &[] };
    let inputs = [references, &sticks].concat();
    let input_names: Vec<String> = inputs.iter().map(|&name| name.to_owned()).collect();
    let pieces: Vec<Experiment> = pieces
        .iter()
        .filter_map(|piece| {
            let moved: Option<Vec<_>> = inputs.iter().map(|name| piece.signal(name).ok()).collect();
            let seen: Option<Vec<_>> = outputs.iter().map(|one| one.measured(piece)).collect();
            let (inputs, outputs) = (moved?, seen?);
            Some(Experiment {
                name: piece.name.clone(),
                period_s: piece.period_s,
                input_names: input_names.clone(),
                output_names: output_names.clone(),
                inputs: DMatrix::from_columns(&inputs),
                outputs: DMatrix::from_columns(&outputs),
            })
        })
        .map(|piece| piece.detrended())
        .collect();
    let longest_s = pieces.iter().map(Experiment::duration_s).fold(0.0, f64::max);
    let band = Band {
        first_hz: FIRST_HZ,
        last_hz: LAST_HZ.min(0.4 / all.period_s),
        points: SPECTRAL_POINTS,
    };
    let settings = ResponseSettings::composite(band, 2.0 * longest_s);
    Ok((basis, joint_response(&pieces, references, &settings)?))
}

/// Frequency responses of the equations as a flight shows them: sticks held between samples, with delay and lag.
struct Responder<'a> {
    identified: &'a Identified,
    kept: Vec<usize>,
    /// Index of the state; for an acceleration also the index of its tilt, and gravity. Indices count the kept states.
    outputs: Vec<(usize, Option<(usize, f64)>)>,
    /// Indices among all sticks.
    sticks: Vec<usize>,
    /// Indices of the delay and lag parameters of each stick.
    late: Vec<[Option<usize>; 2]>,
    period_s: f64,
}

impl<'a> Responder<'a> {
    fn new(identified: &'a Identified, measured: &FrequencyResponse, period_s: f64) -> Self {
        let structure = &identified.structure;
        let kept = identified.vehicle_states();
        let place = |name: &str| kept.iter().position(|&state| structure.states[state] == name);
        let output = |name: &String| {
            let output = OUTPUTS.iter().find(|output| output.name == name)?;
            let state = place(output.state)?;
            // Without a tilt among the states, as for heave alone, gravity has no effect.
            let felt = output.felt.map(|(_, tilt, gravity_mps2)| {
                place(tilt).map_or((state, 0.0), |t| (t, gravity_mps2))
            });
            Some((state, felt))
        };
        let of_pilot: Vec<&str> = structure.inputs_of_pilot().collect();
        let stick = |name: &String| of_pilot.iter().position(|own| own == name);
        let late = measured.input_names.iter().map(|name| {
            let input = structure.inputs.iter().position(|own| own == name);
            [&structure.delays, &structure.lags].map(|of| input.and_then(|input| of[input]))
        });
        Self {
            outputs: measured.output_names.iter().filter_map(output).collect(),
            sticks: measured.input_names.iter().filter_map(stick).collect(),
            late: late.collect(),
            identified,
            kept,
            period_s,
        }
    }

    fn at(&self, values: &[f64], radps: &[f64]) -> Option<Responses> {
        let held = self.identified.vehicle_at(values, &self.kept).held(self.period_s)?;
        let one = |&radps: &f64| {
            let whole = held.frequency_response(radps)?;
            // Gain of the central difference of samples for a rate.
            let rate = Complex::new(0.0, (radps * self.period_s).sin() / self.period_s);
            Some(DMatrix::from_fn(self.outputs.len(), self.sticks.len(), |output, stick| {
                let [delay_s, lag_s] =
                    self.late[stick].map(|of| of.map_or(0.0, |parameter| values[parameter]));
                let (state, felt) = self.outputs[output];
                let of = |state: usize| whole[(state, self.sticks[stick])];
                let answer = match felt {
                    None => of(state),
                    Some((tilt, gravity_mps2)) => of(state) * rate + of(tilt) * gravity_mps2,
                };
                answer * Complex::from_polar(1.0, -radps * delay_s)
                    / Complex::new(1.0, radps * lag_s)
            }))
        };
        radps.iter().map(one).collect()
    }
}

/// `values` with `theta` at the indices `free`.
fn with(values: &[f64], free: &[usize], theta: &[f64]) -> Vec<f64> {
    let mut all = values.to_vec();
    free.iter().zip(theta).for_each(|(&place, value)| all[place] = *value);
    all
}

/// Parameters of `free` that are not identifiable from the responses: all with too large an insensitivity, or else the
/// one with the widest bound.
fn least_told(identified: &Identified, free: &[usize], fit: &ResponseFit) -> Vec<usize> {
    let doubts = |spread: &[f64]| -> Vec<(usize, f64)> {
        let own = free.iter().zip(fit.parameters.iter().zip(spread));
        let doubts = own.map(|(&parameter, (value, spread))| {
            let is_delay = identified.structure.delays.contains(&Some(parameter));
            let doubt = spread / if is_delay { UNTOLD_DELAY_S } else { UNTOLD * value.abs() };
            (parameter, if doubt.is_nan() { f64::INFINITY } else { doubt })
        });
        doubts.filter(|(_, doubt)| *doubt > 1.0).collect()
    };
    let unseen = doubts(&fit.insensitivities);
    if !unseen.is_empty() {
        return unseen.into_iter().map(|(parameter, _)| parameter).collect();
    }
    let worst = doubts(&fit.bounds).into_iter().max_by(|one, other| one.1.total_cmp(&other.1));
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
