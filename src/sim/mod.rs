//! Simulation: flights without error. Needs `std`.

mod plan;
mod trajectory;

pub use plan::{FlightPlan, Leg, Level};
pub use trajectory::{State, Trajectory, TrajectoryError};
