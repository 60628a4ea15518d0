//! Steps of a clock within a recording: a counter that starts again from zero, and a clock that is set back.

use crate::remarks::Remarks;
use crate::statistics::median_interval_s;
use hovernav::time::Time;

/// Periods of counters, ns, with their names.
const PERIODS: [(i64, &str); 6] = [
    (65_536_000_000, "65.536 s, 2^16 ms"),
    (4_294_967_296_000, "4294.967 s, 2^32 µs"),
    (4_294_967_296_000_000, "4294967.296 s, 2^32 ms"),
    (604_800_000_000_000, "604800 s, a week"),
    (86_400_000_000_000, "86400 s, a day"),
    (3_600_000_000_000, "3600 s, an hour"),
];
/// Number of the periods above, from the first, after which a clock may show the time at which the log began.
const COUNTERS: usize = 4;
/// Smallest step, s, and in intervals between rows: smaller ones are rows out of order.
const LEAST_S: f64 = 1.0;
const LEAST_INTERVALS: f64 = 5.0;
/// Largest interval between the rows around the end of a period, in usual intervals.
const LONGEST_INTERVALS: f64 = 3.0;
/// Number of rows on either side that show a step, at least and at most.
const ROWS: [f64; 2] = [2.0, 20.0];
/// Largest number of breaks in a log; with more, its rows are shuffled.
const MOST_BREAKS: usize = 8;
/// Time between the rows around a break, s. The true time is unknown, and is mostly one interval. The filter opens
/// its covariance over such a gap by more than the motion within it.
const BREAK_S: f64 = 5.0;

/// Breaks in the clock of a log, as its first sensor shows them. The other sensors follow.
#[derive(Clone, Debug, Default)]
pub struct ClockSteps(Option<Vec<Break>>);

#[derive(Clone, Copy, Debug)]
struct Break {
    /// Time before the break, with earlier shifts.
    before: Time,
    back_s: f64,
    shift_s: f64,
}

/// Nanoseconds to be added to the times of the rows from an index on, ascending.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Shifts(Vec<(usize, i64)>);

impl Shifts {
    /// The time of the row `index`.
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
    /// Notes that the first sensor of the log has no steps.
    pub(crate) fn none(&mut self) {
        self.0.get_or_insert_default();
    }

    /// Whether the first sensor has breaks, which the others may need.
    pub(crate) fn has_breaks(&self) -> bool {
        self.0.as_ref().is_some_and(|breaks| !breaks.is_empty())
    }

    /// The shifts that make the `times` of a sensor, in the order of its file, run forward. Each step that no sensor
    /// before has shown is named in `remarks`.
    pub(crate) fn shifts(
        &mut self,
        times: &[Time],
        lines: &[u64],
        remarks: &mut Remarks,
    ) -> Shifts {
        let usual_s = median_interval_s(times).unwrap_or(0.0).max(0.0);
        if times.is_empty() || are_shuffled(times, usual_s) {
            return Shifts::default();
        }
        let steps: Vec<usize> =
            (1..times.len()).filter(|&index| is_step(times, index, usual_s)).collect();
        let back_s = |index: usize| times[index - 1] - times[index];
        let mut unseen = self.0.clone().unwrap_or_default();
        // Rows at which time is added, s.
        let mut added: Vec<(usize, f64)> = Vec::new();
        for index in steps {
            let (back_s, line) = (back_s(index), format!("{} {}", remarks.place(), lines[index]));
            let from_start_s = (times[index] - times[0]).abs();
            let is_restart = from_start_s < LEAST_S.max(LONGEST_INTERVALS * usual_s);
            let counters = if is_restart { &PERIODS[..COUNTERS] } else { &PERIODS[..] };
            let known = unseen.iter().position(|known| {
                (known.back_s - back_s).abs() < LONGEST_INTERVALS * usual_s + LEAST_S
            });
            if let Some(known) = known {
                added.push((index, unseen.remove(known).shift_s));
            } else if let Some((period_ns, name)) = period(counters, back_s, usual_s) {
                added.push((index, *period_ns as f64 * 1e-9));
                remarks.say(format!("{line}: the clock starts again after {name}: continued"));
            } else if is_restart {
                // A second recording.
            } else if self.0.is_some() {
                added.push((index, back_s + usual_s));
                remarks.say(format!(
                    "{line}: the clock goes back by {back_s:.3} s, that of the first sensor does not: continued"
                ));
            } else {
                let shift_s = back_s + BREAK_S;
                added.push((index, shift_s));
                remarks.say(format!(
                    "{line}: the clock goes back by {back_s:.3} s. The time that passed is unknown: read as a \
                     gap of {BREAK_S} s, and later times are {shift_s:.3} s more than in the log"
                ));
            }
        }
        // A clock that goes on where that of the first sensor breaks only gets the gap.
        let passed = |known: &Break| {
            let after = times.partition_point(|time| *time <= known.before);
            (after > 0 && after < times.len()).then_some((after, BREAK_S))
        };
        added.extend(unseen.iter().filter_map(passed));
        added.sort_by_key(|(index, _)| *index);
        let (mut by_ns, mut shifts, mut breaks) = (0, Vec::new(), Vec::new());
        for (index, shift_s) in added {
            let before = later(times[index - 1], by_ns);
            breaks.push(Break { before, back_s: back_s(index), shift_s });
            by_ns += (1e9 * shift_s).round() as i64;
            shifts.push((index, by_ns));
        }
        // Periods are those of each sensor's own counter.
        breaks.retain(|one| period(&PERIODS, one.back_s, usual_s).is_none());
        self.0.get_or_insert(breaks);
        Shifts(shifts)
    }
}

/// Whether the clock steps back at the row `index`, and stays there: a few stray rows are no step.
fn is_step(times: &[Time], index: usize, usual_s: f64) -> bool {
    let (before, at) = (times[index - 1], times[index]);
    let back_s = before - at;
    if back_s <= LEAST_S.max(LEAST_INTERVALS * usual_s) {
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

/// The period that ends where the clock goes back by `back_s`.
fn period(
    periods: &'static [(i64, &str)],
    back_s: f64,
    usual_s: f64,
) -> Option<&'static (i64, &'static str)> {
    let is_interval = |seconds: f64| (0.0..LONGEST_INTERVALS * usual_s).contains(&seconds);
    periods.iter().find(|(period_ns, _)| is_interval(*period_ns as f64 * 1e-9 - back_s))
}

/// Whether rows are shuffled: their clock breaks more often than any clock.
fn are_shuffled(times: &[Time], usual_s: f64) -> bool {
    let is_break = |index: &usize| {
        is_step(times, *index, usual_s)
            && period(&PERIODS, times[index - 1] - times[*index], usual_s).is_none()
    };
    (1..times.len()).filter(is_break).count() > MOST_BREAKS
}
