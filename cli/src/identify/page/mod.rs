//! The page of an identification: the flight, the model and its verdict.

mod document;
mod held;
mod histories;
mod parameters;
mod poles;
mod responses;

pub use document::IdentificationPage;
