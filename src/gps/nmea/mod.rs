//! NMEA 0183 sentences, from any receiver that sends them.
//!
//! Framing, checksum and the pairing of sentences into epochs are here; the sentences themselves are
//! read by the `nmea` crate's parsers, behind a check of each field's form that they lack.
//!
//! Line: 4800 baud, 8-N-1 by the standard; modern receivers are faster. NMEA carries no vertical
//! speed and, unless GST is switched on, no accuracy.

mod decoder;
mod fields;
mod framer;
mod sentence;

pub use decoder::Decoder;
