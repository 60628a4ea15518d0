//! Ends of a simulated flight.

use std::fmt;

/// Event that ended a flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Crash {
    /// Contact with the ground, too fast or too tilted for the skids. For a linear model, which has no skids, any
    /// contact.
    Ground {
        /// Sink rate, m/s.
        sinking_mps: f64,
        /// Larger of roll and pitch, rad.
        tilt_rad: f64,
    },
    /// Roll or pitch beyond 80° in the air.
    Upset,
    /// More airspeed than a linear hover model describes.
    TooFast {
        /// Airspeed, m/s.
        airspeed_mps: f64,
    },
    /// The motion grew without bound.
    Diverged,
}

impl fmt::Display for Crash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ground { sinking_mps, tilt_rad } => write!(
                f,
                "struck the ground at {sinking_mps:.1} m/s, tilted by {:.0}°",
                tilt_rad.to_degrees()
            ),
            Self::Upset => f.write_str("rolled or pitched beyond 80°"),
            Self::TooFast { airspeed_mps } => {
                write!(f, "left the range of its linear model: {airspeed_mps:.0} m/s of airspeed")
            }
            Self::Diverged => f.write_str("its motion grew without bound"),
        }
    }
}
