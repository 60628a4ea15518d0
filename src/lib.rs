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
//! | [`ins`] | increments, the strapdown mechanization, lever arms, alignment |
//! | [`ekf`] | the filter; [`ekf::Estimator`] is the whole of it behind one call |
//! | `sim`, `log` | with `std`: simulated flights, recorded flights and their scores |
//! | `sysid` | with `std`: a model identified from a recorded flight, and how far to trust it |
#![cfg_attr(not(feature = "std"), no_std)]

pub mod dmu;
pub mod earth;
pub mod ekf;
pub mod event;
pub mod frames;
pub mod gps;
pub mod ins;
#[cfg(feature = "std")]
pub mod log;
#[cfg(feature = "std")]
pub mod sim;
#[cfg(feature = "std")]
pub mod sysid;
pub mod time;
