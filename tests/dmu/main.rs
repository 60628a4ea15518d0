//! The inertial unit on the wire: captured and synthetic streams, damage of every kind, its timer,
//! and a simulated unit to start up.

mod capture;
mod clock;
mod generator;
mod measurement;
mod simulated_unit;
mod start;
mod stream;
