//! Servo pulses to a microcontroller on a serial port.

use crate::serial::{Clock, Port, PortEvent, Read, WriteError};
use hovernav::controls::Channels;
use hovernav::servo::packet::ServoPacket;
use hovernav::time::Time;

/// Timeout for writing a packet to the port, s.
const WRITE_S: f64 = 0.003;

/// Sends the packets of `docs/servo-packet.md` to the servos.
///
/// When packets stop, the microcontroller holds the last widths, and after 200 ms passes the receiver's pulses
/// through; see the same page.
pub struct StreamOutput {
    port: Port,
    clock: Clock,
    sequence: u8,
    started: bool,
}

impl StreamOutput {
    /// Servo packets to `port`.
    pub fn new(port: Port, clock: &Clock) -> Self {
        Self { port, clock: clock.clone(), sequence: 0, started: false }
    }

    /// Opens a closed port without waiting; returns a change of its state.
    pub fn poll(&mut self, now: Time) -> Option<PortEvent> {
        // Data from the microcontroller are ignored.
        let mut said = [0; 64];
        match self.port.read_until(&mut said, now) {
            Read::Changed(event) => Some(event),
            Read::Bytes { .. } | Read::Silent => None,
        }
    }

    /// Sends `widths_ms`, ms.
    ///
    /// # Errors
    /// The line did not accept the packet.
    pub fn write(&mut self, widths_ms: &Channels<f64>) -> Result<(), WriteError> {
        let packet = ServoPacket {
            sequence: self.sequence,
            width_ticks: widths_ms.map(|width_ms| Some(ServoPacket::ticks(width_ms))),
            started: !self.started,
            ..ServoPacket::default()
        };
        self.port.write(&packet.encode(), self.clock.now() + WRITE_S)?;
        self.sequence = self.sequence.wrapping_add(1);
        self.started = true;
        Ok(())
    }
}
