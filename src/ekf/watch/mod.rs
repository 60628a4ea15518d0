//! Monitors: what samples and innovations show of noise and faults. A monitor sees observations, never the filter.

pub(super) mod antenna;
pub(super) mod attitude_watch;
pub(super) mod barometer;
pub(super) mod bias_shift;
pub(super) mod excess;
pub(super) mod field_watch;
pub(super) mod ground;
pub(super) mod heading_memory;
pub(super) mod heading_revision;
pub(super) mod level_force;
pub(super) mod net_turn;
pub(super) mod position_scatter;
pub(super) mod rectification;
pub(super) mod self_contradiction;
pub(super) mod wheels;

/// Longest interval, s, for which one reading counts.
pub(super) const READING_S: f64 = 1.0;
/// Longest interval, s, between two fixes that are compared.
pub(super) const BETWEEN_FIXES_S: f64 = 3.0;
/// Size, in one-sigmas, beyond which a value counts as an outlier: chance alone rarely causes it.
pub(super) const OUTLIER_SIGMAS: f64 = 3.0;
