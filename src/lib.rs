// The README's links lead to files next to the README. Of several definitions of a link the first one counts, so these
// definitions take effect in the documentation.
#![doc = "[architecture]: https://github.com/hovernav/hovernav/blob/main/docs/architecture.md"]
#![doc = "[commands]: https://github.com/hovernav/hovernav/blob/main/docs/commands.md"]
#![doc = "[embedded]: https://github.com/hovernav/hovernav/blob/main/docs/embedded.md"]
#![doc = "[equations]: https://github.com/hovernav/hovernav/blob/main/docs/equations.md"]
#![doc = "[faq]: https://github.com/hovernav/hovernav/blob/main/docs/faq.md"]
#![doc = "[faults]: https://github.com/hovernav/hovernav/blob/main/docs/faults.md"]
#![doc = "[ffi]: https://github.com/hovernav/hovernav/blob/main/ffi/README.md"]
#![doc = "[filter]: https://github.com/hovernav/hovernav/blob/main/docs/filter.md"]
#![doc = "[flying]: https://github.com/hovernav/hovernav/blob/main/docs/flying.md"]
#![doc = "[formats]: https://github.com/hovernav/hovernav/blob/main/docs/formats.md"]
#![doc = "[ground]: https://github.com/hovernav/hovernav/blob/main/docs/ground.md"]
#![doc = "[prepare]: https://github.com/hovernav/hovernav/blob/main/docs/prepare.md"]
#![doc = "[python]: https://github.com/hovernav/hovernav/blob/main/docs/python.md"]
#![doc = "[report]: https://raw.githubusercontent.com/hovernav/hovernav/main/docs/report.png"]
#![doc = "[timing]: https://github.com/hovernav/hovernav/blob/main/docs/timing.md"]
#![doc = "[tuning]: https://github.com/hovernav/hovernav/blob/main/docs/tuning.md"]
#![doc = "[tutorials]: https://github.com/hovernav/hovernav/blob/main/docs/tutorials.md"]
#![doc = "[validation]: https://github.com/hovernav/hovernav/blob/main/docs/validation.md"]
#![doc = "[warnings]: https://github.com/hovernav/hovernav/blob/main/docs/warnings.md"]
#![doc = ""]
#![doc = include_str!("../README.md")]
//!
//! # The tour
//!
//! [`prelude`] has the types of a first program. The table lists the modules in the order in which data passes through
//! them. The page of each module begins with its purpose.
//!
//! | module | contents |
//! |---|---|
//! | [`scalar`], [`time`], [`frames`], [`earth`] | number type, clock, vectors with their frames, ellipsoid |
//! | [`imu`], [`controls`] | a sample of an inertial unit; the names of sticks and channels |
//! | [`dmu`], [`gps`], [`event`] | the Crossbow inertial unit, GPS receivers, and one stream of sensor measurements |
//! | [`sensors`] | both sensor links together: events from the bytes of two serial lines |
//! | [`setup`] | likely mistakes in units, signs and axes of the sensors |
//! | [`ins`] | increments, the strapdown mechanization, lever arms, alignment |
//! | [`ekf`] | the filter; [`ekf::Estimator`] is the complete filter behind one call |
//! | [`health`] | quantities of a solution that are good enough to use, and why the others are not |
//! | [`autopilot`] | hover control: modes, set-points and loops, from a solution to sticks |
//! | [`servo`] | pulses from the pilot and to the servos |
//! | [`flight_control`] | the pilot's switch, the autopilot and the failsafes |
//! | [`telemetry`] | the frames that the ground station receives |
//!
//! A module imports only modules above it in this table. Vectors and quaternions are those of [`glam`], which is
//! re-exported so that users need not match its version.
#![cfg_attr(not(test), no_std)]
// Flight code must not panic.
#![cfg_attr(
    not(test),
    deny(
        clippy::expect_used,
        clippy::indexing_slicing,
        clippy::panic,
        clippy::todo,
        clippy::unimplemented,
        clippy::unreachable,
        clippy::unwrap_used
    )
)]

#[cfg(feature = "alloc")]
extern crate alloc;

pub use glam;

pub mod autopilot;
mod buffer;
pub mod controls;
pub mod dmu;
pub mod earth;
pub mod ekf;
pub mod event;
pub mod flight_control;
pub mod frames;
pub mod gps;
pub mod health;
pub mod imu;
pub mod ins;
pub mod prelude;
pub mod scalar;
#[cfg(any(feature = "nmea", feature = "tsip", feature = "ubx"))]
pub mod sensors;
pub mod servo;
pub mod setup;
pub mod telemetry;
pub mod time;
