//! A sender of MAVLink 2, one message at a time.

use mavlink::dialects::common::{
    ATTITUDE_DATA, HEARTBEAT_DATA, MavAutopilot, MavMessage, MavModeFlag, MavType,
};
use mavlink::{MavHeader, write_v2_msg};

/// One sender of MAVLink 2.
pub struct Sender {
    pub header: MavHeader,
    bytes: Vec<u8>,
}

impl Sender {
    pub fn new(system_id: u8, component_id: u8) -> Self {
        let header = MavHeader { system_id: system_id.into(), component_id, sequence: 0 };
        Self { header, bytes: Vec::new() }
    }

    pub fn say(&mut self, message: &MavMessage) -> Vec<u8> {
        self.bytes.clear();
        write_v2_msg(&mut self.bytes, self.header, message).unwrap();
        self.header.sequence = self.header.sequence.wrapping_add(1);
        self.bytes.clone()
    }

    /// A message that no known dialect contains, with its own layout.
    pub fn foreign(&mut self, id: u32, payload: &[u8], layout: u8) -> Vec<u8> {
        let [low, middle, high, _] = id.to_le_bytes();
        let MavHeader { sequence, system_id, component_id } = self.header;
        let head = [payload.len() as u8, 0, 0, sequence, system_id as u8, component_id];
        let mut frame = vec![0xFD];
        frame.extend(head);
        frame.extend([low, middle, high]);
        frame.extend(payload);
        let checksum = mavlink::calculate_crc(&frame[1..], layout);
        frame.extend(checksum.to_le_bytes());
        self.header.sequence = sequence.wrapping_add(1);
        frame
    }

    pub fn heartbeat(&mut self, autopilot: MavAutopilot, mavtype: MavType) -> Vec<u8> {
        let base_mode = MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED;
        let custom_mode = 3 << 16;
        let data = HEARTBEAT_DATA {
            autopilot,
            mavtype,
            base_mode,
            custom_mode,
            ..HEARTBEAT_DATA::DEFAULT
        };
        self.say(&MavMessage::HEARTBEAT(data))
    }

    pub fn attitude(&mut self, time_boot_ms: u32, roll: f32) -> Vec<u8> {
        let data = ATTITUDE_DATA { time_boot_ms, roll, ..ATTITUDE_DATA::DEFAULT };
        self.say(&MavMessage::ATTITUDE(data))
    }
}
