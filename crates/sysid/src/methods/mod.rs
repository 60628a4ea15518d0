//! Methods of identification and validation, independent of any vehicle.

pub mod excitation;
pub mod frequency;
mod innovation;
mod kalman;
pub mod least_squares;
pub mod prediction_error;
pub mod structure;
pub mod subspace;
pub mod validate;

pub use innovation::InnovationModel;
