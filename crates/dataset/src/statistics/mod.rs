//! Quantiles, selection and thinning of series, shared by all tools.

pub(crate) mod allan;
pub(crate) mod distribution;

use hovernav::time::Time;

pub use distribution::Distribution;

/// Quantile `fraction` of `values`, interpolated linearly between the two nearest values (Hyndman and Fan's type 7);
/// `None` without values. `fraction` is limited to 0 to 1. Changes the order of `values`; NaN sorts above any number.
///
/// ```
/// use hovernav_dataset::statistics::quantile;
/// assert_eq!(quantile(&mut [4.0, 1.0, 3.0, 2.0], 0.5), Some(2.5));
/// assert_eq!(quantile(&mut [], 0.5), None);
/// ```
///
/// # Source
/// R. J. Hyndman, Y. Fan (1996), Sample quantiles in statistical packages, *The American
/// Statistician* 50 (4), 361–365, definition 7.
#[must_use]
pub fn quantile(values: &mut [f64], fraction: f64) -> Option<f64> {
    let last = values.len().checked_sub(1)?;
    let position = fraction.clamp(0.0, 1.0) * last as f64;
    let below = position as usize;
    let (_, &mut low, above) = values.select_nth_unstable_by(below, f64::total_cmp);
    let high = above.iter().copied().min_by(f64::total_cmp).unwrap_or(low);
    Some(low + (high - low) * (position - below as f64))
}

/// Median interval between successive `times`, s; `None` with fewer than two.
#[must_use]
pub fn median_interval_s(times: &[Time]) -> Option<f64> {
    let mut intervals: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    quantile(&mut intervals, 0.5)
}

/// The part of `items`, in order of time, from `start` to `end`, both included.
#[must_use]
pub fn within<T, K: PartialOrd>(items: &[T], time: impl Fn(&T) -> K, start: K, end: K) -> &[T] {
    let first = items.partition_point(|item| time(item) < start);
    let last = items.partition_point(|item| time(item) <= end);
    items.get(first..last).unwrap_or_default()
}

/// Indices of the samples to draw, rising, at most `limit` of them. These are the first, the last, and the smallest and
/// largest of every channel in each of several equal groups.
///
/// A plot of a long log shows its extremes: every peak keeps its height and time, which taking each n-th sample would
/// lose. `channels` are series of one length with the same abscissa (a value and its band, north and east of a track).
/// Samples that are not finite are never chosen as extremes. `limit` is at least 2 + 2 × the number of channels, which
/// is one group.
///
/// # Source
/// U. Jugel, Z. Jerzak, G. Hackenbroich, V. Markl (2014), M4: a visualization-oriented time series
/// data aggregation, *Proceedings of the VLDB Endowment* 7 (10), 797–808: minimum and maximum of
/// each pixel column decide what a line plot looks like.
#[must_use]
pub fn thin_to_extremes(channels: &[&[f64]], limit: usize) -> Vec<usize> {
    let length = channels.iter().map(|channel| channel.len()).min().unwrap_or(0);
    if length <= limit {
        return (0..length).collect();
    }
    let buckets = (limit.saturating_sub(2) / (2 * channels.len())).max(1);
    let mut kept = Vec::with_capacity(limit);
    kept.push(0);
    for bucket in 0..buckets {
        let (start, end) = (bucket * length / buckets, (bucket + 1) * length / buckets);
        for channel in channels {
            kept.extend(extremes(channel, start, end).into_iter().flatten());
        }
    }
    kept.push(length - 1);
    kept.sort_unstable();
    kept.dedup();
    kept
}

/// Indices of the smallest and the largest value of `channel` within `start..end`; `None` without finite values.
fn extremes(channel: &[f64], start: usize, end: usize) -> Option<[usize; 2]> {
    let mut finite = (start..end).filter(|&index| channel[index].is_finite());
    let first = finite.next()?;
    Some(finite.fold([first, first], |[lowest, highest], index| {
        [
            if channel[index] < channel[lowest] { index } else { lowest },
            if channel[index] > channel[highest] { index } else { highest },
        ]
    }))
}

/// A series to draw, thinned as it comes. A short one keeps every point. A longer one keeps the lowest and the highest
/// point of each group, so that peaks keep their height and time. At most 65 536 points remain. `X` is the abscissa.
#[derive(Clone, Debug)]
pub struct Extremes<X = f64> {
    /// Number of points in a group, of which the lowest and the highest are kept; 1 while every point is kept.
    stride: usize,
    /// Extremes of the current group, and the number of its points.
    near: Option<[(X, f64); 2]>,
    count: usize,
    points: Vec<(X, f64)>,
}

impl<X> Default for Extremes<X> {
    fn default() -> Self {
        Self { stride: 1, near: None, count: 0, points: Vec::new() }
    }
}

impl<X: Copy + PartialOrd> Extremes<X> {
    const MAX: usize = 1 << 16;

    /// Adds a finite point with an abscissa above the previous one.
    pub fn push(&mut self, point: (X, f64)) {
        self.near = Some(self.near.map_or([point; 2], |near| widened(near, point)));
        self.count += 1;
        if self.count < self.stride {
            return;
        }
        if self.points.len() + 2 > Self::MAX {
            let halved = self.points.chunks(4).flat_map(|four| {
                let four =
                    four.iter().skip(1).fold([four[0]; 2], |near, point| widened(near, *point));
                in_order(four)
            });
            self.points = halved.collect();
            self.stride = if self.stride == 1 { 4 } else { 2 * self.stride };
        }
        self.flush();
    }

    fn flush(&mut self) {
        self.points.extend(self.near.take().into_iter().flat_map(in_order));
        self.count = 0;
    }

    /// The remaining points, in their order.
    #[must_use]
    pub fn finish(mut self) -> Vec<(X, f64)> {
        self.flush();
        self.points
    }
}

/// Lowest and highest of the points `low`, `high` and `point`.
fn widened<X: Copy>([low, high]: [(X, f64); 2], point: (X, f64)) -> [(X, f64); 2] {
    [if point.1 < low.1 { point } else { low }, if point.1 > high.1 { point } else { high }]
}

/// Both points in order of their abscissa, or one if they are the same.
fn in_order<X: Copy + PartialOrd>([low, high]: [(X, f64); 2]) -> impl Iterator<Item = (X, f64)> {
    let [first, second] = if low.0 <= high.0 { [low, high] } else { [high, low] };
    std::iter::once(first).chain((first != second).then_some(second))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_interpolated_between_the_nearest_values() {
        let of = |values: &[f64], fraction| quantile(&mut values.to_vec(), fraction);
        assert_eq!(of(&[2.0], 0.3), Some(2.0));
        assert_eq!(of(&[4.0, 1.0, 3.0, 2.0], 0.75), Some(3.25));
        assert_eq!(of(&[4.0, 1.0], 0.0), Some(1.0));
        assert_eq!(of(&[4.0, 1.0], 1.0), Some(4.0));
        assert_eq!(of(&[4.0, 1.0], 7.0), Some(4.0));
        assert_eq!(of(&[], 0.5), None);
    }

    fn noise(length: usize, seed: u64) -> Vec<f64> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..length).map(|_| next()).collect()
    }

    fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        })
    }

    #[test]
    fn a_short_log_is_drawn_whole() {
        for length in [0, 1, 2, 3000] {
            let values = noise(length, 1);
            assert_eq!(thin_to_extremes(&[&values], 3000), (0..length).collect::<Vec<_>>());
        }
        assert!(thin_to_extremes(&[], 3000).is_empty());
    }

    #[test]
    fn no_limit_is_exceeded_and_the_ends_stay() {
        for length in [3001, 9900, 60_000, 1_000_003] {
            let (values, band) = (noise(length, 2), noise(length, 3));
            for limit in [6, 100, 3000] {
                let kept = thin_to_extremes(&[&values, &band], limit);
                assert!(kept.len() <= limit, "{} of {limit} at {length}", kept.len());
                assert!(kept.windows(2).all(|pair| pair[0] < pair[1]));
                assert_eq!((kept[0], *kept.last().unwrap()), (0, length - 1));
            }
        }
    }

    #[test]
    fn what_comes_point_by_point_keeps_its_peaks_in_little_memory() {
        let drawn = |count: u32| {
            let mut extremes = Extremes::default();
            for k in 0..count {
                let spike = f64::from(u8::from(k == 700_001)) - f64::from(u8::from(k == 12_345));
                extremes.push((f64::from(k), spike + 1e-3 * f64::from(k % 7)));
            }
            extremes.finish()
        };
        assert_eq!(drawn(60_000).len(), 60_000);
        let long = drawn(1_000_000);
        assert!(long.len() <= Extremes::<f64>::MAX && long.len() > Extremes::<f64>::MAX / 4);
        assert!(long.windows(2).all(|pair| pair[0].0 < pair[1].0));
        let has = |time: f64| long.iter().any(|point| point.0 == time);
        assert!(has(700_001.0) && has(12_345.0));
    }

    #[test]
    fn a_single_spike_in_a_million_samples_survives_in_each_channel() {
        for place in [0, 1, 499_999, 777_777, 999_999] {
            let mut value = vec![0.0; 1_000_000];
            let mut band = value.clone();
            value[place] = 1.0;
            band[999_999 - place] = -1.0;
            let kept = thin_to_extremes(&[&value, &band], 3000);
            assert!(kept.contains(&place) && kept.contains(&(999_999 - place)));
        }
    }

    #[test]
    fn every_stretch_as_wide_as_two_buckets_keeps_its_extent() {
        let values = noise(60_000, 4);
        let kept = thin_to_extremes(&[&values], 3002);
        let bucket = 60_000 / 1500;
        for start in (0..60_000).step_by(bucket) {
            let stretch = start..start + bucket;
            let drawn = kept.iter().filter(|index| stretch.contains(index)).map(|&i| values[i]);
            assert_eq!(extent(drawn), extent(values[stretch.clone()].iter().copied()));
        }
    }

    #[test]
    fn samples_that_are_not_finite_hide_no_peak() {
        let mut values = noise(10_000, 5);
        for index in (0..10_000).step_by(3) {
            values[index] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][index % 9 / 3];
        }
        values[5_000] = 7.0;
        assert!(thin_to_extremes(&[&values], 100).contains(&5_000));
        assert!(thin_to_extremes(&[&[f64::NAN; 10_000]], 100).len() <= 2);
    }
}
