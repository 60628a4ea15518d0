//! Distribution of the times of many calls.

use std::time::{Duration, Instant};

use serde::Serialize;

/// Times of calls, ns.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Distribution {
    /// Number of calls.
    pub calls: usize,
    /// Median.
    pub p50_ns: f64,
    /// 99th percentile; `None` for fewer than 100 calls.
    pub p99_ns: Option<f64>,
    /// 99.9th percentile; `None` for fewer than 1000 calls.
    pub p99_9_ns: Option<f64>,
    /// Maximum.
    pub max_ns: f64,
    /// Tail of the distribution: time, ns, and fraction of calls that took longer.
    pub tail: Vec<(f64, f64)>,
}

/// Raw times of calls, ns.
#[derive(Clone, Debug, Default)]
pub struct Times(Vec<u32>);

impl Times {
    /// Reserves memory for `calls` times.
    pub fn with_capacity(calls: u64) -> Self {
        Self(Vec::with_capacity(usize::try_from(calls).unwrap_or(0)))
    }

    /// Times `work`.
    #[inline(always)]
    pub fn time<R>(&mut self, work: impl FnOnce() -> R) -> R {
        let start = Instant::now();
        let result = work();
        self.push(start);
        result
    }

    /// Stores the time since `start`.
    #[inline(always)]
    pub fn push(&mut self, start: Instant) {
        let ns = start.elapsed().as_nanos();
        self.0.push(u32::try_from(ns).unwrap_or(u32::MAX));
    }

    /// The distribution, after `clock_ns` is subtracted from each time.
    pub fn distribution(mut self, clock_ns: f64) -> Distribution {
        self.0.sort_unstable();
        let calls = self.0.len();
        let at = |share: f64| {
            let index = (share * calls as f64).ceil() as usize;
            self.0
                .get(index.clamp(1, calls.max(1)) - 1)
                .map_or(f64::NAN, |&ns| (f64::from(ns) - clock_ns).max(0.0))
        };
        // Evenly spaced in the logarithm of the tail fraction, because the tail is the result of interest.
        let decades = (calls.max(1) as f64).log10();
        let tail = (0..=60)
            .map(|step| 10f64.powf(-decades * f64::from(step) / 60.0))
            .map(|longer| (at(1.0 - longer), longer))
            .filter(|(ns, _)| ns.is_finite())
            .collect();
        Distribution {
            calls,
            p50_ns: at(0.5),
            p99_ns: (calls >= 100).then(|| at(0.99)),
            p99_9_ns: (calls >= 1_000).then(|| at(0.999)),
            max_ns: at(1.0),
            tail,
        }
    }
}

/// Rests regularly. Linux suspends a real-time thread that never waits for one twentieth of each second, which would
/// distort the times.
pub struct Pace(Instant);

/// Duration of work between two rests.
const WORK: Duration = Duration::from_millis(100);
/// Duration of a rest.
const REST: Duration = Duration::from_millis(10);

impl Pace {
    pub fn begin() -> Self {
        Self(Instant::now())
    }

    /// Rests if a rest is due; call it between two timed calls.
    pub fn rest(&mut self) {
        if self.0.elapsed() > WORK {
            std::thread::sleep(REST);
            self.0 = Instant::now();
        }
    }
}

/// Time to read the clock, ns: the median of many empty measurements.
pub fn clock_ns() -> f64 {
    let mut times = Times::with_capacity(10_000);
    for _ in 0..10_000 {
        times.time(|| std::hint::black_box(()));
    }
    times.distribution(0.0).p50_ns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_sorted_times() {
        let times = Times((1..=1_000).rev().collect());
        let found = times.distribution(0.0);
        assert_eq!((found.p50_ns, found.p99_ns, found.p99_9_ns), (500.0, Some(990.0), Some(999.0)));
        assert_eq!((found.calls, found.max_ns), (1_000, 1_000.0));
        assert!(found.tail.is_sorted_by(|a, b| a.0 <= b.0 && a.1 >= b.1));
    }

    #[test]
    fn of_a_few_calls_no_rare_ones_are_reported() {
        let of = |calls: u32| Times((1..=calls).collect()).distribution(0.0);
        assert_eq!((of(30).p50_ns, of(30).p99_ns, of(30).p99_9_ns), (15.0, None, None));
        assert_eq!((of(999).p99_ns, of(999).p99_9_ns), (Some(990.0), None));
    }

    #[test]
    fn no_times_make_no_numbers() {
        assert!(Times::default().distribution(0.0).max_ns.is_nan());
    }
}
