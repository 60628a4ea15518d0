//! Design and check of feedback loops, on the ground.
//!
//! [`care`] and [`dare`] solve the Riccati equations without LAPACK; [`lqr`], [`sampled_lqr`] and
//! [`kalman`] turn them into gains; [`zero_order_hold`] turns a continuous model into what a sampled
//! loop sees of it. [`reachability`] says whether a model can be controlled, [`bode`],
//! [`step_response`] and [`root_locus`] how a loop behaves, and [`Loop::margins`] how far it is from
//! not behaving. [`hover`] makes of these the gains that [`autopilot`](hovernav::autopilot) flies with;
//! [`thesis`] is the design that they replace.

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
pub use discretize::zero_order_hold;
pub use disturbance::{DISTURBED, DisturbanceResponse, SETTLED, TABLE_6_1};
pub use error::DesignError;
pub use handling::HandlingQualities;
pub use hovernav_model::nalgebra;
pub use lqr::{Regulator, discrete_lqr, kalman, lqr, sampled_lqr};
pub use margins::{ChannelMargins, Crossing, Loop, Margins, Peak};
pub use nichols::{Nichols, ZONE};
pub use notch::NotchCost;
pub use reachability::{Reachability, observability, reachability};
pub use response::{StepResponse, bode, logarithmic_frequencies, root_locus, step_response};
pub use riccati::{RiccatiSolution, care, dare};
