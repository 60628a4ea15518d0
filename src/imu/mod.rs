//! What an inertial unit measures, in the units and axes the filter takes, whoever made the unit.

mod clipped;
mod errors;
mod held_force;
mod integrity;
mod motion;
mod notch;
mod repetition;
mod rest;
mod second_difference;
mod vibration;

pub use clipped::ClippedAxes;
pub use errors::ImuErrors;
pub use integrity::{FullScale, Integrity, StuckAxes, Suspicion};
pub use motion::{MeanRates, Motion};
pub use notch::{MOST_HARMONICS, Notch, NotchConfig, apparent_hz};
pub use rest::Rest;
pub(crate) use second_difference::{SecondDifference, noise_variance};
pub(crate) use vibration::Vibration;

use crate::frames::{Body, EulerAngles, Vector};
use crate::time::Time;

/// One sample of the inertial unit, axes already turned to forward-right-down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuSample {
    /// When the rates were sampled, or the increments ended.
    pub time: Time,
    /// Rates or increments.
    pub motion: Motion,
    /// The unit's own attitude, if it computes one; yaw from the north its dataset names.
    pub attitude: Option<EulerAngles>,
    /// Magnetic field in body axes, gauss, if the unit measures it.
    pub magnetic_field_gauss: Option<Vector<Body>>,
    /// Which sensors were at their full scale at some time since the sample before, if the unit marks it.
    pub clipped: ClippedAxes,
}

impl ImuSample {
    /// Motion alone: no attitude, no magnetic field, nothing clipped.
    #[must_use]
    pub const fn new(time: Time, motion: Motion) -> Self {
        Self {
            time,
            motion,
            attitude: None,
            magnetic_field_gauss: None,
            clipped: ClippedAxes::NONE,
        }
    }
}
