//! The heading: its sources and their disturbances.

use hovernav::ekf::{Channel, Notice};
use hovernav::ins::HeadingSource;

use super::judged::Judged;
use super::spans::{Spans, spans, when};
use crate::finding::{Finding, FindingKind, Sensor, Severity};
use hovernav::frames::{Body, Vector};
use hovernav::time::Time;
use hovernav_dataset::statistics::Distribution;

/// Relative deviation of the field's strength from its median beyond which the field is disturbed.
const DISTURBED: f64 = 0.25;
/// Largest relative change of the field that an imperfect calibration of the magnetometer can explain.
const UNCALIBRATED: f64 = 0.15;
/// Largest heading difference, rad (10°), that occurs by chance; a larger one is a warning.
const SUSPECT_RAD: f64 = 0.175;
/// Longest time, s, between suspect headings of one finding.
const ONE_AMBIGUITY_S: f64 = 30.0;
/// Shortest disturbance of the field that is reported, s: a shorter one is noise.
const LASTING_S: f64 = 3.0;

pub(super) fn find(log: &Judged<'_>, field: FieldStrength, findings: &mut Vec<Finding>) {
    start(log, findings);
    checks(log, findings);
    let known = findings.len();
    field.find(findings);
    changed_fields(log, known, findings);
}

/// Heading sources of a run, as the end of a sentence on their lockout; empty without any.
fn sources(log: &Judged<'_>) -> String {
    let (mut attitude, mut magnetometer, mut antennas) = (false, false, false);
    for report in log.run.reports() {
        let has = |channel| report.innovations().any(|axis| axis.channel == channel);
        attitude |= has(Channel::Roll);
        magnetometer |= has(Channel::Yaw) && !has(Channel::Roll);
        antennas |= has(Channel::BaselineHeading);
    }
    let named = [
        (attitude, "the unit's own attitude"),
        (magnetometer, "the magnetometer"),
        (antennas, "the second antenna"),
    ];
    let named: Vec<&str> =
        named.into_iter().filter_map(|(is_used, name)| is_used.then_some(name)).collect();
    if named.is_empty() {
        return String::new();
    }
    format!("; its source, {}, is not used until it agrees", named.join(" or "))
}

/// Adds the changes of the magnetic field that the filter's field monitor reported. Changes that the field's strength
/// has shown are among `findings` from index `known` on, and are skipped.
fn changed_fields(log: &Judged<'_>, known: usize, findings: &mut Vec<Finding>) {
    let log_end_s = log.span_s().map_or(0.0, |(_, end_s)| end_s);
    let mut notices = log.run.notices.iter();
    while let Some(notice) = notices.next() {
        let Notice::MagneticFieldDisturbed { time, share, sigma_rad, .. } = notice else {
            continue;
        };
        let start_s = time.seconds();
        let restored_s = notices.clone().find_map(|notice| match notice {
            Notice::MagneticFieldUsual { time, .. } => Some(time.seconds()),
            _ => None,
        });
        let end_s = restored_s.unwrap_or(log_end_s);
        let is_reported = |found: &Finding| found.start_s < end_s && start_s < found.end_s;
        if end_s - start_s < LASTING_S || findings.iter().skip(known).any(is_reported) {
            continue;
        }
        let words = format!(
            "magnetometer disturbed {}: the field changed by {:.0} % of its strength, in size, dip or direction, \
             likely by a current or iron nearby; its heading may be off by {:.0}° and was weighted less",
            when(start_s, end_s),
            100.0 * share,
            sigma_rad.to_degrees()
        );
        findings.push(
            Finding::warning(
                Sensor::Magnetometer,
                FindingKind::MagneticDisturbance,
                (start_s, end_s),
                words,
            )
            .severity(if *share > UNCALIBRATED {
                Severity::Warning
            } else {
                Severity::Info
            }),
        );
    }
}

fn start(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let (mut aligned, mut lost_s) = (None, None);
    for notice in &log.run.notices {
        match notice {
            Notice::Aligned(alignment) => aligned = Some(*alignment),
            Notice::GapBridged { time, .. } | Notice::CovarianceReset { time, .. } => {
                lost_s = Some(time.seconds());
            }
            Notice::HeadingFound { time, sigma_rad, .. } => {
                let time_s = time.seconds();
                let start = aligned.take().map(|by| by.start.state.time.seconds());
                let start_s = start.or(lost_s).unwrap_or(time_s);
                let words = format!(
                    "heading unknown {}, then found in motion with a one-sigma of {:.1}°",
                    when(start_s, time_s),
                    sigma_rad.to_degrees()
                );
                // In flight the heading was lost; at the start it was only unknown.
                let severity = if start.is_some() { Severity::Info } else { Severity::Warning };
                findings.push(
                    Finding::warning(
                        Sensor::Filter,
                        FindingKind::HeadingFound,
                        (start_s, time_s),
                        words,
                    )
                    .severity(severity),
                );
            }
            Notice::HeadingReset { time, turn_rad, sigma_rad } => {
                let (kind, time_s) = (FindingKind::HeadingReset, time.seconds());
                let words = format!(
                    "the heading was inconsistent with GPS at {:.1} s: the filter turned it by {:.0}°, one-sigma now \
                     {:.0}°{}",
                    time.seconds(),
                    turn_rad.to_degrees(),
                    sigma_rad.to_degrees(),
                    sources(log)
                );
                findings.push(Finding::warning(Sensor::Filter, kind, (time_s, time_s), words));
            }
            _ => {}
        }
    }
    let Some(unknown) = aligned.filter(|by| by.heading == HeadingSource::Unknown) else { return };
    let start_s = unknown.start.state.time.seconds();
    let end_s = log.span_s().map_or(start_s, |(_, end_s)| end_s);
    let words = format!(
        "the heading was not found {}: too little horizontal acceleration, and no attitude or magnetometer",
        when(start_s, end_s)
    );
    findings.push(Finding::warning(
        Sensor::Filter,
        FindingKind::HeadingUnknown,
        (start_s, end_s),
        words,
    ));
}

/// Adds the headings that were suspect according to the fixes, but were not reset.
fn checks(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let checks = log.run.notices.iter().filter_map(|notice| match notice {
        Notice::HeadingSuspect { time, off_rad, .. } => Some((time.seconds(), off_rad.abs())),
        _ => None,
    });
    for span in spans(checks, ONE_AMBIGUITY_S) {
        let times = if span.count > 1 { format!(" ({} times)", span.count) } else { String::new() };
        let words = format!(
            "the heading was up to {:.0}° off {} according to GPS{times}: an error of the attitude, magnetometer \
             or mounting, or sideways drift; the filter has enlarged the one-sigmas of the heading and its \
             source",
            span.largest.to_degrees(),
            span.when(),
        );
        findings.push(
            Finding::warning(Sensor::Filter, FindingKind::HeadingSuspect, span.bounds_s(), words)
                .severity(if span.largest > SUSPECT_RAD {
                    Severity::Warning
                } else {
                    Severity::Info
                })
                .of(span.count),
        );
    }
}

/// Strength of the magnetic field and its disturbances: one pass for the median, a second for the deviations.
pub(super) struct FieldStrength {
    strengths: Distribution,
    largest: f64,
    usual: f64,
    off: Spans,
}

impl Default for FieldStrength {
    fn default() -> Self {
        Self {
            strengths: Distribution::default(),
            largest: 0.0,
            usual: 0.0,
            off: Spans::apart(1.0),
        }
    }
}

impl FieldStrength {
    pub fn look(&mut self, field_gauss: Vector<Body>) {
        let strength = field_gauss.norm();
        self.largest = self.largest.max(strength);
        self.strengths.push(strength);
    }

    /// Ends the first pass. Returns whether a second pass can find anything.
    pub fn looked(&mut self) -> bool {
        self.usual = self.strengths.quantile(0.5).unwrap_or(0.0);
        let weakest = self.strengths.quantile(0.0).unwrap_or(0.0);
        self.usual > 0.0
            && [weakest, self.largest].iter().any(|strength| self.off(*strength) > DISTURBED)
    }

    /// Relative deviation of a strength from the median.
    fn off(&self, strength: f64) -> f64 {
        (strength / self.usual - 1.0).abs()
    }

    pub fn look_again(&mut self, time: Time, field_gauss: Vector<Body>) {
        let off = self.off(field_gauss.norm());
        if self.usual > 0.0 && off > DISTURBED {
            self.off.push((time.seconds(), off));
        }
    }

    fn find(self, findings: &mut Vec<Finding>) {
        let usual = self.usual;
        for span in self.off.found {
            if span.end_s - span.start_s < LASTING_S {
                continue;
            }
            let words = format!(
                "magnetometer disturbed {}: the field is up to {:.0} % off its usual {usual:.2} gauss, likely by \
                 a current or iron nearby; its heading is off too",
                span.when(),
                100.0 * span.largest
            );
            findings.push(
                Finding::warning(
                    Sensor::Magnetometer,
                    FindingKind::MagneticDisturbance,
                    span.bounds_s(),
                    words,
                )
                .of(span.count),
            );
        }
    }
}
