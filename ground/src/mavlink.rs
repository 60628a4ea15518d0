//! MAVLink 1 and 2 as channel values, from hovernav and from any other vehicle with the common message set.
//!
//! Source: MAVLink, *common message set* and *packet serialization*.

mod clocks;
mod ekf_status;
pub(crate) mod modes;
mod translate;

use std::collections::BTreeMap;

use hovernav::telemetry::Sequence;
use mavlink::dialects::common::{MavAutopilot, MavMessage};
use mavlink::{MavlinkVersion, Message as _};

use hovernav_fly::mavlink_frame::{self as frame, Begun, Frame};
pub use translate::Said;
use translate::Translator;

/// Largest number of unknown message types whose layout is remembered.
const STRANGERS: usize = 256;
/// Silence of the present vehicle, s, after which the decoder switches to another autopilot, at any message rate of the
/// other one.
const GONE_S: f64 = 5.0;

/// Counts of the stream.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counts {
    /// Complete messages.
    pub messages: u64,
    /// Messages with a wrong checksum.
    pub damaged: u64,
    /// Messages missing in the sequence.
    pub missing: u64,
}

/// Finds the messages in a stream of bytes. It follows the first vehicle: an autopilot, not a camera, a gimbal or
/// another ground station on the same link.
#[derive(Default)]
pub struct Decoder {
    bytes: Vec<u8>,
    vehicle: Option<Vehicle>,
    /// Layouts of message types that the vehicle sends and the decoder does not know.
    strangers: BTreeMap<u32, u8>,
    /// Whether version 2 was received. After that, bytes that look like version 1 are ignored.
    speaks_second: bool,
    /// Whether a complete message was received, from any sender.
    pub is_spoken: bool,
    /// Counts of the stream.
    pub counts: Counts,
    /// Arrival time of the present bytes, s.
    now_s: f64,
}

/// The followed vehicle.
struct Vehicle {
    sender: (u8, u8),
    /// Whether its heartbeat identifies it as an autopilot.
    is_autopilot: bool,
    /// Time of the vehicle's last message, s.
    received_s: f64,
    sequence: Sequence,
    translator: Translator,
}

impl Vehicle {
    fn new(sender: (u8, u8), is_autopilot: bool, received_s: f64) -> Self {
        let translator = Translator::default();
        Self { sender, is_autopilot, received_s, sequence: Sequence::default(), translator }
    }
}

impl Decoder {
    /// Decodes bytes that arrived at `arrival_s`, seconds on any clock, and calls `said` for each item.
    pub fn receive(&mut self, bytes: &[u8], arrival_s: f64, mut said: impl FnMut(Said)) {
        self.now_s = arrival_s;
        self.bytes.extend_from_slice(bytes);
        // The bytes are moved out of `self`, so that a frame can borrow them while `self` changes.
        let bytes = std::mem::take(&mut self.bytes);
        let mut from = 0;
        while let Some(start) = self.next_magic(&bytes[from..]) {
            from += start;
            match frame::begun(&bytes[from..], Some((ekf_status::ID, ekf_status::LAYOUT))) {
                Begun::Short => break,
                Begun::Frame(frame) => {
                    from += frame.length;
                    self.frame(&frame, &mut said);
                }
                Begun::Stranger(frame, layout) if self.is_known(&frame, layout) => {
                    from += frame.length;
                    self.count(&frame);
                }
                Begun::Damaged => {
                    self.counts.damaged += 1;
                    from += 1;
                }
                Begun::Stranger(..) | Begun::Nothing => from += 1,
            }
        }
        // Bytes before the next possible start of a message are dropped. The remainder is shorter than one message.
        let gone = self.next_magic(&bytes[from..]).map_or(bytes.len(), |keep| from + keep);
        self.bytes = bytes;
        self.bytes.drain(..gone);
    }

    fn next_magic(&self, bytes: &[u8]) -> Option<usize> {
        bytes.iter().position(|byte| frame::is_magic(*byte, !self.speaks_second))
    }

    /// Whether an unknown message is from the vehicle and has the layout of earlier messages of its type.
    fn is_known(&mut self, frame: &Frame<'_>, layout: u8) -> bool {
        if self.vehicle.as_ref().is_none_or(|vehicle| vehicle.sender != frame.sender) {
            return false;
        }
        if self.strangers.len() < STRANGERS {
            self.strangers.entry(frame.id).or_insert(layout);
        }
        self.strangers.get(&frame.id) == Some(&layout)
    }

    fn frame(&mut self, frame: &Frame<'_>, said: &mut impl FnMut(Said)) {
        self.speaks_second |= frame.version == MavlinkVersion::V2;
        self.is_spoken = true;
        let message = MavMessage::parse(frame.version, frame.id, frame.payload).ok();
        if let Some(MavMessage::HEARTBEAT(beat)) = &message {
            self.introduce(frame.sender, beat.autopilot != MavAutopilot::MAV_AUTOPILOT_INVALID);
        } else if self.vehicle.is_none() {
            self.vehicle = Some(Vehicle::new(frame.sender, false, self.now_s));
        }
        if !self.count(frame) {
            return;
        }
        let Some(vehicle) = &mut self.vehicle else { return };
        match (frame.id, &message) {
            (ekf_status::ID, _) => said(Translator::ekf_status(frame.payload)),
            (_, Some(message)) => vehicle.translator.said(message, frame.payload, said),
            (_, None) => {}
        }
    }

    /// Updates the followed vehicle from a heartbeat of `sender`.
    fn introduce(&mut self, sender: (u8, u8), is_autopilot: bool) {
        match &mut self.vehicle {
            Some(vehicle) if vehicle.sender == sender => {
                vehicle.is_autopilot = is_autopilot;
                if !is_autopilot {
                    self.vehicle = None;
                }
            }
            Some(vehicle)
                if is_autopilot
                    && (!vehicle.is_autopilot || self.now_s - vehicle.received_s > GONE_S) =>
            {
                self.vehicle = Some(Vehicle::new(sender, true, self.now_s));
            }
            None if is_autopilot => self.vehicle = Some(Vehicle::new(sender, true, self.now_s)),
            _ => {}
        }
    }

    /// Counts a message and the missing messages before it. Returns whether the message is from the vehicle.
    fn count(&mut self, frame: &Frame<'_>) -> bool {
        let Some(vehicle) = self.vehicle.as_mut().filter(|it| it.sender == frame.sender) else {
            return false;
        };
        vehicle.received_s = self.now_s;
        self.counts.messages += 1;
        vehicle.sequence.observe(frame.sequence);
        self.counts.missing = vehicle.sequence.missing();
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::channel::Id;
    use mavlink::dialects::common::{ATTITUDE_DATA, STATUSTEXT_DATA};
    use mavlink::{MavHeader, write_v1_msg, write_v2_msg};

    fn attitude(sequence: u8, roll: f32) -> (MavHeader, MavMessage) {
        let header = MavHeader { sequence, system_id: 1, component_id: 1 };
        (header, MavMessage::ATTITUDE(ATTITUDE_DATA { roll, ..ATTITUDE_DATA::default() }))
    }

    /// The decoded roll angles of a stream in pieces of three bytes, and the counts.
    fn heard(stream: &[u8]) -> (Vec<f64>, Counts) {
        let mut decoder = Decoder::default();
        let mut rolls = Vec::new();
        for piece in stream.chunks(3) {
            decoder.receive(piece, 0.0, |said| {
                if let Said::Values(_, values) = said {
                    let roll = values.iter().find(|(id, _)| *id == Id::Roll);
                    rolls.extend(roll.and_then(|(_, value)| *value));
                }
            });
        }
        (rolls, decoder.counts)
    }

    #[test]
    fn an_old_autopilot_that_speaks_the_first_version_is_received() {
        let mut stream = vec![0xFE, 0x00, 0xFD, 0x41];
        for sequence in 0..20 {
            let (header, message) = attitude(sequence, 0.5);
            write_v1_msg(&mut stream, header, &message).unwrap();
        }
        let text = MavMessage::STATUSTEXT(STATUSTEXT_DATA::default());
        write_v1_msg(&mut stream, attitude(20, 0.0).0, &text).unwrap();
        let (rolls, counts) = heard(&stream);
        assert_eq!((rolls.len(), counts.messages, counts.missing), (20, 21, 0));
        assert!(rolls.iter().all(|roll| (roll - 0.5f64.to_degrees()).abs() < 1e-4));
    }

    #[test]
    fn one_that_goes_over_to_the_second_version_is_received_on() {
        let mut stream = Vec::new();
        for sequence in 0..20 {
            let (header, message) = attitude(sequence, 0.1);
            match sequence {
                0..10 => write_v1_msg(&mut stream, header, &message).unwrap(),
                _ => write_v2_msg(&mut stream, header, &message).unwrap(),
            };
        }
        let (rolls, counts) = heard(&stream);
        assert_eq!((rolls.len(), counts.missing, counts.damaged), (20, 0, 0));
    }
}
