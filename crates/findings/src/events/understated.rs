//! A receiver whose positions or velocities scatter more than the one-sigmas it states.

use super::judged::Judged;
use super::spans::when;
use crate::finding::{Finding, FindingKind, Sensor};

/// Ratio of the used to the stated one-sigmas above which the stated ones are too small. For correct ones the ratio
/// reaches 1.2, because part of the error drifts.
const UNDERSTATED: f64 = 1.5;
/// Smallest number of fixes from which the ratio is judged.
const MIN: usize = 50;

pub(super) fn find(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let fixes = &log.dataset.fixes;
    let Some((start_s, end_s)) = log.span_s().filter(|_| fixes.len() >= MIN) else { return };
    let places = fixes.iter().filter(|fix| fix.position_sigma_m.is_some()).count();
    let velocities = fixes.iter().filter(|fix| fix.velocity_sigma_mps.is_some()).count();
    let stated = [("positions", places), ("velocities", velocities)];
    for ((what, count), times) in stated.into_iter().zip(log.run.stated_times) {
        if times < UNDERSTATED || 2 * count <= fixes.len() {
            continue;
        }
        let words = format!(
            "gps understates the one-sigmas of its {what} {}: the filter used {times:.1} times the stated ones on \
             average, by the scatter of the {what}; it may have rejected good ones before",
            when(start_s, end_s)
        );
        findings.push(
            Finding::warning(Sensor::Gps, FindingKind::Understated, (start_s, end_s), words)
                .of(count),
        );
    }
}
