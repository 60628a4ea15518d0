//! Pulses from a microcontroller on a serial port or another reader.

use std::io::{self, ErrorKind, Read};

use hovernav::servo::packet::{PacketCapture, PacketCounts};
use hovernav::servo::{PilotPulses, PulseCapture};
use hovernav::time::Time;

/// Largest number of bytes per call. It exceeds one second of packets at 50 Hz, so the loop catches up after a
/// stall. Continuous noise on the line cannot block the loop.
const MAX_BYTES: usize = 1_024;

/// Reads the packets of `docs/servo-packet.md` from `R`.
///
/// `R` should not block, for example a serial port with a timeout of 0. A read without data is not an error: a count of
/// 0, `WouldBlock`, `TimedOut` or `Interrupted`. The last pulses stay, and their age grows.
#[derive(Clone, Debug)]
pub struct StreamCapture<R> {
    source: R,
    capture: PacketCapture,
}

impl<R: Read> StreamCapture<R> {
    /// Pulses from `source`.
    pub fn new(source: R) -> Self {
        Self { source, capture: PacketCapture::default() }
    }

    /// Statistics of the stream until now.
    #[must_use]
    pub const fn counts(&self) -> &PacketCounts {
        self.capture.counts()
    }
}

impl<R: Read> PulseCapture for StreamCapture<R> {
    type Error = io::Error;

    fn poll(&mut self, now: Time) -> Result<&PilotPulses, io::Error> {
        let mut bytes = [0; 256];
        let mut total = 0;
        while total < MAX_BYTES {
            match self.source.read(&mut bytes) {
                Ok(0) => break,
                Ok(count) => {
                    total += count;
                    self.capture.receive(bytes.get(..count).unwrap_or_default(), now);
                    if count < bytes.len() {
                        break;
                    }
                }
                Err(error) => match error.kind() {
                    ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted => break,
                    _ => return Err(error),
                },
            }
        }
        Ok(self.capture.pulses())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hovernav::controls::Channels;
    use hovernav::servo::packet::{LENGTH, ServoPacket};
    use hovernav::servo::{Signal, SignalConfig};

    /// Returns one piece or one error per call.
    struct Script(Vec<io::Result<Vec<u8>>>);

    impl Read for Script {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            if self.0.is_empty() {
                return Ok(0);
            }
            let piece = self.0.remove(0)?;
            buffer[..piece.len()].copy_from_slice(&piece);
            Ok(piece.len())
        }
    }

    fn packet(sequence: u8) -> [u8; LENGTH] {
        let width_ticks = Channels::from_fn(|_| Some(3_000));
        ServoPacket { sequence, width_ticks, ..ServoPacket::default() }.encode()
    }

    #[test]
    fn a_packet_in_pieces_arrives_and_silence_makes_it_stale() {
        let config = SignalConfig::default();
        let whole = packet(0);
        let (a, b) = whole.split_at(5);
        let script = vec![Ok(a.to_vec()), Err(ErrorKind::TimedOut.into()), Ok(b.to_vec())];
        let mut capture = StreamCapture::new(Script(script));
        let now = Time::from_seconds(1.0);
        assert!(matches!(capture.poll(now).unwrap().signal(now, &config), Signal::Stale(_)));
        capture.poll(now).unwrap();
        assert_eq!(capture.poll(now).unwrap().signal(now, &config), Signal::Good);
        let later = now + 0.2;
        assert!(matches!(capture.poll(later).unwrap().signal(later, &config), Signal::Stale(_)));
    }

    #[test]
    fn a_lost_port_is_reported_and_the_last_pulses_are_kept() {
        let gone = Err(ErrorKind::BrokenPipe.into());
        let mut capture = StreamCapture::new(Script(vec![Ok(packet(0).to_vec()), gone]));
        capture.poll(Time::ZERO).unwrap();
        assert_eq!(capture.poll(Time::ZERO).unwrap_err().kind(), ErrorKind::BrokenPipe);
        let pulses = capture.poll(Time::ZERO).unwrap();
        assert_eq!(pulses.channels.pedal.fresh_ms(Time::ZERO, 0.1), Some(1.5));
    }

    #[test]
    fn continuous_noise_does_not_block_the_loop() {
        let mut capture = StreamCapture::new(io::repeat(0x55));
        capture.poll(Time::ZERO).unwrap();
        assert_eq!(capture.counts().bytes, MAX_BYTES as u64);
    }
}
