//! The heading: where it came from, and what disturbed it.

use hovernav::ekf::{Channel, Notice};
use hovernav::ins::HeadingSource;

use super::spans::{Spans, spans};
use super::{Judged, when};
use crate::distribution::Distribution;
use crate::finding::{Finding, FindingKind, Sensor, Severity};
use hovernav::frames::{Body, Vector};
use hovernav::time::Time;

/// A field whose strength is off its median by this share is not the Earth's alone.
const DISTURBED: f64 = 0.25;
/// A field that comes off what it was by no more than this share may be that of a unit that is not quite calibrated.
const UNCALIBRATED: f64 = 0.15;
/// A doubt of less than this, rad (10°), is chance now and then.
const DOUBTED_RAD: f64 = 0.175;
/// Doubts no further apart than this, s, are one.
const ONE_DOUBT_S: f64 = 30.0;
/// A disturbance shorter than this, s, passes with the noise.
const LASTING_S: f64 = 3.0;

pub(super) fn find(log: &Judged<'_>, field: FieldStrength, findings: &mut Vec<Finding>) {
    start(log, findings);
    doubts(log, findings);
    let known = findings.len();
    field.find(findings);
    changed_fields(log, known, findings);
}

/// What tells the heading of a run, and that it is not used while it is distrusted.
fn sources(log: &Judged<'_>) -> String {
    let (mut attitude, mut magnetometer, mut antennas) = (false, false, false);
    for notice in &log.run.notices {
        let Notice::Updated(report) = notice else { continue };
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
        named.into_iter().filter_map(|(told, name)| told.then_some(name)).collect();
    if named.is_empty() {
        return String::new();
    }
    format!("; what told it, {}, is not used until it agrees", named.join(" or "))
}

/// Where the field came off what was usual by the filter's own watch over it, and no look at its strength, from the
/// `known`th finding on, has told already.
fn changed_fields(log: &Judged<'_>, known: usize, findings: &mut Vec<Finding>) {
    let log_end_s = log.span_s().map_or(0.0, |(_, end_s)| end_s);
    let mut notices = log.run.notices.iter();
    while let Some(notice) = notices.next() {
        let Notice::FieldDisturbed { time, share, sigma_rad, .. } = notice else { continue };
        let start_s = time.seconds();
        let restored_s = notices.clone().find_map(|notice| match notice {
            Notice::FieldUsual { time, .. } => Some(time.seconds()),
            _ => None,
        });
        let end_s = restored_s.unwrap_or(log_end_s);
        let told = |found: &Finding| found.start_s < end_s && start_s < found.end_s;
        if end_s - start_s < LASTING_S || findings.iter().skip(known).any(told) {
            continue;
        }
        findings.push(Finding {
            start_s,
            end_s,
            sensor: Sensor::Magnetometer,
            kind: FindingKind::MagneticDisturbance,
            severity: if *share > UNCALIBRATED { Severity::Warning } else { Severity::Info },
            count: 1,
            words: format!(
                "magnetometer disturbed {}: the field came off what it was by {:.0} % of its strength, in strength, dip \
                 or direction, by a current or iron nearby; the heading it gives, wrong by perhaps {:.0}°, counted for as much \
                 less",
                when(start_s, end_s),
                100.0 * share,
                sigma_rad.to_degrees()
            ),
        });
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
                findings.push(Finding {
                    start_s,
                    end_s: time_s,
                    sensor: Sensor::Filter,
                    kind: FindingKind::HeadingFound,
                    // In flight it is a loss.
                    severity: if start.is_some() { Severity::Info } else { Severity::Warning },
                    count: 1,
                    words: format!(
                        "heading unknown {}, then found in motion, sure to {:.1}°",
                        when(start_s, time_s),
                        sigma_rad.to_degrees()
                    ),
                });
            }
            Notice::HeadingReset { time, turn_rad, sigma_rad } => findings.push(Finding {
                start_s: time.seconds(),
                end_s: time.seconds(),
                sensor: Sensor::Filter,
                kind: FindingKind::HeadingReset,
                severity: Severity::Warning,
                count: 1,
                words: format!(
                    "the heading was wrong at {:.1} s by what the fixes say: turned by {:.0}°, sure to \
                     {:.0}°{}",
                    time.seconds(),
                    turn_rad.to_degrees(),
                    sigma_rad.to_degrees(),
                    sources(log)
                ),
            }),
            _ => {}
        }
    }
    let Some(unknown) = aligned.filter(|by| by.heading == HeadingSource::Unknown) else { return };
    let start_s = unknown.start.state.time.seconds();
    let end_s = log.span_s().map_or(start_s, |(_, end_s)| end_s);
    findings.push(Finding {
        start_s,
        end_s,
        sensor: Sensor::Filter,
        kind: FindingKind::HeadingUnknown,
        severity: Severity::Warning,
        count: 1,
        words: format!(
            "the heading was not found {}: too little horizontal acceleration, no attitude and no \
             magnetometer",
            when(start_s, end_s)
        ),
    });
}

/// Where the fixes doubted the heading without denying it.
fn doubts(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let doubts = log.run.notices.iter().filter_map(|notice| match notice {
        Notice::HeadingDoubted { time, off_rad, .. } => Some((time.seconds(), off_rad.abs())),
        _ => None,
    });
    for span in spans(doubts, ONE_DOUBT_S) {
        let times = if span.count > 1 { format!(" ({} times)", span.count) } else { String::new() };
        findings.push(Finding {
            start_s: span.start_s,
            end_s: span.end_s,
            sensor: Sensor::Filter,
            kind: FindingKind::HeadingInDoubt,
            severity: if span.largest > DOUBTED_RAD { Severity::Warning } else { Severity::Info },
            count: span.count,
            words: format!(
                "the heading was up to {:.0}° off {} by what the fixes say{times}: an error of the attitude or \
                 magnetometer that gave it, or of the mounting, or a drift to the side; it and its source are \
                 less sure from then on",
                span.largest.to_degrees(),
                when(span.start_s, span.end_s),
            ),
        });
    }
}

/// How strong the magnetic field is, and where it is not the Earth's: what is usual takes one look at all
/// readings, when it is not another.
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

    /// Ends the first look; whether a second can find anything.
    pub fn looked(&mut self) -> bool {
        self.usual = self.strengths.quantile(0.5).unwrap_or(0.0);
        let weakest = self.strengths.quantile(0.0).unwrap_or(0.0);
        self.usual > 0.0
            && [weakest, self.largest].iter().any(|strength| self.off(*strength) > DISTURBED)
    }

    /// Share by which a strength is off what is usual.
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
            findings.push(Finding {
                start_s: span.start_s,
                end_s: span.end_s,
                sensor: Sensor::Magnetometer,
                kind: FindingKind::MagneticDisturbance,
                severity: Severity::Warning,
                count: span.count,
                words: format!(
                    "magnetometer disturbed {}: the field is up to {:.0} % off its usual {usual:.2} gauss, \
                     by a current or iron nearby, and so is the heading it gives",
                    when(span.start_s, span.end_s),
                    100.0 * span.largest
                ),
            });
        }
    }
}
