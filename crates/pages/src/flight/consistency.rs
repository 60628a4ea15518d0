//! Comparison of the innovations with the filter's predicted uncertainty.

use hovernav_log::consistency::PooledInnovations;

use crate::Level;

/// Limits of the mean square of normalised innovations: chance and small correlations do not explain values outside.
const TIMID_BELOW: f64 = 0.5;
const SURE_ABOVE: f64 = 2.0;
/// The result of the comparison in words. Innovations below the lower limit never make a solution bad.
pub fn in_words(pooled: &PooledInnovations) -> (Level, &'static str) {
    let (low, high) = pooled.interval;
    match pooled.mean {
        mean if (low..=high).contains(&mean) => (Level::Good, "pass: consistent"),
        mean if mean < TIMID_BELOW => {
            (Level::Good, "conservative: the sensor is more accurate than its model")
        }
        mean if mean > SURE_ABOVE => (Level::Bad, "fail: the filter is overconfident"),
        mean if mean < low => (Level::Good, "pass: slightly conservative"),
        _ => (Level::Care, "care: slightly overconfident"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pooled(mean: f64) -> PooledInnovations {
        PooledInnovations { mean, interval: (0.97, 1.03), share_inside: 0.95 }
    }

    #[test]
    fn a_filter_that_is_too_sure_does_not_pass_and_one_that_is_timid_is_reported_as_such() {
        assert_eq!(in_words(&pooled(1.0)).0, Level::Good);
        assert_eq!(in_words(&pooled(0.8)).0, Level::Good);
        assert!(in_words(&pooled(0.2)).1.starts_with("conservative"));
        assert_eq!(in_words(&pooled(1.4)).0, Level::Care);
        assert_eq!(in_words(&pooled(2.5)).0, Level::Bad);
    }
}
