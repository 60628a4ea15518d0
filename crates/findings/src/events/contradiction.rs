//! A receiver that contradicts itself.

use super::judged::Judged;
use super::spans::spans;
use crate::finding::{Finding, FindingKind, Sensor};

/// Longest time, s, between two contradictions of one finding.
const APART_S: f64 = 10.0;

pub(super) fn find(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let contradicted = log.run.reports().filter(|report| report.contradicts_itself());
    let contradicted = contradicted.filter_map(|report| Some((report.time()?.seconds(), 0.0)));
    let carriers = match log.dataset.baro.is_empty() {
        true => "the inertial unit carries",
        false => "inertial unit and barometer carry",
    };
    for span in spans(contradicted, APART_S) {
        let (kind, span_s) = (FindingKind::ContradictsItself, span.bounds_s());
        let words = format!(
            "gps contradicts itself {}: {} fixes are inconsistent with the motion that the inertial unit measured and \
             were rejected; {carriers} the solution{}",
            span.when(),
            span.count,
            log.cost(span.start_s, span.end_s)
        );
        findings.push(Finding::warning(Sensor::Gps, kind, span_s, words).of(span.count));
    }
}
