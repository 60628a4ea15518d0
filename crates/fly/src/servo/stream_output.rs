//! Pulses to a microcontroller on a serial port, which drives the servos.

use crate::serial::{Clock, Port, PortEvent, Read, WriteError};
use hovernav::controls::Channels;
use hovernav::servo::packet::ServoPacket;
use hovernav::time::Time;

/// How long a packet may take to be handed to the line, s.
const WRITE_S: f64 = 0.003;

/// Sends the packets of `docs/servo-packet.md` towards the servos.
///
/// The microcontroller holds the last widths when packets stop and passes the receiver through after
/// 200 ms: see the same page.
pub struct StreamOutput {
    port: Port,
    clock: Clock,
    sequence: u8,
    started: bool,
}

impl StreamOutput {
    /// Packets on `port`.
    pub fn new(port: Port, clock: &Clock) -> Self {
        Self { port, clock: clock.clone(), sequence: 0, started: false }
    }

    /// Opens the port where it is not open, without waiting; a change of its state.
    pub fn poll(&mut self, now: Time) -> Option<PortEvent> {
        // What a microcontroller says back is not looked at.
        let mut said = [0; 64];
        match self.port.read_until(&mut said, now) {
            Read::Changed(event) => Some(event),
            Read::Bytes { .. } | Read::Silent => None,
        }
    }

    /// Sends `widths_ms`.
    ///
    /// # Errors
    /// The line did not take the packet.
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
