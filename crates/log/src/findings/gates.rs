//! Measurements that the gates refused, and what became of the filter.

use std::ops::Range;

use hovernav::ekf::{Channel, Notice, Report, Verdict};
use hovernav::time::Time;

use super::spans::{Span, spans};
use super::{Judged, when};
use crate::finding::{Finding, FindingKind, Sensor, Severity};

/// What is refused and taken together.
struct Group {
    channels: &'static [Channel],
    sensor: Sensor,
    name: &'static str,
    unit: &'static str,
    scale: f64,
    /// Refusals of more than this, in the unit, are worth a word even where they are short.
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

/// One comparison of a group.
struct Compared {
    time_s: f64,
    size: f64,
    verdict: Verdict,
}

/// Refusals in so many measurements in a row and for so long, s, are a warning whatever their size.
const LASTING: usize = 3;
const LASTING_S: f64 = 2.0;
/// A disagreement this soon after trouble, s, comes of it.
const AFTERMATH_S: f64 = 10.0;

pub(super) fn find(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let groups: Vec<Vec<Compared>> = GROUPS.iter().map(|group| compared(log, group)).collect();
    // What one receiver says is refused together, whichever of its groups begins.
    for sensor in [0..4, 4..5, 5..6, 6..7, 7..8, 8..9] {
        let mut refused: Vec<(f64, f64)> = groups[sensor.clone()]
            .iter()
            .flatten()
            .filter(|at| at.verdict != Verdict::Accepted)
            .map(|at| (at.time_s, at.size))
            .collect();
        refused.sort_by(|a, b| a.0.total_cmp(&b.0));
        findings.extend(
            spans(refused, LASTING_S).iter().map(|span| refusal(log, &groups, &sensor, span)),
        );
    }
}

/// A filter that is reopened by a fix has taken it in so long, s, after the fix's time.
const REOPENED_S: f64 = 1.0;

impl Judged<'_> {
    /// Whether a position that was `off_m` from where the filter was, and is taken at `time_s`, leaves it in doubt
    /// between the two.
    fn disputes(&self, time_s: f64, off_m: f64) -> bool {
        let after_s = time_s + REOPENED_S;
        self.solution_at(after_s).is_some_and(|solution| {
            let [north, east, down] = solution.position_sigma_m.to_array();
            north.max(east).max(down) > 0.5 * off_m
        })
    }
}

/// Refusals of one sensor, in a sentence.
fn refusal(
    log: &Judged<'_>,
    groups: &[Vec<Compared>],
    sensor: &Range<usize>,
    span: &Span,
) -> Finding {
    let within = |at: &&Compared| (span.start_s..=span.end_s).contains(&at.time_s);
    let first = &GROUPS[sensor.start];
    let (mut parts, mut reopened, mut large, mut is_refused) =
        (Vec::new(), None, false, [false; GROUPS.len()]);
    let mut farthest_m = 0.0_f64;
    for index in sensor.clone() {
        let (group, heard) = (&GROUPS[index], groups[index].iter().filter(within));
        let refused: Vec<&Compared> =
            heard.clone().filter(|at| at.verdict != Verdict::Accepted).collect();
        let largest = refused.iter().map(|at| at.size).fold(0.0, f64::max) * group.scale;
        if refused.is_empty() {
            continue;
        }
        is_refused[index] = true;
        large |= largest > group.large;
        if group.unit == "m" {
            farthest_m = farthest_m.max(largest);
        }
        let opened = refused.iter().filter(|at| at.verdict == Verdict::Reopened);
        reopened = opened.map(|at| at.time_s).next_back().or(reopened);
        let (name, unit) = (group.name, group.unit);
        // Of a thinned run it is not known how many were accepted in between.
        let left_out = match first.sensor {
            Sensor::Gps => log.run.fixes_left_out,
            _ => log.run.comparisons_left_out,
        };
        let of_all = if left_out == 0 { format!(" of {}", heard.count()) } else { String::new() };
        let count = refused.len();
        parts.push(format!("{name} by up to {largest:.1} {unit} ({count}{of_all} readings)"));
    }
    let lasting = span.count >= LASTING && span.end_s - span.start_s >= LASTING_S;
    // The velocity's gate tells whether the receiver contradicts itself.
    let told = log.dataset.fixes.iter().any(|fix| fix.horizontal_velocity_mps.is_some());
    let agrees = told && !is_refused[2] && !is_refused[3];
    if let Some(time_s) =
        reopened.filter(|_| span.count == 1 && is_first_after_a_gap(log, first, span))
    {
        return Finding {
            start_s: span.start_s,
            end_s: span.end_s,
            sensor: first.sensor,
            kind: FindingKind::TakenAnew,
            severity: Severity::Info,
            count: 1,
            words: format!(
                "{} taken anew at {time_s:.1} s, after a gap in the inertial samples: {}",
                first.sensor,
                parts.join(", "),
            ),
        };
    }
    let why = match cause(log, first, span.start_s) {
        Some(why) => why,
        None if agrees => "a jump of the receiver (glitch), as its velocity agreed".into(),
        None => "a glitch of the receiver or an error of the filter".into(),
    };
    let response = match reopened {
        Some(time_s) if agrees && log.disputes(time_s, farthest_m) => format!(
            "; with nothing that tells which is right, the filter took it at {time_s:.1} s, and its one-sigma reaches \
             back to where it was before{}",
            log.cost(span.start_s, time_s + REOPENED_S)
        ),
        Some(time_s) => format!(
            "; the filter had locked itself out, and was reopened and took it at {time_s:.1} s{}",
            log.cost(span.start_s, time_s + REOPENED_S)
        ),
        None => "; the filter went on without it".into(),
    };
    Finding {
        start_s: span.start_s,
        end_s: span.end_s,
        sensor: first.sensor,
        kind: if reopened.is_some() { FindingKind::FilterReopened } else { FindingKind::Refused },
        severity: if lasting || large || reopened.is_some() {
            Severity::Warning
        } else {
            Severity::Info
        },
        count: span.count,
        words: format!(
            "{} refused {}, off what the filter expected in {}: {why}{response}",
            first.sensor,
            when(span.start_s, span.end_s),
            parts.join(", "),
        ),
    }
}

/// Whether what happens at `start_s` may come of trouble at `time`.
fn in_aftermath(time: Time, start_s: f64) -> bool {
    (0.0..=AFTERMATH_S).contains(&(start_s - time.seconds()))
}

/// Whether it is the attitude or heading that a gap has hidden, taken as it is told again.
fn is_first_after_a_gap(log: &Judged<'_>, group: &Group, span: &Span) -> bool {
    let hides = |notice: &Notice| match notice {
        Notice::GapBridged { time, .. } => in_aftermath(*time, span.start_s),
        _ => false,
    };
    matches!(group.channels, [Channel::Yaw | Channel::Roll, ..])
        && log.run.notices.iter().any(hides)
}

/// Whether the heading of a report is of another sensor than the group's: the unit's own comes with its tilt.
fn tells_another(group: &Group, report: &Report) -> bool {
    let with_tilt = report.innovations().any(|axis| axis.channel == Channel::Roll);
    group.channels == [Channel::Yaw] && with_tilt == (group.sensor == Sensor::Magnetometer)
}

/// What the run says of a group, measurement by measurement.
fn compared(log: &Judged<'_>, group: &Group) -> Vec<Compared> {
    let reports = log.run.notices.iter().filter_map(|notice| match notice {
        Notice::Updated(report) => Some(report),
        _ => None,
    });
    let mut all = Vec::new();
    for report in reports {
        if tells_another(group, report) {
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

/// Why a group was refused from `start_s` on, as far as the sensor or what went before tells.
fn cause(log: &Judged<'_>, group: &Group, start_s: f64) -> Option<String> {
    let of_aid = match group.sensor {
        Sensor::Gps => None,
        Sensor::SecondAntenna => Some("a wrong ambiguity, a reflection or a wrong heading"),
        Sensor::UnitHeading => Some("an error of that or a wrong heading"),
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
        return Some(format!("drift of the filter in {absence_s:.1} s without fixes"));
    }
    for notice in &log.run.notices {
        match notice {
            Notice::GapBridged { time, length_s } if recent(time) => {
                return Some(format!(
                    "drift of the filter in a gap of {length_s:.2} s in the inertial samples"
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
