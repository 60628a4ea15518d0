//! Subspace identification: a state-space model from data alone, without initial values.
//!
//! The future outputs are projected on the past. They span the extended observability matrix, whose shift structure
//! gives A and C. B, D and the initial state then come from least squares on the simulated output, so the model is
//! optimal for simulation.
//!
//! [`identify`] is one pass and takes some milliseconds. [`refine()`] continues by prediction or output error.
//! [`search`] tries several passes and keeps the best on held-back data.
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
