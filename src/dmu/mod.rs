//! The Crossbow DMU-HDX-AHRS, an inertial unit with a serial line: packets, start-up, physical units and sample times.
//!
//! [`Link`] runs the protocol with the inertial unit and delivers packets. [`Plausibility`] checks a packet's values,
//! [`Calibration`] converts its counts to physical units, and [`SampleClock`] computes the time of its sample. These
//! types perform no input or output, so a driver only moves bytes:
//!
//! ```
//! use hovernav::dmu::{Calibration, Link, Plausibility, SampleClock};
//! use hovernav::imu::ImuSample;
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
//!             if self.plausibility.check(&packet).any(|reason| reason.invalidates_packet()) {
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
pub use decoder::{Decoder, PacketCounts, Received};
pub use link::{Flow, Link, LinkAction, LinkFault};
pub use packet::{AnglePacket, Mode, Packet, PacketError, ScaledPacket, VoltagePacket};
pub use plausibility::{Plausibility, PlausibilityFault, Sensor};
pub use startup::{Command, Startup, StartupAction, StartupError};
