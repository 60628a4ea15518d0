//! Arithmetic of the filter: error states, covariance, recent motion. It decides nothing.

pub mod covariance;
pub(super) mod history;
pub mod layout;
pub(super) mod motion_sum;
pub(super) mod trace;
