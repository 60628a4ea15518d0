//! Consistency of innovations with the filter's covariance: the normalised innovation squared (NIS).
//!
//! The filter fuses the components of a measurement one after another, each with the variance that the previous ones
//! left. So their normalised squares add up to the NIS of the whole measurement. For a consistent filter it follows a
//! chi-square distribution with as many degrees of freedom as the measurement has channels.
//!
//! # Source
//! Bar-Shalom, Li, Kirubarajan, *Estimation with Applications to Tracking and Navigation*, section
//! 5.4 (the test and its time average).

use hovernav::ekf::{Channel, Innovation, Verdict};
use hovernav::time::Time;

use crate::level::Level;
use hovernav_replay::Run;

/// The normalised innovation squared of one measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InnovationTest {
    /// Time of validity of the measurement.
    pub time: Time,
    /// Sum of (innovation / one-sigma)² over the measurement's channels.
    pub squared: f64,
    /// Number of channels of the measurement.
    pub degrees_of_freedom: usize,
    /// Whether a channel was rejected, or the filter was reset to it.
    pub refused: bool,
}

impl InnovationTest {
    /// Normalised innovation squared per channel, 1 on average for a consistent filter.
    #[must_use]
    pub fn per_channel(&self) -> f64 {
        self.squared / self.degrees_of_freedom as f64
    }

    /// Whether the normalised innovation squared is within the 95 % interval of its chi-square distribution.
    #[must_use]
    pub fn is_inside(&self) -> bool {
        let (low, high) = chi_square_interval_95(self.degrees_of_freedom);
        (low..=high).contains(&self.squared)
    }
}

/// One test per measurement, from `innovations` in the order in which the filter fused them.
#[must_use]
pub fn innovation_tests(innovations: &[Innovation]) -> Vec<InnovationTest> {
    innovations
        .chunk_by(|a, b| a.time == b.time)
        .map(|channels| InnovationTest {
            time: channels[0].time,
            squared: channels.iter().map(|channel| channel.normalised().powi(2)).sum(),
            degrees_of_freedom: channels.len(),
            refused: channels.iter().any(|channel| channel.verdict != Verdict::Accepted),
        })
        .collect()
}

/// Mean normalised innovation squared per channel below which the filter is conservative: chance and small correlations
/// do not explain such a value.
const TIMID_BELOW: f64 = 0.5;
/// Mean normalised innovation squared per channel above which the filter is overconfident.
const SURE_ABOVE: f64 = 2.0;

/// Normalised innovation squared per channel, pooled over the measurements that were not rejected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PooledInnovations {
    /// Mean normalised innovation squared per channel.
    pub mean: f64,
    /// The 95 % interval of the mean for a consistent filter.
    pub interval: (f64, f64),
    /// Fraction of measurements within their own 95 % interval, 0 to 1.
    pub share_inside: f64,
}

impl PooledInnovations {
    /// Pools the accepted measurements of a span; `None` without any.
    #[must_use]
    pub fn of(tests: &[InnovationTest]) -> Option<Self> {
        let accepted = || tests.iter().filter(|test| !test.refused && test.squared.is_finite());
        let channels: usize = accepted().map(|test| test.degrees_of_freedom).sum();
        if channels == 0 {
            return None;
        }
        let (low, high) = chi_square_interval_95(channels);
        let inside = accepted().filter(|test| test.is_inside()).count();
        Some(Self {
            mean: accepted().map(|test| test.squared).sum::<f64>() / channels as f64,
            interval: (low / channels as f64, high / channels as f64),
            share_inside: inside as f64 / accepted().count() as f64,
        })
    }

    /// Level and verdict in words on the mean. Innovations below the interval never make a solution bad.
    #[must_use]
    pub fn judged(&self) -> (Level, &'static str) {
        let (low, high) = self.interval;
        match self.mean {
            mean if (low..=high).contains(&mean) => (Level::Good, "pass: consistent"),
            mean if mean < TIMID_BELOW => {
                (Level::Good, "conservative: the sensor is more accurate than its model")
            }
            mean if mean > SURE_ABOVE => (Level::Bad, "fail: the filter is overconfident"),
            mean if mean < low => (Level::Good, "pass: slightly conservative"),
            _ => (Level::Care, "care: slightly overconfident"),
        }
    }
}

const POSITION: [Channel; 3] =
    [Channel::PositionNorth, Channel::PositionEast, Channel::PositionDown];
const VELOCITY: [Channel; 3] =
    [Channel::VelocityNorth, Channel::VelocityEast, Channel::VelocityDown];
const ATTITUDE: [Channel; 3] = [Channel::Roll, Channel::Pitch, Channel::Yaw];
const HEIGHT: [Channel; 1] = [Channel::BaroHeight];
const RANGE: [Channel; 1] = [Channel::Range];
const BASELINE: [Channel; 1] = [Channel::BaselineHeading];
const REST: [Channel; 6] = [
    Channel::RestRateX,
    Channel::RestRateY,
    Channel::RestRateZ,
    Channel::RestVelocityNorth,
    Channel::RestVelocityEast,
    Channel::RestVelocityDown,
];
const WHEELS: [Channel; 2] = [Channel::WheelsRight, Channel::WheelsDown];
/// The result of each scalar update of a run, in the filter's order.
#[must_use]
pub fn innovations(run: &Run) -> Vec<Innovation> {
    run.reports().flat_map(|report| report.innovations().copied()).collect()
}

/// Channels that are tested together, with their name.
pub const GROUPS: [(&str, &[Channel]); 8] = [
    ("Position", &POSITION),
    ("Velocity", &VELOCITY),
    ("Attitude", &ATTITUDE),
    ("Baro height", &HEIGHT),
    ("Distance to the ground", &RANGE),
    ("Heading of two antennas", &BASELINE),
    ("Rest", &REST),
    ("Wheels", &WHEELS),
];

/// The `innovations` that belong to `channels`.
#[must_use]
pub fn of_channels(innovations: &[Innovation], channels: &[Channel]) -> Vec<Innovation> {
    innovations.iter().filter(|one| channels.contains(&one.channel)).copied().collect()
}

/// Pooled test of each of [`GROUPS`]; `innovations` are in the order in which the filter fused them.
#[must_use]
pub fn pooled(innovations: &[Innovation]) -> Vec<(&'static str, PooledInnovations)> {
    let groups = GROUPS.into_iter().filter_map(|(name, channels)| {
        let tests = innovation_tests(&of_channels(innovations, channels));
        Some((name, PooledInnovations::of(&tests)?))
    });
    groups.collect()
}

/// The 2.5 % and 97.5 % points of the chi-square distribution.
///
/// Up to six degrees of freedom from the table, beyond by the Wilson–Hilferty approximation: accurate to 2 % at seven,
/// and better above.
///
/// # Source
/// Abramowitz and Stegun, *Handbook of Mathematical Functions*, table 26.8 and equation 26.4.17.
#[must_use]
pub fn chi_square_interval_95(degrees_of_freedom: usize) -> (f64, f64) {
    const TABLE: [(f64, f64); 7] = [
        (0.0, 0.0),
        (0.000_982, 5.023_89),
        (0.050_636, 7.377_76),
        (0.215_795, 9.348_40),
        (0.484_419, 11.143_3),
        (0.831_211, 12.832_5),
        (1.237_347, 14.449_4),
    ];
    TABLE.get(degrees_of_freedom).copied().unwrap_or_else(|| {
        let n = degrees_of_freedom as f64;
        let spread = 1.959_964 * (2.0 / (9.0 * n)).sqrt();
        let centre = 1.0 - 2.0 / (9.0 * n);
        (n * (centre - spread).powi(3), n * (centre + spread).powi(3))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn innovation(second: i64, normalised: f64, verdict: Verdict) -> Innovation {
        Innovation {
            time: Time::from_nanoseconds(second * 1_000_000_000),
            channel: Channel::PositionNorth,
            innovation: 2.0 * normalised,
            sigma: 2.0,
            verdict,
        }
    }

    #[test]
    fn channels_of_one_moment_make_one_fix() {
        let fixes = innovation_tests(&[
            innovation(1, 1.0, Verdict::Accepted),
            innovation(1, -2.0, Verdict::Accepted),
            innovation(2, 9.0, Verdict::Rejected),
        ]);
        assert_eq!(fixes.len(), 2);
        assert_eq!((fixes[0].squared, fixes[0].degrees_of_freedom), (5.0, 2));
        assert!(!fixes[0].refused && fixes[1].refused);
        assert!(fixes[0].is_inside() && !fixes[1].is_inside());
    }

    #[test]
    fn a_refused_fix_does_not_enter_the_mean() {
        let tests = innovation_tests(&[
            innovation(1, 1.0, Verdict::Accepted),
            innovation(2, 100.0, Verdict::Rejected),
            innovation(3, 3.0, Verdict::Accepted),
        ]);
        let pooled = PooledInnovations::of(&tests).unwrap();
        assert_eq!((pooled.mean, pooled.share_inside), (5.0, 0.5));
        assert!(PooledInnovations::of(&tests[1..2]).is_none());
        assert!(PooledInnovations::of(&[]).is_none());
    }

    #[test]
    fn a_filter_that_is_too_sure_does_not_pass_and_one_that_is_timid_is_reported_as_such() {
        let judged =
            |mean| PooledInnovations { mean, interval: (0.97, 1.03), share_inside: 0.95 }.judged();
        assert_eq!(judged(1.0).0, Level::Good);
        assert_eq!(judged(0.8).0, Level::Good);
        assert!(judged(0.2).1.starts_with("conservative"));
        assert_eq!(judged(1.4).0, Level::Care);
        assert_eq!(judged(2.5).0, Level::Bad);
    }

    // Abramowitz and Stegun, table 26.8.
    #[test]
    fn the_interval_beyond_the_table_agrees_with_published_points() {
        for (n, low, high) in
            [(7, 1.68987, 16.0128), (30, 16.7908, 46.9792), (100, 74.2219, 129.561)]
        {
            let interval = chi_square_interval_95(n);
            assert!((interval.0 / low - 1.0).abs() < 0.02, "{n}: {interval:?}");
            assert!((interval.1 / high - 1.0).abs() < 0.002, "{n}: {interval:?}");
        }
    }
}
