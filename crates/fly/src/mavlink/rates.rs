//! Intervals of the messages on request.
//!
//! Source: MAVLink, *common message set*: MAV_CMD_SET_MESSAGE_INTERVAL, MAV_CMD_GET_MESSAGE_INTERVAL, MESSAGE_INTERVAL.

use mavlink::MessageData as _;
use mavlink::dialects::common::{self, MavResult};

use super::pacing::Schedule;
use super::{HOME_HZ, Mavlink, STATES_HZ};

/// Identifiers of the messages that share a schedule and have no rate of their own: SYS_STATUS, SYSTEM_TIME,
/// RC_CHANNELS, VFR_HUD, EXTENDED_SYS_STATE, CURRENT_MODE.
const STATES: [u32; 6] = [1, 2, 65, 74, 245, 436];
/// HOME_POSITION.
const HOME: u32 = 242;

impl Mavlink {
    /// The schedule of message `id`, and its rate in the configuration, Hz; `None` for a message without its own
    /// schedule.
    fn schedule(&mut self, id: u32) -> Option<(&mut Schedule, f64)> {
        let rates = self.config.rates;
        Some(match id {
            common::HEARTBEAT_DATA::ID => (&mut self.heartbeat, rates.heartbeat_hz),
            common::ATTITUDE_DATA::ID => (&mut self.attitude, rates.attitude_hz),
            common::HIGHRES_IMU_DATA::ID => (&mut self.highres_imu, rates.highres_imu_hz),
            common::LOCAL_POSITION_NED_DATA::ID => {
                (&mut self.local_position, rates.local_position_hz)
            }
            common::GLOBAL_POSITION_INT_DATA::ID => {
                (&mut self.global_position, rates.global_position_hz)
            }
            common::GPS_RAW_INT_DATA::ID => (&mut self.gps_raw, rates.gps_raw_hz),
            common::SERVO_OUTPUT_RAW_DATA::ID => (&mut self.servo_output, rates.servo_output_hz),
            common::ESTIMATOR_STATUS_DATA::ID => {
                (&mut self.estimator_status, rates.estimator_status_hz)
            }
            _ => return None,
        })
    }

    /// The interval of message `id`, µs: −1 if it is off, 0 if it does not exist.
    pub(super) fn interval(&mut self, id: u32) -> common::MESSAGE_INTERVAL_DATA {
        let rate_hz = match self.schedule(id) {
            Some((schedule, _)) => Some(schedule.rate_hz()),
            None if STATES.contains(&id) => Some(STATES_HZ),
            None if id == HOME => Some(HOME_HZ),
            None => None,
        };
        let interval_us = match rate_hz {
            None => 0,
            Some(rate_hz) if rate_hz > 0.0 => (1e6 / rate_hz) as i32,
            Some(_) => -1,
        };
        common::MESSAGE_INTERVAL_DATA { interval_us, message_id: id as u16 }
    }

    /// Sets the interval of message `id`, µs: −1 turns the message off, 0 restores the configured interval. A rate
    /// above the configured one is refused, because the line has no capacity for it. A slower heartbeat is refused too,
    /// because ground stations detect the vehicle by it.
    pub(super) fn set_interval(&mut self, id: u32, interval_us: f32) -> MavResult {
        let present = self.interval(id).interval_us;
        let Some((schedule, configured_hz)) = self.schedule(id) else {
            return match present {
                0 => MavResult::MAV_RESULT_UNSUPPORTED,
                _ if interval_us == 0.0 => MavResult::MAV_RESULT_ACCEPTED,
                _ => {
                    self.explain("this message has no rate of its own");
                    MavResult::MAV_RESULT_DENIED
                }
            };
        };
        let rate_hz = match interval_us {
            0.0 => configured_hz,
            -1.0 => 0.0,
            _ if interval_us > 0.0 && interval_us.is_finite() => 1e6 / f64::from(interval_us),
            _ => f64::NAN,
        };
        // A request in whole microseconds may round up.
        let is_possible = rate_hz <= configured_hz * 1.001;
        if id == common::HEARTBEAT_DATA::ID && rate_hz < configured_hz * 0.999 {
            self.explain("the heartbeat is not slowed: stations detect the vehicle by it");
            return MavResult::MAV_RESULT_DENIED;
        }
        if !is_possible {
            self.explain("faster than [mavlink.speaker.rates] allows");
            return MavResult::MAV_RESULT_DENIED;
        }
        schedule.set_rate(rate_hz);
        MavResult::MAV_RESULT_ACCEPTED
    }
}
