//! The page of an identification: what flew, what the model says of it, and how far to trust it.

mod document;
mod held;
mod histories;
mod parameters;
mod poles;
mod responses;

pub use document::IdentificationPage;
