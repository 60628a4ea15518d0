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
//! | `model` | with `std`: the nonlinear helicopter, and linear models as data |
//! | `design` | with `std`: Riccati equations, optimal gains, exact holds, responses and margins |
//! | `sim`, `log` | with `std`: simulated flights, recorded flights and their scores |
#![cfg_attr(not(feature = "std"), no_std)]

#[cfg(feature = "std")]
pub mod design;
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
pub mod model;
#[cfg(feature = "std")]
pub mod sim;
pub mod time;
