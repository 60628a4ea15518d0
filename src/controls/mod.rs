//! The controls of the helicopter: their names, one value for each, and the four sticks.
//!
//! Each of the five [`Channels`] drives a servo with pulses. The pilot and the autopilot command the four [`Sticks`]
//! about trim; the engine governor commands the throttle.

mod channel;
mod sticks;

pub use channel::{Channel, Channels};
pub use sticks::Sticks;
