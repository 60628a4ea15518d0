//! Settings: error models of the sensors, gates, switches of the mechanisms.

pub(super) mod config;
mod datasheet;
pub(super) mod estimator_config;
pub(super) mod mechanisms;
pub(super) mod setting;
pub(super) mod vehicle_kind;
