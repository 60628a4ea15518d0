//! Design and analysis of feedback loops, on the ground.
//!
//! [`care`] and [`dare`] solve the Riccati equations without LAPACK. [`lqr`], [`sampled_lqr`] and [`kalman`] compute
//! gains from them. [`zero_order_hold`] discretises a continuous model. [`reachability`] analyses controllability;
//! [`bode`], [`step_response`] and [`root_locus`] compute responses. [`Loop::margins`] computes stability margins.
//! [`hover`] combines these into the gains of the [`autopilot`](hovernav::autopilot). [`thesis`] is the design printed
//! by Paw (2005).

mod arguments;
mod check;
mod curve;
mod discretize;
mod disturbance;
mod double_double;
mod error;
mod handling;
pub mod hover;
mod lqr;
mod margins;
mod nichols;
mod notch;
mod reachability;
mod response;
mod riccati;
pub mod thesis;

pub use check::{CheckedDesign, CheckedPrintedDesign};
pub use curve::Peak;
pub use discretize::zero_order_hold;
pub use disturbance::{DISTURBED, DisturbanceResponse, SETTLED, TABLE_6_1};
pub use error::DesignError;
pub use handling::HandlingQualities;
pub use hovernav_model::nalgebra;
pub use lqr::{Regulator, discrete_lqr, kalman, lqr, sampled_lqr};
pub use margins::{ChannelMargins, Crossing, Loop, Margins};
pub use nichols::{Nichols, ZONE};
pub use notch::NotchCost;
pub use reachability::{Reachability, observability, reachability};
pub use response::{StepResponse, bode, logarithmic_frequencies, root_locus, step_response};
pub use riccati::{RiccatiSolution, care, dare};
