//! Serial lines to the sensors: opened, read until a deadline, and opened again when they are lost.
//!
//! A [`Port`] is one line; it never blocks past the time it is given, and reports every change as a
//! [`PortEvent`]. A [`Reader`] reads a port in a thread of its own, for a loop that cannot wait. All
//! times are those of one [`Clock`]. Nothing here knows a protocol:
//!
//! ```no_run
//! use hovernav::dmu::{Flow, Link, LinkAction, Mode};
//! use hovernav_fly::serial::{Clock, Port, PortConfig, Read};
//!
//! let clock = Clock::start();
//! let mut port = Port::new(PortConfig::new("/dev/ttyUSB0", 38_400), &clock);
//! let mut link = Link::new(Mode::Angle, Flow::Continuous, clock.now());
//! loop {
//!     match link.next_action(clock.now()) {
//!         LinkAction::Write(command) => {
//!             let _lost_if_the_port_is = port.write(&[command.byte()], clock.now() + 0.01);
//!         }
//!         LinkAction::Lost(fault) => eprintln!("inertial unit: {fault}"),
//!         LinkAction::ReadUntil(deadline) => {
//!             let mut buffer = [0; 256];
//!             match port.read_until(&mut buffer, deadline) {
//!                 Read::Bytes { count, arrival } => {
//!                     let mut bytes = &buffer[..count];
//!                     while let Some(received) = link.next_packet(&mut bytes, arrival) {
//!                         println!("{:?}", received.packet);
//!                     }
//!                 }
//!                 Read::Silent => {}
//!                 Read::Changed(event) => eprintln!("port: {event}"),
//!             }
//!         }
//!     }
//! }
//! ```
//!
//! # The line
//!
//! Eight data bits, one stop bit, no flow control, raw, and exclusively ours. A byte whose parity
//! fails is read as 0x00: that is how `serialport` sets a terminal (`INPCK` without `IGNPAR` or
//! `PARMRK`), and it offers no other way. TSIP, which has no checksum, loses by it: a damaged byte
//! keeps its place, so the packet's length is right and one of its values is wrong. A zero in a
//! packet's frame breaks the packet; one in a value is caught by range and quality checks only as far
//! as it matters to them.
//!
//! A USB adapter may hold bytes back to fill its packets, 16 ms with FTDI's default latency timer;
//! that is the adapter's setting, not the port's.

mod clock;
mod emulation;
mod line;
mod port;
mod reader;
mod wire;

pub use clock::{Clock, Task};
pub use port::{Port, PortConfig, PortCounts, PortEvent, PortFault, Read, WriteError};
pub use reader::{Dropped, Item, Piece, Reader};
pub use serialport::Parity;
#[cfg(unix)]
pub(crate) use wire::DeviceEnd;
