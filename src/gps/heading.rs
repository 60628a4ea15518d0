//! The heading that two antennas give.

use crate::frames::wrap_angle;
use crate::time::Time;

/// Where the second of two antennas lies as seen from the first, as a receiver with both, or two that
/// work as a moving base and a rover, find it.
///
/// ```
/// use hovernav::gps::AntennaHeading;
/// use hovernav::time::Time;
///
/// let heading = AntennaHeading::new(Time::ZERO, 350f64.to_radians(), Some(0.005));
/// assert!((heading.heading_rad + 10f64.to_radians()).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AntennaHeading {
    /// When it was true.
    pub time: Time,
    /// Direction of the horizontal part of the baseline, from the first antenna to the second, clockwise
    /// from true north, rad, −π to π.
    pub heading_rad: f64,
    /// Its one-sigma, rad, where the receiver tells.
    pub sigma_rad: Option<f64>,
    /// Length of the baseline as found, m, where the receiver tells.
    pub length_m: Option<f64>,
}

/// A heading of two antennas as a receiver sent it, dated by its arrival.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReceiverHeading {
    /// The epoch it is of: milliseconds of the GPS week.
    pub time_of_week_ms: u32,
    /// When its first byte arrived, and what it says.
    pub heading: AntennaHeading,
}

impl AntennaHeading {
    /// A heading, brought into −π to π, whose length is not known.
    #[must_use]
    pub fn new(time: Time, heading_rad: f64, sigma_rad: Option<f64>) -> Self {
        Self { time, heading_rad: wrap_angle(heading_rad), sigma_rad, length_m: None }
    }

    /// Whether its numbers are finite and can be: an angle within one turn either way, a one-sigma above zero that
    /// tells something, a length above zero that a vehicle has.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let within =
            |value: Option<f64>, most: f64| value.is_none_or(|value| value > 0.0 && value <= most);
        libm::fabs(self.heading_rad) <= core::f64::consts::TAU
            && within(self.sigma_rad, core::f64::consts::PI)
            && within(self.length_m, LONGEST_M)
    }
}

/// No baseline on a vehicle is longer, m.
const LONGEST_M: f64 = 1e3;
