//! Trajectories of any origin: `solution.csv`, TUM and EuRoC files, placed on Earth or aligned for comparison.

mod poses;
pub(crate) mod possible_motion;
mod read;

pub use poses::{LocalAxes, Trajectory};
