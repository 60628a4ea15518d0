//! States and values for displays, each at one rate.

use mavlink::dialects::common;

use super::{Mavlink, single};
use hovernav::frames::Vector;
use hovernav::telemetry::Snapshot;
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
            alt: single(snapshot.position.map(|place| place.height_m - self.geoid_m)),
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
            altitude: libm::round((origin.height_m - self.geoid_m) * 1e3) as i32,
            q: [f32::NAN; 4],
            ..common::HOME_POSITION_DATA::DEFAULT
        })
    }
}
