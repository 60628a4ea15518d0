//! Steps of a clock within a recording: a counter that starts again from zero, and a clock that is set back.

use crate::statistics::distribution::Distribution;
use crate::statistics::{median_interval_s, quantile};
use crate::table::remarks::Remarks;
use hovernav::time::Time;

const DAY: (i64, &str) = (86_400_000_000_000, "86400 s, a day");
const DAY_S: f64 = 86_400.0;
/// Periods of counters, ns, with their names.
const PERIODS: [(i64, &str); 6] = [
    (65_536_000_000, "65.536 s, 2^16 ms"),
    (4_294_967_296_000, "4294.967 s, 2^32 µs"),
    (4_294_967_296_000_000, "4294967.296 s, 2^32 ms"),
    (604_800_000_000_000, "604800 s, a week"),
    DAY,
    (3_600_000_000_000, "3600 s, an hour"),
];
/// Repetition of the first second of a day after the label 23:59:60, which is one time in UTC since 1970.
const LEAP: (i64, &str) = (1_000_000_000, "a leap second");
/// Number of entries of [`PERIODS`], from the first on, for a clock that returns to its time at the start of the log.
const COUNTERS: usize = 4;
/// Tolerance for the times at which the clocks of two sensors break, s. Also the smallest step back after which the
/// time that passed is unknown.
const MIN_S: f64 = 1.0;
/// Quantile of the intervals between rows that bounds their scatter.
const SCATTER: f64 = 0.9;
/// Largest interval between the rows before and after the end of a period, in usual intervals.
const LONGEST_INTERVALS: f64 = 3.0;
/// Shortest interval that counts as an outage, in usual intervals. Also the smallest step of a clock, in intervals of
/// the quantile [`SCATTER`].
const OUTAGE: f64 = 1.5;
/// Inverse of the smallest fraction of all rows that each side of a restart must have for two recordings.
const SHORT_PARTS: usize = 4;
/// Smallest and largest number of rows on either side of a step that are examined to confirm it.
const ROWS: [f64; 2] = [2.0, 20.0];
/// Largest number of breaks of the clock in a log; with more, the rows are shuffled.
const MAX_BREAKS: usize = 8;
/// Time assumed between the rows around a break, s; at most the step back if that is below [`MIN_S`]. The true time is
/// unknown, and is mostly one interval. Over such a gap the filter enlarges its covariance by more than the motion
/// within it.
const BREAK_S: f64 = 5.0;

/// Whether `warning` is about a step of a clock, other than a counter that starts again.
#[must_use]
pub fn is_clock_step(warning: &str) -> bool {
    let words = ["the clock goes ", "the clock may go ", "the clock of the first sensor "];
    words.into_iter().any(|words| warning.contains(words))
}

/// Steps of a log's clock, as its first sensor shows them. The clocks of the other sensors follow.
#[derive(Clone, Debug, Default)]
pub struct ClockSteps {
    first: Option<FirstClock>,
    /// Whether times are times of day. They start again at midnight, however long the interval around midnight is.
    is_of_day: bool,
}

#[derive(Clone, Debug, Default)]
struct FirstClock {
    /// First and last time of the first sensor, as logged.
    ends: Option<(Time, Time)>,
    /// Times after the shifts.
    course: Course,
    breaks: Vec<Break>,
}

/// Step back of the clock, with the times as logged.
#[derive(Clone, Copy, Debug)]
struct Break {
    before: Time,
    after: Time,
    shift_s: f64,
    /// Time assumed between the rows before and after, s.
    gap_s: f64,
    /// Whether a counter starts again at this step.
    is_period: bool,
}

impl Break {
    fn back_s(&self) -> f64 {
        self.before - self.after
    }

    /// Whether this break may lie between rows at `before` and `at`.
    fn may_be_between(&self, before: Time, at: Time, tolerance_s: f64) -> bool {
        before - self.before <= tolerance_s && self.after - at <= tolerance_s
    }
}

/// Times of a clock that runs forward: the first, the last, and the longest intervals.
#[derive(Clone, Debug, Default)]
pub(crate) struct Course {
    ends: Option<(Time, Time)>,
    intervals_s: Distribution,
    /// The longest intervals: line after the interval, time before it, and its length, s.
    longest: Vec<(u64, Time, f64)>,
}

impl Course {
    pub fn push(&mut self, line: u64, time: Time) {
        let (first, last) = self.ends.unwrap_or((time, time));
        self.ends = Some((first, last.max(time)));
        let length_s = time - last;
        if length_s <= 0.0 {
            return;
        }
        self.intervals_s.push(length_s);
        let interval = (line, last, length_s);
        if self.longest.len() <= MAX_BREAKS {
            self.longest.push(interval);
        } else if let Some(least) = self.longest.iter_mut().min_by(|a, b| a.2.total_cmp(&b.2))
            && least.2 < length_s
        {
            *least = interval;
        }
    }

    fn usual_s(&self) -> f64 {
        self.intervals_s.quantile(0.5).unwrap_or(0.0)
    }

    /// The long intervals; empty if they are too many for steps of a clock.
    fn long(&self) -> Vec<(u64, Time, f64)> {
        let least_s = OUTAGE * self.intervals_s.quantile(SCATTER).unwrap_or(0.0);
        let long: Vec<_> = self.longest.iter().filter(|one| one.2 > least_s).copied().collect();
        if long.len() <= MAX_BREAKS { long } else { Vec::new() }
    }

    /// The interval that is `excess_s` longer than the usual one and that no long interval of `other` overlaps.
    fn lone(&self, other: &Self, excess_s: f64, tolerance_s: f64) -> Option<(u64, Time, f64)> {
        let (usual_s, others) = (self.usual_s(), other.long());
        let is_alone = |(_, before, length_s): &(u64, Time, f64)| {
            let is_apart = |(_, start, other_s): &(u64, Time, f64)| {
                start.offset_by(*other_s) <= *before || *start >= before.offset_by(*length_s)
            };
            others.iter().all(is_apart)
        };
        let is_alike = |(_, _, length_s): &(u64, Time, f64)| {
            let own_s = length_s - usual_s;
            own_s > tolerance_s && (own_s - excess_s).abs() < tolerance_s
        };
        self.long().into_iter().find(|long| is_alike(long) && is_alone(long))
    }
}

/// Step forward of one of two clocks.
struct Leap {
    /// Time of the last row before the step.
    before: Time,
    /// Time to be added to the rows of the other sensor after the step, s. The times of the first sensor stay.
    shift_s: f64,
    /// Whether the two clocks agree on either side of the step, so that it cannot be an outage.
    is_sure: bool,
    words: String,
}

impl Leap {
    /// The step that explains why two clocks begin together but end apart. `place` is the unit of lines.
    fn between(first: &Course, other: &Course, place: &str) -> Option<Self> {
        let (a, b) = (first.ends?, other.ends?);
        let tolerance_s = OUTAGE * first.usual_s().max(other.usual_s());
        let late_s = b.1 - a.1;
        if late_s.abs() <= tolerance_s || b.0 - a.0 < -tolerance_s {
            return None;
        }
        let is_other = late_s > 0.0;
        let (one, another) = if is_other { (other, first) } else { (first, other) };
        let (line, before, length_s) = one.lone(another, late_s.abs(), tolerance_s)?;
        let step_s = length_s - one.usual_s();
        // A sensor that begins later cannot end later than the first, but may end earlier.
        let is_sure = is_other || b.0 - a.0 <= tolerance_s;
        let may = if is_sure { "goes" } else { "may go" };
        let mut words = match is_other {
            true => format!("{place} {line}: the clock {may} forward by {step_s:.3} s"),
            false => format!(
                "the clock of the first sensor {may} forward by {step_s:.3} s at {place} {line} of its file"
            ),
        };
        words += &format!(
            ", the other clock does not: only one of the two has this gap, and this sensor ends {:.3} s {} than the \
             first. ",
            late_s.abs(),
            if is_other { "later" } else { "earlier" }
        );
        let shift_s = if is_other { -step_s } else { step_s };
        words += &match is_sure {
            true => {
                format!("Corrected: later times of this sensor are {shift_s:+.3} s from the log")
            }
            false => "Times are used as logged".to_owned(),
        };
        Some(Self { before, shift_s, is_sure, words })
    }
}

/// Time to be added to the rows from an index on, ns, by ascending index.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Shifts(Vec<(usize, i64)>);

impl Shifts {
    /// Adds `seconds` to the rows from `index` on.
    fn add(&mut self, index: usize, seconds: f64) {
        let at = self.0.partition_point(|(from, _)| *from < index);
        let before = at.checked_sub(1).map_or(0, |last| self.0[last].1);
        self.0.insert(at, (index, before));
        for (_, added) in &mut self.0[at..] {
            *added += (1e9 * seconds).round() as i64;
        }
    }

    /// These shifts with every index replaced by the row of `rows` with that index.
    pub fn of_rows(mut self, rows: &[usize]) -> Self {
        self.0.iter_mut().for_each(|(index, _)| *index = rows[*index]);
        self
    }

    /// Shifted time of the row `index`, logged at `time`.
    pub fn apply(&self, index: usize, time: Time) -> Time {
        let after = self.0.partition_point(|(from, _)| *from <= index);
        match after.checked_sub(1) {
            Some(last) => later(time, self.0[last].1),
            None => time,
        }
    }
}

fn later(time: Time, nanoseconds: i64) -> Time {
    Time::from_nanoseconds(time.nanoseconds().saturating_add(nanoseconds))
}

impl ClockSteps {
    /// A clock whose times are times of day.
    #[must_use]
    pub fn of_day() -> Self {
        Self { is_of_day: true, ..Self::default() }
    }

    /// Records that the clock of a sensor runs forward with the times of `course`. Returns whether its times stay as
    /// logged.
    pub(crate) fn is_steady(&mut self, course: &Course, remarks: &mut Remarks) -> bool {
        let Some(first) = &self.first else {
            self.first =
                Some(FirstClock { ends: course.ends, course: course.clone(), breaks: Vec::new() });
            return true;
        };
        let leap = Leap::between(&first.course, course, remarks.place());
        let is_sure = leap.as_ref().is_some_and(|leap| leap.is_sure);
        if let Some(leap) = leap.filter(|leap| !leap.is_sure) {
            remarks.say(leap.words);
        }
        !is_sure
    }

    /// Whether the clock of the first sensor has breaks, which the other sensors may need too.
    pub(crate) fn has_breaks(&self) -> bool {
        self.first.as_ref().is_some_and(|first| !first.breaks.is_empty())
    }

    /// Whether a sensor was read before, and its clock has no breaks.
    pub(crate) fn first_is_steady(&self) -> bool {
        self.first.as_ref().is_some_and(|first| first.breaks.is_empty())
    }

    /// The shifts that make the `times` of a sensor, in the order of its file, run forward. `remarks` receives each
    /// step that no earlier sensor has shown.
    pub(crate) fn shifts(
        &mut self,
        times: &[Time],
        lines: &[u64],
        remarks: &mut Remarks,
    ) -> Shifts {
        let usual_s = median_interval_s(times).unwrap_or(0.0).max(0.0);
        let (Some(&start), Some(&end)) = (times.first(), times.last()) else {
            return Shifts::default();
        };
        let least_s = least_step_s(times);
        let mut steps: Vec<usize> =
            (1..times.len()).filter(|&index| is_step(times, index, least_s, usual_s)).collect();
        if are_shuffled(times, &steps, usual_s) {
            return Shifts::default();
        }
        // Index of each row from which on time is added, and the added time, s.
        let mut added = match &self.first {
            Some(first) => first.followed(times, usual_s, &mut steps),
            None => Vec::new(),
        };
        let mut breaks = Vec::new();
        for index in steps {
            let (before, after) = (times[index - 1], times[index]);
            let (back_s, line) = (before - after, format!("{} {}", remarks.place(), lines[index]));
            let is_restart = (after - start).abs() < MIN_S.max(LONGEST_INTERVALS * usual_s);
            let counters = if is_restart { &PERIODS[..COUNTERS] } else { &PERIODS[..] };
            let midnight = (self.is_of_day && back_s > 0.5 * DAY_S).then_some(&DAY);
            let is_leap = is_leap(before, after, usual_s);
            let leap = is_leap.then_some(&LEAP);
            let period = leap.or(midnight).or_else(|| period(counters, back_s, usual_s));
            let gap_s = if back_s < MIN_S { back_s } else { BREAK_S };
            let shift_s = if let Some((period_ns, name)) = period {
                remarks.say(format!("{line}: the clock starts again after {name}: continued"));
                // A time of day beyond the end of a day is in a leap second.
                let leap_ns =
                    if midnight.is_some() && before.nanoseconds() >= DAY.0 { LEAP.0 } else { 0 };
                (period_ns + leap_ns) as f64 * 1e-9
            } else if is_restart && SHORT_PARTS * index.min(times.len() - index) > times.len() {
                // The rows from here on are a second recording.
                continue;
            } else if self.first.is_some() {
                remarks.say(format!(
                    "{line}: the clock goes back by {back_s:.3} s, that of the first sensor does not: continued"
                ));
                back_s + usual_s
            } else {
                let shift_s = back_s + gap_s;
                remarks.say(format!(
                    "{line}: the clock goes back by {back_s:.3} s. The time that passed is unknown: read as a \
                     gap of {gap_s:.3} s, and later times are {shift_s:.3} s more than in the log"
                ));
                shift_s
            };
            added.push((index, shift_s));
            let is_period = period.is_some() && !is_leap;
            let gap_s = if is_leap { shift_s - back_s } else { gap_s };
            breaks.push(Break { before, after, shift_s, gap_s, is_period });
        }
        let mut shifts = Shifts::default();
        added.iter().for_each(|(index, shift_s)| shifts.add(*index, *shift_s));
        let mut course = Course::default();
        for (index, (time, line)) in times.iter().zip(lines).enumerate() {
            course.push(*line, shifts.apply(index, *time));
        }
        match &self.first {
            None => self.first = Some(FirstClock { ends: Some((start, end)), course, breaks }),
            Some(first) => {
                if let Some(leap) = Leap::between(&first.course, &course, remarks.place()) {
                    let is_later =
                        |index: &usize| shifts.apply(*index, times[*index]) > leap.before;
                    if leap.is_sure
                        && let Some(index) = (0..times.len()).find(is_later)
                    {
                        shifts.add(index, leap.shift_s);
                    }
                    remarks.say(leap.words);
                }
            }
        }
        shifts
    }
}

impl FirstClock {
    /// Rows of another sensor at which both its clock and that of the first sensor break, and the time to be added, s.
    /// Removes these breaks from `steps`, the steps of the other sensor's clock.
    fn followed(&self, times: &[Time], usual_s: f64, steps: &mut Vec<usize>) -> Vec<(usize, f64)> {
        let tolerance_s = LONGEST_INTERVALS * usual_s + MIN_S;
        let (mut from, mut added) = (0, Vec::new());
        for one in &self.breaks {
            let is_alike = |&index: &usize| {
                (one.back_s() - (times[index - 1] - times[index])).abs() < tolerance_s
            };
            let may_be =
                |index: &usize| one.may_be_between(times[index - 1], times[*index], tolerance_s);
            let own = steps.iter().position(is_alike).or_else(|| steps.iter().position(may_be));
            if let Some(own) = own {
                from = steps.remove(own);
                added.push((from, one.shift_s));
            } else if one.is_period {
                let is_later = |first: Time| {
                    let start = self.ends.map_or(first, |ends| ends.0);
                    from == 0 && start - first > tolerance_s && one.after - first <= tolerance_s
                };
                added.extend(is_later(times[0]).then_some((0, one.shift_s)));
            } else if let Some(index) = self.hidden(one, times, from, usual_s) {
                from = index;
                added.push((index, one.shift_s));
            } else if let Some(after) = times[from..].iter().position(|time| *time > one.before)
                && after > 0
            {
                // The clock of this sensor does not step back with that of the first: only the time between the rows is added.
                added.push((from + after, one.gap_s));
            }
        }
        added
    }

    /// Index of the first row after the break `one`, for a sensor whose rows are too far apart to show the step back.
    /// `None` if the clock of this sensor does not break together with that of the first sensor.
    fn hidden(&self, one: &Break, times: &[Time], from: usize, usual_s: f64) -> Option<usize> {
        let tolerance_s = LONGEST_INTERVALS * usual_s + MIN_S;
        let interval_s = |index: &usize| times[*index] - times[index - 1];
        let around = || {
            let from = from.max(1);
            (from..times.len())
                .filter(|&index| one.may_be_between(times[index - 1], times[index], tolerance_s))
        };
        let by_interval = |a: &usize, b: &usize| interval_s(a).total_cmp(&interval_s(b));
        let shortest = around().min_by(by_interval)?;
        if interval_s(&shortest) < usual_s - 0.5 * one.back_s() {
            return Some(shortest);
        }
        // An outage covers the break. If this clock goes on, it ends later than that of the first sensor.
        let late_s = *times.last()? - self.ends?.1;
        let goes_on = (late_s - one.back_s()).abs() < late_s.abs();
        let longest = around().max_by(by_interval)?;
        if goes_on {
            None
        } else if interval_s(&longest) > OUTAGE * usual_s {
            Some(longest)
        } else {
            // This sensor may begin after the break.
            let begins_after = from == 0 && one.after - times[0] <= tolerance_s;
            begins_after.then_some(0)
        }
    }
}

/// Smallest step back of a clock with these `times`, s; a smaller one is a row out of order.
fn least_step_s(times: &[Time]) -> f64 {
    let mut intervals_s: Vec<f64> =
        times.windows(2).map(|pair| pair[1] - pair[0]).filter(|length_s| *length_s > 0.0).collect();
    OUTAGE * quantile(&mut intervals_s, SCATTER).unwrap_or(0.0)
}

/// Whether the clock steps back at the row `index`, and stays there: a few stray rows are no step.
fn is_step(times: &[Time], index: usize, least_s: f64, usual_s: f64) -> bool {
    let (before, at) = (times[index - 1], times[index]);
    let back_s = before - at;
    if back_s <= least_s && !is_leap(before, at, usual_s) {
        return false;
    }
    let rows = (0.5 * back_s / usual_s.max(1e-9)).clamp(ROWS[0], ROWS[1]) as usize;
    let mostly = |rows: &[Time], is_so: &dyn Fn(&Time) -> bool| {
        let count = rows.iter().filter(|time| is_so(time)).count();
        rows.len() >= ROWS[0] as usize && 5 * count >= 4 * rows.len()
    };
    mostly(&times[index.saturating_sub(rows)..index], &|time| *time > at)
        && mostly(&times[index..times.len().min(index + rows)], &|time| *time < before)
}

/// Whether a clock in UTC repeats the first second of a day, because the second before it is a leap second.
fn is_leap(before: Time, at: Time, usual_s: f64) -> bool {
    let tolerance_s = LONGEST_INTERVALS * usual_s;
    let of_day_s = |time: Time| time.nanoseconds().rem_euclid(DAY.0) as f64 * 1e-9;
    let second = |time: Time| time.nanoseconds().div_euclid(LEAP.0);
    before > at
        && second(before) == second(at)
        && of_day_s(at) < tolerance_s
        && 1.0 - of_day_s(before) < tolerance_s
}

/// Period of a counter that ends where the clock goes back by `back_s`, s.
fn period(
    periods: &'static [(i64, &str)],
    back_s: f64,
    usual_s: f64,
) -> Option<&'static (i64, &'static str)> {
    let is_interval = |seconds: f64| (0.0..LONGEST_INTERVALS * usual_s).contains(&seconds);
    periods.iter().find(|(period_ns, _)| is_interval(*period_ns as f64 * 1e-9 - back_s))
}

/// Whether the rows are shuffled: their clock breaks, at `steps`, more often than that of any log.
fn are_shuffled(times: &[Time], steps: &[usize], usual_s: f64) -> bool {
    let is_break =
        |index: &&usize| period(&PERIODS, times[**index - 1] - times[**index], usual_s).is_none();
    steps.iter().filter(is_break).count() > MAX_BREAKS
}
