//! A histogram of durations with constant memory.

/// Bins per factor of 2.
const BINS_PER_OCTAVE: f64 = 8.0;
/// Upper end of the first bin, s.
const SHORTEST_S: f64 = 1e-6;
/// Number of bins, from 1 µs to 16 s.
const BINS: usize = 8 * 24 + 1;

/// Counts durations in bins 9 % wide, from 1 µs to 16 s; the longest is kept exactly. Adding a duration takes
/// constant time and no memory.
///
/// ```
/// use hovernav_fly::DurationHistogram;
/// let mut histogram = DurationHistogram::default();
/// for microseconds in 1..=1000 {
///     histogram.add(f64::from(microseconds) * 1e-6);
/// }
/// assert!((histogram.quantile_s(0.5) / 500e-6 - 1.0).abs() < 0.09);
/// assert_eq!(histogram.longest_s(), 1e-3);
/// ```
#[derive(Clone, Debug)]
pub struct DurationHistogram {
    bins: [u64; BINS],
    count: u64,
    total_s: f64,
    longest_s: f64,
}

impl Default for DurationHistogram {
    fn default() -> Self {
        Self { bins: [0; BINS], count: 0, total_s: 0.0, longest_s: 0.0 }
    }
}

impl DurationHistogram {
    /// Adds a duration, s; a negative one or NaN counts as 0.
    pub fn add(&mut self, duration_s: f64) {
        let duration_s = duration_s.max(0.0);
        let octaves = (duration_s / SHORTEST_S).max(1.0).log2();
        let bin = (octaves * BINS_PER_OCTAVE).ceil() as usize;
        self.bins[bin.min(BINS - 1)] += 1;
        self.count += 1;
        self.total_s += duration_s;
        self.longest_s = self.longest_s.max(duration_s);
    }

    /// Number of durations.
    #[must_use]
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// Mean duration, s; 0 without durations.
    #[must_use]
    pub fn mean_s(&self) -> f64 {
        if self.count == 0 { 0.0 } else { self.total_s / self.count as f64 }
    }

    /// Longest duration, s; 0 without durations.
    #[must_use]
    pub const fn longest_s(&self) -> f64 {
        self.longest_s
    }

    /// Quantile of the durations, s, for the fraction `part`, 0 to 1. It is at most 9 % above the true quantile and
    /// never below it; 0 without durations.
    #[must_use]
    pub fn quantile_s(&self, part: f64) -> f64 {
        let wanted = (part.clamp(0.0, 1.0) * self.count as f64).ceil() as u64;
        let mut seen = 0;
        for (bin, count) in self.bins.iter().enumerate() {
            seen += count;
            if seen >= wanted && *count > 0 {
                let end_s = SHORTEST_S * (bin as f64 / BINS_PER_OCTAVE).exp2();
                return end_s.min(self.longest_s);
            }
        }
        self.longest_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantile_is_never_below_the_true_one_and_at_most_nine_percent_above() {
        let mut histogram = DurationHistogram::default();
        let mut all: Vec<f64> =
            (0..5000).map(|index| 1e-6 * 1.0023f64.powi(index % 4001)).collect();
        all.iter().for_each(|&duration_s| histogram.add(duration_s));
        all.sort_by(f64::total_cmp);
        for part in [0.001, 0.1, 0.5, 0.9, 0.99, 0.999, 1.0] {
            let rank = (part * all.len() as f64).ceil() as usize;
            let ratio = histogram.quantile_s(part) / all[rank - 1];
            assert!((1.0 - 1e-9..1.0906).contains(&ratio), "{part}: {ratio}");
        }
    }

    #[test]
    fn extreme_durations_are_counted() {
        let mut histogram = DurationHistogram::default();
        assert_eq!(histogram.quantile_s(0.5), 0.0);
        for odd in [f64::NAN, -1.0, 0.0, 1e9] {
            histogram.add(odd);
        }
        assert_eq!(histogram.count(), 4);
        assert_eq!(histogram.longest_s(), 1e9);
        assert!(histogram.quantile_s(0.75) <= SHORTEST_S);
    }
}
