//! The inertial unit: what it measures, in the units the filter takes, and how the Crossbow
//! DMU-HDX-AHRS sends it.
//!
//! [`Link`] converses with the unit and hands out packets; [`Plausibility`] says what a packet cannot
//! be, [`Calibration`] gives its counts units and [`SampleClock`] its sample a time. None of them does
//! any input or output, so a driver moves bytes and nothing else:
//!
//! ```
//! use hovernav::dmu::{Calibration, ImuSample, Link, Plausibility, SampleClock};
//! use hovernav::time::Time;
//!
//! struct Unit {
//!     link: Link,
//!     plausibility: Plausibility,
//!     calibration: Calibration,
//!     clock: SampleClock,
//! }
//!
//! impl Unit {
//!     fn receive(&mut self, mut bytes: &[u8], now: Time, mut sample: impl FnMut(ImuSample)) {
//!         while let Some(received) = self.link.next_packet(&mut bytes, now) {
//!             let packet = received.packet;
//!             if self.plausibility.check(&packet).any(|reason| reason.damns_packet()) {
//!                 continue;
//!             }
//!             if let Ok(stamp) = self.clock.stamp(packet.timer(), received.sequence, now)
//!                 && let Some(measurement) = self.calibration.measure(&packet)
//!             {
//!                 sample(measurement.at(stamp.time));
//!             }
//!         }
//!     }
//! }
//! ```

mod calibration;
mod clock;
mod decoder;
mod link;
mod packet;
mod plausibility;
mod startup;

pub use calibration::{Calibration, Measurement, RangeError, Sign, temperature_degc, volts};
pub use clock::{Basis, ClockFault, SampleClock, Stamp};
pub use decoder::{Decoder, Received, Tally};
pub use link::{Flow, Link, LinkAction, LinkFault};
pub use packet::{AnglePacket, Mode, Packet, PacketError, ScaledPacket, VoltagePacket};
pub use plausibility::{Implausible, Plausibility, Sensor};
pub use startup::{Command, Startup, StartupAction, StartupError};

mod vibration;

pub use vibration::Vibration;

use crate::frames::{Body, EulerAngles, Vector};
use crate::time::Time;

/// The motion between or at samples, in the form the unit delivers it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Instantaneous values at the sample's time.
    Rates {
        /// Angular rate of the body against inertial space, rad/s.
        angular_rate_radps: Vector<Body>,
        /// Acceleration less gravitation, m/s²; level and at rest its z is −9.81.
        specific_force_mps2: Vector<Body>,
    },
    /// Integrals of rate and specific force since the sample before, each resolved in the body axes
    /// of its own moment (what an integrating unit puts out before any coning or sculling
    /// correction).
    Increments {
        /// Integral of angular rate, rad.
        angle_rad: Vector<Body>,
        /// Integral of specific force, m/s.
        velocity_mps: Vector<Body>,
    },
}

impl Motion {
    /// Whether no component is NaN or infinite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        match self {
            Self::Rates { angular_rate_radps: a, specific_force_mps2: b }
            | Self::Increments { angle_rad: a, velocity_mps: b } => a.is_finite() && b.is_finite(),
        }
    }
}

/// One sample of the inertial unit, axes already turned to forward-right-down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuSample {
    /// When the rates were sampled, or the increments ended.
    pub time: Time,
    /// Rates or increments.
    pub motion: Motion,
    /// The unit's own attitude, if it computes one; yaw from the north its dataset names.
    pub attitude: Option<EulerAngles>,
    /// Magnetic field in body axes, gauss, if the unit measures it.
    pub magnetic_field_gauss: Option<Vector<Body>>,
}
