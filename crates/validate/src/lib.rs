//! Evaluation of the filter: the estimator's results on every set and every case, as one table.
//!
//! [`find`] lists the sets, [`run`] runs the estimator on them, and [`moved`] compares two tables. The program
//! `validate` writes the table to `docs/validation`. Every number comes from the functions that `hovernav estimate`
//! calls.

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
