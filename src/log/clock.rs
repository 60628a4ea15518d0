//! Time order: which rows to keep where a clock stutters, jumps or restarts.

use std::path::Path;

use super::error::LogError;
use super::remarks::Remarks;
use crate::time::Time;

/// Rows of a file in the order found, each with its line.
pub(super) struct Rows<T> {
    rows: Vec<T>,
    lines: Vec<u64>,
}

/// A handful of rows, [`STRAY_ROWS`] at most, further than this from all others are stray: garbled
/// times, or the clock before it was set.
const STRAY_GAP_S: f64 = 3600.0;
const STRAY_ROWS: usize = 10;

impl<T> Rows<T> {
    pub fn new() -> Self {
        Self { rows: Vec::new(), lines: Vec::new() }
    }

    pub fn push(&mut self, line: u64, row: T) {
        self.rows.push(row);
        self.lines.push(line);
    }

    /// The rows with time strictly increasing, and their lines; the fewest possible are left out.
    ///
    /// So a single time far ahead costs that row and not all that follow. A handful of rows more
    /// than an hour from all the others goes too.
    ///
    /// # Errors
    /// [`LogError::Clock`] where more than a quarter of the rows, repeated times apart, would be left
    /// out: that is no stray row but a second recording or a shuffled file.
    pub fn in_time_order(
        mut self,
        time: impl Fn(&T) -> Time,
        path: &Path,
        remarks: &mut Remarks,
    ) -> Result<(Vec<T>, Vec<u64>), LogError> {
        let times: Vec<Time> = self.rows.iter().map(&time).collect();
        let mut keep = match times.windows(2).position(|pair| pair[1] <= pair[0]) {
            None => vec![true; times.len()],
            Some(before) => {
                let keep = longest_increasing(&times);
                self.remark(&times, &keep, before, path, remarks)?;
                keep
            }
        };
        for stray in strays(&times, &keep) {
            keep[stray] = false;
            remarks.count("left out: more than an hour from all the others", self.lines[stray]);
        }
        let mut kept = keep.iter();
        self.rows.retain(|_| kept.next() == Some(&true));
        let mut kept = keep.iter();
        self.lines.retain(|_| kept.next() == Some(&true));
        Ok((self.rows, self.lines))
    }

    fn remark(
        &self,
        times: &[Time],
        keep: &[bool],
        before: usize,
        path: &Path,
        remarks: &mut Remarks,
    ) -> Result<(), LogError> {
        let mut known: Vec<Time> = Vec::with_capacity(times.len());
        known.extend(times.iter().zip(keep).filter(|(_, keep)| **keep).map(|(time, _)| *time));
        let mut disordered = 0;
        for (index, time) in times.iter().enumerate().filter(|(index, _)| !keep[*index]) {
            if known.binary_search(time).is_ok() {
                remarks.count("left out: a time already seen", self.lines[index]);
            } else {
                remarks.count("left out: time out of order", self.lines[index]);
                disordered += 1;
            }
        }
        if 4 * disordered > times.len() {
            return Err(LogError::Clock {
                path: path.to_path_buf(),
                line: self.lines[before + 1],
                before: times[before],
                found: times[before + 1],
                left_out: disordered,
                rows: times.len(),
            });
        }
        Ok(())
    }
}

/// Marks a longest strictly increasing subsequence, by patience sorting in n log n.
fn longest_increasing(times: &[Time]) -> Vec<bool> {
    // For each length, the index at which a subsequence of that length ends earliest in time.
    let mut ends: Vec<usize> = Vec::new();
    let mut previous: Vec<Option<usize>> = Vec::with_capacity(times.len());
    for (index, time) in times.iter().enumerate() {
        let length = ends.partition_point(|&end| times[end] < *time);
        previous.push(length.checked_sub(1).map(|shorter| ends[shorter]));
        match ends.get_mut(length) {
            // Of equal times the first row stays.
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

/// Kept rows in small groups far from all others; the largest group always stays.
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

/// A stretch without samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// The last sample before it.
    pub after: Time,
    /// How long until the next sample, s.
    pub length_s: f64,
}

/// Intervals between successive `times` that are longer than five median intervals and than 0.2 s.
///
/// `times` strictly increasing; none of fewer than two.
#[must_use]
pub fn gaps(times: &[Time]) -> Vec<Gap> {
    let longest_s = (5.0 * median_interval_s(times).unwrap_or(f64::INFINITY)).max(0.2);
    times
        .windows(2)
        .map(|pair| Gap { after: pair[0], length_s: pair[1] - pair[0] })
        .filter(|gap| gap.length_s > longest_s)
        .collect()
}

/// The median interval between successive `times`, s; `None` of fewer than two.
#[must_use]
pub fn median_interval_s(times: &[Time]) -> Option<f64> {
    let mut intervals: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = intervals.len() / 2;
    (!intervals.is_empty()).then(|| *intervals.select_nth_unstable_by(middle, f64::total_cmp).1)
}
