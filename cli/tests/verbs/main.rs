//! What the verbs of the command leave, say and refuse, as a user runs them.

#[cfg(feature = "lab")]
mod campaign;
mod command;
#[path = "../common/mod.rs"]
mod common;
#[cfg(feature = "lab")]
mod control;
mod features;
#[cfg(feature = "lab")]
mod identify;
mod inject;
mod long_logs;
mod manners;
#[cfg(feature = "lab")]
mod robustness;
mod trajectories;
mod validate;
