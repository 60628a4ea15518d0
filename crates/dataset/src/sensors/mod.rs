//! Tables of a dataset's sensors, a file each.

pub(crate) mod aids;
pub(crate) mod auxiliary;
pub(crate) mod controls;
pub(crate) mod fix_gate;
pub(crate) mod gps;
pub(crate) mod imu;
pub(crate) mod sample_file;
mod two_receivers;
