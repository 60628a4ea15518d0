#![doc = include_str!("../README.md")]

mod apart;
pub mod consistency;
mod level;
mod relative;
mod score;
mod verdict;

pub use apart::{Apart, set_harms};
pub use consistency::innovations;
pub use level::Level;
pub use relative::{RelativeError, RelativePoint, relative_error};
pub use score::{
    Axis, AxisScore, ErrorPoint, Score, Statistics, axis_errors, axis_sigmas, outage_drift, score,
};
pub use verdict::Verdict;
