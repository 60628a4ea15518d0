//! A receiver whose places or velocities scatter by more than it states of them.

use super::{Judged, when};
use crate::finding::{Finding, FindingKind, Sensor, Severity};

/// One-sigmas that count for more than so many times what was stated are too small; where they are right, for a part of
/// them wanders, up to 1.2 was seen.
const UNDERSTATED: f64 = 1.5;
/// Fewer fixes tell nothing.
const LEAST: usize = 50;

pub(super) fn find(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let fixes = &log.dataset.fixes;
    let Some((start_s, end_s)) = log.span_s().filter(|_| fixes.len() >= LEAST) else { return };
    let places = fixes.iter().filter(|fix| fix.position_sigma_m.is_some()).count();
    let velocities = fixes.iter().filter(|fix| fix.velocity_sigma_mps.is_some()).count();
    let stated = [("places", places), ("velocities", velocities)];
    for ((what, count), times) in stated.into_iter().zip(log.run.stated_times) {
        if times < UNDERSTATED || 2 * count <= fixes.len() {
            continue;
        }
        findings.push(Finding {
            start_s,
            end_s,
            sensor: Sensor::Gps,
            kind: FindingKind::Understated,
            severity: Severity::Warning,
            count,
            words: format!(
                "gps states its {what} surer than they are {}: their one-sigmas count for {times:.1} times as much in \
                 the mean, by what the {what} scatter; right ones may have been refused before that was known",
                when(start_s, end_s)
            ),
        });
    }
}
