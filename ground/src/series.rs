//! One channel over time: a ring buffer of fixed size, and the data for its plot.

use std::collections::VecDeque;

/// A time, seconds since the start of 1970, and a value; NaN is a gap.
pub type Point = (f64, f64);

/// Time without a value, in usual periods, that counts as a gap.
const GAP_PERIODS: f64 = 3.0;
/// Smallest and largest limit of the time without a value that counts as a gap, s.
const GAP_S: (f64, f64) = (0.25, 3.0);
/// Time without a value, in usual periods, after which a channel is silent.
pub const SILENT_PERIODS: f64 = 2.0;
/// Additional time, s, for the delays of the link.
pub const SILENT_MARGIN_S: f64 = 0.2;
/// Assumed period of a channel with a single value, s.
const FIRST_PERIOD_S: f64 = 1.0;
/// Initial capacity, values.
const MIN: usize = 256;
/// Weight of the newest period in the average period.
const SHARE: f64 = 0.1;

/// The newest values of one channel, in order of time.
#[derive(Clone, Debug)]
pub struct Series {
    points: VecDeque<Point>,
    room: usize,
    /// Usual (average) time between two values, s.
    period_s: f64,
    /// Time of the newest value, including a NaN that only extended a gap, s.
    last_s: f64,
    /// Time of the last value that was dropped because the buffer was full, s.
    gone_s: f64,
    /// Times at which the value changed, s. They reach back as far as `points`; only for a channel
    /// [`of_states`](Self::of_states).
    changes: Option<VecDeque<f64>>,
    /// Number of received values, up to four.
    received: u8,
}

impl Series {
    /// A series with space for `room` values, including gaps.
    #[must_use]
    pub const fn new(room: usize) -> Self {
        Self {
            points: VecDeque::new(),
            room,
            period_s: 0.1,
            last_s: f64::NEG_INFINITY,
            gone_s: f64::NEG_INFINITY,
            changes: None,
            received: 0,
        }
    }

    /// A series that also answers [`since`](Self::since).
    #[must_use]
    pub fn of_states(room: usize) -> Self {
        Self { changes: Some(VecDeque::new()), ..Self::new(room) }
    }

    /// Adds a value. Returns whether it is later than the previous one; otherwise it is ignored. After an outage, a gap
    /// is inserted. A NaN is a gap, too.
    pub fn push(&mut self, time_s: f64, value: f64) -> bool {
        if !time_s.is_finite() || time_s <= self.last_s {
            return false;
        }
        let since_s = time_s - self.last_s;
        self.last_s = time_s;
        self.received = 4.min(self.received + 1);
        if self.received > 1 {
            let is_nan = |point: &Point| point.1.is_nan();
            if self.is_outage(since_s) && !self.points.back().is_some_and(is_nan) {
                self.put((time_s - 0.5 * since_s, f64::NAN));
            }
            if value.is_nan() && self.points.back().is_some_and(is_nan) {
                return true;
            }
        }
        self.put((time_s, value));
        true
    }

    /// Whether `since_s` without a value is an outage. Updates the usual period.
    fn is_outage(&mut self, since_s: f64) -> bool {
        let longest_s = |period_s: f64| (GAP_PERIODS * period_s).clamp(GAP_S.0, GAP_S.1);
        if self.received == 2 {
            // The first period counts as the usual one until the next value arrives.
            self.period_s = since_s.min(GAP_S.1);
            return since_s > GAP_S.1;
        }
        if self.received == 3 && self.period_s > longest_s(since_s) {
            self.period_s = since_s;
            self.part_first_two();
            return false;
        }
        let is_outage = since_s > longest_s(self.period_s);
        // A single long period is an outage; repeated ones mean a slower channel.
        let (share, max_s) = if is_outage { (0.3, GAP_S.1) } else { (SHARE, since_s) };
        self.period_s += share * (since_s.min(max_s) - self.period_s);
        is_outage
    }

    /// Inserts a gap between the first two values.
    fn part_first_two(&mut self) {
        if self.points.len() == 2
            && let (Some(second), Some(first)) = (self.points.pop_back(), self.points.back())
        {
            let middle_s = 0.5 * (first.0 + second.0);
            if let Some(changes) = &mut self.changes {
                changes.retain(|changed_s| *changed_s < second.0);
            }
            self.put((middle_s, f64::NAN));
            self.put(second);
        }
    }

    fn put(&mut self, point: Point) {
        if let Some(changes) = &mut self.changes
            && self.points.back().is_none_or(|last| last.1 != point.1)
        {
            changes.push_back(point.0);
        }
        if self.points.len() == self.room {
            self.gone_s = self.points.pop_front().map_or(self.gone_s, |gone| gone.0);
            if let Some(changes) = &mut self.changes
                && changes.front().is_some_and(|changed_s| *changed_s <= self.gone_s)
            {
                changes.pop_front();
            }
        } else if self.points.len() == self.points.capacity() {
            // Doubling the capacity would exceed the room.
            let more = self.points.len().max(MIN).min(self.room - self.points.len());
            self.points.reserve_exact(more);
        }
        self.points.push_back(point);
    }

    /// The newest value; `None` in a gap, or if the channel is silent at `now_s`.
    #[must_use]
    pub fn latest(&self, now_s: f64) -> Option<Point> {
        let period_s = if self.received > 1 { self.period_s } else { FIRST_PERIOD_S };
        let longest_s = SILENT_PERIODS * period_s + SILENT_MARGIN_S;
        let &(last_s, value) = self.points.back()?;
        (now_s - last_s <= longest_s && !value.is_nan()).then_some((last_s, value))
    }

    /// The last value at or before `time_s`; `None` in a gap, before the first value or long after the last one.
    #[must_use]
    pub fn at(&self, time_s: f64) -> Option<f64> {
        let after = self.points.partition_point(|&(other_s, _)| other_s <= time_s);
        if after == self.points.len() {
            return self.latest(time_s).map(|(_, value)| value);
        }
        let &(_, value) = self.points.get(after.checked_sub(1)?)?;
        Some(value).filter(|value| !value.is_nan())
    }

    /// The time, s, since which the channel has had its value at `time_s`. The flag is whether the value was different
    /// or missing before. `None` without a value, or for a channel that is not [`of_states`](Self::of_states).
    #[must_use]
    pub fn since(&self, time_s: f64) -> Option<(f64, bool)> {
        self.at(time_s)?;
        let &(first_s, _) = self.points.front()?;
        let changes = self.changes.as_ref()?;
        let after = changes.partition_point(|&changed_s| changed_s <= time_s);
        let changed_s = after.checked_sub(1).and_then(|last| changes.get(last)).copied();
        let begun_s = changed_s.unwrap_or(first_s);
        Some((begun_s, first_s < begun_s))
    }

    /// The time of the last dropped value, s; minus infinity if no value was dropped.
    #[must_use]
    pub const fn gone_s(&self) -> f64 {
        self.gone_s
    }

    /// The values after `after_s`, up to and including `until_s`.
    pub fn between(&self, after_s: f64, until_s: f64) -> impl Iterator<Item = Point> + '_ {
        let first = self.points.partition_point(|&(time_s, _)| time_s <= after_s);
        let last = self.points.partition_point(|&(time_s, _)| time_s <= until_s);
        self.points.range(first..last.max(first)).copied()
    }

    /// Times of the first and last value.
    #[must_use]
    pub fn span(&self) -> Option<(f64, f64)> {
        Some((self.points.front()?.0, self.points.back()?.0))
    }

    /// The points of a plot from `from_s` to `to_s` with `columns` columns of pixels. Each column has its smallest and
    /// its largest value, in order of time, so that no spike is lost; gaps stay gaps. The values next to the plot's
    /// edges are included, so that lines reach the edges. At most four points per column, plus those two.
    #[must_use]
    pub fn plotted(&self, from_s: f64, to_s: f64, columns: usize) -> Vec<Point> {
        let first = self.points.partition_point(|&(time_s, _)| time_s < from_s);
        let last = self.points.partition_point(|&(time_s, _)| time_s <= to_s).max(first);
        let inside = self.points.range(first..last).copied();
        let mut plotted: Vec<Point> = Vec::new();
        plotted.extend(first.checked_sub(1).and_then(|before| self.points.get(before)));
        if last - first <= 2 * columns {
            plotted.extend(inside);
        } else {
            let width_s = (to_s - from_s) / columns.max(1) as f64;
            let column_of = |time_s: f64| ((time_s - from_s) / width_s) as usize;
            let mut column = Column::default();
            let mut current = 0;
            for (time_s, value) in inside {
                if column_of(time_s) != current {
                    column.drain_into(&mut plotted);
                    current = column_of(time_s);
                }
                column.take((time_s, value));
            }
            column.drain_into(&mut plotted);
        }
        plotted.extend(self.points.get(last));
        plotted
    }
}

/// The points of one column of pixels.
#[derive(Default)]
struct Column {
    least: Option<Point>,
    greatest: Option<Point>,
    gap: Option<Point>,
}

impl Column {
    fn take(&mut self, point: Point) {
        if point.1.is_nan() {
            self.gap = Some(point);
            return;
        }
        if self.least.is_none_or(|least| point.1 < least.1) {
            self.least = Some(point);
        }
        if self.greatest.is_none_or(|greatest| point.1 >= greatest.1) {
            self.greatest = Some(point);
        }
    }

    fn drain_into(&mut self, plotted: &mut Vec<Point>) {
        let mut points = [self.least.take(), self.greatest.take(), self.gap.take()];
        points.sort_by(|a, b| {
            a.map(|p| p.0).partial_cmp(&b.map(|p| p.0)).unwrap_or(std::cmp::Ordering::Equal)
        });
        for point in points.into_iter().flatten() {
            let last_s = plotted.last().map(|&(time_s, _)| time_s);
            if last_s.is_none_or(|last_s| point.0 > last_s) {
                plotted.push(point);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn at_33_hz(count: usize, value: impl Fn(usize) -> f64) -> Series {
        let mut series = Series::new(count.max(1) * 2);
        for k in 0..count {
            series.push(k as f64 / 33.0, value(k));
        }
        series
    }

    proptest! {
        #[test]
        fn no_spike_is_hidden_however_few_the_pixels(
            places in prop::collection::btree_set(0usize..20_000, 1..8),
            columns in 1usize..900,
        ) {
            let series = at_33_hz(20_000, |k| if places.contains(&k) { 100.0 + k as f64 } else { (k as f64).sin() });
            let plotted = series.plotted(0.0, 20_000.0 / 33.0, columns);
            prop_assert!(plotted.len() <= 4 * columns + 2);
            let last = *places.last().unwrap();
            let greatest = plotted.iter().map(|point| point.1).fold(0.0, f64::max);
            prop_assert_eq!(greatest, 100.0 + last as f64);
            // Every column that contains a spike shows it.
            for place in &places {
                let time_s = *place as f64 / 33.0;
                let width_s = 20_000.0 / 33.0 / columns as f64;
                prop_assert!(plotted.iter().any(|p| p.1 >= 100.0 && (p.0 - time_s).abs() <= width_s));
            }
            prop_assert!(plotted.windows(2).all(|pair| pair[0].0 < pair[1].0));
        }
    }

    #[test]
    fn an_outage_is_a_gap_and_a_slow_channel_is_none() {
        let mut series = at_33_hz(100, |_| 1.0);
        series.push(100.0 / 33.0 + 2.0, 1.0);
        assert_eq!(series.points.iter().filter(|point| point.1.is_nan()).count(), 1);
        assert!(series.plotted(0.0, 10.0, 20).iter().any(|point| point.1.is_nan()));
        assert_eq!(series.at(4.5), None);

        let mut slow = Series::new(100);
        for k in 0..50 {
            slow.push(f64::from(k), 1.0);
        }
        let gaps = slow.points.iter().filter(|point| point.1.is_nan()).count();
        assert!(gaps <= 4, "{gaps} gaps in a channel of 1 Hz");
        slow.push(60.0, 1.0);
        assert!(slow.at(57.0).is_none());
    }

    #[test]
    fn a_channel_slower_than_others_has_no_gap_at_its_start() {
        for period_s in [0.35, 1.0, 2.5] {
            let mut slow = Series::new(100);
            for k in 0..20 {
                slow.push(f64::from(k) * period_s, 1.0);
            }
            assert!(slow.points.iter().all(|point| !point.1.is_nan()), "{period_s} s");
        }
        // An outage after the very first value is recognised once the next value shows the usual period.
        let mut late = Series::new(100);
        for k in 0..50 {
            late.push(if k == 0 { 0.0 } else { 2.0 + f64::from(k) / 33.0 }, 1.0);
        }
        assert_eq!(late.at(1.5), None);
        assert_eq!(late.points.iter().filter(|point| point.1.is_nan()).count(), 1);
    }

    #[test]
    fn while_a_value_is_unknown_its_period_is_learned_as_it_is() {
        let mut series = Series::new(1000);
        for k in 0..3300 {
            series.push(f64::from(k) / 33.0, f64::NAN);
        }
        series.push(100.0, 1.0);
        series.push(101.0, 1.0);
        assert_eq!(series.at(100.9), None, "33 values were missing");
        assert_eq!(series.latest(104.0), None);
    }

    #[test]
    fn the_ring_keeps_its_size_and_time_its_direction() {
        let mut series = Series::new(1000);
        for k in 0..100_000 {
            assert!(series.push(f64::from(k) / 33.0, 0.0));
        }
        assert_eq!(series.points.len(), 1000);
        assert!(!series.push(1.0, 0.0) && !series.push(f64::NAN, 0.0));
        assert_eq!(series.latest(99_999.0 / 33.0).unwrap().0, 99_999.0 / 33.0);
    }

    #[test]
    fn a_channel_that_falls_silent_has_no_value_any_more() {
        let series = at_33_hz(100, |_| 1.0);
        assert_eq!(series.at(3.2), Some(1.0));
        assert_eq!((series.at(3.3), series.latest(3.3)), (None, None));
        let mut slow = Series::new(100);
        for k in 0..50 {
            slow.push(f64::from(k), 1.0);
        }
        assert_eq!((slow.at(51.1), slow.at(51.3)), (Some(1.0), None));
    }

    #[test]
    fn a_value_has_held_since_it_changed_or_for_all_that_is_kept() {
        let mut series = Series::of_states(400);
        for k in 0..660 {
            series.push(f64::from(k) / 33.0, if k < 330 { 3.0 } else { 4.0 });
        }
        assert_eq!(series.since(15.0), Some((10.0, true)));
        assert_eq!(series.since(9.0), Some((260.0 / 33.0, false)));
        assert_eq!((series.since(-1.0), series.since(40.0)), (None, None));
        assert_eq!(series.gone_s(), 259.0 / 33.0);
        assert_eq!(at_33_hz(660, |_| 3.0).since(15.0), None);
    }

    proptest! {
        #[test]
        fn since_when_a_value_holds_is_what_looking_through_all_reports(
            steps in prop::collection::vec((0u8..3, 1usize..20, 0.02f64..2.0), 1..40),
            room in 1usize..200,
        ) {
            let mut series = Series::of_states(room);
            let mut time_s = 0.0;
            for (value, count, apart_s) in steps {
                for _ in 0..count {
                    time_s += apart_s;
                    series.push(time_s, if value == 0 { f64::NAN } else { f64::from(value) });
                }
            }
            let points: Vec<Point> = series.points.iter().copied().collect();
            for (index, &(at_s, value)) in points.iter().enumerate() {
                let run = points[..=index].iter().rev().take_while(|point| point.1 == value);
                let begun = run.last().map(|first| (first.0, first.0 > points[0].0));
                prop_assert_eq!(series.since(at_s), begun, "at {}", at_s);
            }
        }
    }

    #[test]
    fn lines_run_to_the_edges_of_the_plot() {
        let series = at_33_hz(1000, |k| k as f64);
        let plotted = series.plotted(10.001, 10.01, 100);
        assert_eq!(plotted.len(), 2, "{plotted:?}");
        assert!(plotted[0].0 < 10.001 && plotted[1].0 > 10.01);
    }
}
