//! Topics of a record and their schemas.

use serde_json::{Map, Value};

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
    Autopilot,
    Events,
    Lost,
}

impl Channel {
    pub const ALL: [Self; 16] = [
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
        Self::Autopilot,
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
            Self::Autopilot => "autopilot",
            Self::Events => "events",
            Self::Lost => "lost",
        }
    }

    pub fn with_topic(topic: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|channel| channel.topic() == topic)
    }

    /// Name of the schema; Foxglove recognises its own schemas by their names.
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
            Self::Autopilot => "hovernav.Autopilot",
            Self::Events => "foxglove.Log",
            Self::Lost => "hovernav.Lost",
        }
    }

    /// The JSON schema of its messages.
    pub fn schema(self) -> Value {
        object(self.schema_name(), self.properties())
    }

    /// The fields of its messages.
    const fn properties(self) -> &'static [(&'static str, Kind)] {
        use Kind::{Axis, Flag, Integer, Number, Numbers, Text, Timestamp};
        const VECTOR: Kind = Numbers(3);
        match self {
            Self::Configuration => &[
                ("version", Text),
                ("start_ns", Integer),
                ("start_unix_ns", Integer),
                ("fly_toml", Text),
            ],
            Self::DmuRaw | Self::GpsRaw | Self::ServoRaw => {
                &[("time_ns", Integer), ("goes_on", Flag), ("hex", Text)]
            }
            Self::GpsRestart => &[("time_ns", Integer)],
            Self::Imu => &[
                ("time_ns", Integer),
                ("angular_rate_body_radps", VECTOR),
                ("specific_force_body_mps2", VECTOR),
                ("magnetic_field_body_gauss", VECTOR),
                ("temperature_degc", Number),
                ("roll_pitch_yaw_deg", VECTOR),
            ],
            Self::GpsFix => &[
                ("time_ns", Integer),
                ("utc_ns", Integer),
                ("used", Flag),
                ("refused_for", Text),
                ("latitude_deg", Number),
                ("longitude_deg", Number),
                ("height_m", Number),
                ("altitude_msl_m", Number),
                ("velocity_north_east_mps", Numbers(2)),
                ("velocity_down_mps", Number),
                ("position_sigma_ned_m", VECTOR),
                ("velocity_sigma_ned_mps", VECTOR),
                ("satellites", Integer),
                ("position_dilution", Number),
                ("horizontal_dilution", Number),
            ],
            Self::GpsLocation | Self::SolutionLocation => &[
                ("timestamp", Timestamp),
                ("frame_id", Text),
                ("latitude", Number),
                ("longitude", Number),
                ("altitude", Number),
                ("position_covariance", Numbers(9)),
                ("position_covariance_type", Integer),
            ],
            Self::Solution => &[
                ("time_ns", Integer),
                ("latitude_rad", Number),
                ("longitude_rad", Number),
                ("height_m", Number),
                ("velocity_ned_mps", VECTOR),
                ("body_to_ned_xyzw", Numbers(4)),
                ("angular_rate_body_radps", VECTOR),
                ("heading_revision_rad", Number),
                ("position_sigma_ned_m", VECTOR),
                ("velocity_sigma_ned_mps", VECTOR),
                ("attitude_sigma_rad", VECTOR),
                ("gyro_bias_body_radps", VECTOR),
                ("accel_bias_body_mps2", VECTOR),
                ("gyro_bias_sigma_body_radps", VECTOR),
                ("accel_bias_sigma_body_mps2", VECTOR),
                ("roll_pitch_yaw_deg", VECTOR),
                ("velocity_body_mps", VECTOR),
            ],
            Self::Innovations => &[
                ("time_ns", Integer),
                ("position_north_m", Axis),
                ("position_east_m", Axis),
                ("position_down_m", Axis),
                ("velocity_north_mps", Axis),
                ("velocity_east_mps", Axis),
                ("velocity_down_mps", Axis),
                ("roll_rad", Axis),
                ("pitch_rad", Axis),
                ("yaw_rad", Axis),
                ("baro_height_m", Axis),
            ],
            Self::Servo => &[("captured_ms", Numbers(5)), ("commanded_ms", Numbers(5))],
            Self::Controls => &[
                ("lateral", Number),
                ("longitudinal", Number),
                ("collective", Number),
                ("pedal", Number),
            ],
            Self::Autopilot => &[
                ("time_ns", Integer),
                ("has_sample", Flag),
                ("servos_good", Flag),
                ("late_cycles", Integer),
                ("work_s", Number),
                ("mode", Text),
                ("switch_on", Flag),
                ("failed_checks", Integer),
                ("pilot", Numbers(4)),
                ("sticks", Numbers(4)),
                ("asked_velocity_ned_mps", VECTOR),
                ("asked_heading_rad", Number),
            ],
            Self::Events => &[
                ("timestamp", Timestamp),
                ("level", Integer),
                ("message", Text),
                ("name", Text),
                ("file", Text),
                ("line", Integer),
                ("part", Text),
            ],
            Self::Lost => &[("raw", Integer), ("decoded", Integer)],
        }
    }
}

/// Type of a field.
#[derive(Clone, Copy)]
enum Kind {
    Integer,
    Number,
    Text,
    Flag,
    /// An array of this length.
    Numbers(u8),
    /// Foxglove's time type.
    Timestamp,
    /// An innovation.
    Axis,
}

impl Kind {
    fn schema(self) -> Value {
        let named = |name: &str| fields([("type", name.into())]);
        match self {
            Self::Integer => named("integer"),
            Self::Number => named("number"),
            Self::Text => named("string"),
            Self::Flag => named("boolean"),
            Self::Numbers(count) => fields([
                ("type", "array".into()),
                ("items", named("number")),
                ("minItems", count.into()),
                ("maxItems", count.into()),
            ]),
            Self::Timestamp => object("time", &[("sec", Self::Integer), ("nsec", Self::Integer)]),
            Self::Axis => fields([
                ("type", "object".into()),
                (
                    "properties",
                    fields([
                        ("innovation", named("number")),
                        ("sigma", named("number")),
                        ("verdict", named("string")),
                    ]),
                ),
            ]),
        }
    }
}

fn object(title: &str, properties: &[(&str, Kind)]) -> Value {
    let properties = properties.iter().map(|(name, kind)| ((*name).into(), kind.schema()));
    fields([
        ("type", "object".into()),
        ("title", title.into()),
        ("properties", Value::Object(properties.collect())),
    ])
}

fn fields<const N: usize>(fields: [(&str, Value); N]) -> Value {
    Value::Object(Map::from_iter(fields.map(|(name, value)| (name.into(), value))))
}
