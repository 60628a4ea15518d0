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
