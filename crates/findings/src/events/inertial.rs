//! Findings from the inertial samples: gaps, losses, repetitions, clipping, shocks, vibration.

use hovernav::ekf::{ImuFault, Notice, ResetCause};
use hovernav::imu::{Checks, FullScale, Integrity, MeanRates};
use hovernav::time::Time;

use super::ends::Ends;
use super::judged::Judged;
use super::spans::{Repeating, Repetitions, Span, Spans, spans, when};
use crate::finding::{Finding, FindingKind, Sensor, Severity};
use crate::limits::{HIGH_VIBRATION_MPS, LOST_SAMPLES};
use crate::rates::{AXES, Rates, Vibration};
use hovernav_dataset::statistics::Distribution;

/// Longest time, s, between two faults of one event.
const APART_S: f64 = 2.0;
/// Shortest span of repeated samples, s, that a fast log may cause. Such a log is written more often than the inertial
/// unit measures.
const LASTING_S: f64 = 10.0;
/// Fraction of repeated samples in such a span, above which the log causes them.
const HELD: f64 = 0.2;
/// Shortest repetition of one axis, s, that counts as stuck.
const STUCK_S: f64 = 0.2;

pub(super) fn find(log: &Judged<'_>, samples: Inertial, ends: Ends, findings: &mut Vec<Finding>) {
    reported(log, findings);
    samples.lost(findings);
    samples.stuck(log, findings);
    samples.shaken(findings);
    ends.find(findings);
    samples.vibration(findings);
}

/// Statistics and suspect samples, gathered sample by sample.
pub(super) struct Inertial {
    intervals: Distribution,
    count: usize,
    first_s: f64,
    last_s: f64,
    repetitions: [Repetitions<f64, Time>; 6],
    scale: FullScale,
    integrity: Integrity,
    shaken: Spans,
    vibration: Vibration,
}

impl Inertial {
    pub fn of(log: &Judged<'_>) -> Self {
        let model = &log.run.config.ekf.imu;
        Self {
            intervals: Distribution::default(),
            count: 0,
            first_s: 0.0,
            last_s: 0.0,
            repetitions: Default::default(),
            scale: FullScale {
                gyro_radps: model.gyro_range_radps,
                accel_mps2: model.accel_range_mps2,
            },
            integrity: Integrity::NONE,
            shaken: Spans::apart(APART_S),
            vibration: Vibration::default(),
        }
    }

    pub fn push(&mut self, at: &Rates) {
        let time_s = at.time.seconds();
        if self.count == 0 {
            self.first_s = time_s;
        } else {
            self.intervals.push(at.interval_s);
        }
        self.count += 1;
        self.last_s = time_s;
        for (repetitions, value) in self.repetitions.iter_mut().zip(at.six()) {
            repetitions.push(value, at.time);
        }
        self.shake(at, time_s);
        self.vibration.push(at);
    }

    /// Adds shocks, by the criterion of the filter.
    fn shake(&mut self, at: &Rates, time_s: f64) {
        if at.interval_s > 0.5 {
            self.integrity.interrupt();
        }
        let mean = MeanRates {
            angular_rate_radps: at.turn_radps.into(),
            specific_force_mps2: at.force_mps2.into(),
        };
        let suspicion = self.integrity.push(
            (&mean, true),
            &at.clipped,
            at.interval_s,
            (&self.scale, Checks::ALL),
        );
        if suspicion.shaken {
            let [x, y, z] = at.force_mps2;
            self.shaken.push((time_s, x.hypot(y).hypot(z)));
        }
    }

    /// Finding for single samples missing throughout the log. Scattered time stamps do not count.
    fn lost(&self, findings: &mut Vec<Finding>) {
        let Some(typical_s) = self.intervals.quantile(0.5) else { return };
        let (mut whole, mut in_time) = (0.0, 0.0);
        for (interval_s, count) in self.intervals.counts() {
            let intervals = interval_s / typical_s;
            // Longer intervals are gaps, each with a finding of its own.
            if intervals < 5.0 {
                whole += (intervals.round() - 1.0).max(0.0) * count as f64;
                in_time += (intervals - 1.0) * count as f64;
            }
        }
        // Scattered time stamps lengthen and shorten intervals, but do not lengthen their sum.
        let missing = whole.min(in_time).max(0.0).round();
        let share = missing / (missing + self.count as f64);
        if share > LOST_SAMPLES {
            let (start_s, end_s) = (self.first_s, self.last_s);
            let words = format!(
                "inertial unit: {:.1} % of the samples are missing {}, {missing:.0} in all, as on a link that \
                 loses packets: each loss turns vibration into velocity and attitude errors",
                100.0 * share,
                when(start_s, end_s),
            );
            findings.push(
                Finding::warning(
                    Sensor::InertialUnit,
                    FindingKind::SamplesLost,
                    (start_s, end_s),
                    words,
                )
                .of(missing as usize),
            );
        }
    }

    /// Findings for single axes that repeat their readings.
    fn stuck(&self, log: &Judged<'_>, findings: &mut Vec<Finding>) {
        let used = |start: Time| log.span_s().is_some_and(|(first_s, _)| start.seconds() > first_s);
        let mut found: Vec<(usize, Repeating<Time>)> = Vec::new();
        for (axis, repetitions) in self.repetitions.iter().enumerate() {
            let runs = repetitions.clone().finish();
            let lasting = runs.into_iter().filter(|run| run.end - run.start >= STUCK_S);
            found.extend(lasting.filter(|run| used(run.start)).map(|run| (axis, run)));
        }
        found.sort_by_key(|(axis, run)| (run.first, run.last, *axis));
        // Axes that are stuck together are one event.
        for together in found.chunk_by(|(_, a), (_, b)| b.first <= a.last) {
            let first = &together[0].1;
            let last = together.iter().map(|(_, run)| run).max_by_key(|run| run.last);
            let last = last.unwrap_or(first);
            let (start_s, end_s) = (first.start.seconds(), last.end.seconds());
            let axes: Vec<&str> = together.iter().map(|(axis, _)| AXES[*axis]).collect();
            let whose = if together.len() == 6 { "all axes".into() } else { axes.join(", ") };
            let words = format!(
                "inertial unit stuck {}: {whose} repeated to the last digit for {:.2} s ({} samples), unlike the \
                 readings before and after",
                when(start_s, end_s),
                end_s - start_s,
                last.last - first.first
            );
            findings.push(
                Finding::warning(
                    Sensor::InertialUnit,
                    FindingKind::StuckAxis,
                    (start_s, end_s),
                    words,
                )
                .of(last.last - first.first),
            );
        }
    }

    fn shaken(&self, findings: &mut Vec<Finding>) {
        for Span { start_s, end_s, count, largest } in &self.shaken.found {
            let words = format!(
                "inertial unit: shock far beyond its usual vibration {}, up to {largest:.0} m/s²: an impact or a \
                 loose part; the filter has enlarged its uncertainty",
                when(*start_s, *end_s)
            );
            findings.push(
                Finding::warning(
                    Sensor::InertialUnit,
                    FindingKind::Shock,
                    (*start_s, *end_s),
                    words,
                )
                .of(*count),
            );
        }
    }

    /// Finding for vibration that is too fast for the sample rate, with the velocity error it causes.
    fn vibration(&self, findings: &mut Vec<Finding>) {
        let Some(interval_s) = self.intervals.quantile(0.5) else { return };
        let strengths = self.vibration.rms().unwrap_or_default();
        let strongest = (3..6).max_by(|&a, &b| strengths[a].total_cmp(&strengths[b])).unwrap_or(3);
        let walk_mps = self.vibration.velocity_error_mps(strongest, interval_s);
        let severity =
            if walk_mps > HIGH_VIBRATION_MPS { Severity::Warning } else { Severity::Info };
        let words = format!(
            "inertial unit: vibration is {} throughout ({} {:.2} m/s² rms between samples); the part too fast for \
             the sample rate of {:.0} Hz adds up to {walk_mps:.2} m/s in a second",
            if severity == Severity::Warning { "high" } else { "moderate" },
            AXES[strongest],
            strengths[strongest],
            1.0 / interval_s,
        );
        findings.push(
            Finding::warning(
                Sensor::InertialUnit,
                FindingKind::Vibration,
                (self.first_s, self.last_s),
                words,
            )
            .severity(severity)
            .of(self.count),
        );
    }
}

/// Explanation of `count` samples within `length_s` that repeat the two before them: the log was written more often
/// than the inertial unit measured. `None` if the fraction of such samples is too small.
fn held(log: &Judged<'_>, length_s: f64, count: usize) -> Option<String> {
    let rate_hz = 1.0 / log.dataset.sample_interval_s()?;
    let share = count as f64 / (rate_hz * length_s);
    (length_s > LASTING_S && share > HELD).then(|| {
        // The first two samples of each reading are used, the others are skipped.
        let rows = 2.0 / (1.0 - share.min(0.99));
        format!(
            "each reading repeated about {rows:.0} times: it measured at {:.0} Hz and the log was written at \
             {rate_hz:.0} Hz",
            rate_hz / rows
        )
    })
}

/// Index of the fault "time far ahead of the previous sample" among the faults of [`reported`].
const FAR_AHEAD: usize = 4;

/// Findings from the estimator's own notices on the samples.
fn reported(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let mut faults: [Vec<(f64, f64)>; 5] = Default::default();
    for notice in &log.run.notices {
        let (time, length_s, response) = match notice {
            Notice::GapBridged { time, length_s } => {
                (*time, *length_s, "bridged at the last velocity with a larger uncertainty")
            }
            Notice::CovarianceReset { time, cause: ResetCause::LongGap { length_s } } => {
                // The first sample after a long gap is rejected until the second confirms its time.
                faults[FAR_AHEAD].pop();
                (*time, *length_s, "too long to bridge, so the filter was reset")
            }
            Notice::CovarianceReset { time, cause } => {
                let time_s = time.seconds();
                let why = match cause {
                    ResetCause::Misaligned { off_rad } => format!(
                        "its attitude was off by {:.0}° from the specific force that the fixes imply; it was aligned \
                         again in motion",
                        off_rad.to_degrees()
                    ),
                    _ => "the inertial sample would have moved it off the Earth".to_owned(),
                };
                findings.push(Finding::warning(
                    Sensor::Filter,
                    FindingKind::Reset,
                    (time_s, time_s),
                    format!("filter reset at {time_s:.1} s: {why}"),
                ));
                continue;
            }
            Notice::SampleRejected { time, fault } => {
                let kind = match fault {
                    ImuFault::Stuck => 0,
                    ImuFault::NotFinite => 1,
                    ImuFault::Interpolated => 2,
                    ImuFault::FarAhead => FAR_AHEAD,
                    _ => 3,
                };
                faults[kind].push((time.seconds(), 0.0));
                continue;
            }
            _ => continue,
        };
        let (start_s, end_s) = (time.seconds() - length_s, time.seconds());
        let words = format!(
            "inertial unit: gap of {length_s:.2} s in the samples from {start_s:.2} to {end_s:.2} s, \
             {response}{}",
            log.cost(start_s - 0.01, end_s)
        );
        findings.push(Finding::warning(
            Sensor::InertialUnit,
            FindingKind::Gap,
            (start_s, end_s),
            words,
        ));
    }
    let what = [
        (FindingKind::Stuck, "all readings repeated to the last digit, so it was not measuring"),
        (
            FindingKind::NotANumber,
            "readings were not finite, or beyond the range of inertial units",
        ),
        (
            FindingKind::Interpolated,
            "all readings follow a straight line, which a logger has drawn where samples were missing",
        ),
        (FindingKind::TimeStamps, "samples not later than the one before"),
        (
            FindingKind::TimeStamps,
            "samples more than a minute after the one before, and before the next",
        ),
    ];
    for (moments, (kind, what)) in faults.into_iter().zip(what) {
        for Span { start_s, end_s, count, .. } in spans(moments, APART_S) {
            let held = held(log, end_s - start_s, count).filter(|_| kind == FindingKind::Stuck);
            let what = held.as_deref().unwrap_or(what);
            let words = format!(
                "inertial unit {}: {what}; {count} samples were ignored",
                when(start_s, end_s)
            );
            findings.push(
                Finding::warning(Sensor::InertialUnit, kind, (start_s, end_s), words).of(count),
            );
        }
    }
}
