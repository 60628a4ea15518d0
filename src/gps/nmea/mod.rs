//! NMEA 0183 sentences, from any receiver that sends them.
//!
//! GGA, GNS, GSA, GST, RMC and VTG of any talker are read; the checksum is required.
//!
//! Line: 4800 baud, 8-N-1 by the standard; modern receivers are faster. NMEA carries no vertical speed, and accuracy
//! only if GST is switched on.

mod decoder;
mod fields;
mod framer;
mod sentence;

pub use decoder::Decoder;
