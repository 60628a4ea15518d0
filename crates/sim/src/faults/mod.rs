//! Faulty copies of a flight, and what they do to the estimator.
//!
//! [`Log::open`] reads a dataset, [`Log::with_faults`] puts [`Fault`]s in it, and [`FaultyLog::write`]
//! makes a dataset of it again. What no fault touches keeps its bytes, field by field.

mod catalogue;
mod fault;
mod inertial;
mod injection;
mod magnetic;
mod satellite;
mod setup;
mod table;
mod window;

pub use catalogue::{CATALOGUE, Entry, Kind, Lasts, Values, list};
pub use fault::Fault;
pub use injection::{FaultyLog, InjectError, Log, Made};
pub use window::Window;
