//! Aids whose readings pause, end early or begin late.

use hovernav::imu::ImuSample;
use hovernav::time::Time;

use super::judged::Judged;
use crate::finding::{Finding, FindingKind, Sensor, Severity};
use hovernav_dataset::statistics::Distribution;

/// Shortest absence that is reported, s.
const ABSENT_S: f64 = 5.0;
/// Shortest absence that is reported, in usual intervals of the readings.
const ABSENT_INTERVALS: f64 = 10.0;
/// Longest time, s, from the first inertial sample to the first reading of an aid that is not late.
const LATE_S: f64 = 10.0;
/// Ratio of the reading next to a pause to the longest reading. Above it, the vehicle may have climbed out of the
/// rangefinder's range.
const FAR: f64 = 0.7;
/// Expected distance minus the longest reading, m, above which the ground is out of range.
const BEYOND_M: f64 = 2.0;
/// Expected distance, m, below which the ground is too close.
const CLOSEST_M: f64 = 0.6;

/// Times of the attitudes and magnetic fields that come with the inertial samples.
#[derive(Default)]
pub(super) struct OfUnit {
    attitude: Readings,
    field: Readings,
}

impl OfUnit {
    pub fn push(&mut self, sample: &ImuSample) {
        if sample.attitude.is_some() {
            self.attitude.push(sample.time);
        }
        if sample.magnetic_field_gauss.is_some() {
            self.field.push(sample.time);
        }
    }
}

/// Times of one aid's readings.
#[derive(Default)]
struct Readings {
    first_last: Option<(Time, Time)>,
    intervals: Distribution,
    /// Pauses: time of the last reading before and of the first reading after, s.
    pauses: Vec<(f64, f64)>,
}

impl Readings {
    fn at(times: impl IntoIterator<Item = Time>) -> Self {
        let mut readings = Self::default();
        times.into_iter().for_each(|time| readings.push(time));
        readings
    }

    fn push(&mut self, time: Time) {
        let (first, last) = self.first_last.unwrap_or((time, time));
        if self.first_last.is_some() {
            self.intervals.push(time - last);
        }
        if time - last > ABSENT_S {
            self.pauses.push((last.seconds(), time.seconds()));
        }
        self.first_last = Some((first, time));
    }
}

pub(super) fn find(log: &Judged<'_>, of_unit: OfUnit, findings: &mut Vec<Finding>) {
    let (dataset, aiding) = (log.dataset, &log.run.config.aiding);
    let of_baro = || Readings::at(dataset.baro.iter().map(|(time, _)| *time));
    let of_field = || match dataset.magnetometer.is_empty() {
        true => of_unit.field,
        false => Readings::at(dataset.magnetometer.iter().map(|(time, _)| *time)),
    };
    let of_headings = || Readings::at(dataset.headings.iter().map(|heading| heading.time));
    let of_ranges = || Readings::at(dataset.ranges.iter().map(|reading| reading.time));
    let gyros = "gyros and fixes alone carry the heading";
    for (is_used, sensor, what, cost, readings) in [
        (
            aiding.attitude,
            Sensor::InertialUnit,
            "own attitude",
            "the attitude continues without it",
            of_unit.attitude,
        ),
        (aiding.magnetometer, Sensor::Magnetometer, "reading", gyros, of_field()),
        (aiding.baro, Sensor::Barometer, "reading", "fixes alone carry the height", of_baro()),
        (aiding.second_antenna, Sensor::SecondAntenna, "heading", gyros, of_headings()),
        (
            aiding.rangefinder,
            Sensor::Rangefinder,
            "reading",
            "the height above the ground is not measured",
            of_ranges(),
        ),
    ] {
        if is_used {
            of_aid(log, (sensor, what, cost), &readings, findings);
        }
    }
}

/// Reports absences of one aid's readings during the solution.
fn of_aid(
    log: &Judged<'_>,
    (sensor, what, cost): (Sensor, &str, &str),
    readings: &Readings,
    findings: &mut Vec<Finding>,
) {
    let (Some((first, last)), Some((start_s, end_s)), Some((unit, _))) =
        (readings.first_last, log.span_s(), log.dataset.sample_span())
    else {
        return;
    };
    let usual_s = readings.intervals.quantile(0.5).unwrap_or(0.0);
    let longest_s = ABSENT_S.max(ABSENT_INTERVALS * usual_s);
    let is_late = first - unit > LATE_S.max(ABSENT_INTERVALS * usual_s);
    let late = is_late.then_some((start_s, first.seconds()));
    let ended = (last.seconds(), end_s);
    for (from_s, to_s) in late.into_iter().chain(readings.pauses.iter().copied()).chain([ended]) {
        let (from_s, to_s) = (from_s.max(start_s), to_s.min(end_s));
        if to_s - from_s - gaps_s(log, from_s, to_s) <= longest_s {
            continue;
        }
        let (begins, ends) = (from_s < first.seconds(), to_s > last.seconds());
        let cause = match (begins, ends) {
            (true, _) => "the sensor or its logging started late",
            (false, true) => "the sensor or its connection stopped until the end of the log",
            (false, false) => "the sensor or its connection paused",
        };
        let out_of_reach = sensor == Sensor::Rangefinder && is_out_of_reach(log, from_s, to_s);
        let cause = if out_of_reach { "the ground was out of range" } else { cause };
        let usual = match usual_s > 0.0 {
            true => format!(" (usually one every {usual_s:.2} s)"),
            false => String::new(),
        };
        let words = format!(
            "{sensor}: no {what} from {from_s:.1} to {to_s:.1} s, for {:.1} s{usual}: {cause}; {cost} meanwhile",
            to_s - from_s
        );
        findings.push(
            Finding::warning(sensor, FindingKind::ReadingsAbsent, (from_s, to_s), words)
                .severity(if out_of_reach { Severity::Info } else { Severity::Warning }),
        );
    }
}

/// Time without inertial samples within a span, s; such gaps have their own findings.
fn gaps_s(log: &Judged<'_>, from_s: f64, to_s: f64) -> f64 {
    let gaps = log.dataset.sample_gaps();
    let within = gaps.iter().map(|gap| {
        let after_s = gap.after.seconds();
        (to_s.min(after_s + gap.length_s) - from_s.max(after_s)).max(0.0)
    });
    within.sum()
}

/// Whether the ground was out of the rangefinder's range at some time within a span, too far or too close. The expected
/// distance is the reading next to the span plus the change of the solution's height.
fn is_out_of_reach(log: &Judged<'_>, from_s: f64, to_s: f64) -> bool {
    let ranges = &log.dataset.ranges;
    let after = ranges.partition_point(|reading| reading.time.seconds() <= from_s);
    let Some(beside) =
        after.checked_sub(1).and_then(|before| ranges.get(before)).or(ranges.first())
    else {
        return false;
    };
    let Some(height_m) = log.solution_at(beside.time.seconds()).map(|at| at.position.height_m)
    else {
        return false;
    };
    let farthest_m = ranges.iter().map(|reading| reading.range_m).fold(0.0, f64::max);
    let within = log
        .run
        .solutions
        .iter()
        .filter(|solution| (from_s..=to_s).contains(&solution.time.seconds()));
    let mut expected_m =
        within.map(|solution| beside.range_m + solution.position.height_m - height_m);
    let is_far = beside.range_m > FAR * farthest_m;
    expected_m.any(|range_m| range_m < CLOSEST_M || is_far && range_m > farthest_m + BEYOND_M)
}
