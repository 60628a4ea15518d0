//! Measurements of an inertial unit, in the units and axes of the filter, independent of its manufacturer.

mod axes;
mod errors;
mod held_force;
mod integrity;
mod motion;
mod notch;
mod repetition;
mod rest;
mod second_difference;
mod vibration;

pub use axes::ImuAxes;
pub use errors::ImuErrors;
pub use integrity::{Checks, FullScale, Integrity, Suspicion};
pub use motion::{MeanRates, Motion};
#[doc(hidden)]
pub use notch::apparent_hz;
pub use notch::{MAX_HARMONICS, Notch, NotchConfig};
#[doc(hidden)]
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
    /// Attitude computed by the inertial unit, if any. The data description states whether its yaw is from true or from
    /// magnetic north.
    pub attitude: Option<EulerAngles>,
    /// Magnetic field in body axes, gauss, if measured.
    pub magnetic_field_gauss: Option<Vector<Body>>,
    /// Sensors at full scale at some time since the previous sample, if the inertial unit reports it.
    pub clipped: ImuAxes,
}

impl ImuSample {
    /// A sample of angular rate, rad/s, and specific force, m/s², both in body axes, valid at `time`. The specific
    /// force of a level vehicle at rest is −9.81 down.
    ///
    /// ```
    /// use hovernav::prelude::*;
    ///
    /// let force_mps2 = Vector::new(0.0, 0.0, -9.81);
    /// let sample = ImuSample::from_rates(Time::from_seconds(0.01), Vector::ZERO, force_mps2)
    ///     .with_magnetic_field_gauss(Vector::new(0.2, 0.0, 0.43));
    /// assert_eq!(sample.attitude, None);
    /// ```
    #[must_use]
    pub const fn from_rates(
        time: Time,
        angular_rate_radps: Vector<Body>,
        specific_force_mps2: Vector<Body>,
    ) -> Self {
        Self::new(time, Motion::Rates { angular_rate_radps, specific_force_mps2 })
    }

    /// A sample of the rotation, rad, and the velocity change, m/s, since the previous sample, as integrating IMUs
    /// output them: see [`Motion::Increments`].
    #[must_use]
    pub const fn from_increments(
        time: Time,
        angle_rad: Vector<Body>,
        velocity_mps: Vector<Body>,
    ) -> Self {
        Self::new(time, Motion::Increments { angle_rad, velocity_mps })
    }

    /// This sample with the inertial unit's own attitude.
    #[must_use]
    pub const fn with_attitude(mut self, attitude: EulerAngles) -> Self {
        self.attitude = Some(attitude);
        self
    }

    /// This sample with a magnetic field in body axes, gauss.
    #[must_use]
    pub const fn with_magnetic_field_gauss(mut self, field_gauss: Vector<Body>) -> Self {
        self.magnetic_field_gauss = Some(field_gauss);
        self
    }

    /// A sample of motion alone: no attitude, no magnetic field, no clipping.
    #[must_use]
    pub const fn new(time: Time, motion: Motion) -> Self {
        Self { time, motion, attitude: None, magnetic_field_gauss: None, clipped: ImuAxes::NONE }
    }
}
