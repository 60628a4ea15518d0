#![doc = include_str!("../README.md")]
//!
//! # The tour
//!
//! In the order data meets them:
//!
//! | module | what it is |
//! |---|---|
//! | [`time`], [`frames`], [`earth`] | the ground: a clock, vectors that know their frame, the ellipsoid |
//! | [`dmu`], [`gps`], [`event`] | what sensors say: a sample, a fix, one stream of both |
//! | [`sensors`] | both conversations at once: from a line's bytes to events |
//! | [`ins`] | increments, the strapdown mechanization, lever arms, alignment |
//! | [`ekf`] | the filter; [`ekf::Estimator`] is the whole of it behind one call |
//! | [`autopilot`] | hover control: modes, set-points and loops, from a solution to sticks |
//! | [`servo`], [`telemetry`] | pulses from the pilot and to the servos; what the ground is told |
//! | `model` | with `std`: the nonlinear helicopter, and linear models as data |
//! | `design` | with `std`: Riccati equations, optimal gains, exact holds, responses and margins; the hover's gains |
//! | `sim`, `log` | with `std`: simulated flights, recorded flights and their scores |
//! | `log::record` | with `record`: the flight record, written beside the loop and replayed to the bit |
//! | `fly` | with `std`: the real-time loop and its configuration |
//! | `serial`, `play` | with `serial`: lines that come back by themselves, and devices to test them on |
//! | `sysid` | with `std`: a model identified from a recorded flight, and how far to trust it |
#![cfg_attr(not(feature = "std"), no_std)]

pub mod autopilot;
#[cfg(feature = "std")]
pub mod design;
pub mod dmu;
pub mod earth;
pub mod ekf;
pub mod event;
#[cfg(feature = "std")]
pub mod fly;
pub mod frames;
pub mod gps;
pub mod ins;
#[cfg(feature = "std")]
pub mod log;
#[cfg(feature = "std")]
pub mod model;
#[cfg(all(feature = "serial", unix))]
pub mod play;
pub mod sensors;
#[cfg(feature = "serial")]
pub mod serial;
pub mod servo;
#[cfg(feature = "std")]
pub mod sim;
#[cfg(feature = "std")]
pub mod sysid;
pub mod telemetry;
pub mod time;
