//! The helicopter: its equations, and the identification of a model from a recorded flight.
//!
//! [`identify`] identifies the model and [`flight_warnings`] checks the flight beforehand. [`FrequencyDomain`] repeats
//! the identification in the frequency domain. [`Identified`](crate::methods::prediction_error::Identified) contains
//! the model, with poles and their bounds.

mod adapted;
mod bandwidth;
mod checks;
mod equations;
mod error;
mod flight;
mod found;
mod frequency_domain;
mod gaps;
mod identify;
mod kind;
mod measured;
mod next;
mod reconcile;
mod responder;
mod response;
mod result;
mod search;
mod stretches;
mod uncertainty;
mod vehicle;
mod velocity_error;
mod verdict;

pub use checks::flight_warnings;
pub use error::IdentifyError;
pub use flight::{FlightRecord, MOTION, Velocity};
pub use frequency_domain::{FrequencyDomain, PairCost, SideBySide};
pub use gaps::Gap;
pub use identify::{Identification, identify};
pub use kind::{Kind, UnknownKind};
pub use measured::Basis;
pub use reconcile::Conflict;
pub use response::StickResponse;
pub use result::BoundSummary;
pub use uncertainty::ResponseUncertainty;
pub use vehicle::Pole;
pub use velocity_error::{SlowError, VelocityError};
