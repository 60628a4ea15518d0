//! The types of a first program: sensors in, a solution out.
//!
//! | step | types |
//! |---|---|
//! | settings | [`EstimatorConfig`], [`ImuModel`], [`GpsModel`], [`Mounting`] |
//! | sensors | [`Event`]: [`ImuSample`], [`Fix`], [`BaroReading`], [`MagneticReading`], [`RangeReading`], [`AntennaHeading`] |
//! | units | [`Time`], [`Geodetic`], [`Vector`] in [`Body`] or [`Ned`] axes, [`EulerAngles`] |
//! | estimate | [`Estimator`], [`Notice`], [`Solution`], [`Health`] |
//!
//! A sensor without an [`Event`] implements [`Measurement`](crate::ekf::Measurement).

pub use crate::earth::Geodetic;
pub use crate::ekf::{Estimator, EstimatorConfig, GpsModel, ImuModel, Notice, Solution};
pub use crate::event::{BaroReading, Event, MagneticReading, RangeReading};
pub use crate::frames::{Body, EulerAngles, Ned, Vector};
pub use crate::gps::{AntennaHeading, Fix};
pub use crate::health::Health;
pub use crate::imu::ImuSample;
pub use crate::ins::Mounting;
pub use crate::time::Time;
