//! One stream of everything the sensors say, in order of arrival.

use crate::frames::{Body, Vector};
use crate::gps::Fix;
use crate::imu::ImuSample;
use crate::time::Time;

/// Something a sensor said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// A sample of the inertial unit.
    Imu(ImuSample),
    /// A satellite fix.
    Gps(Fix),
    /// A barometric height above any fixed level, m, up.
    Baro {
        /// When it was true.
        time: Time,
        /// Height, m.
        height_m: f64,
    },
    /// A magnetometer apart from the inertial unit.
    Magnetometer {
        /// When it was true.
        time: Time,
        /// Magnetic field in body axes, gauss.
        field_gauss: Vector<Body>,
    },
}

impl Event {
    /// When what it says was true.
    #[must_use]
    pub fn time(&self) -> Time {
        match self {
            Self::Imu(sample) => sample.time,
            Self::Gps(fix) => fix.time,
            Self::Baro { time, .. } | Self::Magnetometer { time, .. } => *time,
        }
    }
}
