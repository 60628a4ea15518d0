//! Trimble Standard Interface Protocol of the Lassen family (SK II, SK8, iQ, Copernicus).
//!
//! Line: 9600 baud, 8 data bits, **odd parity**, 1 stop bit. Packets are `10 id data… 10 03`, with every 0x10 in the
//! data doubled; numbers are big-endian. There is no length and no checksum: the parity bit is the only protection on
//! the line. Open a port so that it *drops* bytes with a parity error (`INPCK | IGNPAR`). The packet then has the
//! wrong length and is rejected. The `serial` module cannot request this: see there. Lengths, ranges and
//! [`quality`](super::quality) checks catch some of the errors that parity misses.
//!
//! [`Framer`] finds packets, [`Report`] reads them, and [`Decoder`] assembles one fix per second. [`Startup`] brings
//! a receiver from any state to the reports that [`Decoder`] needs.
//!
//! # Source
//! Trimble, *Lassen-SK8 System Designer Reference Manual*, 34149-01 (1997), appendix A; *Copernicus
//! II Reference Manual*, 63530-10.

mod command;
mod decoder;
mod framer;
mod read;
mod report;
mod values;

pub use command::{Command, Frame, Startup};
pub use decoder::Decoder;
pub use framer::{Framer, MAX_PAYLOAD, Packet};
pub use read::ReportError;
pub use report::{
    Compact, Differential, GpsTime, Health, IoOptions, LastFix, MachineStatus, PositionLla,
    PositionXyz, Report, SatelliteIssue, SatelliteSelection, SatelliteSlot, Superpacket, Tracking,
    VelocityEnu, VelocityXyz, Version,
};
