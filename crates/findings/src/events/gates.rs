//! Measurements that the gates rejected, and the filter's response.

use std::ops::Range;

use hovernav::ekf::{Channel, Notice, Report, Verdict};
use hovernav::time::Time;

use super::judged::Judged;
use super::spans::{Span, spans};
use crate::finding::{Finding, FindingKind, Harm, Sensor, Severity};

/// Channels that are accepted or rejected together.
struct Group {
    channels: &'static [Channel],
    sensor: Sensor,
    name: &'static str,
    unit: &'static str,
    scale: f64,
    /// Difference, in `unit`, above which even a short rejection causes a warning.
    large: f64,
}

const DEGREES: f64 = 180.0 / std::f64::consts::PI;

const GROUPS: [Group; 9] = [
    Group {
        channels: &[Channel::PositionNorth, Channel::PositionEast],
        sensor: Sensor::Gps,
        name: "position",
        unit: "m",
        scale: 1.0,
        large: 10.0,
    },
    Group {
        channels: &[Channel::PositionDown],
        sensor: Sensor::Gps,
        name: "height",
        unit: "m",
        scale: 1.0,
        large: 15.0,
    },
    Group {
        channels: &[Channel::VelocityNorth, Channel::VelocityEast],
        sensor: Sensor::Gps,
        name: "velocity",
        unit: "m/s",
        scale: 1.0,
        large: 5.0,
    },
    Group {
        channels: &[Channel::VelocityDown],
        sensor: Sensor::Gps,
        name: "vertical velocity",
        unit: "m/s",
        scale: 1.0,
        large: 5.0,
    },
    Group {
        channels: &[Channel::Roll, Channel::Pitch],
        sensor: Sensor::InertialUnit,
        name: "roll and pitch",
        unit: "°",
        scale: DEGREES,
        large: 15.0,
    },
    Group {
        channels: &[Channel::Yaw],
        sensor: Sensor::Magnetometer,
        name: "heading",
        unit: "°",
        scale: DEGREES,
        large: 25.0,
    },
    Group {
        channels: &[Channel::BaselineHeading],
        sensor: Sensor::SecondAntenna,
        name: "heading",
        unit: "°",
        scale: DEGREES,
        large: 15.0,
    },
    Group {
        channels: &[Channel::BaroHeight],
        sensor: Sensor::Barometer,
        name: "height",
        unit: "m",
        scale: 1.0,
        large: 15.0,
    },
    Group {
        channels: &[Channel::Yaw],
        sensor: Sensor::UnitHeading,
        name: "heading",
        unit: "°",
        scale: DEGREES,
        large: 25.0,
    },
];

/// One comparison of a group's measurement with the filter.
struct Compared {
    time_s: f64,
    size: f64,
    verdict: Verdict,
}

/// Smallest number of consecutive rejections of any size that cause a warning.
const LASTING: usize = 3;
/// Shortest duration of such consecutive rejections, s.
const LASTING_S: f64 = 2.0;
/// Time after an event, s, in which it may cause a rejection.
const AFTERMATH_S: f64 = 10.0;

pub(super) fn find(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let groups: Vec<Vec<Compared>> = GROUPS.iter().map(|group| compared(log, group)).collect();
    // All groups of the GPS receiver form one finding.
    for sensor in [0..4, 4..5, 5..6, 6..7, 7..8, 8..9] {
        let mut rejected: Vec<(f64, f64)> = groups[sensor.clone()]
            .iter()
            .flatten()
            .filter(|at| at.verdict != Verdict::Accepted)
            .map(|at| (at.time_s, at.size))
            .collect();
        rejected.sort_by(|a, b| a.0.total_cmp(&b.0));
        findings.extend(
            spans(rejected, LASTING_S).iter().map(|span| rejection(log, &groups, &sensor, span)),
        );
    }
}

/// Time after a reset to a fix, s, at which the solution shows the result of the reset.
const REOPENED_S: f64 = 1.0;

impl Judged<'_> {
    /// Whether a position fused at `time_s`, `off_m` from the filter's own position, leaves an ambiguity between the
    /// two: the one-sigma afterwards exceeds half that distance.
    fn leaves_ambiguity(&self, time_s: f64, off_m: f64) -> bool {
        let after_s = time_s + REOPENED_S;
        self.solution_at(after_s).is_some_and(|solution| {
            let [north, east, down] = solution.position_sigma_m.to_array();
            north.max(east).max(down) > 0.5 * off_m
        })
    }
}

/// Finding for the rejections of one sensor within a span.
fn rejection(
    log: &Judged<'_>,
    groups: &[Vec<Compared>],
    sensor: &Range<usize>,
    span: &Span,
) -> Finding {
    let within = |at: &&Compared| (span.start_s..=span.end_s).contains(&at.time_s);
    let first = &GROUPS[sensor.start];
    let (mut parts, mut reopened, mut large, mut is_rejected) =
        (Vec::new(), None, false, [false; GROUPS.len()]);
    let mut farthest_m = 0.0_f64;
    for index in sensor.clone() {
        let (group, readings) = (&GROUPS[index], groups[index].iter().filter(within));
        let rejected: Vec<&Compared> =
            readings.clone().filter(|at| at.verdict != Verdict::Accepted).collect();
        let largest = rejected.iter().map(|at| at.size).fold(0.0, f64::max) * group.scale;
        if rejected.is_empty() {
            continue;
        }
        is_rejected[index] = true;
        large |= largest > group.large;
        if group.unit == "m" {
            farthest_m = farthest_m.max(largest);
        }
        let opened = rejected.iter().filter(|at| at.verdict == Verdict::Reset);
        reopened = opened.map(|at| at.time_s).next_back().or(reopened);
        let (name, unit) = (group.name, group.unit);
        // In a thinned run the number of accepted readings is unknown.
        let thinned = match first.sensor {
            Sensor::Gps => log.run.fixes_thinned,
            _ => log.run.comparisons_thinned,
        };
        let of_all = if thinned == 0 { format!(" of {}", readings.count()) } else { String::new() };
        let count = rejected.len();
        parts.push(format!("{name} by up to {largest:.1} {unit} ({count}{of_all} readings)"));
    }
    let lasting = span.count >= LASTING && span.end_s - span.start_s >= LASTING_S;
    // Only a receiver's own velocity can confirm or contradict its position.
    let has_velocity = log.dataset.fixes.iter().any(|fix| fix.horizontal_velocity_mps.is_some());
    let agrees = has_velocity && !is_rejected[2] && !is_rejected[3];
    if let Some(time_s) =
        reopened.filter(|_| span.count == 1 && is_first_after_a_gap(log, first, span))
    {
        let words = format!(
            "{}: the filter was reset to it at {time_s:.1} s, after a gap in the inertial samples, in {}",
            first.sensor,
            parts.join(", "),
        );
        return Finding::warning(first.sensor, FindingKind::ResetAfterGap, span.bounds_s(), words)
            .severity(Severity::Info);
    }
    let why = match cause(log, first, span.start_s) {
        Some(why) => why,
        None if agrees => "a position jump of the receiver (glitch), as its velocity agreed".into(),
        None => "a receiver glitch or a filter error".into(),
    };
    let response = match reopened {
        Some(time_s) if agrees && log.leaves_ambiguity(time_s, farthest_m) => format!(
            "; the filter cannot tell which position is right: it was reset to that of the receiver at {time_s:.1} s, \
             and its one-sigma covers the earlier position too{}",
            log.cost(span.start_s, time_s + REOPENED_S)
        ),
        Some(time_s) => format!(
            "; the filter had rejected good readings and was reset to them at {time_s:.1} s{}",
            log.cost(span.start_s, time_s + REOPENED_S)
        ),
        None => "; the filter continued without it".into(),
    };
    let kind =
        if reopened.is_some() { FindingKind::ResetToReadings } else { FindingKind::Rejected };
    let is_warning = lasting || large || reopened.is_some();
    let severity = if is_warning { Severity::Warning } else { Severity::Info };
    let words = format!(
        "{} rejected {}, off the filter's prediction in {}: {why}{response}",
        first.sensor,
        span.when(),
        parts.join(", "),
    );
    let finding = Finding::warning(first.sensor, kind, span.bounds_s(), words)
        .severity(severity)
        .of(span.count);
    let sigmas = log.sigmas_at(span.start_s).filter(|_| reopened.is_some() && farthest_m > 0.0);
    let harm = sigmas.map(|(sigma_m, _)| Harm::of_reset(farthest_m, sigma_m));
    Finding { harm, ..finding }
}

/// Whether an event at `time` may cause a rejection at `start_s`.
fn in_aftermath(time: Time, start_s: f64) -> bool {
    (0.0..=AFTERMATH_S).contains(&(start_s - time.seconds()))
}

/// Whether these are the first attitudes or headings after a gap in the inertial samples, during which they were
/// unknown.
fn is_first_after_a_gap(log: &Judged<'_>, group: &Group, span: &Span) -> bool {
    let hides = |notice: &Notice| match notice {
        Notice::GapBridged { time, .. } => in_aftermath(*time, span.start_s),
        _ => false,
    };
    matches!(group.channels, [Channel::Yaw | Channel::Roll, ..])
        && log.run.notices.iter().any(hides)
}

/// Whether the heading in a report comes from a sensor other than the group's. The heading of the inertial unit comes
/// with roll and pitch.
fn is_of_another_fault(group: &Group, report: &Report) -> bool {
    let with_tilt = report.innovations().any(|axis| axis.channel == Channel::Roll);
    group.channels == [Channel::Yaw] && with_tilt == (group.sensor == Sensor::Magnetometer)
}

/// Comparisons of a group, in order of time.
fn compared(log: &Judged<'_>, group: &Group) -> Vec<Compared> {
    let mut all = Vec::new();
    for report in log.run.reports() {
        if is_of_another_fault(group, report) {
            continue;
        }
        let mut axes =
            report.innovations().filter(|axis| group.channels.contains(&axis.channel)).peekable();
        let Some(first) = axes.peek() else { continue };
        let (time_s, mut verdict) = (first.time.seconds(), Verdict::Accepted);
        let mut square_sum = 0.0;
        for axis in axes {
            square_sum += axis.innovation * axis.innovation;
            if axis.verdict != Verdict::Accepted {
                verdict = axis.verdict;
            }
        }
        all.push(Compared { time_s, size: square_sum.sqrt(), verdict });
    }
    all
}

/// Likely cause of a group's rejection from `start_s` on, from its sensor or from earlier events.
fn cause(log: &Judged<'_>, group: &Group, start_s: f64) -> Option<String> {
    let of_aid = match group.sensor {
        Sensor::Gps => None,
        Sensor::SecondAntenna => Some("a wrong ambiguity, a reflection or a wrong heading"),
        Sensor::UnitHeading => Some("an error of that heading or of the filter's"),
        Sensor::Magnetometer => Some("a magnetic disturbance or a wrong heading"),
        _ => Some("a disturbance of the sensor or an error of the filter"),
    };
    if let Some(why) = of_aid {
        return Some(why.into());
    }
    let recent = |time: &Time| in_aftermath(*time, start_s);
    let fixes = &log.dataset.fixes;
    let before = fixes.partition_point(|fix| fix.time.seconds() < start_s);
    let absence_s = match (before.checked_sub(1).and_then(|at| fixes.get(at)), fixes.get(before)) {
        (Some(last), Some(_)) => start_s - last.time.seconds(),
        _ => 0.0,
    };
    if absence_s > 2.5 {
        return Some(format!("filter drift in {absence_s:.1} s without fixes"));
    }
    for notice in &log.run.notices {
        match notice {
            Notice::GapBridged { time, length_s } if recent(time) => {
                return Some(format!(
                    "filter drift in a gap of {length_s:.2} s in the inertial samples"
                ));
            }
            Notice::CovarianceReset { time, .. } if recent(time) => {
                return Some("the filter had been reset".into());
            }
            Notice::SampleSuspect { time, suspicion } if recent(time) => {
                return Some(format!("the inertial samples are suspect ({suspicion})"));
            }
            Notice::HeadingFound { time, .. } if recent(time) => {
                return Some("the heading had just been found".into());
            }
            _ => {}
        }
    }
    None
}
