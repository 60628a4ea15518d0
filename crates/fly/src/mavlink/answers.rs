//! Answers to the requests of ground stations: parameters, missions, commands, messages on request, time.
//!
//! No request changes the flight: parameters are read-only, and only the pilot arms and engages.
//!
//! Source: MAVLink, the services *parameter*, *mission*, *command*, *ping*, *time synchronization* and *standard
//! modes*.

#![expect(deprecated, reason = "older stations still send these messages")]

use mavlink::Message as _;
use mavlink::dialects::common::{self, MavCmd, MavMessage, MavResult};

use super::Mavlink;
use super::frame::{self, Begun};
use super::mode::custom_mode;
use hovernav::telemetry::{Snapshot, SystemMode};
use hovernav::time::Time;
use hovernav_record::Level;

/// The modes of the vehicle. A ground station cannot select one.
const MODES: [SystemMode; 6] = SystemMode::ALL;
/// Largest number of answers in the queue; further requests are ignored until there is room.
const MAX_WAITING: usize = 64;
/// Longest incomplete frame, bytes.
const LONGEST: usize = 280;
/// Length of a parameter's name, bytes.
const NAME: usize = 16;

impl Mavlink {
    /// Receives bytes that the ground sent at `now`. [`answer`](Self::answer) sends the answers.
    pub fn receive(&mut self, bytes: &[u8], now: Time) {
        let mut held = std::mem::take(&mut self.requests.bytes);
        held.extend_from_slice(bytes);
        let mut from = 0;
        while let Some(start) = held[from..].iter().position(|byte| frame::is_magic(*byte, true)) {
            from += start;
            match frame::begun(&held[from..], None) {
                Begun::Short => break,
                Begun::Frame(found) => {
                    from += found.length;
                    if let Ok(message) = MavMessage::parse(found.version, found.id, found.payload) {
                        self.observe(&message, found.payload, found.sender, now);
                    }
                }
                _ => from += 1,
            }
        }
        held.drain(..from);
        if held.len() > LONGEST || !held.first().is_some_and(|byte| frame::is_magic(*byte, true)) {
            held.clear();
        }
        self.requests.bytes = held;
    }

    /// Appends up to two of the queued answers, so that they fit next to the telemetry; call once per snapshot.
    pub fn answer(&mut self, out: &mut Vec<u8>) {
        for _ in 0..2 {
            out.extend(self.requests.answers.pop_front().unwrap_or_default());
        }
    }

    /// Queues the bytes that `say` appends.
    fn reply(&mut self, say: impl FnOnce(&mut Self, &mut Vec<u8>)) {
        if self.requests.answers.len() < MAX_WAITING {
            let mut bytes = Vec::new();
            say(self, &mut bytes);
            self.requests.answers.push_back(bytes);
        }
    }

    /// Handles a message from the system and component in `sender`.
    fn observe(&mut self, message: &MavMessage, payload: &[u8], sender: (u8, u8), now: Time) {
        let own = self.config.system_id;
        let is_ours = message.target_system_id().is_none_or(|target| target == 0 || target == own);
        if sender.0 == own || !is_ours {
            return;
        }
        match message {
            MavMessage::PARAM_REQUEST_LIST(_) => {
                for index in 0..self.parameters().len() {
                    self.report_parameter(index);
                }
            }
            MavMessage::PARAM_REQUEST_READ(m) => {
                match self.parameter(m.param_index, &m.param_id[..]) {
                    Some(index) => self.report_parameter(index),
                    None => {
                        let error = common::MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST;
                        self.refuse_parameter(m.param_index, m.param_id, sender, error);
                    }
                }
            }
            MavMessage::PARAM_SET(m) => {
                let index = self.parameter(-1, &m.param_id[..]);
                let error = match index {
                    Some(_) => common::MavParamError::MAV_PARAM_ERROR_READ_ONLY,
                    None => common::MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST,
                };
                self.refuse_parameter(-1, m.param_id, sender, error);
                // The unchanged value is the answer that stations without PARAM_ERROR understand.
                index.into_iter().for_each(|index| self.report_parameter(index));
                self.explain("parameters are read-only: change fly.toml and start again");
            }
            MavMessage::MISSION_REQUEST_LIST(_) => {
                // The kind of mission is the third byte, an extension.
                let kind = payload.get(2).copied().unwrap_or(0);
                let (target_system, target_component) = sender;
                let none = common::MISSION_COUNT_DATA { count: 0, target_system, target_component };
                self.reply(|own, out| own.send_extended(&none, &[kind], out));
            }
            MavMessage::MISSION_CLEAR_ALL(_) => {
                let kind = payload.get(2).copied().unwrap_or(0);
                self.acknowledge_mission(
                    sender,
                    common::MavMissionResult::MAV_MISSION_ACCEPTED,
                    kind,
                );
            }
            MavMessage::MISSION_COUNT(_) | MavMessage::MISSION_WRITE_PARTIAL_LIST(_) => {
                let kind = payload.get(4).copied().unwrap_or(0);
                let refused = common::MavMissionResult::MAV_MISSION_UNSUPPORTED;
                self.acknowledge_mission(sender, refused, kind);
                self.explain("no missions: the pilot flies, and the autopilot holds");
            }
            MavMessage::COMMAND_LONG(m) => {
                self.command(m.command, [m.param1, m.param2], sender, now);
            }
            MavMessage::COMMAND_INT(m) => {
                self.command(m.command, [m.param1, m.param2], sender, now);
            }
            MavMessage::SET_MODE(_) => {
                let result = MavResult::MAV_RESULT_DENIED;
                self.acknowledge(MavCmd::MAV_CMD_DO_SET_MODE, result, sender);
                self.explain("the pilot's switch selects the mode");
            }
            MavMessage::FILE_TRANSFER_PROTOCOL(m) => self.refuse_file(&m.payload, sender),
            MavMessage::PING(m) if m.target_system == 0 => {
                let (target_system, target_component) = sender;
                let (time_usec, seq) = (m.time_usec, m.seq);
                let answer = common::PING_DATA { time_usec, seq, target_system, target_component };
                self.reply(|own, out| own.send(&answer, out));
            }
            MavMessage::TIMESYNC(m) if m.tc1 == 0 => {
                let tc1 = self.since_boot_us(now).saturating_mul(1_000);
                let answer = common::TIMESYNC_DATA { tc1, ts1: m.ts1 };
                let (system, component) = sender;
                self.reply(|own, out| own.send_extended(&answer, &[system, component], out));
            }
            _ => {}
        }
    }

    fn command(&mut self, command: MavCmd, params: [f32; 2], sender: (u8, u8), now: Time) {
        let result = match command {
            MavCmd::MAV_CMD_REQUEST_MESSAGE => self.on_request(params[0] as u32, params[1], now),
            MavCmd::MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES => self.on_request(148, 0.0, now),
            MavCmd::MAV_CMD_REQUEST_PROTOCOL_VERSION => self.on_request(300, 0.0, now),
            MavCmd::MAV_CMD_GET_HOME_POSITION => self.on_request(242, 0.0, now),
            MavCmd::MAV_CMD_COMPONENT_ARM_DISARM => {
                self.explain("arming is the pilot's: the servos follow the transmitter");
                MavResult::MAV_RESULT_DENIED
            }
            MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL => self.set_interval(params[0] as u32, params[1]),
            MavCmd::MAV_CMD_GET_MESSAGE_INTERVAL => self.on_request(244, params[0], now),
            MavCmd::MAV_CMD_DO_SET_MODE => {
                self.explain("the pilot's switch selects the mode");
                MavResult::MAV_RESULT_DENIED
            }
            _ => MavResult::MAV_RESULT_UNSUPPORTED,
        };
        self.acknowledge(command, result, sender);
    }

    /// Queues message `id`. `which` is the index of a mode for AVAILABLE_MODES, 0 for all modes. For MESSAGE_INTERVAL
    /// it is the id of a message.
    fn on_request(&mut self, id: u32, which: f32, now: Time) -> MavResult {
        let snapshot = self.last.unwrap_or_else(|| Snapshot::at(now));
        match id {
            0 => self.reply(|own, out| own.send(&super::mode::heartbeat(&snapshot), out)),
            1 => self.reply(|own, out| own.send(&own.system_status(&snapshot), out)),
            24 => self.reply(|own, out| own.send_gps_raw(&snapshot, out)),
            148 => self.reply(|own, out| own.send(&version(), out)),
            230 => self.reply(|own, out| own.send(&own.estimator_status_message(&snapshot), out)),
            242 => match self.home() {
                Some(home) => self.reply(|own, out| own.send(&home, out)),
                None => return MavResult::MAV_RESULT_TEMPORARILY_REJECTED,
            },
            244 => {
                let interval = self.interval(which as u32);
                self.reply(|own, out| own.send(&interval, out));
            }
            245 => self.reply(|own, out| own.send(&super::mode::extended_state(), out)),
            300 => self.reply(|own, out| own.send(&protocol(), out)),
            435 => {
                let wanted = |index: usize| which == 0.0 || which == index as f32;
                for index in (1..=MODES.len()).filter(|index| wanted(*index)) {
                    self.reply(|own, out| own.send(&mode(index), out));
                }
            }
            436 => self.reply(|own, out| own.send(&super::mode::current_mode(&snapshot), out)),
            _ => return MavResult::MAV_RESULT_UNSUPPORTED,
        }
        MavResult::MAV_RESULT_ACCEPTED
    }

    fn acknowledge(&mut self, command: MavCmd, result: MavResult, (system, component): (u8, u8)) {
        let answer = common::COMMAND_ACK_DATA { command, result };
        // Extensions: progress, a second result of four bytes, and the receiver.
        let extension = [0, 0, 0, 0, 0, system, component];
        self.reply(|own, out| own.send_extended(&answer, &extension, out));
    }

    fn acknowledge_mission(
        &mut self,
        (target_system, target_component): (u8, u8),
        mavtype: common::MavMissionResult,
        kind: u8,
    ) {
        let answer = common::MISSION_ACK_DATA { target_system, target_component, mavtype };
        self.reply(|own, out| own.send_extended(&answer, &[kind], out));
    }

    /// Refuses a request for a file. The vehicle offers no files.
    fn refuse_file(&mut self, request: &[u8; 251], (target_system, target_component): (u8, u8)) {
        const NAK: u8 = 129;
        const OPEN: u8 = 4;
        const UNKNOWN_COMMAND: u8 = 7;
        const FILE_NOT_FOUND: u8 = 10;
        let [low, high, session, opcode, ..] = *request;
        let [low, high] = u16::from_le_bytes([low, high]).wrapping_add(1).to_le_bytes();
        let why = if opcode == OPEN { FILE_NOT_FOUND } else { UNKNOWN_COMMAND };
        let mut payload = [0; 251];
        payload[..13].copy_from_slice(&[low, high, session, NAK, 1, opcode, 0, 0, 0, 0, 0, 0, why]);
        let answer = common::FILE_TRANSFER_PROTOCOL_DATA {
            target_network: 0,
            target_system,
            target_component,
            payload,
        };
        self.reply(|own, out| own.send(&answer, out));
    }

    pub(super) fn explain(&mut self, text: &str) {
        self.reply(|own, out| own.encode_text(Level::Warning, text, out));
    }

    /// The read-only parameters: each has a name of up to 16 bytes and a value.
    fn parameters(&self) -> [(&'static str, f64); 11] {
        let rates = &self.config.rates;
        [
            ("MAV_SYS_ID", f64::from(self.config.system_id)),
            ("MAV_COMP_ID", f64::from(self.config.component_id)),
            ("EKF_GATE_SIGMAS", self.config.gate_sigmas),
            ("HZ_HEARTBEAT", rates.heartbeat_hz),
            ("HZ_ATTITUDE", rates.attitude_hz),
            ("HZ_HIGHRES_IMU", rates.highres_imu_hz),
            ("HZ_LOCAL_POS", rates.local_position_hz),
            ("HZ_GLOBAL_POS", rates.global_position_hz),
            ("HZ_GPS_RAW", rates.gps_raw_hz),
            ("HZ_SERVO_OUTPUT", rates.servo_output_hz),
            ("HZ_ESTIMATOR", rates.estimator_status_hz),
        ]
    }

    /// The parameter with this index, or with this name for the index −1.
    fn parameter(&self, index: i16, name: &[u8]) -> Option<usize> {
        let parameters = self.parameters();
        match usize::try_from(index) {
            Ok(index) => (index < parameters.len()).then_some(index),
            Err(_) => {
                let end = name.iter().position(|byte| *byte == 0).unwrap_or(name.len());
                parameters.iter().position(|(own, _)| own.as_bytes() == &name[..end])
            }
        }
    }

    fn report_parameter(&mut self, index: usize) {
        let parameters = self.parameters();
        let Some((name, value)) = parameters.get(index).copied() else { return };
        let mut param_id = [0; NAME];
        param_id.iter_mut().zip(name.bytes()).for_each(|(slot, byte)| *slot = byte);
        let answer = common::PARAM_VALUE_DATA {
            param_value: value as f32,
            param_count: parameters.len() as u16,
            param_index: index as u16,
            param_id: param_id.into(),
            param_type: common::MavParamType::MAV_PARAM_TYPE_REAL32,
        };
        self.reply(|own, out| own.send(&answer, out));
    }

    fn refuse_parameter(
        &mut self,
        param_index: i16,
        param_id: mavlink::types::CharArray<NAME>,
        (target_system, target_component): (u8, u8),
        error: common::MavParamError,
    ) {
        let answer = common::PARAM_ERROR_DATA {
            param_index,
            target_system,
            target_component,
            param_id,
            error,
        };
        self.reply(|own, out| own.send(&answer, out));
    }
}

/// Message AVAILABLE_MODES for one mode; `index` counts from 1.
fn mode(index: usize) -> common::AVAILABLE_MODES_DATA {
    use common::MavModeProperty as Property;
    let mode = MODES[index - 1];
    let mut mode_name = [0; 35];
    mode_name.iter_mut().zip(mode.name().bytes()).for_each(|(slot, byte)| *slot = byte);
    common::AVAILABLE_MODES_DATA {
        custom_mode: custom_mode(mode),
        properties: Property::MAV_MODE_PROPERTY_NOT_USER_SELECTABLE,
        number_modes: MODES.len() as u8,
        mode_index: index as u8,
        standard_mode: common::MavStandardMode::MAV_STANDARD_MODE_NON_STANDARD,
        mode_name: mode_name.into(),
    }
}

fn version() -> common::AUTOPILOT_VERSION_DATA {
    use common::MavProtocolCapability as Capability;
    let number = |text: &str| text.parse::<u32>().unwrap_or(0) & 0xFF;
    let [major, minor, patch] = [
        env!("CARGO_PKG_VERSION_MAJOR"),
        env!("CARGO_PKG_VERSION_MINOR"),
        env!("CARGO_PKG_VERSION_PATCH"),
    ]
    .map(number);
    common::AUTOPILOT_VERSION_DATA {
        capabilities: Capability::MAV_PROTOCOL_CAPABILITY_MAVLINK2
            | Capability::MAV_PROTOCOL_CAPABILITY_COMMAND_INT
            | Capability::MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST,
        flight_sw_version: major << 24 | minor << 16 | patch << 8,
        ..common::AUTOPILOT_VERSION_DATA::DEFAULT
    }
}

/// The supported protocol versions: the vehicle sends only MAVLink 2 and reads both versions.
fn protocol() -> common::PROTOCOL_VERSION_DATA {
    common::PROTOCOL_VERSION_DATA {
        version: 200,
        min_version: 100,
        max_version: 200,
        ..common::PROTOCOL_VERSION_DATA::DEFAULT
    }
}

#[cfg(test)]
mod tests;
