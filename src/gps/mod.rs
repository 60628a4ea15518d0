//! Satellite navigation receivers: bytes in, one fix an epoch out.
//!
//! ```text
//! bytes + arrival ──> tsip │ nmea │ ubx ──> ReceiverFix ──> quality ──> Fix ──> filter
//!                     frames, messages,     what the         what it    on the inertial
//!                     epochs                receiver said    fails      unit's clock
//! ```
//!
//! Nothing here opens a port, asks for the time or allocates. A decoder is fed whatever the line
//! gave, in any pieces, with the moment it arrived; it keeps a buffer of one message and the epoch
//! that is being put together. No input makes it panic or forget what was already good, and it counts what it
//! leaves out ([`MessageCounts`]).
//!
//! Each protocol is a feature of this crate, `tsip`, `nmea` and `ubx`; what is not switched on does not
//! exist, down to the variants of [`Protocol`] and [`Receiver`].
//!
//! A receiver names its epochs on its own clock ([`ReceiverTime`]), and the fix reaches us later by
//! the time it took to compute and to send. How that maps to the inertial unit's clock is the
//! caller's to know: [`ReceiverFix::at`] takes the moment, usually the arrival less the latency.
//!
//! ```
//! use hovernav::gps::{Protocol, Receiver};
//! use hovernav::gps::quality::{Limits, QualityCheck};
//! use hovernav::time::Time;
//!
//! let mut receiver = Receiver::new(Protocol::Nmea);
//! let mut quality = QualityCheck::new(Limits::default());
//! let latency_s = 0.12;
//!
//! let mut bytes: &[u8] = b"$GPGGA,094812.00,0120.5000,N,10341.0000,E,1,09,0.9,31.0,M,7.0,M,,*6E\r\n\
//!                          $GPRMC,094812.00,A,0120.5000,N,10341.0000,E,4.0,90.0,230305,,,A*63\r\n";
//! let arrival = Time::ZERO;
//! while let Some(fix) = receiver.read(&mut bytes, arrival) {
//!     if quality.check(&fix).is_empty() {
//!         let fix = fix.at(fix.arrival.offset_by(-latency_s));     // for the filter
//!     }
//! }
//! let fix = receiver.flush().expect("the line fell silent: the epoch is over");
//! assert_eq!(fix.satellites, Some(9));
//! assert_eq!(fix.height_m, Some(38.0));
//! assert!((fix.horizontal_velocity_mps.unwrap()[1] - 2.058).abs() < 1e-3);
//! ```

#[cfg(any(feature = "nmea", feature = "ubx"))]
mod cycle;
mod fix;
mod heading;
mod message_counts;
#[cfg(feature = "nmea")]
pub mod nmea;
pub mod quality;
// The decoders share these modules' checks; of those that are switched off, some have no other use.
#[cfg_attr(not(all(feature = "nmea", feature = "tsip", feature = "ubx")), allow(dead_code))]
mod receiver_fix;
#[cfg_attr(not(all(feature = "nmea", feature = "tsip", feature = "ubx")), allow(dead_code))]
mod receiver_time;
#[cfg(any(feature = "nmea", feature = "tsip", feature = "ubx"))]
mod stream;
#[cfg(feature = "tsip")]
pub mod tsip;
#[cfg(feature = "ubx")]
pub mod ubx;

pub use fix::Fix;
pub use heading::{AntennaHeading, ReceiverHeading};
pub use message_counts::MessageCounts;
pub use receiver_fix::{Correction, DilutionOfPrecision, Dimension, ReceiverFix};
pub use receiver_time::{ReceiverTime, WEEK_FLOOR, unroll_week};
#[cfg(any(feature = "nmea", feature = "tsip", feature = "ubx"))]
pub use stream::{Protocol, Receiver};
