//! The controls of the helicopter: their names, one value for each, and the four sticks.
//!
//! Each of the five [`Channels`] drives a servo with pulses. The pilot and the autopilot command four [`Sticks`]
//! about trim, and leave the throttle to the engine governor.

mod channel;
mod sticks;

pub use channel::{Channel, Channels};
pub use sticks::Sticks;
