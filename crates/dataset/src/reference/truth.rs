//! True motion of a simulated flight, for `reference.csv`.

use hovernav::earth::Geodetic;
use hovernav::frames::{Body, Ned, Rotation, Vector};
use hovernav::time::Time;

/// Position and motion of a point of the vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Time.
    pub time: Time,
    /// Position of the point.
    pub position: Geodetic,
    /// Velocity of the point over the Earth, m/s.
    pub velocity_mps: Vector<Ned>,
    /// Attitude.
    pub body_to_ned: Rotation<Body, Ned>,
    /// Angular rate of the body relative to the NED axes, rad/s.
    pub angular_rate_radps: Vector<Body>,
}
