//! Trajectories of any origin: `solution.csv`, TUM and EuRoC files, placed on Earth or aligned for comparison.

mod align;
mod poses;
mod read;

pub use align::Alignment;
pub use poses::{LocalAxes, Trajectory};
