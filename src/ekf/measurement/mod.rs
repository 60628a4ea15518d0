//! Measurements, a file per sensor, and the sequential scalar update they share.

mod attitude;
mod baro;
mod gps;
mod magnetic;
mod report;
mod rest;
mod update;

pub use report::{Aid, Report, Unusable};
pub(super) use rest::BiasShift;
use update::ScalarMeasurement;

#[cfg(test)]
mod tests;
