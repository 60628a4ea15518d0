//! Measurements, a file per sensor, and the sequential scalar update that they share.

mod antenna_heading;
mod attitude;
mod baro;
mod derivatives;
mod gps;
mod magnetic;
mod own;
mod own_update;
mod range;
mod rest;
mod update;
mod wander;
mod wheels;

pub use derivatives::{WrongRows, check_derivatives};
pub use own::{Expected, Measurement, Row, Rows};

#[cfg(test)]
mod tests;
