//! The methods: from records to models, and from models to their validation. None knows of a
//! helicopter.

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
