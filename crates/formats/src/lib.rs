#![doc = include_str!("../README.md")]

<<<<<<< HEAD
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
=======
#[cfg(feature = "text")]
mod axes;
mod format;
#[cfg(feature = "text")]
mod init;
mod onboard;
mod open;
#[cfg(feature = "text")]
mod text;
>>>>>>> 37229da (Read any text in columns by a mapping, and propose one)

pub use difference::OnboardDifference;
pub use format::Format;
#[cfg(feature = "text")]
pub use init::Proposal;
pub use onboard::{Onboard, OnboardMoment};
pub use open::{Log, Options, open, open_bytes};
