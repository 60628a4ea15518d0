//! NMEA 0183 sentences, from any receiver that sends them.
//!
//! The decoder reads GGA, GNS, GSA, GST, RMC and VTG of any talker; the checksum is required.
//!
//! Line: 4800 baud, 8-N-1 by the standard; modern receivers are faster. NMEA contains no vertical speed, and the
//! accuracy only if the receiver sends GST.

mod decoder;
mod fields;
mod framer;
mod sentence;

pub use decoder::Decoder;
