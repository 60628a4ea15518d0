//! `summary.json` of an identification.

use std::collections::BTreeMap;
use std::path::Path;

use hovernav_log::{Dataset, Run};
use hovernav_model::{Grade, Verdict};
use hovernav_sysid::helicopter::{FrequencyDomain, Identification, IdentifyError};
use hovernav_sysid::methods::frequency::FrequencyError;
use hovernav_sysid::methods::prediction_error::{Estimate, Fit};
use hovernav_sysid::methods::validate::GOOD_FIT_PERCENT;
use hovernav_sysid::record::STICKS;
use serde::Serialize;

use crate::summary::RunSummary;

/// The summary of `hovernav identify`: that of the estimate it stands on, and its own.
#[derive(Debug, Serialize)]
pub struct Summary {
    #[serde(flatten)]
    pub(super) estimate: RunSummary,
    pub(super) model: &'static str,
    time_domain: &'static str,
    pub(super) sample_period_s: f64,
    pub(super) tones_hz: Vec<f64>,
    pub(super) test_points: Vec<TestPointSummary>,
    #[serde(flatten)]
    pub(super) result: IdentificationSummary,
    /// The same identification from GPS velocity held from fix to fix, or why there is none.
    held_gps: HeldSummary,
    /// The same flight asked in the frequency domain, or why it says nothing there.
    frequency_domain: FrequencySummary,
    /// How far the model can be trusted.
    pub(super) verdict: Grade,
    /// Why not further.
    pub(super) reasons: Vec<String>,
    /// What is identified and how well, over the held-back flight where there is any: percent.
    fit: BTreeMap<String, f64>,
}

#[derive(Debug, Serialize)]
#[serde(untagged)]
enum HeldSummary {
    Found(IdentificationSummary),
    Refused { reason: String },
}

#[derive(Debug, Serialize)]
#[serde(untagged)]
enum FrequencySummary {
    Found(Box<FrequencyFindings>),
    Refused { reason: String },
}

#[derive(Debug, Serialize)]
struct FrequencyFindings {
    /// `"sticks"` or `"injected"`: what the responses rest on.
    basis: &'static str,
    converged: bool,
    /// Mean cost J of the model from the time domain, and of that fitted to the responses.
    cost: Costs,
    parameters: Vec<BothSummary>,
    /// Parameters that the responses do not tell.
    untold: Vec<String>,
    pairs: Vec<PairSummary>,
}

#[derive(Debug, Serialize)]
struct Costs {
    time_domain: f64,
    frequency_domain: f64,
}

#[derive(Debug, Serialize)]
struct BothSummary {
    name: String,
    unit: String,
    time_domain: f64,
    time_domain_bound: f64,
    frequency_domain: f64,
    frequency_domain_bound: f64,
    apart_sigma: f64,
}

#[derive(Debug, Serialize)]
struct PairSummary {
    stick: String,
    output: String,
    points: usize,
    cost: Costs,
}

impl FrequencyFindings {
    fn of(found: &FrequencyDomain) -> Self {
        let costs = |(time_domain, frequency_domain)| Costs { time_domain, frequency_domain };
        Self {
            basis: found.basis.name(),
            converged: found.converged,
            cost: costs(found.mean_cost),
            parameters: found
                .parameters
                .iter()
                .map(|own| BothSummary {
                    name: own.name.clone(),
                    unit: own.unit.clone(),
                    time_domain: own.time.0,
                    time_domain_bound: own.time.1,
                    frequency_domain: own.frequency.0,
                    frequency_domain_bound: own.frequency.1,
                    apart_sigma: own.apart(),
                })
                .collect(),
            untold: found.untold.clone(),
            pairs: found
                .costs
                .iter()
                .map(|pair| PairSummary {
                    stick: pair.stick.clone(),
                    output: pair.output.clone(),
                    points: pair.points,
                    cost: costs((pair.time, pair.frequency)),
                })
                .collect(),
        }
    }
}

#[derive(Debug, Serialize)]
pub(super) struct TestPointSummary {
    /// `null` where several sticks moved together.
    stick: Option<&'static str>,
    start_s: f64,
    end_s: f64,
    steps: usize,
    /// `"estimation"`, `"validation"` or `"none"`.
    pub(super) used_for: &'static str,
}

#[derive(Debug, Serialize)]
pub(super) struct IdentificationSummary {
    pub(super) converged: bool,
    pub(super) iterations: usize,
    window_s: f64,
    parameters: Vec<ParameterSummary>,
    strong_correlations: Vec<(String, String, f64)>,
    /// Which parameters were dropped or kept, and why.
    log: Vec<String>,
    estimation: BTreeMap<String, ChannelSummary>,
    /// On test points the search never saw; `null` where there were too few.
    validation: Option<BTreeMap<String, ChannelSummary>>,
}

#[derive(Debug, Serialize)]
struct ParameterSummary {
    name: String,
    unit: String,
    value: f64,
    status: &'static str,
    /// Cramér–Rao bound, one sigma; `null` where the parameter was not estimated.
    bound: Option<f64>,
    bound_percent: Option<f64>,
    insensitivity_percent: Option<f64>,
}

#[derive(Debug, Serialize)]
struct ChannelSummary {
    fit_percent: f64,
    /// What a perfect model would reach against the identified noise.
    noise_floor_percent: f64,
    residual_rms: f64,
}

impl IdentificationSummary {
    fn of(found: &Identification) -> Self {
        let identified = &found.identified;
        let named = |(one, other, value): (&str, &str, f64)| (one.into(), other.into(), value);
        Self {
            converged: identified.converged,
            iterations: identified.iterations,
            window_s: found.estimation.window_s(),
            parameters: found.parameters().iter().map(ParameterSummary::of).collect(),
            strong_correlations: found.strong_correlations(0.9).into_iter().map(named).collect(),
            log: identified.log.clone(),
            estimation: channels(&found.estimation),
            validation: found.validation.as_ref().map(channels),
        }
    }
}

fn channels(fit: &Fit) -> BTreeMap<String, ChannelSummary> {
    let channels = fit.channels().0.iter().map(|channel| {
        let summary = ChannelSummary {
            fit_percent: channel.percent,
            noise_floor_percent: channel.floor_percent,
            residual_rms: channel.residual_rms,
        };
        (channel.name.clone(), summary)
    });
    channels.collect()
}

impl ParameterSummary {
    fn of(estimate: &Estimate) -> Self {
        let known = estimate.is_estimated();
        Self {
            name: estimate.name.clone(),
            unit: estimate.unit.clone(),
            value: estimate.value,
            status: estimate.status.name(),
            bound: known.then_some(estimate.bound),
            bound_percent: known.then(|| estimate.bound_percent()),
            insensitivity_percent: known.then(|| estimate.insensitivity_percent()),
        }
    }
}

impl Summary {
    /// What `found` gave on `run`, the estimate of `dataset`.
    pub fn new(
        input: &Path,
        dataset: &Dataset,
        run: &Run,
        found: &Identification,
        held: Result<&Identification, &IdentifyError>,
        verdict: Verdict,
    ) -> Self {
        let used_for = |index: usize| match index {
            _ if found.estimation_points.contains(&index) => "estimation",
            _ if found.validation_points.contains(&index) => "validation",
            _ => "none",
        };
        let points = found.test_points.iter().enumerate().map(|(index, point)| TestPointSummary {
            stick: point.stick.map(|stick| STICKS[stick]),
            start_s: point.start.seconds(),
            end_s: point.end.seconds(),
            steps: point.steps,
            used_for: used_for(index),
        });
        let mut summary = Self {
            estimate: RunSummary::new(input, dataset, run, true),
            model: found.kind.name(),
            time_domain: "continuous",
            sample_period_s: found.identified.period_s,
            tones_hz: found.tones.iter().map(|tone| tone.frequency_hz).collect(),
            test_points: points.collect(),
            result: IdentificationSummary::of(found),
            held_gps: match held {
                Ok(held) => HeldSummary::Found(IdentificationSummary::of(held)),
                Err(error) => HeldSummary::Refused { reason: error.to_string() },
            },
            frequency_domain: FrequencySummary::Refused { reason: "it was not asked".into() },
            verdict: verdict.grade,
            reasons: verdict.reasons,
            fit: found
                .fit()
                .channels()
                .0
                .iter()
                .map(|one| (one.name.clone(), one.percent))
                .collect(),
        };
        summary.warn(found.warnings.iter().cloned());
        if found.validation.is_none() {
            let why = "no stick was tested twice: nothing is held back, the fit is not validated";
            summary.warn([why.to_owned()]);
        }
        let fit = found.fit();
        for channel in fit.channels().0.iter().filter(|one| one.percent < GOOD_FIT_PERCENT) {
            let (name, percent, floor) = (&channel.name, channel.percent, channel.floor_percent);
            let fits = format!("{name} fits to {percent:.1} %");
            let below = format!("below the {GOOD_FIT_PERCENT} % that count as good");
            summary.warn([if floor <= 0.0 {
                let window_s = fit.window_s();
                format!(
                    "{fits}, which says nothing: within {window_s:.0} s gusts and noise move it more than the sticks do"
                )
            } else if percent >= floor {
                format!("{fits}, {below}, and as well as gusts and noise let a perfect model")
            } else {
                format!("{fits}, {below}; gusts and noise would let a perfect model reach {floor:.1} %")
            }]);
        }
        summary
    }

    /// With what the frequency domain says.
    pub fn ask_frequency(&mut self, found: Result<&FrequencyDomain, &FrequencyError>) {
        self.frequency_domain = match found {
            Ok(found) => {
                self.warn(found.disagreements());
                FrequencySummary::Found(Box::new(FrequencyFindings::of(found)))
            }
            Err(error) => {
                self.warn([format!("the frequency domain has no second opinion: {error}")]);
                FrequencySummary::Refused { reason: error.to_string() }
            }
        };
    }

    /// Adds what deserves a second look.
    pub fn warn(&mut self, warnings: impl IntoIterator<Item = String>) {
        self.estimate.warnings.extend(warnings);
    }

    /// What deserves a second look.
    pub fn warnings(&self) -> &[String] {
        &self.estimate.warnings
    }

    /// Says how long it all took.
    pub fn set_wall(&mut self, wall_s: f64) {
        self.estimate.wall_s = wall_s;
    }
}
