//! Satellite navigation receivers: decoders turn bytes into one fix per epoch.
//!
//! ```text
//! bytes + arrival ──> tsip │ nmea │ ubx ──> ReceiverFix ──> quality ──> Fix ──> filter
//!                     frames, messages,     as the           failed    on the inertial
//!                     epochs                receiver sent    checks    unit's clock
//! ```
//!
//! Nothing here opens a port, reads a clock or allocates. A decoder takes the bytes of a serial line, in any pieces,
//! with their arrival time. It stores at most one message and the current, incomplete epoch. No input causes a panic or
//! a loss of valid data. The decoder counts rejected messages ([`MessageCounts`]).
//!
//! Each protocol is a feature of this crate: `tsip`, `nmea` and `ubx`. Without its feature a protocol is not compiled,
//! nor are its variants of [`Protocol`] and [`Receiver`].
//!
//! The time of an epoch is on the receiver's own clock ([`ReceiverTime`]). The fix arrives later, because computation
//! and transfer take time. The caller must know the time of validity on the inertial unit's clock, usually the arrival
//! minus the latency, and passes it to [`ReceiverFix::at`].
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
// The decoders share the checks of these modules; without some of the features, some checks are unused.
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
