//! The types of a first program, which computes a solution from sensor events.
//!
//! | step | types |
//! |---|---|
//! | settings | [`EstimatorConfig`], [`ImuModel`], [`GpsModel`], [`Mounting`] |
//! | sensors | [`Event`]: [`ImuSample`], [`Fix`], [`BaroReading`] |
//! | other sensors | [`Event`]: [`MagneticReading`], [`RangeReading`], [`AntennaHeading`] |
//! | units | [`Time`], [`Geodetic`], [`Vector`] in [`Body`] or [`Ned`] axes, [`EulerAngles`] |
//! | estimate | [`Estimator`], [`Notice`], [`Solution`], [`Health`] |
//!
//! For a sensor without an [`Event`], implement [`Measurement`](crate::ekf::Measurement).

pub use crate::earth::Geodetic;
pub use crate::ekf::{Estimator, EstimatorConfig, GpsModel, ImuModel, Notice, Solution};
pub use crate::event::{BaroReading, Event, MagneticReading, RangeReading};
pub use crate::frames::{Body, EulerAngles, Ned, Vector};
pub use crate::gps::{AntennaHeading, Fix};
pub use crate::health::Health;
pub use crate::imu::ImuSample;
pub use crate::ins::Mounting;
pub use crate::time::Time;
