//! States and values for displays, each at one rate.

use mavlink::dialects::common;

use super::{Mavlink, single};
use hovernav::frames::Vector;
use hovernav::telemetry::{Snapshot, SystemMode};
use hovernav::time::Time;

impl Mavlink {
    pub(super) fn system_status(&self, snapshot: &Snapshot) -> common::SYS_STATUS_DATA {
        use common::MavSysStatusSensor as Sensor;
        let status = snapshot.status;
        let unit = Sensor::MAV_SYS_STATUS_SENSOR_3D_GYRO | Sensor::MAV_SYS_STATUS_SENSOR_3D_ACCEL;
        let parts = [
            (unit, status.imu),
            (Sensor::MAV_SYS_STATUS_SENSOR_GPS, status.gps),
            (Sensor::MAV_SYS_STATUS_SENSOR_RC_RECEIVER, status.pilot_signal),
            (Sensor::MAV_SYS_STATUS_SENSOR_MOTOR_OUTPUTS, status.servos),
            (Sensor::MAV_SYS_STATUS_LOGGING, status.recorder),
            (Sensor::MAV_SYS_STATUS_AHRS, status.attitude),
        ];
        let (mut present, mut health) = (Sensor::empty(), Sensor::empty());
        for (part, is_good) in parts {
            present |= part;
            health.set(part, is_good);
        }
        // MAVProxy reports a breach where this bit is clear, also without a geofence.
        health |= Sensor::MAV_SYS_STATUS_GEOFENCE;
        let load = snapshot.timing.work_s.zip(snapshot.timing.period_s);
        let load = load.map_or(0.0, |(work_s, period_s)| 1e3 * work_s / period_s.max(1e-3));
        common::SYS_STATUS_DATA {
            onboard_control_sensors_present: present,
            onboard_control_sensors_enabled: present,
            onboard_control_sensors_health: health,
            load: load.clamp(0.0, 1_000.0) as u16,
            // No battery is measured.
            voltage_battery: u16::MAX,
            current_battery: -1,
            battery_remaining: -1,
            ..common::SYS_STATUS_DATA::DEFAULT
        }
    }

    pub(super) fn system_time(&self, now: Time) -> common::SYSTEM_TIME_DATA {
        let time_unix_usec = self.utc_offset_us.map_or(0, |_| self.stamp_us(now));
        common::SYSTEM_TIME_DATA { time_unix_usec, time_boot_ms: self.boot_ms(now) }
    }

    pub(super) fn hud(&self, snapshot: &Snapshot) -> common::VFR_HUD_DATA {
        let heading_deg = snapshot.attitude.map(|angles| angles.yaw_rad.to_degrees());
        let velocity = snapshot.velocity_mps.map(Vector::to_array);
        common::VFR_HUD_DATA {
            airspeed: f32::NAN,
            groundspeed: single(velocity.map(|[north, east, _]| libm::hypot(north, east))),
            alt: single(snapshot.gps.altitude_msl_m.or(snapshot.position.map(|one| one.height_m))),
            climb: single(velocity.map(|[.., down]| -down)),
            heading: heading_deg
                .map_or(-1, |heading| libm::round(heading.rem_euclid(360.0)) as i16),
            throttle: 0,
        }
    }

    /// The pilot's pulses: throttle, collective, longitudinal, lateral, pedal.
    pub(super) fn pilot_channels(&self, snapshot: &Snapshot) -> common::RC_CHANNELS_DATA {
        let [chan1_raw, chan2_raw, chan3_raw, chan4_raw, chan5_raw] = snapshot
            .pilot_ms
            .map(|width_ms| {
                width_ms.map_or(u16::MAX, |width_ms| libm::round(width_ms * 1e3) as u16)
            })
            .to_array();
        let unused = u16::MAX;
        common::RC_CHANNELS_DATA {
            time_boot_ms: self.boot_ms(snapshot.time),
            chan1_raw,
            chan2_raw,
            chan3_raw,
            chan4_raw,
            chan5_raw,
            chan6_raw: unused,
            chan7_raw: unused,
            chan8_raw: unused,
            chan9_raw: unused,
            chan10_raw: unused,
            chan11_raw: unused,
            chan12_raw: unused,
            chan13_raw: unused,
            chan14_raw: unused,
            chan15_raw: unused,
            chan16_raw: unused,
            chan17_raw: unused,
            chan18_raw: unused,
            chancount: 5,
            rssi: u8::MAX,
        }
    }

    /// The home position: the first position of the flight. `None` before the first position.
    pub(super) fn home(&self) -> Option<common::HOME_POSITION_DATA> {
        let origin = self.origin?;
        Some(common::HOME_POSITION_DATA {
            latitude: libm::round(origin.latitude_deg() * 1e7) as i32,
            longitude: libm::round(origin.longitude_deg() * 1e7) as i32,
            altitude: libm::round(origin.height_m * 1e3) as i32,
            q: [f32::NAN; 4],
            ..common::HOME_POSITION_DATA::DEFAULT
        })
    }
}

/// The extended state. It is not known whether the vehicle is in the air.
pub(super) fn extended_state() -> common::EXTENDED_SYS_STATE_DATA {
    common::EXTENDED_SYS_STATE_DATA {
        vtol_state: common::MavVtolState::MAV_VTOL_STATE_UNDEFINED,
        landed_state: common::MavLandedState::MAV_LANDED_STATE_UNDEFINED,
    }
}

pub(super) fn current_mode(snapshot: &Snapshot) -> common::CURRENT_MODE_DATA {
    common::CURRENT_MODE_DATA {
        custom_mode: u32::from(snapshot.mode.code()),
        intended_custom_mode: 0,
        standard_mode: common::MavStandardMode::MAV_STANDARD_MODE_NON_STANDARD,
    }
}

pub(super) fn heartbeat(snapshot: &Snapshot) -> common::HEARTBEAT_DATA {
    use common::{MavModeFlag as Flag, MavState as State};
    let system_status = match snapshot.mode {
        SystemMode::Starting => State::MAV_STATE_BOOT,
        SystemMode::Aligning | SystemMode::SearchingHeading => State::MAV_STATE_CALIBRATING,
        SystemMode::Pilot | SystemMode::Autopilot => State::MAV_STATE_ACTIVE,
        SystemMode::Failsafe => State::MAV_STATE_CRITICAL,
    };
    let mut base_mode = Flag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED;
    base_mode.set(Flag::MAV_MODE_FLAG_MANUAL_INPUT_ENABLED, snapshot.status.pilot_signal);
    // Armed means that the servos are driven.
    let driven = snapshot.commanded_ms.iter().any(|(_, width_ms)| width_ms.is_some());
    base_mode.set(Flag::MAV_MODE_FLAG_SAFETY_ARMED, driven && snapshot.status.servos);
    base_mode.set(
        Flag::MAV_MODE_FLAG_STABILIZE_ENABLED | Flag::MAV_MODE_FLAG_AUTO_ENABLED,
        snapshot.mode == SystemMode::Autopilot,
    );
    common::HEARTBEAT_DATA {
        custom_mode: u32::from(snapshot.mode.code()),
        mavtype: common::MavType::MAV_TYPE_HELICOPTER,
        autopilot: common::MavAutopilot::MAV_AUTOPILOT_GENERIC,
        base_mode,
        system_status,
        mavlink_version: 3,
    }
}
