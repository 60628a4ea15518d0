//! The topics and their schemas.

use serde_json::{Value, json};

/// A topic of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    Configuration,
    DmuRaw,
    GpsRaw,
    ServoRaw,
    GpsRestart,
    Imu,
    GpsFix,
    GpsLocation,
    Solution,
    SolutionLocation,
    Innovations,
    Servo,
    Controls,
    Events,
    Lost,
}

impl Channel {
    pub const ALL: [Self; 15] = [
        Self::Configuration,
        Self::DmuRaw,
        Self::GpsRaw,
        Self::ServoRaw,
        Self::GpsRestart,
        Self::Imu,
        Self::GpsFix,
        Self::GpsLocation,
        Self::Solution,
        Self::SolutionLocation,
        Self::Innovations,
        Self::Servo,
        Self::Controls,
        Self::Events,
        Self::Lost,
    ];

    pub const fn topic(self) -> &'static str {
        match self {
            Self::Configuration => "configuration",
            Self::DmuRaw => "dmu/raw",
            Self::GpsRaw => "gps/raw",
            Self::ServoRaw => "servo/raw",
            Self::GpsRestart => "gps/restart",
            Self::Imu => "imu",
            Self::GpsFix => "gps/fix",
            Self::GpsLocation => "gps/location",
            Self::Solution => "solution",
            Self::SolutionLocation => "solution/location",
            Self::Innovations => "innovations",
            Self::Servo => "servo",
            Self::Controls => "controls",
            Self::Events => "events",
            Self::Lost => "lost",
        }
    }

    pub fn with_topic(topic: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|channel| channel.topic() == topic)
    }

    /// The schema's name; Foxglove knows its own by theirs.
    pub const fn schema_name(self) -> &'static str {
        match self {
            Self::Configuration => "hovernav.Configuration",
            Self::DmuRaw | Self::GpsRaw | Self::ServoRaw => "hovernav.Raw",
            Self::GpsRestart => "hovernav.Restart",
            Self::Imu => "hovernav.Imu",
            Self::GpsFix => "hovernav.Fix",
            Self::GpsLocation | Self::SolutionLocation => "foxglove.LocationFix",
            Self::Solution => "hovernav.Solution",
            Self::Innovations => "hovernav.Innovations",
            Self::Servo => "hovernav.Servo",
            Self::Controls => "hovernav.Controls",
            Self::Events => "foxglove.Log",
            Self::Lost => "hovernav.Lost",
        }
    }

    /// The JSON schema of its messages.
    pub fn schema(self) -> Value {
        let of = |kind: &str| json!({ "type": kind });
        let numbers = |count: usize| {
            json!({ "type": "array", "items": { "type": "number" },
                    "minItems": count, "maxItems": count })
        };
        let (integer, number, text, flag) =
            (of("integer"), of("number"), of("string"), of("boolean"));
        let three = numbers(3);
        let timestamp = json!({ "type": "object", "title": "time",
            "properties": { "sec": integer, "nsec": integer } });
        let properties = match self {
            Self::Configuration => json!({ "version": text, "start_ns": integer,
                "start_unix_ns": integer, "fly_toml": text }),
            Self::DmuRaw | Self::GpsRaw | Self::ServoRaw => {
                json!({ "time_ns": integer, "goes_on": flag, "hex": text })
            }
            Self::GpsRestart => json!({ "time_ns": integer }),
            Self::Imu => json!({ "time_ns": integer,
                "angular_rate_body_radps": three, "specific_force_body_mps2": three,
                "magnetic_field_body_gauss": three, "temperature_degc": number,
                "roll_pitch_yaw_deg": three }),
            Self::GpsFix => json!({ "time_ns": integer, "used": flag, "refused_for": text,
                "latitude_deg": number, "longitude_deg": number, "height_m": number,
                "altitude_msl_m": number, "velocity_north_east_mps": numbers(2),
                "velocity_down_mps": number, "position_sigma_ned_m": three,
                "velocity_sigma_ned_mps": three, "satellites": integer,
                "position_dilution": number, "horizontal_dilution": number }),
            Self::GpsLocation | Self::SolutionLocation => json!({ "timestamp": timestamp,
                "frame_id": text, "latitude": number, "longitude": number, "altitude": number,
                "position_covariance": numbers(9), "position_covariance_type": integer }),
            Self::Solution => json!({ "time_ns": integer, "latitude_rad": number,
                "longitude_rad": number, "height_m": number, "velocity_ned_mps": three,
                "body_to_ned_xyzw": numbers(4), "angular_rate_body_radps": three,
                "position_sigma_ned_m": three, "velocity_sigma_ned_mps": three,
                "attitude_sigma_rad": three, "gyro_bias_body_radps": three,
                "accel_bias_body_mps2": three, "gyro_bias_sigma_body_radps": three,
                "accel_bias_sigma_body_mps2": three, "roll_pitch_yaw_deg": three,
                "velocity_body_mps": three }),
            Self::Innovations => {
                let axis = json!({ "type": "object", "properties": {
                    "innovation": number, "sigma": number, "verdict": text } });
                json!({ "time_ns": integer,
                    "position_north_m": axis, "position_east_m": axis, "position_down_m": axis,
                    "velocity_north_mps": axis, "velocity_east_mps": axis,
                    "velocity_down_mps": axis, "roll_rad": axis, "pitch_rad": axis,
                    "yaw_rad": axis, "baro_height_m": axis })
            }
            Self::Servo => json!({ "captured_ms": numbers(5), "commanded_ms": numbers(5) }),
            Self::Controls => json!({ "lateral": number, "longitudinal": number,
                "collective": number, "pedal": number }),
            Self::Events => json!({ "timestamp": timestamp, "level": integer, "message": text,
                "name": text, "file": text, "line": integer }),
            Self::Lost => json!({ "raw": integer, "decoded": integer }),
        };
        json!({ "type": "object", "title": self.schema_name(), "properties": properties })
    }
}
