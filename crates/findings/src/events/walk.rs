//! Positions that drift from the receiver's own velocity.

use super::judged::Judged;
use super::spans::spans;
use crate::finding::{Finding, FindingKind, Sensor};

/// Longest time, s, between drifting fixes of one finding.
const APART_S: f64 = 5.0;

pub(super) fn find(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let drifting = log.run.reports();
    let drifting =
        drifting.filter_map(|report| Some((report.time()?.seconds(), report.position_drift_m()?)));
    for span in spans(drifting, APART_S) {
        let (kind, span_s) = (FindingKind::PositionDrift, span.bounds_s());
        let words = format!(
            "gps position drifted from the receiver's own velocity {}, by up to {:.0} m: a receiver glitch or a wrong \
             velocity; the filter follows the position, and its one-sigma covers the earlier position too{}",
            span.when(),
            span.largest,
            log.cost(span.start_s, span.end_s)
        );
        findings.push(Finding::warning(Sensor::Gps, kind, span_s, words).of(span.count));
    }
}
