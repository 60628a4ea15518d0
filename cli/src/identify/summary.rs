//! `summary.json` of an identification.

use std::collections::BTreeMap;
use std::path::Path;

use hovernav_dataset::Dataset;
use hovernav_findings::findings;
use hovernav_formats::RunSummary;
use hovernav_model::{Grade, Verdict};
use hovernav_replay::Run;
use hovernav_sysid::helicopter::{FrequencyDomain, Identification, IdentifyError};
use hovernav_sysid::methods::frequency::FrequencyError;
use hovernav_sysid::methods::prediction_error::{Estimate, Fit};
use hovernav_sysid::methods::validate::GOOD_FIT_PERCENT;
use hovernav_sysid::record::STICKS;
use serde::Serialize;

/// The summary of `hovernav identify`: the summary of the estimate it uses, and its own results.
#[derive(Debug, Serialize)]
pub struct Summary {
    #[serde(flatten)]
    pub(super) estimate: RunSummary,
    pub(super) model: String,
    time_domain: &'static str,
    pub(super) sample_period_s: f64,
    pub(super) tones_hz: Vec<f64>,
    /// Dead band of each stick's servo, in the stick's unit.
    pub(super) dead_bands: [f64; 4],
    pub(super) test_points: Vec<TestPointSummary>,
    #[serde(flatten)]
    pub(super) result: IdentificationSummary,
    /// The identification from GPS velocity held between fixes, or the reason for its failure, where requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    held_gps: Option<HeldSummary>,
    /// The identification in the frequency domain, or the reason for its failure.
    frequency_domain: FrequencySummary,
    /// The verdict on the use of the model.
    pub(super) verdict: Grade,
    /// Reasons for the verdict.
    pub(super) reasons: Vec<String>,
    /// Fit of the identified quantities, percent; over the validation flight if there is one.
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
    /// Inputs of the frequency responses: `"sticks"` or `"injected"`.
    basis: &'static str,
    converged: bool,
    /// Mean cost J of the model from the time domain, and of the model fitted to the responses.
    cost: Costs,
    parameters: Vec<BothSummary>,
    /// Parameters that the frequency responses do not determine.
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
    /// `null` if several sticks moved together.
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
    /// Reasons for each dropped and kept parameter.
    log: Vec<String>,
    estimation: BTreeMap<String, ChannelSummary>,
    /// Fit on test points that the search did not use; `null` if there were too few.
    validation: Option<BTreeMap<String, ChannelSummary>>,
}

#[derive(Debug, Serialize)]
struct ParameterSummary {
    name: String,
    unit: String,
    value: f64,
    status: &'static str,
    /// Cramér–Rao bound, one sigma; `null` if the parameter was not estimated.
    bound: Option<f64>,
    bound_percent: Option<f64>,
    insensitivity_percent: Option<f64>,
}

#[derive(Debug, Serialize)]
struct ChannelSummary {
    fit_percent: f64,
    /// The fit of a perfect model, given the identified noise.
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
    /// The summary of `found`, with `run`, the estimate of `dataset`.
    pub fn new(
        input: &Path,
        dataset: &Dataset,
        run: &Run,
        found: &Identification,
        held: Option<Result<&Identification, &IdentifyError>>,
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
        let mut estimate = RunSummary::new(input, dataset, run, true);
        estimate.set_findings(findings(dataset, run), &run.solutions, None);
        let mut summary = Self {
            estimate,
            model: found.identified.structure.name.clone(),
            time_domain: "continuous",
            sample_period_s: found.identified.period_s,
            tones_hz: found.tones.iter().map(|tone| tone.frequency_hz).collect(),
            dead_bands: found.dead_bands,
            test_points: points.collect(),
            result: IdentificationSummary::of(found),
            held_gps: held.map(|held| match held {
                Ok(held) => HeldSummary::Found(IdentificationSummary::of(held)),
                Err(error) => HeldSummary::Refused { reason: error.to_string() },
            }),
            frequency_domain: FrequencySummary::Refused { reason: "not computed".into() },
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
            let why = "no stick was tested twice: no test points are left for validation, so the fit is not validated";
            summary.warn([why.to_owned()]);
        }
        let fit = found.fit();
        for channel in fit.channels().0.iter().filter(|one| one.percent < GOOD_FIT_PERCENT) {
            let (name, percent, floor) = (&channel.name, channel.percent, channel.floor_percent);
            let fits = format!("{name} fits to {percent:.1} %");
            let below = format!("below the {GOOD_FIT_PERCENT} % of a good fit");
            summary.warn([if floor <= 0.0 {
                let window_s = fit.window_s();
                format!(
                    "{fits}, which is meaningless: within {window_s:.0} s gusts and noise affect it more than the sticks do"
                )
            } else if percent >= floor {
                format!("{fits}, {below}, but a perfect model would fit no better in these gusts and noise")
            } else {
                format!("{fits}, {below}; a perfect model would reach {floor:.1} % in these gusts and noise")
            }]);
        }
        summary
    }

    /// Adds the results of the frequency domain.
    pub fn ask_frequency(&mut self, found: Result<&FrequencyDomain, &FrequencyError>) {
        self.frequency_domain = match found {
            Ok(found) => {
                self.warn(found.disagreements());
                FrequencySummary::Found(Box::new(FrequencyFindings::of(found)))
            }
            Err(error) => {
                self.warn([format!("no comparison with the frequency domain: {error}")]);
                FrequencySummary::Refused { reason: error.to_string() }
            }
        };
    }

    /// Adds points to check.
    pub fn warn(&mut self, warnings: impl IntoIterator<Item = String>) {
        self.estimate.warnings.extend(warnings);
    }

    /// The points to check.
    pub fn warnings(&self) -> &[String] {
        &self.estimate.warnings
    }

    /// Sets the wall time of the run, s.
    pub fn set_wall(&mut self, wall_s: f64) {
        self.estimate.wall_s = wall_s;
    }
}
