//! Emulated sensors: what answers a flight computer on a serial line when there is no hardware.
//!
//! | device | emulates | from |
//! |---|---|---|
//! | [`DmuDevice`] | Crossbow DMU-HDX-AHRS: commands `R r c a P C G`, three packet formats, polled or continuous | packets or inertial samples |
//! | [`GpsDevice`] | a receiver that speaks TSIP, NMEA 0183 or UBX, and is configured like a real one | fixes |
//! | [`RecordedDevice`] | nothing: it repeats the bytes of a flight record | bytes with their times |
//!
//! A [`Device`] stands at the far end of a serial line. It is handed what the host wrote and the time,
//! and gives the bytes that have arrived at the host's end by then. Each byte takes its time on the
//! line, so a packet comes in pieces and a burst comes late, as from hardware; more than a second of
//! backlog is lost. A device does no input or output of its own: [`play`](crate::play) puts it behind
//! a pseudo-terminal, and a test calls it directly. [`encode`] writes the receivers' messages.
//!
//! What is not emulated: noise and damage on the line (a test adds its own), a receiver's acquisition
//! and its time to first fix, the unit's self-test and its calibration commands.
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

/// A device at the far end of a serial line. Its time must not run backwards.
pub trait Device: Send {
    /// Takes what the host wrote; the last byte came `now`.
    fn receive(&mut self, bytes: &[u8], now: Time);

    /// When bytes are next to be taken; `None` if only the host can bring more.
    fn next_transmission(&self) -> Option<Time>;

    /// Appends the bytes that arrive at the host up to `now` to `wire`.
    fn transmit(&mut self, now: Time, wire: &mut Vec<u8>);

    /// The times of its first and its last measurement; `None` if it has none.
    fn span(&self) -> Option<(Time, Time)>;

    /// Whether it sends its measurements; some devices wait for a command first.
    fn is_started(&self) -> bool;
}
