//! Identification: from a recorded flight to a model that can be trusted, or to the reason why not.
//!
//! The work flows in this order, and each step names what is wrong before the next one starts:
//!
//! | step | what it does |
//! |---|---|
//! | [`inputs`] | what to fly: steps, doublets, 3-2-1-1, sine sweeps |
//! | [`experiment`] | one record of inputs and outputs, uniformly sampled and finite |
//! | [`test_points`], [`tones`] | where the pilot tested what; vibration's lines taken out |
//! | [`preprocess`] | filters, trim, segments; is the data fit to be fitted? |
//! | [`subspace`] | black-box models without a start value |
//! | [`frequency`] | frequency responses with their coherence, and models fitted to them |
//! | [`structure`], [`helicopter`] | what is known of the plant, as equations with unknowns |
//! | [`prediction_error`] | those unknowns with their bounds, what was dropped and why |
//! | [`validate`] | how well the model does on data it has not seen, or why it is refused |
//! | [`identify`] | all of it for a helicopter, from a recorded flight to a model |
//! | [`flight_checks`], [`flight_response`] | is the flight fit for it; what it says of the model in frequency |
//! | [`vehicle`] | the model that others get, its poles and how sure they are |
//!
//! Every matrix found here says in which time domain it is: [`LinearModel`] is
//! a one-step map and carries its sample period.

pub mod experiment;
pub mod flight_checks;
pub mod flight_response;
pub mod frequency;
pub mod helicopter;
pub mod identify;
pub mod inputs;
pub mod least_squares;
pub mod linear;
mod linear_least_squares;
pub mod prediction_error;
pub mod preprocess;
mod result;
mod riccati;
pub mod structure;
pub mod subspace;
pub mod test_points;
pub mod tones;
pub mod validate;
pub mod vehicle;

pub use experiment::{Experiment, ExperimentError, Offsets};
pub use linear::{InnovationModel, LinearModel};
pub use result::BoundSummary;
