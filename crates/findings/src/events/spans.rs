//! Events gathered into spans.

use std::collections::VecDeque;

/// Events that are close in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Time of the first event, s.
    pub start_s: f64,
    /// Time of the last event, s.
    pub end_s: f64,
    /// Number of events.
    pub count: usize,
    /// Largest size of these events.
    pub largest: f64,
}

impl Span {
    /// Start and end, s.
    pub(super) fn bounds_s(&self) -> (f64, f64) {
        (self.start_s, self.end_s)
    }

    /// The time in words, as in [`when`].
    pub(super) fn when(&self) -> String {
        when(self.start_s, self.end_s)
    }
}

/// "at 3.0 s" or "from 3.0 to 5.0 s".
pub(super) fn when(start_s: f64, end_s: f64) -> String {
    if end_s - start_s < 0.05 {
        format!("at {start_s:.1} s")
    } else {
        format!("from {start_s:.1} to {end_s:.1} s")
    }
}

/// Spans of events `(time, size)` in order of time. An event at most `apart_s` after the previous one is in the same
/// span.
pub fn spans(moments: impl IntoIterator<Item = (f64, f64)>, apart_s: f64) -> Vec<Span> {
    let mut spans = Spans::apart(apart_s);
    moments.into_iter().for_each(|moment| spans.push(moment));
    spans.found
}

/// Builder of [`spans`] that receives one event after another.
pub(super) struct Spans {
    apart_s: f64,
    pub found: Vec<Span>,
}

impl Spans {
    pub const fn apart(apart_s: f64) -> Self {
        Self { apart_s, found: Vec::new() }
    }

    pub fn push(&mut self, (time_s, size): (f64, f64)) {
        match self.found.last_mut() {
            Some(span) if time_s - span.end_s <= self.apart_s => {
                span.end_s = time_s;
                span.count += 1;
                span.largest = span.largest.max(size);
            }
            _ => self.found.push(Span { start_s: time_s, end_s: time_s, count: 1, largest: size }),
        }
    }
}

/// Runs of `values` that repeat to the last bit more often than by chance: first and last index of each.
///
/// The chance of a repetition is its frequency shortly before and after the run: a coarse sensor at rest repeats
/// itself all the time.
pub(super) fn improbable_runs<T: PartialEq>(values: &[T]) -> Vec<(usize, usize)> {
    let mut runs = Repetitions::default();
    values.iter().for_each(|value| runs.push(value, ()));
    runs.finish().into_iter().map(|run| (run.first, run.last)).collect()
}

/// Number of pairs on each side of a run from which the chance of a repetition is estimated.
const NEAR: usize = 60;
/// Negative logarithm of the chance below which a run is improbable.
const UNLIKELY: f64 = 18.0;

/// Detector of [`improbable_runs`] that receives one value after another, each with its time.
#[derive(Clone)]
pub(super) struct Repetitions<T, M> {
    last: Option<(T, M)>,
    /// Number of pairs of successive values.
    pairs: usize,
    /// For each of the most recent pairs, whether it repeats.
    recent: VecDeque<bool>,
    /// The current run.
    open: Option<Repeating<M>>,
    /// Completed runs that wait for the pairs after them.
    waiting: VecDeque<Repeating<M>>,
    found: Vec<Repeating<M>>,
}

/// A run of values that repeat their predecessor.
#[derive(Clone, Copy)]
pub(super) struct Repeating<M> {
    /// Index and time of the first value.
    pub first: usize,
    pub start: M,
    /// Index and time of the last value.
    pub last: usize,
    pub end: M,
    /// Number of pairs shortly before and after the run.
    near: usize,
    /// Number of those pairs that repeat.
    repeated: usize,
    /// Number of the pairs after the run.
    after: usize,
}

impl<T, M> Default for Repetitions<T, M> {
    fn default() -> Self {
        Self {
            last: None,
            pairs: 0,
            recent: VecDeque::new(),
            open: None,
            waiting: VecDeque::new(),
            found: Vec::new(),
        }
    }
}

impl<T: PartialEq, M: Copy> Repetitions<T, M> {
    pub fn push(&mut self, value: T, moment: M) {
        let repeats = self.last.as_ref().map(|(last, start)| (*last == value, *start));
        self.last = Some((value, moment));
        if let Some((repeats, start)) = repeats {
            self.pair(repeats, start, moment);
        }
    }

    fn pair(&mut self, repeats: bool, start: M, end: M) {
        if !repeats {
            self.close();
        }
        for run in &mut self.waiting {
            run.near += 1;
            run.repeated += usize::from(repeats);
            run.after += 1;
        }
        while self.waiting.front().is_some_and(|run| run.after == NEAR) {
            self.judge();
        }
        if repeats {
            let recent = &self.recent;
            let run = self.open.get_or_insert_with(|| Repeating {
                first: self.pairs,
                start,
                last: self.pairs,
                end,
                near: recent.len(),
                repeated: recent.iter().filter(|repeats| **repeats).count(),
                after: 0,
            });
            run.last += 1;
            run.end = end;
        }
        self.pairs += 1;
        self.recent.push_back(repeats);
        if self.recent.len() > NEAR {
            self.recent.pop_front();
        }
    }

    /// Ends the current run; a single repetition does not count.
    fn close(&mut self) {
        self.waiting.extend(self.open.take().filter(|run| run.last - run.first > 1));
    }

    /// Judges the run that has waited longest.
    fn judge(&mut self) {
        let Some(run) = self.waiting.pop_front() else { return };
        let chance = (run.repeated as f64 + 1.0) / (run.near as f64 + 2.0);
        let length = (run.last - run.first) as f64;
        if run.near >= NEAR / 4 && length * -chance.ln() > UNLIKELY {
            self.found.push(run);
        }
    }

    /// The improbable runs, in their order.
    pub fn finish(mut self) -> Vec<Repeating<M>> {
        self.close();
        while !self.waiting.is_empty() {
            self.judge();
        }
        self.found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_close_together_are_one_span() {
        let found = spans([(1.0, 2.0), (1.5, 5.0), (4.0, 1.0)], 1.0);
        let first = Span { start_s: 1.0, end_s: 1.5, count: 2, largest: 5.0 };
        assert_eq!(found, [first, Span { start_s: 4.0, end_s: 4.0, count: 1, largest: 1.0 }]);
    }

    #[test]
    fn a_run_is_improbable_only_where_its_neighbours_do_not_repeat() {
        let mut values: Vec<usize> = (0..200).collect();
        values[100..115].fill(7);
        assert_eq!(improbable_runs(&values), [(100, 114)]);
        let coarse: Vec<usize> = (0..400).map(|k| k / 13).collect();
        assert_eq!(improbable_runs(&coarse), []);
    }
}
