//! The Earth, the strapdown mechanization and the simulated motion, each against what is known of it.

mod earth;
mod jacobians;
mod simulation;
mod strapdown;
mod trajectory;
