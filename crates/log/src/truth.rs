//! What was true of a simulated flight: what `reference.csv` is written from.

use hovernav::earth::Geodetic;
use hovernav::frames::{Body, Ned, Rotation, Vector};
use hovernav::time::Time;

/// Where a point of the vehicle was and how it moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// When.
    pub time: Time,
    /// Position of the point.
    pub position: Geodetic,
    /// Velocity of the point over the Earth, m/s.
    pub velocity_mps: Vector<Ned>,
    /// Attitude.
    pub body_to_ned: Rotation<Body, Ned>,
    /// Angular rate of the body against the NED axes, rad/s.
    pub angular_rate_radps: Vector<Body>,
}
