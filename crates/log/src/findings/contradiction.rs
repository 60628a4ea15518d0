//! A receiver that contradicts itself.

use hovernav::ekf::Notice;

use super::spans::spans;
use super::{Judged, when};
use crate::finding::{Finding, FindingKind, Sensor, Severity};

/// Longest time, s, between two contradictions of one finding.
const APART_S: f64 = 10.0;

pub(super) fn find(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let contradicted = log.run.notices.iter().filter_map(|notice| match notice {
        Notice::Updated(report) if report.contradicts_itself() => {
            report.innovations().next().map(|axis| (axis.time.seconds(), 0.0))
        }
        _ => None,
    });
    let carriers = match log.dataset.baro.is_empty() {
        true => "the inertial unit carries",
        false => "inertial unit and barometer carry",
    };
    findings.extend(spans(contradicted, APART_S).into_iter().map(|span| Finding {
        start_s: span.start_s,
        end_s: span.end_s,
        sensor: Sensor::Gps,
        kind: FindingKind::ContradictsItself,
        severity: Severity::Warning,
        harm: None,
        count: span.count,
        words: format!(
            "gps contradicts itself {}: {} fixes are inconsistent with the motion that the inertial unit measured and \
             were rejected; {carriers} the solution{}",
            when(span.start_s, span.end_s),
            span.count,
            log.cost(span.start_s, span.end_s)
        ),
    }));
}
