//! The page of a filtered flight: map, motion, biases, innovations, errors.
//!
//! [`estimate`](crate::estimate) uses it for a log, [`simulate`](crate::simulate) for a simulated flight. The library
//! computes every number; this module adds units and layout.

mod consistency;
mod data;
mod errors;
mod innovations;
mod motion;
mod raw;
mod sections;
mod sensors;
mod spectrum;
#[cfg(test)]
mod tests;
mod verdict;

pub use data::{FlightData, reference_moments, sticks};
pub use sections::page;
