//! One stretch of a planned flight.

use hovernav::frames::Vector;

/// Forward, right and down of the heading, with the horizon level: the body turned by yaw alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level;

/// One stretch of flight: over `duration_s` everything below moves smoothly from what it was at the
/// end of the leg before to the value given here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// Duration, s, above zero.
    pub duration_s: f64,
    /// Rate of change of the forward, right and down speed, m/s². What turning the heading adds to
    /// the acceleration comes on top.
    pub acceleration_mps2: Vector<Level>,
    /// Rate of change of the heading, rad/s.
    pub yaw_rate_radps: f64,
    /// Roll, rad.
    pub roll_rad: f64,
    /// Pitch, rad, within ±1.5.
    pub pitch_rad: f64,
}

impl Leg {
    /// Level and without acceleration, for no time.
    pub(super) const STEADY: Self = Self {
        duration_s: 0.0,
        acceleration_mps2: Vector::ZERO,
        yaw_rate_radps: 0.0,
        roll_rad: 0.0,
        pitch_rad: 0.0,
    };
}
