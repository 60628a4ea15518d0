//! The heading of two antennas.

use crate::frames::wrap_angle;
use crate::time::Time;

/// Direction from the first of two antennas to the second. It comes from one receiver with both antennas, or from two
/// receivers that work as moving base and rover.
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
    /// Time of validity.
    pub time: Time,
    /// Direction of the horizontal part of the baseline, from the first antenna to the second, clockwise
    /// from true north, rad, −π to π.
    pub heading_rad: f64,
    /// One-sigma of the heading, rad, if the receiver reports it.
    pub sigma_rad: Option<f64>,
    /// Measured length of the baseline, m, if the receiver reports it.
    pub length_m: Option<f64>,
}

/// A heading of two antennas as the receiver sent it, with its arrival time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReceiverHeading {
    /// The epoch of the heading: milliseconds of the GPS week.
    pub time_of_week_ms: u32,
    /// The heading; its time is the arrival of the message's first byte.
    pub heading: AntennaHeading,
}

impl AntennaHeading {
    /// A heading, wrapped into −π to π, with an unknown length of the baseline.
    #[must_use]
    pub fn new(time: Time, heading_rad: f64, sigma_rad: Option<f64>) -> Self {
        Self { time, heading_rad: wrap_angle(heading_rad), sigma_rad, length_m: None }
    }

    /// Whether all numbers are finite and possible. The angle must be within one turn in either direction. The
    /// one-sigma must be above zero and small enough to contain information. The length of the baseline must be above
    /// zero and possible on a vehicle.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let within =
            |value: Option<f64>, most: f64| value.is_none_or(|value| value > 0.0 && value <= most);
        libm::fabs(self.heading_rad) <= core::f64::consts::TAU
            && within(self.sigma_rad, core::f64::consts::PI)
            && within(self.length_m, LONGEST_M)
    }
}

/// Longest baseline on a vehicle, m.
const LONGEST_M: f64 = 1e3;
