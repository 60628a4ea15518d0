//! Measurements, a file per sensor, and the sequential scalar update that they share.

mod antenna_heading;
mod attitude;
mod baro;
mod climb;
mod derivatives;
mod gps;
mod magnetic;
mod own;
mod own_update;
mod range;
mod report;
mod rest;
mod update;
mod wander;
mod wheels;

pub use derivatives::{WrongRows, check_derivatives};
pub(super) use gps::stated_times;
pub use own::{Expected, Measurement, Row, Rows};
pub use report::{Aid, Report, Unusable};

#[cfg(test)]
mod tests;
