//! `summary.json` of an identification, and what the terminal shows. No fit without its bounds.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use hovernav_log::{Dataset, Run};
use hovernav_sysid::identify::Identification;
use hovernav_sysid::prediction_error::{Estimate, Fit, Status};
use hovernav_sysid::test_points::STICKS;
use hovernav_sysid::validate::GOOD_FIT_PERCENT;
use serde::Serialize;

use super::Held;
use super::page::{bounds_in_words, correlations, fit_of};
use crate::report::Fact;
use crate::summary::{Summary as EstimateSummary, write_json};

/// The summary of `hovernav identify`: that of the estimate it stands on, and its own.
#[derive(Debug, Serialize)]
pub struct Summary {
    #[serde(flatten)]
    estimate: EstimateSummary,
    model: &'static str,
    time_domain: &'static str,
    sample_period_s: f64,
    tones_hz: Vec<f64>,
    test_points: Vec<TestPointSummary>,
    #[serde(flatten)]
    result: IdentificationSummary,
    /// The same identification from GPS velocity held from fix to fix, or why there is none.
    held_gps: HeldSummary,
}

#[derive(Debug, Serialize)]
#[serde(untagged)]
enum HeldSummary {
    Found(IdentificationSummary),
    Refused { reason: String },
}

#[derive(Debug, Serialize)]
struct TestPointSummary {
    /// `null` where several sticks moved together.
    stick: Option<&'static str>,
    start_s: f64,
    end_s: f64,
    steps: usize,
    /// `"estimation"`, `"validation"` or `"none"`.
    used_for: &'static str,
}

#[derive(Debug, Serialize)]
struct IdentificationSummary {
    converged: bool,
    iterations: usize,
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
        let estimates = &identified.estimates;
        let count = identified.structure.parameters.len();
        let named = |(one, other, value): (&str, &str, f64)| (one.into(), other.into(), value);
        Self {
            converged: identified.converged,
            iterations: identified.iterations,
            window_s: found.estimation.window_s(),
            parameters: estimates.list.iter().take(count).map(ParameterSummary::of).collect(),
            strong_correlations: correlations(found, 0.9).into_iter().map(named).collect(),
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
        let known = is_estimated(estimate);
        Self {
            name: estimate.name.clone(),
            unit: estimate.unit.clone(),
            value: estimate.value,
            status: status_name(estimate.status),
            bound: known.then_some(estimate.bound),
            bound_percent: known.then(|| estimate.bound_percent()),
            insensitivity_percent: known.then(|| estimate.insensitivity_percent()),
        }
    }
}

/// Whether the search was free to move it.
pub fn is_estimated(estimate: &Estimate) -> bool {
    matches!(estimate.status, Status::Free | Status::OnBound)
}

/// What became of a parameter, in a word or two.
pub const fn status_name(status: Status) -> &'static str {
    match status {
        Status::Free => "estimated",
        Status::OnBound => "on its limit",
        Status::Held => "held",
        Status::Dropped => "dropped",
    }
}

impl Summary {
    /// What `found` gave on `run`, the estimate of `dataset`.
    pub fn new(
        input: &Path,
        dataset: &Dataset,
        run: &Run,
        found: &Identification,
        held: Held<'_>,
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
            estimate: EstimateSummary::new(input, dataset, run, true),
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
        };
        summary.warn(found.warnings.iter().cloned());
        if found.validation.is_none() {
            let why = "no stick was tested twice: nothing is held back, the fit is not validated";
            summary.warn([why.to_owned()]);
        }
        let fit = fit_of(found);
        for channel in fit.channels().0.iter().filter(|one| one.percent < GOOD_FIT_PERCENT) {
            summary.warn([format!(
                "{} fits to {:.1} %, below the {GOOD_FIT_PERCENT} % that count as good; the noise \
                 would let a perfect model reach {:.1} %",
                channel.name, channel.percent, channel.floor_percent
            )]);
        }
        summary
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

    /// Writes `summary.json`.
    pub fn write(&self, path: &Path) -> anyhow::Result<()> {
        write_json(self, path)
    }

    /// The facts of the run, for the page and the terminal.
    pub fn facts(&self) -> Vec<Fact> {
        let count = |purpose| self.test_points.iter().filter(|p| p.used_for == purpose).count();
        let mut facts = self.estimate.facts();
        facts.push(Fact::new("model", format!("{}, continuous in time", self.model)));
        facts.push(Fact::new(
            "test points found / fitted / held back",
            format!(
                "{} / {} / {}",
                self.test_points.len(),
                count("estimation"),
                count("validation")
            ),
        ));
        facts.push(Fact::new("sample period", format!("{:.4} s", self.sample_period_s)));
        if !self.tones_hz.is_empty() {
            let tones: Vec<String> = self.tones_hz.iter().map(|hz| format!("{hz:.1}")).collect();
            facts.push(Fact::new("vibration notched out", format!("{} Hz", tones.join(", "))));
        }
        let result = &self.result;
        let end = if result.converged { "converged" } else { "not converged" };
        facts.push(Fact::new("search", format!("{} linearisations, {end}", result.iterations)));
        facts
    }

    /// What the terminal shows.
    pub fn in_words(
        &self,
        found: &Identification,
        held: Option<&Identification>,
        out: &Path,
    ) -> String {
        let mut text = String::new();
        for fact in self.facts() {
            let _ = writeln!(text, "{:<40} {}", fact.label, fact.value);
        }
        let fit = fit_of(found);
        let on = if found.validation.is_some() { "held-back" } else { "fitted" };
        let _ = writeln!(
            text,
            "\n{:<12} {:>9} {:>12} {:>12} {:>14}",
            "output", "fit %", "noise floor", "residual", "held GPS fit %"
        );
        for channel in fit.channels().0 {
            let mut channels = held.into_iter().flat_map(|held| fit_of(held).channels().0);
            let other = channels.find(|other| other.name == channel.name);
            let other = other.map_or_else(|| "–".into(), |other| format!("{:.1}", other.percent));
            let _ = writeln!(
                text,
                "{:<12} {:>9.1} {:>12.1} {:>12.4} {:>14}",
                channel.name, channel.percent, channel.floor_percent, channel.residual_rms, other
            );
        }
        let window_s = fit.window_s();
        let _ = writeln!(text, "(free runs of {window_s:.1} s over {on} test points)");
        let _ = writeln!(text, "bounds of the parameters, 1σ: {}\n", bounds_in_words(found));
        let count = found.identified.structure.parameters.len();
        let _ = writeln!(
            text,
            "{:<10} {:>11} {:<10} {:>10} {:>8} {:>14}",
            "parameter", "value", "unit", "bound 1σ", "bound %", "insensitivity %"
        );
        for estimate in found.identified.estimates.list.iter().take(count) {
            let _ = write!(
                text,
                "{:<10} {:>11.4} {:<10} ",
                estimate.name, estimate.value, estimate.unit
            );
            let _ = if is_estimated(estimate) {
                let on_limit =
                    if estimate.status == Status::OnBound { "  on its limit" } else { "" };
                writeln!(
                    text,
                    "{:>10.4} {:>8.1} {:>14.1}{on_limit}",
                    estimate.bound,
                    estimate.bound_percent(),
                    estimate.insensitivity_percent()
                )
            } else {
                writeln!(text, "{:>10}", status_name(estimate.status))
            };
        }
        for (one, other, value) in &self.result.strong_correlations {
            let _ = writeln!(text, "correlation of {one} and {other}: {value:.3}");
        }
        let _ = writeln!(text);
        for warning in self.warnings() {
            let _ = writeln!(text, "warning: {warning}");
        }
        let wall_s = self.estimate.wall_s;
        let _ = writeln!(text, "{:<40} {} ({wall_s:.3} s)", "written", out.display());
        text
    }
}
