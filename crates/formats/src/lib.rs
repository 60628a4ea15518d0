#![doc = include_str!("../README.md")]

mod assembly;
mod choice;
#[cfg(feature = "dataflash")]
mod dataflash;
mod difference;
mod format;
mod integrals;
mod onboard;
mod open;
#[cfg(feature = "ulog")]
mod ulog;
mod utc;
mod window;

pub use difference::OnboardDifference;
pub use format::Format;
pub use onboard::{Onboard, OnboardMoment};
pub use open::{Log, Options, open, open_bytes};
