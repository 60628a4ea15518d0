//! The innovations with their bounds, and the test of their consistency.

use hovernav::ekf::{Channel, Innovation, Verdict};
use hovernav_formats::Onboard;
use hovernav_score::consistency::{
    GROUPS, InnovationTest, PooledInnovations, chi_square_interval_95, innovation_tests,
    of_channels,
};

use super::motion::Clock;
use crate::{Figure, Role, Row, Section, Series};

/// Number of fixes in the running mean of the test.
const MEAN_OVER: usize = 30;

/// The labels of a channel: name, displayed unit, and factor from the channel's own unit.
fn labels(channel: Channel) -> (&'static str, &'static str, f64) {
    const DEGREES: f64 = 180.0 / std::f64::consts::PI;
    match channel {
        Channel::PositionNorth => ("Position north", "m", 1.0),
        Channel::PositionEast => ("Position east", "m", 1.0),
        Channel::PositionDown => ("Position down", "m", 1.0),
        Channel::VelocityNorth => ("Velocity north", "m/s", 1.0),
        Channel::VelocityEast => ("Velocity east", "m/s", 1.0),
        Channel::VelocityDown => ("Velocity down", "m/s", 1.0),
        Channel::Roll => ("Roll", "°", DEGREES),
        Channel::Pitch => ("Pitch", "°", DEGREES),
        Channel::Yaw => ("Yaw", "°", DEGREES),
        Channel::BaroHeight => ("Baro height", "m", 1.0),
        Channel::Range => ("Distance to the ground", "m", 1.0),
        Channel::BaselineHeading => ("Heading of two antennas", "°", DEGREES),
        Channel::RestRateX => ("Rate at rest, x", "°/s", DEGREES),
        Channel::RestRateY => ("Rate at rest, y", "°/s", DEGREES),
        Channel::RestRateZ => ("Rate at rest, z", "°/s", DEGREES),
        Channel::RestVelocityNorth => ("Velocity north at rest", "m/s", 1.0),
        Channel::RestVelocityEast => ("Velocity east at rest", "m/s", 1.0),
        Channel::RestVelocityDown => ("Velocity down at rest", "m/s", 1.0),
        Channel::WheelsRight => ("Velocity across the road", "m/s", 1.0),
        Channel::Own(_) => ("Own sensor", "", 1.0),
        Channel::WheelsDown => ("Velocity down from the road", "m/s", 1.0),
    }
}

/// The innovations of each channel with their 3σ bounds.
pub fn innovations(innovations: &[Innovation], onboard: Option<&Onboard>, clock: Clock) -> Section {
    let rows =
        GROUPS.iter().flat_map(|(_, channels)| channels.iter().copied()).filter_map(|channel| {
            let own = of_channels(innovations, &[channel]);
            let (name, unit, scale) = labels(channel);
            let times: Vec<f64> = own.iter().map(|one| clock.seconds(one.time)).collect();
            let high: Vec<f64> = own.iter().map(|one| 3.0 * scale * one.sigma).collect();
            let those = |verdict| {
                let points = own.iter().filter(move |one| one.verdict == verdict);
                points.map(move |one| (clock.seconds(one.time), scale * one.innovation))
            };
            let theirs = onboard.map_or(&[][..], |onboard| &onboard.innovations);
            let theirs = theirs.iter().filter(|one| one.channel == channel);
            let theirs = theirs.map(|one| (clock.seconds(one.time), scale * one.innovation));
            let row = Row::new(name, unit)
                .with(Series::points(Role::OnboardInnovation, theirs))
                .with(Series::points(Role::Innovation, those(Verdict::Accepted)))
                .with(Series::points(Role::Reopened, those(Verdict::Reset)))
                .with(Series::points(Role::Rejected, those(Verdict::Rejected)));
            let row = if own.is_empty() { row } else { row.with(Series::bound(&times, &high)) };
            (!row.series.is_empty()).then_some(row)
        });
    let has_theirs = onboard.is_some_and(|onboard| !onboard.innovations.is_empty());
    let theirs = if has_theirs {
        " Rings are the innovations of the onboard estimator, which has its own bounds."
    } else {
        ""
    };
    Section::new(
        "innovations",
        "Innovations",
        format!(
            "Each measurement minus the filter's prediction. Nearly all should be inside the band, as \
             often above zero as below. Crosses are rejected measurements.{theirs}"
        ),
    )
    .with(Figure::against_time(rows))
}

/// The normalised innovation squared of each fix, and its running mean.
pub fn test(innovations: &[Innovation], clock: Clock) -> Section {
    let rows = GROUPS.into_iter().filter_map(|(name, channels)| {
        let tests = innovation_tests(&of_channels(innovations, channels));
        (!tests.is_empty()).then(|| test_row(name, &tests, clock))
    });
    Section::new(
        "test",
        "Normalised innovation test",
        format!(
            "Mean over the channels of each fix's squared innovations, normalised by their predicted variance. \
             The average is 1 for a consistent filter, higher for an overconfident one and lower for a \
             conservative one. The shaded interval contains 95 % of the fixes of a consistent filter \
             (chi-square). The line is the mean over {MEAN_OVER} fixes."
        ),
    )
    .with(Figure::against_time(rows))
}

fn test_row(name: &str, tests: &[InnovationTest], clock: Clock) -> Row {
    let times: Vec<f64> = tests.iter().map(|test| clock.seconds(test.time)).collect();
    let (low, high): (Vec<f64>, Vec<f64>) = tests
        .iter()
        .map(|test| {
            let (low, high) = chi_square_interval_95(test.degrees_of_freedom);
            let channels = test.degrees_of_freedom as f64;
            (low / channels, high / channels)
        })
        .unzip();
    let those = |refused: bool| {
        let points = tests.iter().filter(move |test| test.refused == refused);
        points.map(move |test| (clock.seconds(test.time), test.per_channel()))
    };
    let mean: Vec<f64> = (0..tests.len())
        .map(|last| {
            let recent = &tests[(last + 1).saturating_sub(MEAN_OVER)..=last];
            let enough = recent.len() == MEAN_OVER.min(tests.len());
            PooledInnovations::of(recent).filter(|_| enough).map_or(f64::NAN, |pooled| pooled.mean)
        })
        .collect();
    let pooled = PooledInnovations::of(tests);
    let judged = pooled.as_ref().map(PooledInnovations::judged);
    let note = pooled.zip(judged).map(
        |(PooledInnovations { mean, interval: (low, high), share_inside }, (_, words))| {
            format!(
                "{words}; mean {mean:.2}, expected {low:.2} to {high:.2}, {:.1} % of fixes inside",
                100.0 * share_inside
            )
        },
    );
    let judged = judged.map(|(level, _)| level);
    Row { logarithmic: true, note, judged, ..Row::new(name, "") }
        .with(Series::range(Role::Interval, &times, &low, &high))
        .with(Series::points(Role::Test, those(false)))
        .with(Series::points(Role::TestRefused, those(true)))
        .with(Series::line(Role::Mean, &times, &mean, None))
}
