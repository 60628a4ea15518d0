//! The IMU on the serial line: captured and synthetic streams, damage of every kind, its timer, and the start-up of a
//! simulated IMU.

mod capture;
mod clock;
mod generator;
mod measurement;
mod simulated_unit;
mod start;
mod stream;
