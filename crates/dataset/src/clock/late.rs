//! Rows that a logger wrote late, and rows that it wrote twice.

use std::collections::{BTreeSet, HashSet};
use std::fmt::Debug;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::ops::RangeInclusive;

use crate::clock::steps::{ClockSteps, Shifts};
use crate::statistics::median_interval_s;
use crate::table::remarks::Remarks;
use hovernav::time::Time;

/// Interval between rows that fill a gap, in usual intervals.
const FILLING: RangeInclusive<f64> = 0.75..=1.5;

/// Largest number of steps of the clock and of stray rows up to which late rows are searched.
const MAX_BREAKS: usize = 100;

pub(crate) fn is_rising(times: &[Time]) -> bool {
    times.windows(2).all(|pair| pair[0] < pair[1])
}

/// Fingerprint of the content of `row`, without its time.
pub(crate) fn print<T: Debug>(row: &mut T, time: impl Fn(&mut T) -> &mut Time) -> u64 {
    let stamp = std::mem::replace(time(row), Time::from_nanoseconds(0));
    let mut hasher = DefaultHasher::new();
    format!("{row:?}").hash(&mut hasher);
    *time(row) = stamp;
    hasher.finish()
}

/// State of each row of a file: in order or a step of the clock, written late, or written twice.
#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    InOrder,
    Late,
    Twice,
}

/// State of all rows of a file; empty if their times rise.
#[derive(Debug)]
pub(crate) struct Late(Vec<State>);

impl Late {
    /// The states of rows with these `times` and fingerprints. `first_is_steady` states that the clock of the first
    /// sensor runs forward.
    pub fn of(times: &[Time], prints: &[u64], first_is_steady: bool) -> Self {
        if is_rising(times) {
            return Self(Vec::new());
        }
        let usual_s = median_interval_s(times).unwrap_or(0.0);
        let mut states = vec![State::InOrder; times.len()];
        let (mut rows, mut known) = (HashSet::new(), BTreeSet::new());
        let (mut index, mut breaks) = (0, 0);
        while let Some(&time) = times.get(index).filter(|_| breaks <= MAX_BREAKS) {
            let last = known.last().copied().unwrap_or(time);
            if time >= last {
                rows.insert((time, prints[index]));
                known.insert(time);
                index += 1;
                continue;
            }
            let behind = times[index..].iter().position(|time| *time > last);
            let end = behind.map_or(times.len(), |rows| index + rows);
            let is_known = |row: usize| rows.contains(&(times[row], prints[row]));
            let is_varied = || prints[index..end].iter().any(|print| *print != prints[index]);
            let state = if (index..end).all(is_known) && (first_is_steady || is_varied()) {
                State::Twice
            } else if fill(&times[index..end], &known, usual_s) {
                State::Late
            } else {
                // The clock steps at this row: the later times are compared only with each other.
                breaks += 1;
                rows.clear();
                known.clear();
                continue;
            };
            for row in index..end {
                states[row] = state;
                rows.insert((times[row], prints[row]));
                known.insert(times[row]);
            }
            index = end;
        }
        Self(states)
    }

    pub fn has_late(&self) -> bool {
        self.0.contains(&State::Late)
    }

    /// Counts the rows that are not in order.
    pub fn remark(&self, lines: &[u64], remarks: &mut Remarks) {
        for (state, line) in self.0.iter().zip(lines) {
            match state {
                State::InOrder => {}
                State::Late => {
                    remarks.count("written late: moved to the gap in time that it fills", *line);
                }
                State::Twice => remarks.count("skipped: written twice", *line),
            }
        }
    }

    /// The shifts of [`ClockSteps::shifts`] from the rows in order.
    pub fn shifts(
        &self,
        times: &[Time],
        lines: &[u64],
        steps: &mut ClockSteps,
        remarks: &mut Remarks,
    ) -> Shifts {
        if self.0.iter().all(|state| *state == State::InOrder) {
            return steps.shifts(times, lines, remarks);
        }
        let rows: Vec<usize> =
            (0..times.len()).filter(|row| self.0[*row] == State::InOrder).collect();
        let times: Vec<Time> = rows.iter().map(|row| times[*row]).collect();
        let lines: Vec<u64> = rows.iter().map(|row| lines[*row]).collect();
        steps.shifts(&times, &lines, remarks).of_rows(&rows)
    }

    /// Indices of the rows that were not written twice, with late rows sorted in by their `times`, and indices of the
    /// other rows.
    pub fn sorted(&self, times: &[Time]) -> (Vec<usize>, Vec<usize>) {
        let is_new = |row: &usize| self.0.get(*row) != Some(&State::Twice);
        let (mut rows, twice): (Vec<usize>, Vec<usize>) = (0..times.len()).partition(is_new);
        if self.has_late() {
            rows.sort_by_key(|row| times[*row]);
        }
        (rows, twice)
    }
}

/// Whether the rows at `times` fill gaps between the `known` times.
fn fill(mut times: &[Time], known: &BTreeSet<Time>, usual_s: f64) -> bool {
    while let Some(first) = times.first() {
        let (Some(before), Some(after)) =
            (known.range(..*first).next_back(), known.range(*first..).next())
        else {
            return false;
        };
        let count = times.iter().take_while(|time| *time < after).count();
        let interval_s = (*after - *before) / (count + 1) as f64;
        if count == 0 || !is_rising(&times[..count]) || !FILLING.contains(&(interval_s / usual_s)) {
            return false;
        }
        times = &times[count..];
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Order of rows with these times, ms, and contents, and the remarks.
    fn ordered(rows: &[(i64, u64)]) -> (Vec<usize>, Vec<String>) {
        let times: Vec<Time> =
            rows.iter().map(|(ms, _)| Time::from_nanoseconds(1_000_000 * ms)).collect();
        let prints: Vec<u64> = rows.iter().map(|(_, print)| *print).collect();
        let lines: Vec<u64> = (2..).take(rows.len()).collect();
        let (late, mut remarks) = (Late::of(&times, &prints, false), Remarks::new("imu.csv"));
        late.remark(&lines, &mut remarks);
        (late.sorted(&times).0, remarks.into_warnings().collect())
    }

    fn block(rows: std::ops::Range<i64>) -> impl Iterator<Item = (i64, u64)> {
        rows.map(|row| (10 * row, row as u64))
    }

    #[test]
    fn blocks_written_in_the_wrong_order_are_sorted_in() {
        let rows: Vec<_> = block(0..100)
            .chain(block(400..700))
            .chain(block(100..400))
            .chain(block(700..800))
            .collect();
        let (order, warnings) = ordered(&rows);
        assert!(order.windows(2).all(|pair| rows[pair[0]] < rows[pair[1]]) && order.len() == 800);
        let expected = "imu.csv: 300 rows, the first at line 402, written late: moved to the gap in time that it fills";
        assert_eq!(warnings, [expected]);
    }

    #[test]
    fn a_block_written_twice_is_skipped_once_but_a_clock_that_steps_back_is_not() {
        let rows: Vec<_> = block(0..300).chain(block(100..500)).collect();
        let (order, warnings) = ordered(&rows);
        assert_eq!(order, (0..300).chain(500..700).collect::<Vec<_>>());
        assert_eq!(warnings, ["imu.csv: 200 rows, the first at line 302, skipped: written twice"]);
        // A clock that steps back by whole intervals repeats times as well, but with other contents.
        let other = block(100..500).map(|(ms, print)| (ms, print + 7));
        let rows: Vec<_> = block(0..300).chain(other).collect();
        let (order, warnings) = ordered(&rows);
        assert_eq!((order.len(), warnings.len()), (700, 0));
    }

    #[test]
    fn shuffled_rows_take_bounded_time() {
        let rows: Vec<_> = (0..200_000).rev().map(|row| (10 * row, row as u64)).collect();
        assert_eq!(ordered(&rows).0.len(), 200_000);
    }
}
