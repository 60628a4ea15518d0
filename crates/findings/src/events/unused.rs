//! Readings that the filter could not compare at all.

use std::ops::RangeInclusive;

use hovernav::ekf::{Aid, Notice, ResetCause, Unusable};

use super::judged::Judged;
use super::spans::spans;
use crate::finding::{Finding, FindingKind, Sensor};

/// Longest time, s, between two unused readings of one event.
const APART_S: f64 = 5.0;
/// Longest interval between spikes of a field in one event, s.
const SPIKES_S: f64 = 60.0;
/// Smallest number of spikes in an event.
const MIN_SPIKES: usize = 3;
/// Longest time, s, from the first reading of a disturbance to its report.
const BEGINS_S: f64 = 1.0;

const AIDS: [(Aid, Sensor); 6] = [
    (Aid::Gps, Sensor::Gps),
    (Aid::Attitude, Sensor::InertialUnit),
    (Aid::Magnetometer, Sensor::Magnetometer),
    (Aid::Baro, Sensor::Barometer),
    (Aid::SecondAntenna, Sensor::SecondAntenna),
    (Aid::Rangefinder, Sensor::Rangefinder),
];

/// Reasons why readings are not used, each with whether the readings came during a gap in the inertial samples.
const REASONS: [(Unusable, bool); 12] = [
    (Unusable::NotFinite, false),
    (Unusable::TooOld, false),
    (Unusable::TooOld, true),
    (Unusable::AheadOfImu, false),
    (Unusable::AheadOfImu, true),
    (Unusable::Repeated, false),
    (Unusable::Stuck, false),
    (Unusable::WrongBaseline, false),
    (Unusable::BaselineReversed, false),
    (Unusable::InconsistentWithGyros, false),
    (Unusable::Outlier, false),
    (Unusable::HorizontalFieldTooWeak, false),
];

/// Time before a gap in the inertial samples, s, within which readings also become too old because of the gap.
const WAITING_S: f64 = 0.3;

/// Time after the start, s, in which the filter's history is too short for late fixes.
const STARTING_S: f64 = 1.0;

pub(super) fn find(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let starting_s = log.span_s().map_or(f64::NEG_INFINITY, |(first_s, _)| first_s + STARTING_S);
    let last_sample = log.dataset.sample_span().map(|(_, last)| last.seconds());
    let ended_s = last_sample.unwrap_or(f64::INFINITY);
    let disturbed_s: Vec<f64> = (log.run.notices.iter())
        .filter_map(|notice| match notice {
            Notice::MagneticFieldDisturbed { time, .. } => Some(time.seconds()),
            _ => None,
        })
        .collect();
    // The first reading of a disturbance counts as an outlier, but the disturbance has its own finding.
    let begins_one = |time_s: f64| {
        let next = disturbed_s.partition_point(|&disturbed_s| disturbed_s < time_s);
        disturbed_s.get(next).is_some_and(|&disturbed_s| disturbed_s - time_s < BEGINS_S)
    };
    let gaps = gaps(log);
    let hides = |reason| matches!(reason, Unusable::AheadOfImu | Unusable::TooOld);
    let in_a_gap = |time_s: f64| gaps.iter().any(|gap| gap.contains(&time_s));
    for (aid, sensor) in AIDS {
        for (reason, of_gaps) in REASONS {
            let is_told = |time_s: f64| reason == Unusable::Outlier && begins_one(time_s);
            let moments = log.run.notices.iter().filter_map(|notice| match notice {
                Notice::NotUsed { time, aid: of, reason: why }
                    if (*of, *why) == (aid, reason)
                        && !is_told(time.seconds())
                        && of_gaps == (hides(reason) && in_a_gap(time.seconds())) =>
                {
                    Some((time.seconds(), 0.0))
                }
                _ => None,
            });
            for span in spans(moments, if reason == Unusable::Outlier { SPIKES_S } else { APART_S })
            {
                let known = findings.iter().any(|finding| {
                    reason == Unusable::Repeated
                        && finding.kind == FindingKind::FrozenFix
                        && finding.start_s <= span.start_s
                        && span.end_s <= finding.end_s
                });
                let known = known || (reason == Unusable::Outlier && span.count < MIN_SPIKES);
                if known || (reason == Unusable::TooOld && span.end_s < starting_s) {
                    continue;
                }
                let samples_ended = reason == Unusable::AheadOfImu && span.start_s >= ended_s;
                let words = format!(
                    "{sensor}: {} {aid} readings not used {}: {}",
                    span.count,
                    span.when(),
                    if samples_ended {
                        "the inertial samples had ended"
                    } else if of_gaps {
                        "the inertial samples were missing, and these readings too old when the samples resumed"
                    } else {
                        in_words(reason)
                    }
                );
                findings.push(
                    Finding::warning(sensor, kind(reason), span.bounds_s(), words).of(span.count),
                );
            }
        }
    }
}

/// Gaps in the inertial samples, s, each extended by [`WAITING_S`] before its start.
fn gaps(log: &Judged<'_>) -> Vec<RangeInclusive<f64>> {
    let of_notice = |notice: &Notice| match *notice {
        Notice::GapBridged { time, length_s }
        | Notice::CovarianceReset { time, cause: ResetCause::LongGap { length_s } } => {
            Some(time.seconds() - length_s - WAITING_S..=time.seconds())
        }
        _ => None,
    };
    log.run.notices.iter().filter_map(of_notice).collect()
}

const fn kind(reason: Unusable) -> FindingKind {
    match reason {
        Unusable::Repeated => FindingKind::FrozenFix,
        Unusable::Stuck => FindingKind::Stuck,
        Unusable::WrongBaseline => FindingKind::WrongBaseline,
        Unusable::BaselineReversed => FindingKind::Reversed,
        Unusable::Outlier => FindingKind::Spikes,
        Unusable::InconsistentWithGyros => FindingKind::AttitudeUnlikeGyros,
        _ => FindingKind::Unusable,
    }
}

const fn in_words(reason: Unusable) -> &'static str {
    match reason {
        Unusable::NotFinite => "not finite, or outside the possible range",
        Unusable::TooOld => "older than the filter's history: check clock and latency",
        Unusable::AheadOfImu => "ahead of the inertial samples: check the clock",
        Unusable::Stuck => "the same distance to the last bit while the vehicle moved",
        Unusable::WrongBaseline => {
            "the antennas found further apart, or closer, than they are mounted"
        }
        Unusable::BaselineReversed => "pointing backwards: are the two antennas exchanged?",
        Unusable::Outlier => "single spikes, off the field before and after",
        Unusable::HorizontalFieldTooWeak => {
            "without a horizontal part of the field, so without a heading"
        }
        Unusable::InconsistentWithGyros => {
            "the attitude turns unlike the gyros: it is frozen, late, smoothed or disturbed by accelerations"
        }
        _ => "frozen: the previous fix repeated while the vehicle moved",
    }
}
