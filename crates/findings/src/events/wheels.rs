//! A vehicle on wheels, constrained to its road while fixes are absent.

use hovernav::ekf::Notice;

use super::judged::Judged;
use crate::finding::{Finding, FindingKind, Sensor, Severity};

pub(super) fn find(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let (_, end_s) = log.span_s().unwrap_or_default();
    let mut notices = log.run.notices.iter().filter_map(|notice| match *notice {
        Notice::WheelConstraintOn { time, sigma_mps } => Some((time.seconds(), Some(sigma_mps))),
        Notice::WheelConstraintOff { time } => Some((time.seconds(), None)),
        _ => None,
    });
    while let Some((start_s, held)) = notices.next() {
        let Some(sigma_mps) = held else { continue };
        let off_s = notices.next().map(|(off_s, _)| off_s);
        let words = format!(
            "the vehicle rolls on wheels, known from {start_s:.0} s on: without fixes the filter \
             constrains its velocity sideways and off the road to zero, one-sigma {sigma_mps:.2} m/s"
        );
        findings.push(
            Finding::warning(
                Sensor::Vehicle,
                FindingKind::OnWheels,
                (start_s, off_s.unwrap_or(end_s)),
                words,
            )
            .severity(Severity::Info),
        );
    }
}
