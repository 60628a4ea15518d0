//! Findings from the fixes alone: absent, frozen, without velocity, height held.

use hovernav::gps::Fix;

use super::judged::Judged;
use super::spans::{improbable_runs, when};
use crate::finding::{Finding, FindingKind, Sensor, Severity};
use hovernav_dataset::statistics::median_interval_s;

/// Longest span without fixes, s, that is not an outage; three usual intervals apply if they are longer.
const OUTAGE_S: f64 = 3.5;
/// Shortest repetition of a whole fix, s, that counts as frozen.
const FROZEN_S: f64 = 2.0;
/// Shortest repetition of a height, s, that counts as held: a shorter one may be real.
const HELD_S: f64 = 10.0;

pub(super) fn find(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let fixes = &log.dataset.fixes;
    outages(log, findings);
    early(log, findings);
    without_velocity(log, findings);
    let times: Vec<f64> = fixes.iter().map(|fix| fix.time.seconds()).collect();
    let said = |fix: &Fix| (fix.position, fix.horizontal_velocity_mps, fix.down_velocity_mps);
    let whole: Vec<_> = fixes.iter().map(said).collect();
    let frozen: Vec<(usize, usize)> = improbable_runs(&whole)
        .into_iter()
        .filter(|&(first, last)| times[last] - times[first] >= FROZEN_S)
        .collect();
    for &(first, last) in &frozen {
        let words = format!(
            "gps frozen {}: {} fixes repeat the previous one to the last digit: the receiver was not measuring, or \
             outputs too few digits{}",
            when(times[first], times[last]),
            last - first,
            log.cost(times[first], times[last])
        );
        findings.push(
            Finding::warning(
                Sensor::Gps,
                FindingKind::FrozenFix,
                (times[first], times[last]),
                words,
            )
            .of(last - first),
        );
    }
    let heights: Vec<f64> = fixes.iter().map(|fix| fix.position.height_m).collect();
    for (first, last) in improbable_runs(&heights) {
        let (start_s, end_s) = (times[first], times[last]);
        let is_frozen = frozen.iter().any(|&(a, b)| a <= first && last <= b);
        if end_s - start_s < HELD_S || is_frozen {
            continue;
        }
        // The log's reader has marked these fixes as two-dimensional.
        let known = fixes[first + 1..=last].iter().filter(|fix| fix.two_dimensional).count();
        let is_known = 2 * known > last - first;
        let (when, count) = (when(start_s, end_s), last - first);
        let words = match is_known {
            true => format!(
                "gps without height {when}: {count} two-dimensional fixes, used for the horizontal alone"
            ),
            false => format!(
                "gps height held at {:.1} m {when} in {count} fixes while the position moved: likely 2-D fixes, \
                 whose height is not measured",
                heights[first]
            ),
        };
        findings.push(
            Finding::warning(Sensor::Gps, FindingKind::HeightHeld, (start_s, end_s), words)
                .severity(if is_known { Severity::Info } else { Severity::Warning })
                .of(count),
        );
    }
}

fn outages(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let Some((first_s, last_s)) = log.span_s() else { return };
    let times: Vec<_> = log.dataset.fixes.iter().map(|fix| fix.time).collect();
    let longest_s = OUTAGE_S.max(3.0 * median_interval_s(&times).unwrap_or(0.0));
    let mut times_s: Vec<f64> = times.iter().map(|time| time.seconds()).collect();
    times_s.retain(|time_s| (first_s..=last_s).contains(time_s));
    times_s.push(last_s);
    let mut before_s = first_s;
    for time_s in times_s {
        let length_s = time_s - before_s;
        if length_s > longest_s {
            let end = if time_s == last_s { ", to the end of the log" } else { "" };
            let words = format!(
                "gps outage from {before_s:.1} to {time_s:.1} s: no fix for {length_s:.1} s{end}, \
                 bridged by dead reckoning{}",
                log.cost(before_s, time_s - 0.1)
            );
            findings.push(Finding::warning(
                Sensor::Gps,
                FindingKind::Outage,
                (before_s, time_s),
                words,
            ));
        }
        before_s = time_s;
    }
}

fn early(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let fixes = &log.dataset.fixes;
    let (Some(first), Some((imu, _))) = (fixes.first(), log.dataset.sample_span()) else {
        return;
    };
    let early = fixes.iter().take_while(|fix| fix.time < imu).count();
    if early > 0 {
        findings.push(
            Finding::warning(
                Sensor::Gps,
                FindingKind::FixesTooEarly,
                (first.time.seconds(), imu.seconds()),
                format!("{early} fixes before the first inertial sample have no effect"),
            )
            .severity(Severity::Info)
            .of(early),
        );
    }
}

fn without_velocity(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let fixes = &log.dataset.fixes;
    let (Some(first), Some(last)) = (fixes.first(), fixes.last()) else { return };
    let count = |lacks: fn(&Fix) -> bool| fixes.iter().filter(|fix| lacks(fix)).count();
    let horizontal = count(|fix| fix.horizontal_velocity_mps.is_none());
    let (without, words) = match horizontal {
        // The usual receiver on a telemetry link reports only speed and course.
        0 => {
            let without = count(|fix| fix.down_velocity_mps.is_none() && !fix.two_dimensional);
            let cost = "the climb rate comes from heights alone";
            (
                without,
                format!(
                    "gps vertical velocity absent in {without} of {} fixes: {cost}",
                    fixes.len()
                ),
            )
        }
        without => {
            let heading = match without == fixes.len() {
                true => ", as is a heading that has to be found in motion",
                false => "",
            };
            let cost = "velocity comes from positions and is about 1.5 times less accurate";
            let words = format!(
                "gps velocity absent in {without} of {} fixes: {cost}{heading}",
                fixes.len()
            );
            (without, words)
        }
    };
    if without == 0 {
        return;
    }
    let severity = if 10 * without > fixes.len() { Severity::Warning } else { Severity::Info };
    findings.push(
        Finding::warning(
            Sensor::Gps,
            FindingKind::VelocityAbsent,
            (first.time.seconds(), last.time.seconds()),
            words,
        )
        .severity(severity)
        .of(without),
    );
}
