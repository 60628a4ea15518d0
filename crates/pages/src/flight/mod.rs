//! The page of a filtered flight: map, motion, biases, innovations, errors.
//!
//! [`LogPage`] is the page of an estimated log, [`page`] that of any flight in parts.

mod data;
pub(crate) mod errors;
mod facts;
mod innovations;
mod log;
mod motion;
mod raw;
mod sections;
mod sensors;
mod spectrum;
#[cfg(test)]
mod tests;

pub use data::{FlightData, reference_moments, sticks};
pub use facts::{facts, headlines};
pub use log::LogPage;
pub use sections::page;
