//! The controls of the helicopter: names, one value for each, and the four sticks.

mod channel;
mod sticks;

pub use channel::{Channel, Channels};
pub use sticks::Sticks;
