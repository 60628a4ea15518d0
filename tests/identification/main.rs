//! From records to models: preparation, methods, their results on published data and on flights, and flights on the
//! models.

mod chain;
mod daisy;
mod data;
mod fixed_wing;
mod flight;
mod forward;
mod frequency;
mod injected;
mod pilot;
mod prediction_error;
mod preprocess;
mod r50_flight;
mod second_opinion;
mod structures;
mod subspace;
mod units;
mod verdicts;
