//! The closed loop of vehicle, sensors, estimator and autopilot, with the code of the flight computer.

mod config;
mod record;
mod run;
mod statistics;

pub use config::{Feedback, FlightConfig, FlightError, FlightEvent};
pub use record::{Flight, FlightSample};
pub use statistics::{Excursion, HoverStatistics, velocity_deviation_mps};
