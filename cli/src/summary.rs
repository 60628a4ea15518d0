//! `summary.json`: what a run was and what it gave, for programs and for the terminal.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use anyhow::Context as _;
use hovernav::ekf::{Aid, Channel, ImuFault, Notice, ResetCause, Unusable, Verdict};
use hovernav::ins::HeadingSource;
use hovernav_log::{Axis, Dataset, Run, Score, Statistics};
use serde::Serialize;

use crate::log::Flown;
use crate::report::Fact;

/// The summary of `hovernav estimate`.
#[derive(Debug, Serialize)]
pub struct Summary {
    tool: &'static str,
    version: &'static str,
    input: String,
    duration_s: f64,
    /// Filled in last.
    pub wall_s: f64,
    imu_samples: usize,
    /// Fixes of which anything corrected the state.
    gps_fixes_used: usize,
    /// Fixes of which anything was refused by a gate.
    gps_fixes_rejected: usize,
    /// Fixes that could not be compared at all.
    gps_fixes_unusable: usize,
    smoothed: bool,
    alignment: Option<AlignmentSummary>,
    innovations: BTreeMap<&'static str, ChannelSummary>,
    reopened: Vec<Reopened>,
    /// How it compares with the solution that flew, of a flight record.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flown: Option<Flown>,
    /// What the closed loop did, of a simulated flight.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flight: Option<crate::simulate::Flown>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<BTreeMap<&'static str, Statistics>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    within_3_sigma: Option<BTreeMap<&'static str, f64>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    outages: Vec<OutageDrift>,
    /// Of the largest horizontal drift in each outage.
    #[serde(skip_serializing_if = "Option::is_none")]
    outage_drift_m: Option<Statistics>,
    /// What deserves a second look, one plain sentence each.
    pub warnings: Vec<String>,
}

#[derive(Debug, Serialize)]
struct AlignmentSummary {
    end_s: f64,
    duration_s: f64,
    heading: &'static str,
    heading_sigma_deg: f64,
    /// When a heading unknown at first was found.
    heading_found_s: Option<f64>,
    attitude: &'static str,
    at_rest: bool,
}

#[derive(Debug, Default, Serialize)]
struct ChannelSummary {
    used: usize,
    rejected: usize,
    /// Mean square of the normalised innovations that were used: 1 of a consistent filter.
    mean_square: f64,
}

#[derive(Debug, Serialize)]
struct Reopened {
    time_s: f64,
    channel: &'static str,
    innovation: f64,
}

/// How far the solution drifted in one span without GPS.
#[derive(Debug, Serialize)]
pub struct OutageDrift {
    pub start_s: f64,
    pub duration_s: f64,
    pub max_horizontal_m: Option<f64>,
}

impl Summary {
    /// What a run over `dataset` gave; scores and times are still to come.
    pub fn new(input: &Path, dataset: &Dataset, run: &Run, smoothed: bool) -> Self {
        let span = |first: Option<_>, last: Option<_>| match (first, last) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        };
        let times = |end: Option<&hovernav::imu::ImuSample>| end.map(|sample| sample.time);
        let mut summary = Self {
            tool: "hovernav",
            version: env!("CARGO_PKG_VERSION"),
            input: input.display().to_string(),
            duration_s: span(times(dataset.imu.first()), times(dataset.imu.last())),
            wall_s: 0.0,
            imu_samples: dataset.imu.len(),
            gps_fixes_used: 0,
            gps_fixes_rejected: 0,
            gps_fixes_unusable: 0,
            smoothed,
            alignment: None,
            innovations: BTreeMap::new(),
            reopened: Vec::new(),
            flown: None,
            flight: None,
            error: None,
            within_3_sigma: None,
            outages: Vec::new(),
            outage_drift_m: None,
            warnings: dataset.warnings.clone(),
        };
        let early = dataset.fixes_before_imu();
        if early > 0 {
            let warning = format!("{early} fixes before the first inertial sample have no effect");
            summary.warnings.push(warning);
        }
        summary.tell(run);
        summary
    }

    fn tell(&mut self, run: &Run) {
        let mut faults: BTreeMap<&'static str, (usize, f64)> = BTreeMap::new();
        let mut note = |kind: &'static str, time_s: f64| {
            faults.entry(kind).or_insert((0, time_s)).0 += 1;
        };
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
                    if let Some(alignment) = &mut self.alignment {
                        alignment.heading_found_s = Some(time.seconds());
                        alignment.heading_sigma_deg = sigma_rad.to_degrees();
                    }
                }
                Notice::Updated(report) => self.count(report),
                Notice::NotUsed { time, aid, reason } if reason.is_fault() => {
                    self.gps_fixes_unusable += usize::from(*aid == Aid::Gps);
                    note(unusable_name(*aid, *reason), time.seconds());
                }
                Notice::GapBridged { time, .. } => {
                    note("a gap in the inertial samples, bridged", time.seconds());
                }
                Notice::CovarianceReset { time, cause } => note(reset_name(cause), time.seconds()),
                Notice::SampleRefused { time, fault } => note(fault_name(fault), time.seconds()),
                _ => {}
            }
        }
        let not_found = |alignment: &AlignmentSummary| {
            alignment.heading == "unknown" && alignment.heading_found_s.is_none()
        };
        if self.alignment.as_ref().is_some_and(not_found) {
            let why = "too little horizontal acceleration, no attitude and no magnetometer";
            self.warnings.push(format!("the heading was not found: {why}"));
        }
        for (kind, (count, first_s)) in faults {
            self.warnings.push(format!("{count} × {kind}, first at {first_s:.3} s"));
        }
        for channel in self.innovations.values_mut() {
            channel.mean_square /= channel.used.max(1) as f64;
        }
        if let [first, ..] = &self.reopened[..] {
            self.warnings.push(format!(
                "the filter had locked itself out and was reopened, {} axes in all, first at {:.3} s",
                self.reopened.len(),
                first.time_s
            ));
        }
        if self.gps_fixes_rejected > 0 {
            self.warnings.push(format!(
                "{} fixes were refused by a gate, in whole or in part",
                self.gps_fixes_rejected
            ));
        }
    }

    fn count(&mut self, report: &hovernav::ekf::Report) {
        let of_gps = report.innovations().any(|axis| is_gps(axis.channel));
        if of_gps {
            self.gps_fixes_used += usize::from(report.any_accepted());
            self.gps_fixes_rejected += usize::from(report.any_rejected());
        }
        for axis in report.innovations() {
            let channel = self.innovations.entry(axis.channel.name()).or_default();
            match axis.verdict {
                Verdict::Rejected => channel.rejected += 1,
                verdict => {
                    channel.used += 1;
                    channel.mean_square += axis.normalised().powi(2);
                    if verdict == Verdict::Reopened {
                        self.reopened.push(Reopened {
                            time_s: axis.time.seconds(),
                            channel: axis.channel.name(),
                            innovation: axis.innovation,
                        });
                    }
                }
            }
        }
    }

    /// Adds the scores against a reference and the drift in each outage.
    pub fn set_scores(&mut self, score: Option<&Score>, drifts: Vec<OutageDrift>) {
        let known: Vec<f64> = drifts.iter().filter_map(|outage| outage.max_horizontal_m).collect();
        self.outage_drift_m = Statistics::of(&known);
        self.outages = drifts;
        let Some(score) = score else { return };
        self.error =
            Some(score.axes.iter().map(|axis| (axis.axis.name(), axis.statistics)).collect());
        self.within_3_sigma = Some(
            score
                .axes
                .iter()
                .filter_map(|axis| Some((axis.axis.name(), axis.within_3_sigma?)))
                .collect(),
        );
    }

    /// Writes `summary.json`.
    pub fn write(&self, path: &Path) -> anyhow::Result<()> {
        write_json(self, path)
    }

    /// The facts of the run as the report's table has them.
    pub fn facts(&self) -> Vec<Fact> {
        let mut facts = vec![
            Fact::new("input", &self.input),
            Fact::new("duration", format!("{:.1} s", self.duration_s)),
            Fact::new("inertial samples", self.imu_samples),
            Fact::new(
                "fixes used / refused / unusable",
                format!(
                    "{} / {} / {}",
                    self.gps_fixes_used, self.gps_fixes_rejected, self.gps_fixes_unusable
                ),
            ),
        ];
        if let Some(alignment) = &self.alignment {
            facts.push(Fact::new("alignment", alignment.in_words()));
        }
        for outage in &self.outages {
            let span = format!("outage {} s for {} s", outage.start_s, outage.duration_s);
            let drift =
                outage.max_horizontal_m.map_or("not covered by a reference".into(), |drift| {
                    format!("drifted {drift:.2} m")
                });
            facts.push(Fact { label: span, value: drift });
        }
        if let Some(Statistics { median, max, .. }) = self.outage_drift_m {
            let words = format!("{median:.2} m median, {max:.2} m worst");
            facts.push(Fact { label: "drift in outages".into(), value: words });
        }
        facts
    }

    /// The few numbers to see first.
    pub fn headlines(&self) -> Vec<Fact> {
        let Some(error) = &self.error else { return Vec::new() };
        let mut headlines = Vec::new();
        for (label, axes, unit) in [
            ("velocity RMSE n / e / d", ["vn_mps", "ve_mps", "vd_mps"], "m/s"),
            ("attitude RMSE roll / pitch / yaw", ["roll_deg", "pitch_deg", "yaw_deg"], "°"),
        ] {
            let numbers: Vec<String> = axes
                .iter()
                .filter_map(|axis| Some(format!("{:.3}", error.get(axis)?.rmse)))
                .collect();
            if !numbers.is_empty() {
                headlines.push(Fact::new(label, format!("{} {unit}", numbers.join(" / "))));
            }
        }
        headlines
    }

    /// What the terminal shows.
    pub fn in_words(&self, out: &Path) -> String {
        let mut text = String::new();
        for fact in self.facts() {
            let _ = writeln!(text, "{:<32} {}", fact.label, fact.value);
        }
        if let Some(error) = &self.error {
            let _ = writeln!(
                text,
                "{:<32} {:>9} {:>9} {:>9} {:>9}",
                "error", "rmse", "median", "p95", "max"
            );
            for axis in Axis::ALL {
                if let Some(Statistics { rmse, median, p95, max }) = error.get(axis.name()) {
                    let name = axis.name();
                    let _ = writeln!(
                        text,
                        "  {name:<30} {rmse:>9.3} {median:>9.3} {p95:>9.3} {max:>9.3}"
                    );
                }
            }
        }
        if let Some(flown) = &self.flown {
            let _ = writeln!(text, "{}", flown.in_words());
        }
        for warning in &self.warnings {
            let _ = writeln!(text, "warning: {warning}");
        }
        let _ = writeln!(text, "{:<32} {} ({:.3} s)", "written", out.display(), self.wall_s);
        text
    }
}

/// Writes a summary as JSON that people can read, too.
pub fn write_json(summary: &impl Serialize, path: &Path) -> anyhow::Result<()> {
    let text = serde_json::to_string_pretty(summary)? + "\n";
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

impl AlignmentSummary {
    fn in_words(&self) -> String {
        let source = match (self.heading, self.heading_found_s) {
            ("unknown", Some(found_s)) => format!("heading found in motion at {found_s:.1} s"),
            ("unknown", None) => "heading not found".to_owned(),
            (source, _) => format!("heading from {source}"),
        };
        let rest = if self.at_rest { "at rest" } else { "in motion" };
        format!(
            "at {:.2} s, {rest}, roll and pitch {}, {source}, sure to {:.1}°",
            self.end_s, self.attitude, self.heading_sigma_deg
        )
    }
}

const fn is_gps(channel: Channel) -> bool {
    !matches!(channel, Channel::Roll | Channel::Pitch | Channel::Yaw | Channel::BaroHeight)
}

const fn heading_name(source: HeadingSource) -> &'static str {
    match source {
        HeadingSource::Attitude => "attitude",
        HeadingSource::Magnetometer => "magnetometer",
        HeadingSource::Course => "course",
        HeadingSource::Unknown => "unknown",
    }
}

const fn unusable_name(aid: Aid, reason: Unusable) -> &'static str {
    match (aid, reason) {
        (Aid::Gps, Unusable::NotFinite) => "a fix that is no place or not finite",
        (Aid::Gps, Unusable::TooOld) => "a fix older than the filter's memory",
        (Aid::Gps, Unusable::AheadOfImu) => "a fix ahead of the inertial samples",
        (Aid::Attitude, _) => "an attitude of the unit that is not finite",
        (Aid::Magnetometer, _) => "a magnetic field that is not finite or has no horizontal part",
        (Aid::Baro, _) => "a barometric height that is not finite or beyond 100 km",
        _ => "a measurement that could not be used",
    }
}

const fn reset_name(cause: &ResetCause) -> &'static str {
    match cause {
        ResetCause::LongGap { .. } => {
            "a gap in the inertial samples too long to bridge, the covariance reset"
        }
        ResetCause::Diverged => {
            "an inertial sample that would lead off the Earth, the covariance reset"
        }
        _ => "a reset of the covariance",
    }
}

const fn fault_name(fault: &ImuFault) -> &'static str {
    match fault {
        ImuFault::NotFinite => "an inertial sample that is not finite, passed over",
        ImuFault::NotLater => "an inertial sample not later than the one before, passed over",
        _ => "an inertial sample passed over",
    }
}
