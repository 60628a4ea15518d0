//! Subspace identification: a state-space model from data alone, without a start value.
//!
//! The future outputs are projected on the past; the space they span is the extended observability
//! matrix, whose shift structure gives A and C. B, D and the initial state then come from least
//! squares on the simulated output, so the model is as good as it can be at what it will be asked:
//! to run free.
//!
//! [`identify`] is one pass, some milliseconds. [`refine()`] goes on from there by prediction or
//! output error, and [`search`] tries several passes and keeps what holds on data set aside.
//!
//! Source: P. Van Overschee & B. De Moor, *Subspace Identification for Linear Systems* (1996),
//! chapters 4 and 5; L. Ljung, *System Identification*, 2nd ed., section 10.6.

mod balance;
mod error;
mod gain;
mod input_fit;
mod pass;
mod projection;
mod realization;
mod refine;
mod responses;
mod scales;
mod search;
mod settings;

pub use error::SubspaceError;
pub use input_fit::fit_initial_state;
pub use pass::identify;
pub use refine::{Criterion, RefineSettings, Refined, refine};
pub use search::{Candidate, Search, SearchSettings, Way, search};
pub use settings::{Identified, InputFit, SubspaceSettings, Weighting};
