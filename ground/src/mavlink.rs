//! MAVLink, of both versions, as channels: from this project's vehicles, and from any other that speaks the common set.
//!
//! Source: MAVLink, *common message set* and *packet serialization*.

mod clocks;
mod ekf_status;
mod frame;
pub(crate) mod modes;
mod translate;

use std::collections::BTreeMap;

use hovernav::telemetry::Sequence;
use mavlink::dialects::common::{MavAutopilot, MavMessage};
use mavlink::{MavlinkVersion, Message as _};

use frame::{Begun, Frame};
pub use translate::Said;
use translate::Translator;

/// Messages that nobody here knows, of which the layout is remembered.
const STRANGERS: usize = 256;
/// Heartbeats of another autopilot, with none of ours in between, after which that one is heard.
const GONE: u8 = 5;

/// What became of the stream.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counts {
    /// Whole messages.
    pub messages: u64,
    /// Messages whose checksum does not hold.
    pub damaged: u64,
    /// Messages that the numbers show to be missing.
    pub missing: u64,
}

/// Finds the messages in a stream of bytes. It listens to the first vehicle that it hears: an autopilot,
/// not the camera, the gimbal or the other ground station on the same line.
#[derive(Default)]
pub struct Decoder {
    bytes: Vec<u8>,
    vehicle: Option<Vehicle>,
    /// Layouts of messages that the vehicle sends and nobody here knows.
    strangers: BTreeMap<u32, u8>,
    /// The second version was heard: bytes that look like the first are none.
    speaks_second: bool,
    /// A whole message was heard, whoever sent it.
    pub is_spoken: bool,
    /// What became of the stream.
    pub counts: Counts,
}

/// Who is listened to.
struct Vehicle {
    sender: (u8, u8),
    /// It has said that it is an autopilot.
    is_autopilot: bool,
    /// Heartbeats of other autopilots since its last message.
    others: u8,
    sequence: Sequence,
    translator: Translator,
}

impl Vehicle {
    fn new(sender: (u8, u8), is_autopilot: bool) -> Self {
        let translator = Translator::default();
        Self { sender, is_autopilot, others: 0, sequence: Sequence::default(), translator }
    }
}

impl Decoder {
    /// Takes bytes; `said` hears what they say.
    pub fn receive(&mut self, bytes: &[u8], mut said: impl FnMut(Said)) {
        self.bytes.extend_from_slice(bytes);
        // Taken out so that a frame in it can be looked at while the rest of this changes.
        let bytes = std::mem::take(&mut self.bytes);
        let mut from = 0;
        while let Some(start) = self.next_magic(&bytes[from..]) {
            from += start;
            match frame::begun(&bytes[from..]) {
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
        // What cannot begin a message any more is gone; what is left is shorter than one.
        let gone = self.next_magic(&bytes[from..]).map_or(bytes.len(), |keep| from + keep);
        self.bytes = bytes;
        self.bytes.drain(..gone);
    }

    fn next_magic(&self, bytes: &[u8]) -> Option<usize> {
        bytes.iter().position(|byte| frame::is_magic(*byte, !self.speaks_second))
    }

    /// Whether a message that nobody here knows is the vehicle's, and laid out as the one of its kind before.
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
            self.vehicle = Some(Vehicle::new(frame.sender, false));
        }
        if !self.count(frame) {
            return;
        }
        let Some(vehicle) = &mut self.vehicle else { return };
        match (frame.id, &message) {
            (ekf_status::ID, _) => said(vehicle.translator.ekf_status(frame.payload)),
            (_, Some(message)) => vehicle.translator.said(message, frame.payload, said),
            (_, None) => {}
        }
    }

    /// Hears who `sender` is, by its heartbeat.
    fn introduce(&mut self, sender: (u8, u8), is_autopilot: bool) {
        match &mut self.vehicle {
            Some(vehicle) if vehicle.sender == sender => {
                vehicle.is_autopilot = is_autopilot;
                if !is_autopilot {
                    self.vehicle = None;
                }
            }
            Some(vehicle) if is_autopilot => {
                vehicle.others = vehicle.others.saturating_add(1);
                if !vehicle.is_autopilot || vehicle.others > GONE {
                    self.vehicle = Some(Vehicle::new(sender, true));
                }
            }
            None if is_autopilot => self.vehicle = Some(Vehicle::new(sender, true)),
            _ => {}
        }
    }

    /// Counts a message, and those that its number shows to be missing; whether it is the vehicle's.
    fn count(&mut self, frame: &Frame<'_>) -> bool {
        let Some(vehicle) = self.vehicle.as_mut().filter(|it| it.sender == frame.sender) else {
            return false;
        };
        vehicle.others = 0;
        self.counts.messages += 1;
        vehicle.sequence.hear(frame.sequence);
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

    /// What a stream says, handed over in pieces of three bytes, and what became of it.
    fn heard(stream: &[u8]) -> (Vec<f64>, Counts) {
        let mut decoder = Decoder::default();
        let mut rolls = Vec::new();
        for piece in stream.chunks(3) {
            decoder.receive(piece, |said| {
                if let Said::Values(_, values) = said {
                    let roll = values.iter().find(|(id, _)| *id == Id::Roll);
                    rolls.extend(roll.and_then(|(_, value)| *value));
                }
            });
        }
        (rolls, decoder.counts)
    }

    #[test]
    fn an_old_autopilot_that_speaks_the_first_version_is_heard() {
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
    fn one_that_goes_over_to_the_second_version_is_heard_on() {
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
