//! The heading: where it came from, and what disturbed it.

use hovernav::ekf::Notice;
use hovernav::ins::HeadingSource;

use super::spans::spans;
use super::{Judged, when};
use crate::finding::{Finding, Severity};
use crate::statistics::quantile;

/// A field whose strength is off its median by this share is not the Earth's alone.
const DISTURBED: f64 = 0.25;
/// A doubt of less than this, rad (10°), is chance now and then.
const DOUBTED_RAD: f64 = 0.175;
/// Doubts no further apart than this, s, are one.
const ONE_DOUBT_S: f64 = 30.0;
/// A disturbance shorter than this, s, passes with the noise.
const LASTING_S: f64 = 3.0;

pub(super) fn find(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    start(log, findings);
    doubts(log, findings);
    disturbances(log, findings);
}

fn start(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let mut aligned = None;
    for notice in &log.run.notices {
        match notice {
            Notice::Aligned(alignment) => aligned = Some(*alignment),
            Notice::HeadingFound { time, sigma_rad, .. } => {
                let time_s = time.seconds();
                let start_s = aligned.map_or(time_s, |by| by.start.state.time.seconds());
                aligned = None;
                findings.push(Finding {
                    start_s,
                    end_s: time_s,
                    sensor: "filter",
                    kind: "heading found",
                    severity: Severity::Info,
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
                sensor: "filter",
                kind: "heading reset",
                severity: Severity::Warning,
                count: 1,
                words: format!(
                    "the heading was wrong at {:.1} s by what the fixes say: turned by {:.0}°, sure to \
                     {:.0}°; what gave it, attitude or magnetometer, is not used until it agrees",
                    time.seconds(),
                    turn_rad.to_degrees(),
                    sigma_rad.to_degrees()
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
        sensor: "filter",
        kind: "heading unknown",
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
            sensor: "filter",
            kind: "heading in doubt",
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

/// Where the magnetic field is not the Earth's.
fn disturbances(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let own = log.dataset.imu.iter();
    let own = own.filter_map(|sample| Some((sample.time, sample.magnetic_field_gauss?)));
    let apart = log.dataset.magnetometer.iter().copied();
    let strengths: Vec<(f64, f64)> = if log.dataset.magnetometer.is_empty() {
        own.map(|(time, field)| (time.seconds(), field.norm())).collect()
    } else {
        apart.map(|(time, field)| (time.seconds(), field.norm())).collect()
    };
    let mut sorted: Vec<f64> = strengths.iter().map(|(_, strength)| *strength).collect();
    let Some(usual) = quantile(&mut sorted, 0.5).filter(|usual| *usual > 0.0) else { return };
    let off = strengths
        .iter()
        .map(|&(time_s, strength)| (time_s, (strength / usual - 1.0).abs()))
        .filter(|&(_, off)| off > DISTURBED);
    for span in spans(off, 1.0) {
        if span.end_s - span.start_s < LASTING_S {
            continue;
        }
        findings.push(Finding {
            start_s: span.start_s,
            end_s: span.end_s,
            sensor: "magnetometer",
            kind: "magnetic disturbance",
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
