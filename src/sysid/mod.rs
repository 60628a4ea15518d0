//! Identification: from a recorded flight to a model that can be trusted, or to the reason why not.
//!
//! The work flows in this order, and each step names what is wrong before the next one starts:
//!
//! | step | what it does |
//! |---|---|
//! | [`experiment`] | one record of inputs and outputs, uniformly sampled and finite |
//!
//! Every matrix found here says in which time domain it is: [`LinearModel`](linear::LinearModel) is
//! a one-step map and carries its sample period.

pub mod experiment;
pub mod helicopter;
pub mod identify;
pub mod least_squares;
pub mod linear;
pub mod prediction_error;
pub mod structure;
pub mod test_points;
pub mod tones;

pub use experiment::{Experiment, ExperimentError, Offsets};
pub use linear::LinearModel;
