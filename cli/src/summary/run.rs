//! The summary of a run of the filter: what it was and what it gave.

use std::collections::BTreeMap;
use std::path::Path;

use hovernav::ekf::{Aid, Channel, ImuFault, Notice, ResetCause, Unusable, Verdict};
use hovernav::imu::Suspicion;
use hovernav::ins::HeadingSource;
use hovernav_log::{Dataset, Run, Score, Statistics, UnusedReadings};
use serde::Serialize;

use super::reproduction::ReproductionSummary;

/// The summary of a run of the filter over a log.
#[derive(Debug, Serialize)]
pub struct RunSummary {
    tool: &'static str,
    version: &'static str,
    pub(super) input: String,
    pub(super) duration_s: f64,
    /// Filled in last.
    pub wall_s: f64,
    pub(super) imu_samples: usize,
    /// Fixes of which anything corrected the state.
    pub(super) gps_fixes_used: usize,
    /// Fixes of which anything was refused by a gate.
    pub(super) gps_fixes_rejected: usize,
    /// Fixes that could not be compared at all.
    pub(super) gps_fixes_unusable: usize,
    smoothed: bool,
    pub(super) alignment: Option<AlignmentSummary>,
    innovations: BTreeMap<&'static str, ChannelSummary>,
    reopened: Vec<Reopened>,
    /// How it compares with the solution that flew, of a flight record.
    #[serde(rename = "flown", skip_serializing_if = "Option::is_none")]
    pub reproduction: Option<ReproductionSummary>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) error: Option<BTreeMap<&'static str, Statistics>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    within_3_sigma: Option<BTreeMap<&'static str, f64>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) outages: Vec<OutageDrift>,
    /// Of the largest horizontal drift in each outage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) outage_drift_m: Option<Statistics>,
    /// What deserves a second look, one plain sentence each.
    pub warnings: Vec<String>,
    /// Readings that could not be used for a fault of theirs.
    aids_unusable: UnusedReadings,
    /// Readings left out by design.
    aids_left_out: UnusedReadings,
}

/// How and when the filter was aligned.
#[derive(Debug, Serialize)]
pub struct AlignmentSummary {
    pub(super) end_s: f64,
    pub(super) duration_s: f64,
    pub(super) heading: &'static str,
    pub(super) heading_sigma_deg: f64,
    /// When a heading unknown at first was found.
    pub(super) heading_found_s: Option<f64>,
    pub(super) attitude: &'static str,
    pub(super) at_rest: bool,
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

impl RunSummary {
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
            gps_fixes_unusable: run.unusable.gps,
            smoothed,
            alignment: None,
            innovations: BTreeMap::new(),
            reopened: Vec::new(),
            reproduction: None,
            error: None,
            within_3_sigma: None,
            outages: Vec::new(),
            outage_drift_m: None,
            warnings: dataset.warnings.clone(),
            aids_unusable: run.unusable,
            aids_left_out: run.left_out,
        };
        let early = dataset.fixes_before_imu();
        if early > 0 {
            let warning = format!("{early} fixes before the first inertial sample have no effect");
            summary.warnings.push(warning);
        }
        summary.add_notices(run);
        summary
    }

    fn add_notices(&mut self, run: &Run) {
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
                    note(unusable_name(*aid, *reason), time.seconds());
                }
                Notice::GapBridged { time, .. } => {
                    note("a gap in the inertial samples, bridged", time.seconds());
                }
                Notice::CovarianceReset { time, cause } => note(reset_name(cause), time.seconds()),
                Notice::SampleSuspect { time, suspicion } => {
                    note(suspicion_name(suspicion), time.seconds());
                }
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
        (Aid::Gps, Unusable::Repeated) => "a frozen fix, the one before again though moving",
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

fn suspicion_name(suspicion: &Suspicion) -> &'static str {
    if suspicion.accel_clipped.contains(&true) {
        "clipping of an accelerometer at its full scale, counted in the uncertainty"
    } else if suspicion.gyro_clipped.contains(&true) {
        "clipping of a gyro at its full scale, counted in the uncertainty"
    } else {
        "shaking of the inertial unit far beyond its usual vibration, counted in the uncertainty"
    }
}

const fn fault_name(fault: &ImuFault) -> &'static str {
    match fault {
        ImuFault::NotFinite => "an inertial sample that is not finite, passed over",
        ImuFault::Stuck => "an inertial sample stuck at the one before, passed over",
        ImuFault::NotLater => "an inertial sample not later than the one before, passed over",
        _ => "an inertial sample passed over",
    }
}
