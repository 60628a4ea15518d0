//! Measurements of an inertial unit, in the units and axes of the filter, independent of its manufacturer.

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
    /// Time of the rates, or of the end of the increments.
    pub time: Time,
    /// Rates or increments.
    pub motion: Motion,
    /// Attitude computed by the inertial unit, if any; yaw from the north named in its data description.
    pub attitude: Option<EulerAngles>,
    /// Magnetic field in body axes, gauss, if measured.
    pub magnetic_field_gauss: Option<Vector<Body>>,
    /// Sensors at full scale at some time since the previous sample, if the inertial unit reports it.
    pub clipped: ClippedAxes,
}

impl ImuSample {
    /// A sample of motion alone: no attitude, no magnetic field, no clipping.
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
