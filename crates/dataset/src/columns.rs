//! Names of the columns of a dataset directory, for programs that hold its tables in memory.

use crate::sensors::gps::{POSITION, POSITION_SIGMA, SATELLITES, VELOCITY, VELOCITY_SIGMA};

pub use crate::sensors::auxiliary::ALTITUDE;
pub use crate::sensors::controls::STICKS;
pub use crate::sensors::imu::{ATTITUDE, INCREMENTS, MAGNETIC, RATES};
pub use crate::table::TIME;

/// Columns of `gps.csv`, in order.
pub const GPS: [&str; 14] = [
    TIME,
    POSITION[0],
    POSITION[1],
    POSITION[2],
    VELOCITY[0],
    VELOCITY[1],
    VELOCITY[2],
    POSITION_SIGMA[0],
    POSITION_SIGMA[1],
    POSITION_SIGMA[2],
    VELOCITY_SIGMA[0],
    VELOCITY_SIGMA[1],
    VELOCITY_SIGMA[2],
    SATELLITES,
];
