//! The summary of a filter run: its input and its results.

use std::collections::BTreeMap;
use std::path::Path;

use hovernav::ekf::{Innovation, Notice, Solution, Verdict as Judged};
use hovernav::ins::HeadingSource;
use hovernav_dataset::Dataset;
use hovernav_findings::{Finding, sentences};
use hovernav_replay::{ChannelTally, FixTally, Run, UnusedReadings};
use hovernav_score::{Apart, AxisScore, Score, Statistics, Verdict, set_harms};
use serde::Serialize;

#[cfg(feature = "record")]
use super::reproduction::ReproductionSummary;
use crate::difference::OnboardDifference;
use crate::onboard::InnovationSizes;

/// The summary of a filter run over a log.
#[derive(Debug, Serialize)]
pub struct RunSummary {
    tool: &'static str,
    version: &'static str,
    /// Name of the log.
    pub input: String,
    /// Time from the first to the last inertial sample, s.
    pub duration_s: f64,
    /// Wall time of the run, s; set last.
    pub wall_s: f64,
    /// Number of inertial samples.
    pub imu_samples: usize,
    /// Fixes with at least one measurement that corrected the state.
    pub gps_fixes_used: usize,
    /// Fixes with at least one measurement rejected by a gate. A partly used fix also counts in `gps_fixes_used`.
    pub gps_fixes_rejected: usize,
    /// Fixes that could not be compared with the state.
    pub gps_fixes_unusable: usize,
    /// Whether the solution also uses later measurements.
    pub smoothed: bool,
    /// The alignment, if it ended.
    pub alignment: Option<AlignmentSummary>,
    innovations: BTreeMap<&'static str, ChannelSummary>,
    reopened: Vec<Reopened>,
    /// Comparison with the solution computed in flight, for a flight record.
    #[serde(rename = "flown", skip_serializing_if = "Option::is_none")]
    #[cfg(feature = "record")]
    pub reproduction: Option<ReproductionSummary>,
    /// Difference from the solution of the onboard estimator, if the log contains one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub onboard: Option<OnboardDifference>,
    /// Innovations of the onboard estimator next to those of hovernav, if the log contains them.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub onboard_innovations: BTreeMap<&'static str, InnovationSizes>,
    /// Statistics of the error of each axis, by its name, if there is a reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<BTreeMap<&'static str, Statistics>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    within_3_sigma: Option<BTreeMap<&'static str, f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error_over_sigma: Option<BTreeMap<&'static str, f64>>,
    /// Drift in each requested span without GPS.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub outages: Vec<OutageDrift>,
    /// Statistics of the largest horizontal drift in each outage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outage_drift_m: Option<Statistics>,
    /// Choices and assumptions during reading of the log, one sentence each.
    pub notes: Vec<String>,
    /// The verdict on the solution; `None` until [`conclude`](Self::conclude).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub verdict: Option<Verdict>,
    /// Points to check, one sentence each.
    pub warnings: Vec<String>,
    /// Events with their time span and a sentence; the warnings are among them.
    pub findings: Vec<Finding>,
    /// Number of readings that were unusable because of an error in them.
    aids_unusable: UnusedReadings,
    /// Number of readings that were skipped by design.
    aids_left_out: UnusedReadings,
}

/// Time, duration and result of the alignment of the filter.
#[derive(Debug, Serialize)]
pub struct AlignmentSummary {
    /// End of the alignment, s on the log's clock.
    pub end_s: f64,
    /// Duration of the alignment, s.
    pub duration_s: f64,
    /// Source of the heading.
    pub heading: &'static str,
    /// One-sigma of the heading, °.
    pub heading_sigma_deg: f64,
    /// Time at which an initially unknown heading was found, s.
    pub heading_found_s: Option<f64>,
    /// Source of roll and pitch: `unit` (the inertial unit) or `levelled`.
    pub attitude: &'static str,
    /// Whether the vehicle was at rest during the alignment.
    pub at_rest: bool,
}

#[derive(Debug, Serialize)]
struct ChannelSummary {
    used: usize,
    rejected: usize,
    /// Mean square of the normalised innovations that were used; 1 for a consistent filter.
    mean_square: f64,
}

impl From<&ChannelTally> for ChannelSummary {
    fn from(tally: &ChannelTally) -> Self {
        let &ChannelTally { used, rejected, square_sum } = tally;
        Self { used, rejected, mean_square: square_sum / used.max(1) as f64 }
    }
}

#[derive(Debug, Serialize)]
struct Reopened {
    time_s: f64,
    channel: &'static str,
    innovation: f64,
}

/// Drift of the solution in one span without GPS.
#[derive(Debug, Serialize)]
pub struct OutageDrift {
    /// Start of the span, s on the log's clock.
    pub start_s: f64,
    /// Duration of the span, s.
    pub duration_s: f64,
    /// Largest horizontal drift, m; `None` if the reference does not cover the span.
    pub max_horizontal_m: Option<f64>,
    /// Whether the outage lies outside the log.
    #[serde(skip)]
    pub is_outside: bool,
}

impl RunSummary {
    /// The summary of a run over `dataset`, without findings, scores, verdict and wall time, which are added later.
    pub fn new(input: &Path, dataset: &Dataset, run: &Run, smoothed: bool) -> Self {
        let mut summary = Self {
            tool: "hovernav",
            version: env!("CARGO_PKG_VERSION"),
            input: input.display().to_string(),
            duration_s: dataset.sample_span().map_or(0.0, |(first, last)| last - first),
            wall_s: 0.0,
            imu_samples: dataset.sample_count(),
            gps_fixes_used: 0,
            gps_fixes_rejected: 0,
            gps_fixes_unusable: run.unusable.gps,
            smoothed,
            alignment: None,
            innovations: BTreeMap::new(),
            reopened: Vec::new(),
            #[cfg(feature = "record")]
            reproduction: None,
            onboard: None,
            onboard_innovations: BTreeMap::new(),
            error: None,
            within_3_sigma: None,
            error_over_sigma: None,
            outages: Vec::new(),
            outage_drift_m: None,
            verdict: None,
            notes: dataset.notes.clone(),
            warnings: dataset.warnings.clone(),
            findings: Vec::new(),
            aids_unusable: run.unusable,
            aids_left_out: run.skipped,
        };
        if run.solutions_thinned > 0 {
            let (kept, all) = (run.solutions.len(), run.solutions.len() + run.solutions_thinned);
            summary.notes.push(format!(
                "page, scores and findings use {kept} of {all} solutions, thinned evenly"
            ));
        }
        if run.fixes_thinned > 0 {
            summary.notes.push(format!(
                "page and findings omit {} comparisons of accepted fixes, thinned evenly; the counts include all",
                run.fixes_thinned
            ));
        }
        if run.comparisons_thinned > 0 {
            summary.notes.push(format!(
                "the page omits {} accepted measurements of other sensors, thinned evenly; the counts include all",
                run.comparisons_thinned
            ));
        }
        summary.add_notices(run);
        summary
    }

    fn add_notices(&mut self, run: &Run) {
        let FixTally { used, rejected } = run.fixes_compared;
        (self.gps_fixes_used, self.gps_fixes_rejected) = (used, rejected);
        for notice in &run.notices {
            match notice {
                Notice::Aligned(alignment) => {
                    let start = &alignment.start;
                    self.alignment = Some(AlignmentSummary {
                        end_s: start.state.time.seconds(),
                        duration_s: alignment.duration_s,
                        heading: heading_name(alignment.heading),
                        heading_sigma_deg: start.attitude_sigma_rad.z().to_degrees(),
                        heading_found_s: None,
                        attitude: if alignment.attitude_given { "unit" } else { "levelled" },
                        at_rest: alignment.at_rest,
                    });
                }
                Notice::HeadingFound { time, sigma_rad, .. } => {
                    // Only the first heading counts; a heading found later had been lost in a gap.
                    let first = self.alignment.as_mut().filter(|by| by.heading_found_s.is_none());
                    if let Some(alignment) =
                        first.filter(|by| by.heading == heading_name(HeadingSource::Unknown))
                    {
                        alignment.heading_found_s = Some(time.seconds());
                        alignment.heading_sigma_deg = sigma_rad.to_degrees();
                    }
                }
                Notice::Updated(report) => self.add_reopened(report),
                _ => {}
            }
        }
        self.innovations = run.channels.iter().map(|(name, tally)| (*name, tally.into())).collect();
    }

    /// Records the axes on which the filter was reset to the measurement.
    fn add_reopened(&mut self, report: &hovernav::ekf::Report) {
        let reopened = report.innovations().filter(|axis| axis.verdict == Judged::Reset);
        self.reopened.extend(reopened.map(|axis| Reopened {
            time_s: axis.time.seconds(),
            channel: axis.channel.name(),
            innovation: axis.innovation,
        }));
    }

    /// Sets the findings. Adds those of contradictions by an independent solution; `apart` has its distances from the
    /// `solutions` of the run. Each finding gets its harm.
    pub fn set_findings(
        &mut self,
        mut findings: Vec<Finding>,
        solutions: &[Solution],
        apart: Option<&Apart>,
    ) {
        findings.extend(apart.map(Apart::contradictions).unwrap_or_default());
        set_harms(&mut findings, solutions, apart);
        findings.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
        self.warnings.extend(sentences(&findings));
        self.findings = findings;
    }

    /// Sets the verdict by the findings, the warnings and the `innovations` of the run. Must be called last.
    pub fn conclude(&mut self, innovations: &[Innovation]) {
        if self.gps_fixes_used == 0 {
            self.warnings
                .push("gps: no fix was used, so nothing measures position and velocity".into());
        }
        self.verdict = Some(Verdict::of_run(&self.findings, &self.warnings, innovations));
    }

    /// Adds the scores against a reference and the drift in each outage.
    pub fn set_scores(&mut self, score: Option<&Score>, drifts: Vec<OutageDrift>) {
        let known: Vec<f64> = drifts.iter().filter_map(|outage| outage.max_horizontal_m).collect();
        self.outage_drift_m = Statistics::of(&known);
        self.outages = drifts;
        let Some(score) = score else { return };
        self.error =
            Some(score.axes.iter().map(|axis| (axis.axis.name(), axis.statistics)).collect());
        let of_axes = |pick: fn(&AxisScore) -> Option<f64>| {
            score.axes.iter().filter_map(|axis| Some((axis.axis.name(), pick(axis)?))).collect()
        };
        self.within_3_sigma = Some(of_axes(|axis| axis.within_3_sigma));
        self.error_over_sigma = Some(of_axes(|axis| axis.error_over_sigma));
    }
}

const fn heading_name(source: HeadingSource) -> &'static str {
    match source {
        HeadingSource::Attitude => "attitude",
        HeadingSource::SecondAntenna => "second antenna",
        HeadingSource::Magnetometer => "magnetometer",
        HeadingSource::Course => "course",
        HeadingSource::Unknown => "unknown",
    }
}
