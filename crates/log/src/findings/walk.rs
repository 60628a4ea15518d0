//! Positions that drift from the receiver's own velocity.

use hovernav::ekf::Notice;

use super::spans::spans;
use super::{Judged, when};
use crate::finding::{Finding, FindingKind, Sensor, Severity};

/// Longest time, s, between drifting fixes of one finding.
const APART_S: f64 = 5.0;

pub(super) fn find(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let drifting = log.run.notices.iter().filter_map(|notice| match notice {
        Notice::Updated(report) => report
            .innovations()
            .next()
            .map(|axis| axis.time.seconds())
            .zip(report.position_drift_m()),
        _ => None,
    });
    findings.extend(spans(drifting, APART_S).into_iter().map(|span| Finding {
        start_s: span.start_s,
        end_s: span.end_s,
        sensor: Sensor::Gps,
        kind: FindingKind::PlaceWalks,
        severity: Severity::Warning,
        harm: None,
        count: span.count,
        words: format!(
            "gps position drifted from the receiver's own velocity {}, by up to {:.0} m: a receiver glitch or a wrong \
             velocity; the filter follows the position, and its one-sigma covers the earlier position too{}",
            when(span.start_s, span.end_s),
            span.largest,
            log.cost(span.start_s, span.end_s)
        ),
    }));
}
