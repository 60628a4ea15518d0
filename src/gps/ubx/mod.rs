//! u-blox binary protocol, of receivers from the Antaris (2004) to the M10.
//!
//! A message is `B5 62 class id length payload checksum`, little-endian, with an 8-bit Fletcher
//! checksum over class to payload.
//!
//! Line: 9600 baud, 8-N-1 (38 400 from the M9 on). NAV-PVT takes 100 bytes: 10 Hz need 38 400 baud. [`Configuration`]
//! sets rate and messages, but not the line's speed: a change would break the connection.

mod configuration;
mod decoder;
mod framer;
mod message;
mod relative;
mod values;

pub use configuration::{Configuration, ConfigurationError, Message};
pub use decoder::Decoder;
pub use message::Acknowledgement;
