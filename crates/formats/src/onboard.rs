//! What the estimator on board said during the flight: something to compare with, never the truth.

use std::collections::BTreeMap;

use serde::Serialize;

use hovernav::earth::Geodetic;
use hovernav::ekf::{Channel, Innovation, Verdict};
use hovernav::frames::{Body, Ned, Rotation, Vector};
use hovernav::time::Time;

/// The solution of the estimator that flew, in time order.
#[derive(Clone, Debug, Default)]
pub struct Onboard {
    /// Its name, such as `EKF2`.
    pub name: String,
    /// What it said, moment by moment, times strictly increasing.
    pub moments: Vec<OnboardMoment>,
    /// How far measurements were from what it expected, in time order.
    pub innovations: Vec<OnboardInnovation>,
}

/// A measurement less what the estimator on board expected of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnboardInnovation {
    /// When, on the clock of the dataset.
    pub time: Time,
    /// Of what.
    pub channel: Channel,
    /// Measurement less expectation, in the unit of the channel: m, m/s or rad.
    pub innovation: f64,
    /// How large it was expected to be, one-sigma, where the log says so.
    pub sigma: Option<f64>,
}

/// How large the innovations of a channel were, of the estimator on board and of ours.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct InnovationSizes {
    /// The estimator's on board.
    pub onboard: InnovationSize,
    /// Ours in the same span; `None` where there are none.
    pub ours: Option<InnovationSize>,
}

/// How large innovations were.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct InnovationSize {
    /// How many.
    pub count: usize,
    /// Root of their mean square, m, m/s or rad.
    pub rms: f64,
    /// Mean square in units of the size expected, 1 of an estimator that knows itself; `None` where no
    /// size was expected.
    pub mean_square: Option<f64>,
}

impl InnovationSize {
    /// That of innovations with their one-sigma; `None` of none.
    fn of(innovations: impl Iterator<Item = (f64, Option<f64>)>) -> Option<Self> {
        let (mut count, mut squares, mut expected, mut normalised) = (0, 0.0, 0, 0.0);
        for (innovation, sigma) in innovations {
            count += 1;
            squares += innovation * innovation;
            if let Some(sigma) = sigma.filter(|sigma| *sigma > 0.0) {
                expected += 1;
                normalised += (innovation / sigma).powi(2);
            }
        }
        (count > 0).then(|| Self {
            count,
            rms: (squares / count as f64).sqrt(),
            mean_square: (expected > 0).then(|| normalised / f64::from(expected)),
        })
    }
}

impl Onboard {
    /// How large its innovations were, and `ours` in the same span but for those refused, by
    /// [`Channel::name`].
    #[must_use]
    pub fn innovation_sizes(&self, ours: &[Innovation]) -> BTreeMap<&'static str, InnovationSizes> {
        let mut sizes = BTreeMap::new();
        let (Some(first), Some(last)) = (self.innovations.first(), self.innovations.last()) else {
            return sizes;
        };
        let span = first.time..=last.time;
        for OnboardInnovation { channel, .. } in &self.innovations {
            if sizes.contains_key(channel.name()) {
                continue;
            }
            let theirs = self.innovations.iter().filter(|one| one.channel == *channel);
            let same = ours.iter().filter(|one| {
                one.channel == *channel
                    && one.verdict != Verdict::Rejected
                    && span.contains(&one.time)
            });
            let ours = InnovationSize::of(same.map(|one| (one.innovation, Some(one.sigma))));
            let onboard = InnovationSize::of(theirs.map(|one| (one.innovation, one.sigma)));
            sizes
                .extend(onboard.map(|onboard| (channel.name(), InnovationSizes { onboard, ours })));
        }
        sizes
    }
}

/// What the estimator on board said at one moment; `None` where it said nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnboardMoment {
    /// When, on the clock of the dataset.
    pub time: Time,
    /// The attitude.
    pub body_to_ned: Option<Rotation<Body, Ned>>,
    /// The velocity, m/s.
    pub velocity_mps: Option<Vector<Ned>>,
    /// The place.
    pub position: Option<Geodetic>,
}

impl OnboardMoment {
    /// A moment of which nothing is said.
    #[must_use]
    pub const fn at(time: Time) -> Self {
        Self { time, body_to_ned: None, velocity_mps: None, position: None }
    }
}
