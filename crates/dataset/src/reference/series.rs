//! Time series of three components that store only what later interpolation needs.

use crate::statistics::distribution::Distribution;
use hovernav::time::Time;

/// Longest interval between rows that is interpolated, s, unless three median intervals are longer.
const LONGEST_GAP_S: f64 = 0.5;

/// A [`Series`] being built.
pub(crate) struct SeriesAt<'a> {
    /// Times still to be interpolated; `None` if unknown.
    moments: Option<&'a [Time]>,
    times: Vec<Time>,
    values: Vec<[f64; 3]>,
    /// The latest row, if it is not stored yet.
    waiting: Option<(Time, [f64; 3])>,
    last: Option<Time>,
    intervals: Distribution,
}

impl<'a> SeriesAt<'a> {
    /// An empty series for interpolation at `moments`, in order of time, or at any time.
    pub fn new(moments: Option<&'a [Time]>) -> Self {
        let (times, values) = (Vec::new(), Vec::new());
        Self {
            moments,
            times,
            values,
            waiting: None,
            last: None,
            intervals: Distribution::default(),
        }
    }

    /// Adds a row unless all its values are unknown.
    pub fn push(&mut self, time: Time, values: [f64; 3]) {
        if !values.iter().any(|value| value.is_finite()) {
            return;
        }
        if let Some(last) = self.last.replace(time) {
            self.intervals.push(time - last);
        }
        let Some(moments) = &mut self.moments else { return self.take(time, values) };
        // Interpolation needs the row at or before a time and the row after it.
        let (passed, to_come) = moments.split_at(moments.partition_point(|moment| *moment < time));
        *moments = to_come;
        match self.waiting.take() {
            _ if passed.is_empty() => self.waiting = Some((time, values)),
            before => {
                before.into_iter().for_each(|(time, values)| self.take(time, values));
                self.take(time, values);
            }
        }
    }

    fn take(&mut self, time: Time, values: [f64; 3]) {
        self.times.push(time);
        self.values.push(values);
    }

    pub fn finish(mut self) -> Series {
        self.waiting.take().into_iter().for_each(|(time, values)| self.take(time, values));
        let usual_s = self.intervals.quantile(0.5).unwrap_or(0.0);
        let longest_gap_s = LONGEST_GAP_S.max(3.0 * usual_s);
        Series { times: self.times, values: self.values, longest_gap_s }
    }
}

/// Three components over time; NaN for an unknown one.
#[derive(Clone, Debug)]
pub(crate) struct Series {
    times: Vec<Time>,
    values: Vec<[f64; 3]>,
    longest_gap_s: f64,
}

impl Series {
    /// The components at `time`, interpolated between two rows by `interpolate`; NaN before the first row, after the
    /// last one and across gaps.
    pub fn at(
        &self,
        time: Time,
        interpolate: impl Fn([f64; 3], [f64; 3], f64) -> [f64; 3],
    ) -> [f64; 3] {
        const UNKNOWN: [f64; 3] = [f64::NAN; 3];
        let next = self.times.partition_point(|known| *known <= time);
        let Some(last) = next.checked_sub(1) else { return UNKNOWN };
        if self.times[last] == time {
            return self.values[last];
        }
        let Some(&end) = self.times.get(next) else { return UNKNOWN };
        let interval_s = end - self.times[last];
        if interval_s > self.longest_gap_s {
            return UNKNOWN;
        }
        interpolate(self.values[last], self.values[next], (time - self.times[last]) / interval_s)
    }
}
