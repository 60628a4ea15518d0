//! Solution of the onboard estimator during the flight. It is for comparison, and is not the truth.

use std::collections::BTreeMap;

use serde::Serialize;

use hovernav::earth::Geodetic;
use hovernav::ekf::{Channel, Innovation, Verdict};
use hovernav::frames::{Body, Ned, Rotation, Vector};
use hovernav::time::Time;

/// The solution of the estimator that ran during the flight, in time order.
#[derive(Clone, Debug, Default)]
pub struct Onboard {
    /// Name of the estimator, such as `EKF2`.
    pub name: String,
    /// Solution of the estimator, with strictly increasing times.
    pub moments: Vec<OnboardMoment>,
    /// Innovations of the estimator, in time order.
    pub innovations: Vec<OnboardInnovation>,
}

/// An innovation of the onboard estimator: a measurement minus its prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnboardInnovation {
    /// Time on the clock of the dataset.
    pub time: Time,
    /// The measured quantity.
    pub channel: Channel,
    /// Measurement minus prediction, in the unit of the channel: m, m/s or rad.
    pub innovation: f64,
    /// Expected one-sigma of the innovation, if the log has it.
    pub sigma: Option<f64>,
}

/// Innovation statistics of one channel, of the onboard estimator and of hovernav.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct InnovationSizes {
    /// Statistics of the onboard estimator.
    pub onboard: InnovationSize,
    /// Statistics of hovernav in the same time span; `None` without innovations.
    pub ours: Option<InnovationSize>,
}

/// Innovation statistics.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct InnovationSize {
    /// Number of innovations.
    pub count: usize,
    /// Root mean square, m, m/s or rad.
    pub rms: f64,
    /// Mean square of the innovations divided by their expected one-sigma; 1 for a consistent estimator. `None` if the
    /// log has no one-sigmas.
    pub mean_square: Option<f64>,
}

impl InnovationSize {
    /// Statistics of innovations with their one-sigma; `None` without innovations.
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
    /// Statistics of the onboard innovations and of `ours` in the same time span, keyed by [`Channel::name`].
    /// Rejected innovations of `ours` are not counted.
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

/// Solution of the onboard estimator at one time; `None` for missing values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnboardMoment {
    /// Time on the clock of the dataset.
    pub time: Time,
    /// The attitude.
    pub body_to_ned: Option<Rotation<Body, Ned>>,
    /// The velocity, m/s.
    pub velocity_mps: Option<Vector<Ned>>,
    /// The position.
    pub position: Option<Geodetic>,
}

impl OnboardMoment {
    /// A moment without values.
    #[must_use]
    pub const fn at(time: Time) -> Self {
        Self { time, body_to_ned: None, velocity_mps: None, position: None }
    }
}
