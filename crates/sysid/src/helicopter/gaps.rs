//! Gaps in the record of a flight.

use std::fmt;

use hovernav::time::Time;

/// Time between rows above which they form a gap, s. A gap is also longer than [`USUAL`] median intervals.
const LONGEST_S: f64 = 0.3;
/// Number of median intervals between rows above which they form a gap.
const USUAL: f64 = 10.0;

/// A part of a flight without data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// The missing data: sticks or motion.
    pub of: &'static str,
    /// Time of the last row before the gap.
    pub from: Time,
    /// Time of the first row after the gap.
    pub to: Time,
}

impl fmt::Display for Gap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { of, from, to } = self;
        write!(
            f,
            "{of} not recorded from {:.2} s to {:.2} s: this part is ignored",
            from.seconds(),
            to.seconds()
        )
    }
}

/// Gaps between rows at `times`, in time order, within a flight from `first` to `last`.
pub(super) fn gaps(of: &'static str, times: &[Time], [first, last]: [Time; 2]) -> Vec<Gap> {
    let mut intervals: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    intervals.sort_by(f64::total_cmp);
    let usual_s = intervals.get(intervals.len() / 2).copied().unwrap_or(0.0);
    let longest_s = LONGEST_S.max(USUAL * usual_s);
    let ends =
        [first].into_iter().chain(times.iter().copied()).zip(times.iter().copied().chain([last]));
    let within = ends.map(|(from, to)| Gap { of, from: from.max(first), to: to.min(last) });
    within.filter(|gap| gap.to - gap.from > longest_s).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(time_s: f64) -> Time {
        Time::ZERO + time_s
    }

    #[test]
    fn parts_without_rows_are_reported_at_both_ends_and_within() {
        let rows =
            (0..400).map(|row| 0.03 * f64::from(row)).filter(|time_s| !(4.0..6.0).contains(time_s));
        let times: Vec<Time> = rows.map(at).collect();
        let found = gaps("sticks", &times, [at(-1.0), at(20.0)]);
        let spans: Vec<[f64; 2]> =
            found.iter().map(|gap| [gap.from.seconds(), gap.to.seconds()]).collect();
        let expected = [[-1.0, 0.0], [3.99, 6.0], [11.97, 20.0]];
        assert_eq!(spans.len(), 3, "{spans:?}");
        for (found, expected) in spans.iter().flatten().zip(expected.iter().flatten()) {
            assert!((found - expected).abs() < 1e-6, "{spans:?}");
        }
        assert_eq!(gaps("sticks", &times, [at(1.0), at(3.0)]), Vec::new());
    }

    #[test]
    fn rows_that_come_slowly_have_no_gaps() {
        let times: Vec<Time> = (0..40).map(|row| at(0.2 * f64::from(row))).collect();
        assert_eq!(gaps("sticks", &times, [at(0.0), at(8.0)]), Vec::new());
    }
}
