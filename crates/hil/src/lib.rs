#![doc = include_str!("../README.md")]
#![cfg(unix)]

mod error;
mod lines;
mod pilot;
mod plant;
mod scene;
mod statistics;

pub use error::LiveFlightError;
pub use lines::{LinePaths, LiveFlight};
pub use plant::{LiveConfig, LiveSample, ServoPackets};
pub use scene::{Act, ActError, Scene, TimedAct};
pub use statistics::LiveStatistics;
