//! What the inertial samples tell of their unit: gaps, losses, repetitions, full scale, blows, vibration.

use hovernav::ekf::{ImuFault, Notice, ResetCause};
use hovernav::imu::{FullScale, Integrity, MeanRates};

use super::Judged;
use super::spans::{Span, improbable_runs, spans};
use super::when;
use crate::finding::{Finding, Severity};
use crate::rates::{Rates, rates};
use crate::statistics::quantile;

const UNIT: &str = "inertial unit";
const AXES: [&str; 6] =
    ["gyro x", "gyro y", "gyro z", "accelerometer x", "accelerometer y", "accelerometer z"];
/// Events closer than this, s, are one.
const APART_S: f64 = 2.0;
/// An axis that repeats itself for less than this, s, is not called stuck.
const STUCK_S: f64 = 0.2;
/// More lost samples than this share are worth a word.
const LOST: f64 = 0.02;
/// Vibration that adds more than this to the velocity's error in a second, m/s, is high.
const HIGH_MPS: f64 = 0.6;

pub(super) fn find(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let rates = rates(&log.dataset.imu);
    reported(log, findings);
    lost(&rates, findings);
    stuck(log, &rates, findings);
    shaken(log, &rates, findings);
    clipped(log, &rates, findings);
    vibration(&rates, findings);
}

/// What the estimator itself reported of the samples.
fn reported(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let mut faults: [Vec<(f64, f64)>; 3] = Default::default();
    for notice in &log.run.notices {
        let (time, length_s, response) = match notice {
            Notice::GapBridged { time, length_s } => {
                (*time, *length_s, "bridged with the velocity kept and the uncertainty opened")
            }
            Notice::CovarianceReset { time, cause: ResetCause::LongGap { length_s } } => {
                (*time, *length_s, "too long to bridge, so the filter was reset")
            }
            Notice::CovarianceReset { time, .. } => {
                let time_s = time.seconds();
                findings.push(Finding {
                    start_s: time_s,
                    end_s: time_s,
                    sensor: "filter",
                    kind: "reset",
                    severity: Severity::Warning,
                    count: 1,
                    words: format!(
                        "filter reset at {time_s:.1} s: the inertial sample would have led off the \
                         Earth"
                    ),
                });
                continue;
            }
            Notice::SampleRefused { time, fault } => {
                let kind = match fault {
                    ImuFault::Stuck => 0,
                    ImuFault::NotFinite => 1,
                    _ => 2,
                };
                faults[kind].push((time.seconds(), 0.0));
                continue;
            }
            _ => continue,
        };
        let (start_s, end_s) = (time.seconds() - length_s, time.seconds());
        findings.push(Finding {
            start_s,
            end_s,
            sensor: UNIT,
            kind: "gap",
            severity: Severity::Warning,
            count: 1,
            words: format!(
                "inertial unit: gap of {length_s:.2} s in the samples from {start_s:.2} to {end_s:.2} s, \
                 {response}{}",
                log.cost(start_s - 0.01, end_s)
            ),
        });
    }
    let what = [
        ("stuck", "repeated all its readings to the last digit, so it was not measuring"),
        ("not a number", "gave readings that are not finite"),
        ("time stamps", "gave samples not later than the one before"),
    ];
    for (moments, (kind, what)) in faults.into_iter().zip(what) {
        for Span { start_s, end_s, count, .. } in spans(moments, APART_S) {
            findings.push(Finding {
                start_s,
                end_s,
                sensor: UNIT,
                kind,
                severity: Severity::Warning,
                count,
                words: format!(
                    "inertial unit {} {what}; {count} samples were passed over",
                    when(start_s, end_s)
                ),
            });
        }
    }
}

/// Samples missing here and there, and time stamps that scatter.
fn lost(rates: &[Rates], findings: &mut Vec<Finding>) {
    let mut intervals: Vec<f64> = rates.iter().skip(1).map(|at| at.interval_s).collect();
    let (Some(typical_s), Some(first), Some(last)) =
        (quantile(&mut intervals, 0.5), rates.first(), rates.last())
    else {
        return;
    };
    let missing = |interval_s: &f64| ((interval_s / typical_s).round() - 1.0).max(0.0);
    // Longer ones are gaps, told one by one.
    let short = intervals.iter().filter(|&&interval_s| interval_s < 5.0 * typical_s);
    let missing: f64 = short.map(missing).sum();
    let share = missing / (missing + rates.len() as f64);
    if share > LOST {
        findings.push(Finding {
            start_s: first.time.seconds(),
            end_s: last.time.seconds(),
            sensor: UNIT,
            kind: "samples lost",
            severity: Severity::Warning,
            count: missing as usize,
            words: format!(
                "inertial unit: {:.1} % of the samples are missing {}, {missing:.0} in all, as a line \
                 that loses packets makes it: each leaves the vibration in velocity and attitude",
                100.0 * share,
                when(first.time.seconds(), last.time.seconds()),
            ),
        });
    }
}

/// Single axes that repeat themselves.
fn stuck(log: &Judged<'_>, rates: &[Rates], findings: &mut Vec<Finding>) {
    let mut found: Vec<(usize, usize, usize)> = Vec::new();
    for axis in 0..6 {
        let values: Vec<f64> = rates.iter().map(|at| component(at, axis)).collect();
        for (first, last) in improbable_runs(&values) {
            let used =
                log.span_s().is_some_and(|(start_s, _)| rates[first].time.seconds() > start_s);
            if used && rates[last].time - rates[first].time >= STUCK_S {
                found.push((first, last, axis));
            }
        }
    }
    found.sort_unstable();
    // Axes that are stuck together are one event.
    for together in found.chunk_by(|a, b| b.0 <= a.1) {
        let (first, last) = (together[0].0, together.iter().map(|run| run.1).max().unwrap_or(0));
        let (start_s, end_s) = (rates[first].time.seconds(), rates[last].time.seconds());
        let axes: Vec<&str> = together.iter().map(|run| AXES[run.2]).collect();
        let whose = if together.len() == 6 { "all axes".into() } else { axes.join(", ") };
        findings.push(Finding {
            start_s,
            end_s,
            sensor: UNIT,
            kind: "stuck axis",
            severity: Severity::Warning,
            count: last - first,
            words: format!(
                "inertial unit stuck {}: {whose} repeated to the last digit for {:.2} s ({} samples), \
                 while the readings before and after do not",
                when(start_s, end_s),
                end_s - start_s,
                last - first
            ),
        });
    }
}

/// Blows, by the judgement that the filter uses.
fn shaken(log: &Judged<'_>, rates: &[Rates], findings: &mut Vec<Finding>) {
    let model = &log.run.config.ekf.imu;
    let scale =
        FullScale { gyro_radps: model.gyro_range_radps, accel_mps2: model.accel_range_mps2 };
    let mut integrity = Integrity::NONE;
    let mut shaken = Vec::new();
    for at in rates {
        if at.interval_s > 0.5 {
            integrity.interrupt();
        }
        let mean = MeanRates {
            angular_rate_radps: at.turn_radps.into(),
            specific_force_mps2: at.force_mps2.into(),
        };
        if integrity.push((&mean, true), &at.clipped, at.interval_s, &scale).shaken {
            let [x, y, z] = at.force_mps2;
            shaken.push((at.time.seconds(), x.hypot(y).hypot(z)));
        }
    }
    for Span { start_s, end_s, count, largest } in spans(shaken, APART_S) {
        findings.push(Finding {
            start_s,
            end_s,
            sensor: UNIT,
            kind: "shock",
            severity: Severity::Warning,
            count,
            words: format!(
                "inertial unit shaken far beyond its usual vibration {}, up to {largest:.0} m/s²: a \
                 blow or something loose; the uncertainty was opened",
                when(start_s, end_s)
            ),
        });
    }
}

/// Spans in which axes stand at their full scale, for each axis.
fn clipped(log: &Judged<'_>, rates: &[Rates], findings: &mut Vec<Finding>) {
    let model = &log.run.config.ekf.imu;
    for (axis, name) in AXES.into_iter().enumerate() {
        let known = if axis < 3 { model.gyro_range_radps } else { model.accel_range_mps2 };
        let values: Vec<f64> = rates.iter().map(|at| component(at, axis)).collect();
        let scale = full_scale(&values);
        let is_marked = rates.iter().any(|at| marked(at, axis));
        let is_clipped = |at: &&Rates| {
            let value = component(at, axis);
            let at_end =
                scale.contains(&Some(value)) || (known > 0.0 && value.abs() >= 0.998 * known);
            if is_marked { marked(at, axis) } else { at_end }
        };
        let moments = rates.iter().filter(is_clipped);
        let moments = moments.map(|at| (at.time.seconds(), component(at, axis).abs()));
        for Span { start_s, end_s, count, largest } in spans(moments, 10.0) {
            let within = rates.iter().filter(|at| {
                let time_s = at.time.seconds();
                (start_s..=end_s).contains(&time_s)
            });
            // A marked sample is a mean of readings of which one may have been at the end.
            let level = if is_marked {
                "full scale by the unit's own marks".to_owned()
            } else if axis < 3 {
                format!("its full scale of {:.0} °/s", largest.to_degrees())
            } else {
                format!("its full scale of {largest:.1} m/s² ({:.2} g)", largest / 9.806_65)
            };
            findings.push(Finding {
                start_s,
                end_s,
                sensor: UNIT,
                kind: "clipping",
                severity: Severity::Warning,
                count,
                words: format!(
                    "{} clipped at {level} {}: {count} samples, {:.1} % of that \
                     time, so what lay beyond is not known",
                    name,
                    when(start_s, end_s),
                    100.0 * count as f64 / (within.count().max(1) as f64)
                ),
            });
        }
    }
}

/// The lowest and the highest of `values` where readings pile up there, again and again, as they do at
/// the end of a range and nowhere else.
fn full_scale(values: &[f64]) -> [Option<f64>; 2] {
    /// Readings, and times that the range was left and reached again, that make an end.
    const PILED: usize = 6;
    const VISITS: usize = 3;
    [-1.0, 1.0].map(|side| {
        let (mut end, mut next) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        for &value in values {
            let value = side * value;
            if value > end {
                (next, end) = (end, value);
            } else if value > next && value < end {
                next = value;
            }
        }
        let at = |level: f64| values.iter().filter(|&&value| side * value == level).count();
        let visits =
            values.windows(2).filter(|pair| side * pair[0] != end && side * pair[1] == end).count();
        let is_end = at(end) >= PILED && visits >= VISITS && at(end) >= 4 * at(next);
        is_end.then_some(side * end)
    })
}

/// What of the vibration the samples cannot follow, where that is much.
fn vibration(rates: &[Rates], findings: &mut Vec<Finding>) {
    let (Some(first), Some(last)) = (rates.first(), rates.last()) else { return };
    let mut intervals: Vec<f64> = rates.iter().skip(1).map(|at| at.interval_s).collect();
    let Some(interval_s) = quantile(&mut intervals, 0.5) else { return };
    let rms = |axis: usize| {
        let bends = rates.windows(3).map(|three| {
            let [a, b, c] = [0, 1, 2].map(|at| component(&three[at], axis));
            a - 2.0 * b + c
        });
        let count = rates.len().saturating_sub(2).max(1) as f64;
        (bends.map(|bend| bend * bend).sum::<f64>() / (6.0 * count)).sqrt()
    };
    let strengths: [f64; 3] = std::array::from_fn(|axis| rms(3 + axis));
    let strongest = (0..3).max_by(|&a, &b| strengths[a].total_cmp(&strengths[b])).unwrap_or(0);
    // White noise of this size, summed up for a second.
    let walk_mps = strengths[strongest] * interval_s.sqrt();
    let severity = if walk_mps > HIGH_MPS { Severity::Warning } else { Severity::Info };
    findings.push(Finding {
        start_s: first.time.seconds(),
        end_s: last.time.seconds(),
        sensor: UNIT,
        kind: "vibration",
        severity,
        count: rates.len(),
        words: format!(
            "inertial unit: vibration is {} throughout ({} {:.2} m/s² rms between samples), and what \
             the sample rate of {:.0} Hz cannot follow adds up to {walk_mps:.2} m/s in a second",
            if severity == Severity::Warning { "high" } else { "moderate" },
            AXES[3 + strongest],
            strengths[strongest],
            1.0 / interval_s,
        ),
    });
}

fn marked(at: &Rates, axis: usize) -> bool {
    if axis < 3 { at.clipped.gyro[axis] } else { at.clipped.accel[axis - 3] }
}

fn component(at: &Rates, axis: usize) -> f64 {
    if axis < 3 { at.turn_radps[axis] } else { at.force_mps2[axis - 3] }
}
