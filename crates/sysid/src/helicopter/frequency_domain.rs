//! The same helicopter from the same flight in the frequency domain: a second opinion.

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

/// What the responses are taken to: rates, and what accelerometers at the centre of gravity feel.
///
/// Attitude and velocity are the integrals of these and say nothing more, but what they had before a window
/// of some seconds lasts through it.
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
    /// Where its state's rate of change is meant: less this term of kinematics, plus this tilt times
    /// gravity.
    felt: Option<(&'static str, &'static str, f64)>,
}

impl Output {
    /// What the record has of it; `None` where a signal is missing.
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

/// The slowest movement a test point of ten seconds holds, Hz, and the fastest a step still excites.
const FIRST_HZ: f64 = 0.15;
const LAST_HZ: f64 = 4.0;
/// Frequencies of the spectra, and of the fit.
const SPECTRAL_POINTS: usize = 160;
const FIT_POINTS: usize = 32;
/// A response is fitted where so many of them are coherent.
const LEAST_POINTS: usize = 8;
/// Where a stick has less than this part of the power it has beside, nothing is fitted.
const GAP: f64 = 0.1;
/// Least span of a stick, and of what was injected on it, that says something, of full travel.
const LEAST_MOVE: f64 = 0.02;
/// A parameter whose bound is more than this part of it is not told by the responses; of a delay, s.
const UNTOLD: f64 = 1.0;
const UNTOLD_DELAY_S: f64 = 0.03;
/// A search ends where this part of the cost is left to gain.
const LEAST_DECREASE: f64 = 1e-4;
/// How many sigma the methods may be apart by chance.
const APART: f64 = 3.0;

/// What the responses rest on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Basis {
    /// The sticks themselves, over the test points: right where nobody answers gusts with them.
    Sticks,
    /// What was injected beside a controller, over all of the flight near a hover.
    Injected,
}

impl Basis {
    /// Coherence of a point that is fitted. Tischler and Remple's 0.6 for the sticks, as what answers the
    /// vehicle is coherent too; of what was injected a low coherence says that gusts drown it, for which it is
    /// weighed down already, and steps of 1.5 s leave little more in a wind.
    const fn least_coherence(self) -> f64 {
        match self {
            Self::Sticks => 0.6,
            Self::Injected => 0.4,
        }
    }

    /// In a word.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sticks => "sticks",
            Self::Injected => "injected",
        }
    }
}

/// One parameter by both methods.
#[derive(Debug, Clone, PartialEq)]
pub struct SideBySide {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Value and bound, one sigma, in the time domain.
    pub time: (f64, f64),
    /// Value and bound, one sigma, in the frequency domain.
    pub frequency: (f64, f64),
}

impl SideBySide {
    /// How far the two are apart, in sigma of both together.
    #[must_use]
    pub fn apart(&self) -> f64 {
        (self.time.0 - self.frequency.0).abs() / self.time.1.hypot(self.frequency.1)
    }

    /// Whether they are further apart than chance allows.
    #[must_use]
    pub fn disagrees(&self) -> bool {
        self.apart() > APART
    }
}

/// How far both models are from the flight's response of one output to one stick.
#[derive(Debug, Clone, PartialEq)]
pub struct PairCost {
    /// The stick.
    pub stick: String,
    /// The output.
    pub output: String,
    /// Coherent frequencies.
    pub points: usize,
    /// Cost J of the model from the time domain.
    pub time: f64,
    /// Cost J of the model fitted to the responses.
    pub frequency: f64,
}

/// What the frequency domain makes of a flight.
#[derive(Debug, Clone, PartialEq)]
pub struct FrequencyDomain {
    /// What the responses rest on.
    pub basis: Basis,
    /// The flight's responses of all outputs to all sticks that moved, each with the other sticks taken out.
    pub measured: FrequencyResponse,
    /// What the model from the time domain makes of them, at the same frequencies.
    pub modelled: Responses,
    /// Parameters that the responses tell, by both methods.
    pub parameters: Vec<SideBySide>,
    /// Parameters that they do not tell, held at what the time domain found.
    pub untold: Vec<String>,
    /// Every response that was coherent over enough frequencies.
    pub costs: Vec<PairCost>,
    /// Mean cost of the model from the time domain, and of that fitted to the responses.
    pub mean_cost: (f64, f64),
    /// Whether the fit ended where nothing was left to gain.
    pub converged: bool,
}

impl FrequencyDomain {
    /// Fits the equations of `found` to the frequency responses of `record`, the flight it was identified
    /// from.
    ///
    /// Started at what the time domain found, and led by the responses alone. Lags of servos are held: up
    /// to 4 Hz they are delays. Parameters that the responses do not tell are held one by one, the least
    /// told first.
    ///
    /// # Errors
    /// [`FrequencyError`] where no stick moved by itself, or nothing answers it coherently.
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
    /// One sentence for each parameter of which the two methods say what chance does not explain.
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

/// The responses, and what they rest on.
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

/// The equations' responses as a flight shows them: sticks held from sample to sample, late and lagging.
struct Responder<'a> {
    identified: &'a Identified,
    kept: Vec<usize>,
    /// State, where its rate is meant tilt and gravity: places among the states kept.
    outputs: Vec<(usize, Option<(usize, f64)>)>,
    /// Places among all sticks.
    sticks: Vec<usize>,
    /// Delay and lag of each stick, indices of their parameters.
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
            // Without a tilt among the states, as of heave alone, gravity has no part in it.
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
            // What the central difference of samples makes of a rate.
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

/// `values` with `theta` in the places `free`.
fn with(values: &[f64], free: &[usize], theta: &[f64]) -> Vec<f64> {
    let mut all = values.to_vec();
    free.iter().zip(theta).for_each(|(&place, value)| all[place] = *value);
    all
}

/// Those of `free` that the responses do not tell: all that could move alone unnoticed, or else the one whose
/// bound is widest for it.
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

/// Every response of which both costs are known, on-axis first.
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
