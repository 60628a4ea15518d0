//! Time order: which rows to keep where a clock stutters, jumps or restarts.

use std::path::Path;

use crate::error::LogError;
use crate::remarks::Remarks;
use crate::statistics::quantile;
use hovernav::time::Time;

/// Rows of a file in the order found, each with its line, or its byte where the file has no lines.
#[derive(Debug)]
pub struct Rows<T> {
    rows: Vec<T>,
    lines: Vec<u64>,
}

/// As many rows may be stray whatever the size of the file.
const STRAY_ROWS: usize = 10;
/// So few rows further than this from all others are stray, s: garbled times, or the clock before it
/// was set.
const STRAY_GAP_S: f64 = 3600.0;

impl<T> Default for Rows<T> {
    fn default() -> Self {
        Self { rows: Vec::new(), lines: Vec::new() }
    }
}

impl<T> Rows<T> {
    /// No rows yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds the row found at `line`.
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
    /// [`LogError::Clock`] where more than a handful of rows and a quarter of all would be left out,
    /// those that repeat the time before apart: a second recording, or a shuffled file.
    pub fn in_time_order(
        mut self,
        time: impl Fn(&T) -> Time,
        path: &Path,
        remarks: &mut Remarks,
    ) -> Result<(Vec<T>, Vec<u64>), LogError> {
        let times: Vec<Time> = self.rows.iter().map(&time).collect();
        let is_ordered = times.windows(2).all(|pair| pair[0] < pair[1]);
        let mut keep = vec![true; times.len()];
        if !is_ordered {
            keep = longest_increasing(&times);
            self.remark(&times, &keep, path, remarks)?;
        }
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
        path: &Path,
        remarks: &mut Remarks,
    ) -> Result<(), LogError> {
        let mut disordered = 0;
        for index in (0..times.len()).filter(|index| !keep[*index]) {
            if index > 0 && times[index] == times[index - 1] {
                remarks.count("left out: same time as the row before", self.lines[index]);
            } else {
                remarks.count("left out: time out of order", self.lines[index]);
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
pub(crate) struct Gap {
    /// The last sample before it.
    pub after: Time,
    /// How long until the next sample, s.
    pub length_s: f64,
}

/// Intervals between successive `times` that are longer than five median intervals and than 0.2 s.
///
/// `times` strictly increasing; none of fewer than two.
pub(crate) fn gaps(times: &[Time]) -> Vec<Gap> {
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
    quantile(&mut intervals, 0.5)
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
            // The longest chain that ends at each row, by trying every row before it.
            let mut longest: Vec<usize> = Vec::new();
            for (index, time) in times.iter().enumerate() {
                let before = (0..index).filter(|&i| times[i] < *time).map(|i| longest[i]).max();
                longest.push(1 + before.unwrap_or(0));
            }
            prop_assert_eq!(kept.len(), longest.into_iter().max().unwrap_or(0));
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
