//! One leg of a planned flight.

use hovernav::frames::Vector;

/// Axes of the heading: forward, right and down with a level horizon, the body turned by yaw alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level;

/// One leg of a flight. Over `duration_s` all quantities change smoothly from their values at the end of the previous
/// leg to the values given here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// Duration, s, above zero.
    pub duration_s: f64,
    /// Rate of change of the forward, right and down speed, m/s², without the acceleration due to a turning heading.
    pub acceleration_mps2: Vector<Level>,
    /// Rate of change of the heading, rad/s.
    pub yaw_rate_radps: f64,
    /// Roll, rad.
    pub roll_rad: f64,
    /// Pitch, rad, within ±1.5.
    pub pitch_rad: f64,
}

impl Leg {
    /// A level leg without acceleration, of zero duration.
    pub(super) const STEADY: Self = Self {
        duration_s: 0.0,
        acceleration_mps2: Vector::ZERO,
        yaw_rate_radps: 0.0,
        roll_rad: 0.0,
        pitch_rad: 0.0,
    };
}
