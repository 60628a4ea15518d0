//! Fixes withheld from a dataset, for a test of the filter's drift.

use crate::dataset::{Dataset, Source};
use hovernav::time::Time;

/// A span without GPS, for a test of the filter's drift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outage {
    /// Start of the outage.
    pub start: Time,
    /// Duration, s.
    pub duration_s: f64,
}

impl Outage {
    /// Whether the outage contains a time.
    #[must_use]
    pub fn covers(&self, time: Time) -> bool {
        time >= self.start && time - self.start < self.duration_s
    }
}

impl Dataset {
    /// Removes the fixes within `outages`, and thins the rest to at most `rate_hz`.
    pub fn withhold(&mut self, outages: &[Outage], rate_hz: Option<f64>) {
        // The interval may be a tenth shorter, for the jitter of the receiver's clock.
        let interval_s = rate_hz.map_or(0.0, |rate_hz| 0.9 / rate_hz);
        let mut last: Option<Time> = None;
        let keep = self.fixes.iter().map(|fix| {
            let keep = !outages.iter().any(|outage| outage.covers(fix.time))
                && (rate_hz.is_none() || last.is_none_or(|last| fix.time - last >= interval_s));
            if keep {
                last = Some(fix.time);
            }
            keep
        });
        let keep: Vec<bool> = keep.collect();
        let mut kept = keep.iter();
        self.order.retain(|source| *source != Source::Gps || kept.next() != Some(&false));
        let mut kept = keep.iter();
        self.fixes.retain(|_| kept.next() == Some(&true));
    }
}
