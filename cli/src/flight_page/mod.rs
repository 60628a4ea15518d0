//! The page of a flight through the filter: map, motion, biases, innovations, errors.
//!
//! [`estimate`](crate::estimate) shows a log with it, [`simulate`](crate::simulate) a simulated
//! flight. Every number comes from the library; here it only gets its unit and its place.

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

pub use data::{FlightData, innovations, reference_moments, sticks};
pub use sections::page;
