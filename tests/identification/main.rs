//! From records to models: preparation, the methods, what they make of data of others and of flights, and what flies on
//! it.

mod chain;
mod daisy;
mod data;
mod flight;
mod frequency;
mod prediction_error;
mod preprocess;
mod r50_flight;
mod second_opinion;
mod subspace;
