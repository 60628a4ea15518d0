//! The Earth, the strapdown mechanization and the simulated motion, each compared with known results.

mod earth;
mod jacobians;
mod simulation;
mod strapdown;
mod trajectory;
