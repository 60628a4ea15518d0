//! What the estimator on board said during the flight: something to compare with, never the truth.

use hovernav::earth::Geodetic;
use hovernav::frames::{Body, Ned, Rotation, Vector};
use hovernav::time::Time;

/// The solution of the estimator that flew, in time order.
#[derive(Clone, Debug, Default)]
pub struct Onboard {
    /// Its name, such as `EKF2`.
    pub name: String,
    /// What it said, moment by moment, times strictly increasing.
    pub moments: Vec<OnboardMoment>,
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
