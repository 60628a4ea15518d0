//! Navigation for small helicopters and drones from a vibrating inertial unit and a slow GPS.
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
pub mod time;
