//! Serial lines to the sensors: read until a deadline, and reopened after a loss.
//!
//! A [`Port`] is one line; it never blocks beyond its deadline, and reports every change as a [`PortEvent`]. A
//! [`Reader`] reads a port in a thread of its own, for a loop that cannot wait. All times are on one [`Clock`]. This
//! module is independent of protocols:
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
//! Eight data bits, one stop bit, no flow control, raw mode, exclusive access. A byte with a parity error is read as
//! 0x00, because `serialport` sets `INPCK` without `IGNPAR` or `PARMRK` and offers no other setting. This affects TSIP,
//! which has no checksum: the packet keeps its length, but one of its values is wrong. A zero in the frame of a packet
//! makes the packet invalid. A zero in a value is detected only by range and quality checks.
//!
//! A USB adapter may delay bytes to fill its packets, by 16 ms with FTDI's default latency timer. That is a setting of
//! the adapter, not of the port.

mod clock;
mod emulation;
mod line;
mod port;
mod port_config;
mod reader;
mod signal;
mod wire;
mod wire_end;

pub use clock::{Clock, Task};
pub use port::{Port, PortCounts, PortEvent, Read, WriteError};
pub use port_config::{PortConfig, PortFault};
pub use reader::{Dropped, Item, Piece, Reader};
pub use serialport::Parity;
#[cfg(unix)]
pub(crate) use wire_end::DeviceEnd;
