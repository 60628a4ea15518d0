//! Faulty copies of a flight, and their effect on the estimator.
//!
//! [`Log::open`] reads a dataset, [`Log::with_faults`] injects [`Fault`]s, and [`FaultyLog::write`] writes the result
//! as a dataset. Fields without a fault keep their bytes.

mod ablation;
mod aids;
mod campaign;
mod catalogue;
mod fault;
mod flights;
mod goals;
mod inertial;
mod injection;
mod magnetic;
mod measure;
mod plot;
mod runner;
mod satellite;
mod setup;
mod shaking;
mod table;
mod tables;
mod window;

pub use ablation::{Ablated, Ablation, Cut, ablation_csv, ablation_markdown, read_ablation};
pub use campaign::{Campaign, Outcome, standard_cells};
pub use catalogue::{CATALOGUE, Entry, Kind, Lasts, Values, list};
pub use fault::Fault;
pub use flights::{Clean, Flight};
pub use goals::{Verdict, goals_markdown, verdicts};
pub use injection::{FaultyLog, InjectError, Log, Made};
pub use measure::{AXES, Measures};
pub use plot::svg;
pub use tables::{csv, markdown};
pub use window::Window;
