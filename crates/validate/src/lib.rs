//! The measuring instrument of the filter: every set and every case through the estimator, as one table.
//!
//! [`find`] lists the sets, [`run`] flies them, and [`moved`] compares two tables. The program `validate` writes the
//! table to `docs/validation`. Every number comes from the functions that `hovernav estimate` calls.

mod markdown;
mod moved;
mod outages;
mod row;
mod run;
mod sets;

pub use markdown::markdown;
pub use moved::moved;
pub use outages::{Drift, drifts};
pub use row::{NUMBERS, Row, read_csv, write_csv};
pub use run::run;
pub use sets::{Set, Windows, find};
