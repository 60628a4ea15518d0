//! Steps of the ground in the rangefinder's distance.

use hovernav::ekf::{Channel, Verdict};

use super::judged::Judged;
use super::spans::spans;
use crate::finding::{Finding, FindingKind, Sensor, Severity};

/// Longest time, s, between two rejections of one event.
const APART_S: f64 = 2.0;

pub(super) fn find(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let axes = log.run.reports().filter_map(|report| report.innovations().next());
    let off: Vec<(f64, f64)> = axes
        .filter(|axis| axis.channel == Channel::Range && axis.verdict != Verdict::Accepted)
        .map(|axis| (axis.time.seconds(), axis.innovation.abs()))
        .collect();
    for span in spans(off.iter().copied(), APART_S) {
        let within = |at: &&(f64, f64)| (span.start_s..=span.end_s).contains(&at.0);
        let largest_m = off.iter().filter(within).map(|at| at.1).fold(0.0, f64::max);
        let words = format!(
            "rangefinder: the distance jumped by up to {largest_m:.1} m {} in {} readings: rejected, and a \
             lasting jump counted as another ground level, not as height",
            span.when(),
            span.count
        );
        findings.push(
            Finding::warning(
                Sensor::Rangefinder,
                FindingKind::StepOfGround,
                span.bounds_s(),
                words,
            )
            .severity(Severity::Info)
            .of(span.count),
        );
    }
}
