//! Grey-box identification by prediction error: the parameters of a [`Structure`](super::structure::Structure) whose Kalman
//! predictor leaves the smallest innovations, and how well the data know them.
//!
//! # Method
//! The innovations ν of the steady predictor are those of a maximum-likelihood estimate:
//! −ln L = ½ Σ νᵀ S⁻¹ ν + N/2 ln det S. The gain is not a parameter. What is estimated is the standard
//! deviation of every process and measurement noise, and gain and S follow from the Riccati equation.
//! That keeps the noise model at a dozen numbers with a meaning, where a free gain of an R-50 would
//! have 104, and the sensitivities stay analytic, as the gain's derivative solves a Lyapunov
//! equation. A record's initial state, its offsets (trim, mean wind) and its output biases enter the
//! innovations linearly and are solved away exactly. The search is Fisher's scoring with Marquardt's
//! damping.
//!
//! On an unstable plant use [`Form::Innovations`]: a free run over more than a few time constants of
//! the instability fits its own divergence.
//!
//! # Source
//! Ljung, *System Identification*, second edition, chapter 7; Jategaonkar, *Flight Vehicle System
//! Identification*, second edition, chapter 5 (filter error method); Tischler and Remple, *Aircraft
//! and Rotorcraft System Identification*, chapters 12–13 (bounds, insensitivities, what to drop).

mod dropping;
mod error;
mod estimates;
mod fit;
mod identified;
mod identify;
mod instrument;
mod own_rows;
mod predictor;
mod problem;
mod products;
mod settings;
mod statistics;
mod sweep;
#[cfg(test)]
mod tests;

pub use error::PredictionErrorError;
pub use estimates::{Estimate, Estimates, Status};
pub use fit::{ChannelFit, Fit, Run};
pub use identified::{Identified, OwnValues};
pub use identify::{assemble, identify, identify_from, identify_on};
pub use instrument::delay_from_injected;
pub use settings::{Dropping, Form, Settings};
