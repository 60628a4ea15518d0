//! The error-state Kalman filter.

mod innovation;
mod solution;

pub use innovation::{Channel, Innovation, Verdict};
pub use solution::Solution;
