//! The closed loop: vehicle, sensors, estimator and autopilot, as they fly.

mod config;
mod record;
mod run;
mod statistics;

pub use config::{Feedback, FlightConfig, FlightError, FlightEvent};
pub use record::{Flight, FlightSample};
pub use statistics::{Excursion, HoverStatistics};
