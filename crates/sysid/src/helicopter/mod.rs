//! The helicopter: its equations, and the identification of a model from a recorded flight.
//!
//! [`identify`] identifies the model and [`flight_warnings`] checks the flight beforehand. [`FrequencyDomain`] repeats
//! the identification in the frequency domain. [`Identified`](crate::methods::prediction_error::Identified) contains
//! the model, with poles and their bounds.

mod activity;
mod adapted;
mod bandwidth;
mod checks;
mod dead_band;
mod error;
mod flight;
mod flight_condition;
mod found;
mod frequency_domain;
mod gaps;
mod gyros_alone;
mod identify;
mod measured;
mod model_structure;
mod next;
mod outputs;
mod reconcile;
mod responder;
mod response;
mod result;
mod search;
mod side_by_side;
mod stretches;
mod structure_file;
mod uncertainty;
mod vehicle;
mod velocity_error;
mod verdict;

pub use activity::{Activity, StickActivity};
pub use checks::flight_warnings;
pub use error::IdentifyError;
pub use flight::{FlightRecord, MOTION, Velocity};
pub use flight_condition::FlightCondition;
pub use frequency_domain::FrequencyDomain;
pub use gaps::Gap;
pub use gyros_alone::{gyro_solutions, solutions_for};
pub use identify::{Identification, Request, identify};
pub use measured::Basis;
pub use model_structure::ModelStructure;
pub use reconcile::Conflict;
pub use response::StickResponse;
pub use result::BoundSummary;
pub use side_by_side::{PairCost, SideBySide};
pub use structure_file::ModelStructureError;
pub use uncertainty::ResponseUncertainty;
pub use vehicle::Pole;
pub use velocity_error::{SlowError, VelocityError};
