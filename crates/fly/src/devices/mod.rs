//! Emulated sensors: they answer a flight computer on a serial line without hardware.
//!
//! | device | emulates | from |
//! |---|---|---|
//! | [`DmuDevice`] | Crossbow DMU-HDX-AHRS: `R r c a P C G`, three formats, polled or continuous | packets or samples |
//! | [`GpsDevice`] | a receiver with TSIP, NMEA 0183 or UBX, configured like a real one | fixes |
//! | [`RecordedDevice`] | nothing: it replays the bytes of a flight record | bytes with their times |
//!
//! A [`Device`] is at the far end of a serial line. It receives the bytes that the host wrote, and returns the bytes
//! that have arrived at the host by a given time. Each byte needs its transmission time, so packets arrive in pieces
//! and bursts arrive late, as from hardware. More than a second of backlog is lost. A device does no input or output:
//! [`play`](crate::play) connects it to a pseudo-terminal, and tests call it directly. [`encode`] writes the receivers'
//! messages.
//!
//! Not emulated: noise and damage on the line (tests add their own), a receiver's acquisition and time to first fix,
//! the IMU's self-test and calibration commands.
//!
//! ```
//! use hovernav::dmu::{AnglePacket, Flow, Link, LinkAction, Mode};
//! use hovernav_fly::devices::{Device, DmuDevice};
//! use hovernav::time::Time;
//!
//! let packets = (0..100).map(|k| (Time::ZERO + 0.5 + 0.0303 * f64::from(k), AnglePacket::default()));
//! let mut unit = DmuDevice::new(packets.collect());
//! let mut link = Link::new(Mode::Angle, Flow::Continuous, Time::ZERO);
//! let (mut now, mut received) = (Time::ZERO, 0);
//! while now < Time::ZERO + 5.0 {
//!     match link.next_action(now) {
//!         LinkAction::Write(command) => unit.receive(&[command.byte()], now),
//!         LinkAction::Lost(_) => {}
//!         LinkAction::ReadUntil(time) => {
//!             now = unit.next_transmission().map_or(time, |next| next.min(time)).max(now);
//!             let mut wire = Vec::new();
//!             unit.transmit(now, &mut wire);
//!             let mut bytes = &wire[..];
//!             while link.next_packet(&mut bytes, now).is_some() {
//!                 received += 1;
//!             }
//!         }
//!     }
//! }
//! assert_eq!(received, 100);
//! ```

mod dmu;
pub mod encode;
mod gps;
mod line;
mod recorded;

pub use dmu::{DmuDevice, Firmware, GivenPackets, PacketSource};
pub use gps::GpsDevice;
pub use recorded::RecordedDevice;

use hovernav::time::Time;

/// A device at the far end of a serial line. The times passed to it must not decrease.
pub trait Device: Send {
    /// Receives `bytes` from the host; the last byte arrives at `now`.
    fn receive(&mut self, bytes: &[u8], now: Time);

    /// Time of the next transmission; `None` if it sends only after a command of the host.
    fn next_transmission(&self) -> Option<Time>;

    /// Appends to `wire` the bytes that arrive at the host up to `now`.
    fn transmit(&mut self, now: Time, wire: &mut Vec<u8>);

    /// Times of the first and the last measurement; `None` without measurements.
    fn span(&self) -> Option<(Time, Time)>;

    /// Whether the device sends measurements; some devices first wait for a command.
    fn is_started(&self) -> bool;
}
