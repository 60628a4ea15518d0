//! Time order: selection of rows where a clock stutters, jumps or restarts.

pub(crate) mod batch;
mod late;
pub(crate) mod ordered;
pub(crate) mod steps;

use std::fmt::Debug;
use std::path::Path;

use crate::clock::late::{Late, is_rising};
use crate::clock::steps::{ClockSteps, Course, Shifts};
use crate::error::LogError;
use crate::statistics::distribution::Distribution;
use crate::table::remarks::{REPEATED, Remarks};
use hovernav::time::Time;

/// Rows of a file in the order found, each with its line, or its byte offset in a binary file.
#[derive(Debug)]
pub struct Rows<T> {
    rows: Vec<T>,
    lines: Vec<u64>,
}

/// Largest number of rows that count as stray in a file of any size.
const STRAY_ROWS: usize = 10;
/// Smallest distance from all other rows, s, at which a few rows count as stray. Their times are garbled, or the clock
/// was not set yet.
const STRAY_GAP_S: f64 = 3600.0;

impl<T> Default for Rows<T> {
    fn default() -> Self {
        Self { rows: Vec::new(), lines: Vec::new() }
    }
}

impl<T> Rows<T> {
    /// A list without rows.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds the row found at `line`.
    pub fn push(&mut self, line: u64, row: T) {
        self.rows.push(row);
        self.lines.push(line);
    }

    /// All rows with their lines.
    pub(crate) fn into_rows(self) -> impl Iterator<Item = (u64, T)> {
        self.lines.into_iter().zip(self.rows)
    }

    /// Selects rows with strictly increasing times, and returns them with their lines. As few rows as possible are
    /// skipped. `time` gives access to the time of a row. Where the clock steps back, the rows after the step get later
    /// times: see [`ClockSteps`]. Rows written late are moved to the gap that they fill, and rows written twice are
    /// skipped.
    ///
    /// If a single time is far ahead, only that row is skipped, not all rows after it. A few rows more than an hour
    /// from all others are skipped too.
    ///
    /// # Errors
    /// [`LogError::Clock`] if more than ten rows and more than a quarter of all would be skipped: the file has a second
    /// recording, or is shuffled. Rows that repeat the time of the row before do not count.
    pub fn in_time_order(
        mut self,
        time: impl Fn(&mut T) -> &mut Time,
        path: &Path,
        steps: &mut ClockSteps,
        remarks: &mut Remarks,
    ) -> Result<(Vec<T>, Vec<u64>), LogError>
    where
        T: Debug,
    {
        let (times, prints) = self.times(&time);
        let order = looked_again(times, &prints, &self.lines, path, steps, remarks)?;
        self.shift(&time, &order.shifts);
        let mut skipped = order.skipped.into_iter().peekable();
        let staying =
            self.into_rows().enumerate().filter(|(index, _)| skipped.next_if_eq(index).is_none());
        let mut rows: Vec<(Time, (u64, T))> =
            staying.map(|(_, (line, mut row))| (*time(&mut row), (line, row))).collect();
        if order.has_late {
            rows.sort_by_key(|(time, _)| *time);
        }
        let (lines, rows) = rows.into_iter().map(|(_, row)| row).unzip();
        Ok((rows, lines))
    }

    /// The rows in the order of the file, with their times on the clock of the first sensor.
    pub fn shifted(mut self, time: impl Fn(&mut T) -> &mut Time, steps: &mut ClockSteps) -> Vec<T>
    where
        T: Debug,
    {
        let (times, prints) = self.times(&time);
        let late = Late::of(&times, &prints, steps.first_is_steady());
        let shifts = late.shifts(&times, &self.lines, steps, &mut Remarks::new(""));
        self.shift(&time, &shifts);
        self.rows
    }

    /// The times of the rows, and if they do not rise, the fingerprints of the rows.
    fn times(&mut self, time: &impl Fn(&mut T) -> &mut Time) -> (Vec<Time>, Vec<u64>)
    where
        T: Debug,
    {
        let times: Vec<Time> = self.rows.iter_mut().map(|row| *time(row)).collect();
        let prints = match is_rising(&times) {
            true => Vec::new(),
            false => self.rows.iter_mut().map(|row| late::print(row, time)).collect(),
        };
        (times, prints)
    }

    fn shift(&mut self, time: &impl Fn(&mut T) -> &mut Time, shifts: &Shifts) {
        for (index, row) in self.rows.iter_mut().enumerate() {
            let time = time(row);
            *time = shifts.apply(index, *time);
        }
    }
}

const STRAY: &str = "rejected: more than an hour from all the others";

/// For each row, whether it stays, from the `times` and `lines` of all rows: see [`Rows::in_time_order`].
fn kept(
    times: &[Time],
    lines: &[u64],
    path: &Path,
    remarks: &mut Remarks,
) -> Result<Vec<bool>, LogError> {
    let mut keep = vec![true; times.len()];
    if !is_rising(times) {
        keep = longest_increasing(times);
        remark(times, lines, &keep, path, remarks)?;
    }
    for stray in strays(times, &keep) {
        keep[stray] = false;
        remarks.count(STRAY, lines[stray]);
    }
    Ok(keep)
}

fn remark(
    times: &[Time],
    lines: &[u64],
    keep: &[bool],
    path: &Path,
    remarks: &mut Remarks,
) -> Result<(), LogError> {
    let mut disordered = 0;
    for index in (0..times.len()).filter(|index| !keep[*index]) {
        if index > 0 && times[index] == times[index - 1] {
            remarks.count(REPEATED, lines[index]);
        } else {
            remarks.count("skipped: time out of order", lines[index]);
            disordered += 1;
        }
    }
    let goes_back = times.windows(2).position(|pair| pair[1] < pair[0]);
    if let Some(before) = goes_back
        && disordered > STRAY_ROWS
        && 4 * disordered > times.len()
    {
        return Err(LogError::Clock {
            path: path.to_path_buf(),
            line: lines[before + 1],
            before: times[before],
            found: times[before + 1],
            skipped: disordered,
            rows: times.len(),
        });
    }
    Ok(())
}

/// First pass over the rows of a file, which selects the rows to skip so that time runs forward. Rows with the time of
/// the row before are always skipped, and counted separately.
#[derive(Debug, Default)]
pub(crate) struct FirstLook {
    rows: usize,
    last: Option<Time>,
    /// Number of rows with the time of the row before, and the line of the first such row.
    repeated: (usize, u64),
    groups: Vec<Group>,
    course: Course,
    goes_back: bool,
}

/// Successive rows at most an hour apart.
#[derive(Debug, Default)]
struct Group {
    rows: usize,
    /// Index and line of the first rows of the group.
    first: Vec<(usize, u64)>,
}

impl FirstLook {
    /// Adds a row; returns whether its time differs from that of the row before.
    pub fn push(&mut self, line: u64, time: Time) -> bool {
        let index = self.rows;
        self.rows += 1;
        let before = self.last.replace(time);
        if before == Some(time) {
            if self.repeated.0 == 0 {
                self.repeated.1 = line;
            }
            self.repeated.0 += 1;
            return false;
        }
        self.goes_back |= before.is_some_and(|before| time < before);
        self.course.push(line, time);
        if before.is_none_or(|before| time - before > STRAY_GAP_S) {
            self.groups.push(Group::default());
        }
        if let Some(group) = self.groups.last_mut() {
            group.rows += 1;
            if group.first.len() < STRAY_ROWS {
                group.first.push((index, line));
            }
        }
        true
    }

    /// Indices of the rows to skip, in rising order. `None` if time goes back in this file or in the file of the first
    /// sensor, or if times have to be shifted. The caller then has to use [`looked_again`].
    pub fn skipped(mut self, steps: &mut ClockSteps, remarks: &mut Remarks) -> Option<Vec<usize>> {
        if self.goes_back || steps.has_breaks() || !steps.is_steady(&self.course, remarks) {
            return None;
        }
        let (count, line) = self.repeated;
        (0..count).for_each(|_| remarks.count(REPEATED, line));
        if let Some(largest) = (0..self.groups.len()).max_by_key(|&index| self.groups[index].rows) {
            self.groups.remove(largest);
        }
        self.groups.retain(|group| group.rows <= STRAY_ROWS);
        let strays = self.groups.into_iter().flat_map(|group| group.first);
        Some(
            strays
                .inspect(|(_, line)| remarks.count(STRAY, *line))
                .map(|(index, _)| index)
                .collect(),
        )
    }
}

/// Order of the rows of a file: the skipped rows, and the shifts of the times.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Order {
    /// Indices of the rows that are skipped so that time runs forward, in rising order. A row that repeats the time of
    /// the previous row may be absent from this list.
    pub skipped: Vec<usize>,
    pub shifts: Shifts,
    /// Whether rows were written late, so that the rows that stay have to be sorted by time.
    pub has_late: bool,
}

/// Determines the order of the rows from their `times` and `lines`, and from their fingerprints if the times do not
/// rise.
///
/// # Errors
/// As [`Rows::in_time_order`].
pub(crate) fn looked_again(
    mut times: Vec<Time>,
    prints: &[u64],
    lines: &[u64],
    path: &Path,
    steps: &mut ClockSteps,
    remarks: &mut Remarks,
) -> Result<Order, LogError> {
    let late = Late::of(&times, prints, steps.first_is_steady());
    late.remark(lines, remarks);
    let shifts = late.shifts(&times, lines, steps, remarks);
    for (index, time) in times.iter_mut().enumerate() {
        *time = shifts.apply(index, *time);
    }
    let (rows, mut skipped) = late.sorted(&times);
    let times: Vec<Time> = rows.iter().map(|row| times[*row]).collect();
    let lines: Vec<u64> = rows.iter().map(|row| lines[*row]).collect();
    let keep = kept(&times, &lines, path, remarks)?;
    skipped.extend(rows.iter().zip(keep).filter(|(_, keep)| !keep).map(|(row, _)| *row));
    skipped.sort_unstable();
    Ok(Order { skipped, shifts, has_late: late.has_late() })
}

/// Marks a longest strictly increasing subsequence, by patience sorting in O(n log n).
fn longest_increasing(times: &[Time]) -> Vec<bool> {
    // For each length: index of the last row of a subsequence of that length, the one that ends earliest.
    let mut ends: Vec<usize> = Vec::new();
    let mut previous: Vec<Option<usize>> = Vec::with_capacity(times.len());
    for (index, time) in times.iter().enumerate() {
        let length = ends.partition_point(|&end| times[end] < *time);
        previous.push(length.checked_sub(1).map(|shorter| ends[shorter]));
        match ends.get_mut(length) {
            // Of rows with equal times the first one stays.
            Some(end) if times[*end] == *time => {}
            Some(end) => *end = index,
            None => ends.push(index),
        }
    }
    let mut keep = vec![false; times.len()];
    let mut next = ends.last().copied();
    while let Some(index) = next {
        keep[index] = true;
        next = previous[index];
    }
    keep
}

/// Indices of kept rows in small groups far from all others; the largest group always stays.
fn strays(times: &[Time], keep: &[bool]) -> Vec<usize> {
    let kept: Vec<usize> = (0..times.len()).filter(|&index| keep[index]).collect();
    let mut groups: Vec<&[usize]> =
        kept.chunk_by(|&a, &b| times[b] - times[a] <= STRAY_GAP_S).collect();
    if let Some(largest) = (0..groups.len()).max_by_key(|&group| groups[group].len()) {
        groups.remove(largest);
    }
    groups.retain(|group| group.len() <= STRAY_ROWS);
    groups.concat()
}

/// An interval without samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Time of the last sample before the gap.
    pub after: Time,
    /// Time from that sample to the next one, s.
    pub length_s: f64,
}

/// Gaps: intervals between successive `times` that exceed five median intervals and 0.2 s. `times` are strictly
/// increasing; fewer than two have no gaps.
#[must_use]
pub fn gaps(times: &[Time]) -> Vec<Gap> {
    let mut gaps = Gaps::default();
    times.iter().for_each(|time| gaps.push(*time));
    gaps.found()
}

/// Shortest gap, s.
const SHORTEST_GAP_S: f64 = 0.2;

/// Detector of [`gaps`] that receives one time after another.
#[derive(Clone, Debug, Default)]
pub(crate) struct Gaps {
    pub last: Option<Time>,
    pub intervals: Distribution,
    /// Intervals that may be gaps: at most five a second, however fast the sensor is.
    long: Vec<Gap>,
}

impl Gaps {
    pub fn push(&mut self, time: Time) {
        let Some(after) = self.last.replace(time) else { return };
        let length_s = time - after;
        self.intervals.push(length_s);
        if length_s > SHORTEST_GAP_S {
            self.long.push(Gap { after, length_s });
        }
    }

    pub fn found(&self) -> Vec<Gap> {
        let usual_s = self.intervals.quantile(0.5).unwrap_or(f64::INFINITY);
        let longest_s = (5.0 * usual_s).max(SHORTEST_GAP_S);
        self.long.iter().filter(|gap| gap.length_s > longest_s).copied().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn no_other_choice_of_rows_in_order_keeps_more(
            times in prop::collection::vec(-5i64..20, 0..30),
        ) {
            let times: Vec<Time> = times.into_iter().map(Time::from_nanoseconds).collect();
            let keep = longest_increasing(&times);
            let kept: Vec<Time> =
                times.iter().zip(&keep).filter(|(_, keep)| **keep).map(|(time, _)| *time).collect();
            prop_assert!(kept.windows(2).all(|pair| pair[0] < pair[1]));
            // Longest chain that ends at each row, by brute force over all rows before it.
            let mut longest: Vec<usize> = Vec::new();
            for (index, time) in times.iter().enumerate() {
                let before = (0..index).filter(|&i| times[i] < *time).map(|i| longest[i]).max();
                longest.push(1 + before.unwrap_or(0));
            }
            prop_assert_eq!(kept.len(), longest.into_iter().max().unwrap_or(0));
        }
    }

    proptest! {
        #[test]
        fn a_first_look_leaves_out_what_the_whole_would(steps in prop::collection::vec(-1i64..6, 0..60)) {
            // Steps of the time: most are 1 to 4 ms, some are 0, −1 ms or +3700 s.
            let hour = 3_700_000_000_000;
            let mut ns = 0;
            let times: Vec<Time> = steps
                .into_iter()
                .map(|step| {
                    ns += match step { 5 => hour, step => step * 1_000_000 };
                    Time::from_nanoseconds(ns)
                })
                .collect();
            let lines: Vec<u64> = (10..).take(times.len()).collect();
            let (path, mut whole, mut first) =
                (Path::new("imu.csv"), Remarks::new("imu.csv"), Remarks::new("imu.csv"));
            let mut look = FirstLook::default();
            let fresh: Vec<bool> =
                lines.iter().zip(&times).map(|(line, time)| look.push(*line, *time)).collect();
            let goes_back = times.windows(2).any(|pair| pair[1] < pair[0]);
            let skipped = look.skipped(&mut ClockSteps::default(), &mut first);
            prop_assert_eq!(skipped.is_none(), goes_back);
            if let Some(skipped) = skipped {
                let steps = &mut ClockSteps::default();
                let expected =
                    looked_again(times.clone(), &lines, &lines, path, steps, &mut whole).unwrap().skipped;
                let found: Vec<usize> = (0..times.len())
                    .filter(|index| !fresh[*index] || skipped.contains(index))
                    .collect();
                prop_assert_eq!(found, expected);
                prop_assert_eq!(
                    first.into_warnings().collect::<Vec<_>>(),
                    whole.into_warnings().collect::<Vec<_>>()
                );
            }
        }
    }

    #[test]
    fn a_gap_is_long_against_the_usual_interval_and_against_a_blink() {
        let times = |milliseconds: &[i64]| -> Vec<Time> {
            milliseconds.iter().map(|ms| Time::from_nanoseconds(ms * 1_000_000)).collect()
        };
        assert_eq!(gaps(&times(&[0, 10, 20, 220, 230])), []);
        let found = gaps(&times(&[0, 10, 20, 221, 230]));
        assert_eq!(found, [Gap { after: Time::from_nanoseconds(20_000_000), length_s: 0.201 }]);
        assert_eq!(gaps(&times(&[0, 1000, 2000, 7000, 8000])), []);
        assert_eq!(gaps(&times(&[0])), []);
    }
}
