//! What changes slowly: biases that step, and the time of the fixes.

use hovernav::ekf::Notice;

use super::timing::Felt;
use super::{Judged, when};
use crate::comparisons::FixTally;
use crate::finding::{Finding, Severity};

/// Over how long a bias is compared with itself, s.
const OVER_S: f64 = 20.0;
/// A change of more than so many one-sigmas, the larger of before and after, is none that the filter expects of the bias:
/// not even where a rest has ended in between.
const STEP: f64 = 6.0;
/// Smaller steps of a gyro's bias, rad/s, and of an accelerometer's, m/s², cost little.
const LEAST_GYRO: f64 = 0.005;
const LEAST_ACCEL: f64 = 0.2;
/// A time offset of the fixes beyond this, s, is worth declaring.
const OFFSET_S: f64 = 0.1;
/// So far, s, the filter follows it, where it refuses no more than such a share of the fixes.
const FOLLOWED_S: std::ops::RangeInclusive<f64> = -0.28..=0.45;
const REFUSED: f64 = 0.1;
/// What shows in when the vehicle accelerates is asked for beyond this, s, and is surer than what the filter found
/// where the two are further apart than that.
const FAR_S: f64 = 0.25;
const AGREES_S: f64 = 0.1;

pub(super) fn find(log: &Judged<'_>, felt: &Felt, findings: &mut Vec<Finding>) {
    biases(log, findings);
    offset(log, felt, findings);
}

fn biases(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let solutions = &log.run.solutions;
    let Some(first) = solutions.first() else { return };
    // Where the filter has opened its biases for a step, others judge what became of them.
    let doubted: Vec<f64> = log
        .run
        .notices
        .iter()
        .filter_map(|notice| match notice {
            Notice::Updated(report) if report.biases_were_doubted() => report.innovations().next(),
            _ => None,
        })
        .map(|axis| axis.time.seconds())
        .collect();
    // Ten moments a second are enough.
    let mut coarse = Vec::new();
    let mut next_s = first.time.seconds() + OVER_S;
    for solution in solutions {
        if solution.time.seconds() >= next_s {
            next_s += 0.5;
            coarse.push(solution);
        }
    }
    for (what, least, unit, scale) in [
        ("gyro", LEAST_GYRO, "°/s", 180.0 / std::f64::consts::PI),
        ("accelerometer", LEAST_ACCEL, "m/s²", 1.0),
    ] {
        for axis in 0..3 {
            let at = |index: usize| {
                let solution = coarse[index];
                let (bias, sigma) = if what == "gyro" {
                    (solution.gyro_bias_radps, solution.gyro_bias_sigma_radps)
                } else {
                    (solution.accel_bias_mps2, solution.accel_bias_sigma_mps2)
                };
                (solution.time.seconds(), bias.to_array()[axis], sigma.to_array()[axis])
            };
            let mut largest: Option<(f64, f64, f64, f64)> = None;
            let mut before = 0;
            for index in 0..coarse.len() {
                let (end_s, after, sigma_after) = at(index);
                while at(before).0 < end_s - OVER_S {
                    before += 1;
                }
                let (start_s, earlier, sigma_before) = at(before);
                let sigma = sigma_before.max(sigma_after);
                let change = after - earlier;
                let ratio = change.abs() / sigma.max(1e-12);
                if change.abs() > least
                    && ratio > STEP
                    && !doubted.iter().any(|&doubted_s| (start_s..end_s).contains(&doubted_s))
                    && largest.is_none_or(|most| change.abs() > most.2.abs())
                {
                    largest = Some((start_s, end_s, change, sigma));
                }
            }
            let Some((start_s, end_s, change, sigma)) = largest else { continue };
            findings.push(Finding {
                start_s,
                end_s,
                sensor: "inertial unit",
                kind: "bias step",
                severity: Severity::Warning,
                count: 1,
                words: format!(
                    "{what} bias of axis {} changed by {:.3} {unit} {}, where its one-sigma was {:.3}: a \
                     step of the sensor, or an error that the filter puts down to it",
                    ["x", "y", "z"][axis],
                    change * scale,
                    when(start_s, end_s),
                    sigma * scale
                ),
            });
        }
    }
}

fn offset(log: &Judged<'_>, felt: &Felt, findings: &mut Vec<Finding>) {
    let Some((start_s, end_s)) = log.span_s() else { return };
    let declared_s = log.dataset.manifest.gps.latency_s;
    // One that was refused much of what it was told has found nothing that is worth telling.
    let FixTally { used, rejected } = log.run.fixes_compared;
    let is_trusted = |offset_s: f64| {
        FOLLOWED_S.contains(&offset_s) && (rejected as f64) < REFUSED * (used + rejected) as f64
    };
    let own_s = log.run.gps_offset.map(|(offset_s, _)| offset_s).filter(|&own_s| is_trusted(own_s));
    let far_s = felt.delay_s(log).filter(|far_s| {
        far_s.abs() > FAR_S && own_s.is_none_or(|own_s| (far_s - own_s).abs() > AGREES_S)
    });
    let side = |offset_s: f64| {
        let found_s = declared_s + offset_s;
        let side = if found_s >= 0.0 { "earlier" } else { "later" };
        (found_s, format!("{:.3} s {side} than their time stamps say", found_s.abs()))
    };
    let (is_off, what) = match (far_s, log.run.gps_offset) {
        (Some(far_s), _) => {
            let (found_s, side) = side(far_s);
            let how = "by when the vehicle accelerates";
            (
                true,
                format!(
                    "fixes hold {side} ({how}), declared latency {declared_s:.3} s; set [gps] latency_s = {found_s:.2}"
                ),
            )
        }
        (None, Some((offset_s, sigma_s))) => {
            let is_off = offset_s.abs() > OFFSET_S && offset_s.abs() > 4.0 * sigma_s;
            let (found_s, side) = side(offset_s);
            let what = match is_off {
                true if !is_trusted(offset_s) => format!(
                    "fixes hold at other times than their time stamps say, by more than the filter can follow (it found \
                     {side}, declared latency {declared_s:.3} s); look at the clocks"
                ),
                true => format!(
                    "fixes hold {side} (one-sigma {sigma_s:.3} s), declared latency {declared_s:.3} s; set [gps] \
                     latency_s = {found_s:.2}"
                ),
                false => format!(
                    "fixes hold {side} (one-sigma {sigma_s:.3} s), declared latency {declared_s:.3} s"
                ),
            };
            (is_off, what)
        }
        _ => return,
    };
    findings.push(Finding {
        start_s,
        end_s,
        sensor: "gps",
        kind: "time offset",
        severity: if is_off { Severity::Warning } else { Severity::Info },
        count: 1,
        words: format!("gps time offset: {what}"),
    });
}
