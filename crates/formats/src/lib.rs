#![doc = include_str!("../README.md")]

mod format;
mod onboard;
mod open;

pub use format::Format;
pub use onboard::{Onboard, OnboardMoment};
pub use open::{Log, Options, open};
