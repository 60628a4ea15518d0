//! Grey-box identification by prediction error. It finds the parameters of a [`Structure`](super::structure::Structure)
//! whose Kalman predictor has the smallest innovations, and their uncertainty.
//!
//! # Method
//! The innovations ν of the steady-state predictor give a maximum-likelihood estimate: −ln L = ½ Σ νᵀ S⁻¹ ν + N/2 ln
//! det S. The gain is not a parameter. The standard deviations of all process and measurement noises are estimated, and
//! the gain and S follow from the Riccati equation. The noise model then has about a dozen physical parameters, where a
//! free gain of an R-50 would have 104. The sensitivities stay analytic, because the gain's derivative solves a
//! Lyapunov equation. A record's initial state, its offsets (trim, mean wind) and its output biases enter the
//! innovations linearly and are eliminated exactly. The search is Fisher scoring with Marquardt's damping.
//!
//! For an unstable vehicle use [`Form::Innovations`]: a simulation over more than a few time constants of the
//! instability fits its own divergence.
//!
//! # Source
//! Ljung, *System Identification*, second edition, chapter 7; Jategaonkar, *Flight Vehicle System Identification*,
//! second edition, chapter 5 (filter error method); Tischler and Remple, *Aircraft and Rotorcraft System
//! Identification*, chapters 12–13 (bounds, insensitivities, dropping of parameters).

mod delay;
mod dropping;
mod error;
mod estimates;
mod fit;
mod identified;
mod identify;
mod instrument;
mod late_input;
mod own_rows;
mod predictor;
mod problem;
mod products;
mod settings;
mod statistics;
mod step;
mod sweep;
#[cfg(test)]
mod tests;

pub use delay::delay_from_injected;
pub use error::PredictionErrorError;
pub use estimates::{Estimate, Estimates, Status};
pub use fit::{ChannelFit, Fit, Run};
pub use identified::{Identified, OwnValues};
pub use identify::{assemble, identify, identify_from, identify_on, identify_with};
pub use instrument::identify_from_injected;
pub(crate) use late_input::LateInput;
pub use settings::{Dropping, Form, Settings};
