//! `mapping.toml`: the columns of foreign text files.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::decimal::TimeUnit;
use super::layout::Delimiter;
use super::scale::TimeScale;
use super::units::{
    AngleUnit, AttitudeRole, BaroUnit, CourseUnit, ForceUnit, HeightAbove, LengthUnit,
    MagneticUnit, PlaceUnit, RateUnit, SpeedUnit, StickUnit, World,
};
use hovernav_dataset::{ClockSteps, LogError};
use hovernav_toml::TomlError;

/// File name of a mapping.
pub const MAPPING_FILE: &str = "mapping.toml";

/// `mapping.toml`: files, columns, units and axes of the sensors.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct Mapping {
    /// The files, each a table of rows.
    pub table: Vec<TableMapping>,
}

/// `[[table]]`: one file.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct TableMapping {
    /// Path of the file, relative to the directory of the mapping.
    pub file: PathBuf,
    /// Whether the file is a capture of a receiver, NMEA 0183, UBX or TSIP, instead of text in columns. Its times are
    /// UTC since 1970. Of the other keys, only `offset_s` under `[table.time]` has an effect.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub capture: bool,
    /// Separator of the fields.
    pub delimiter: Delimiter,
    /// Whether numbers have a decimal comma.
    pub decimal_comma: bool,
    /// Line number of the names, from 1. 0 for a file without names, whose columns are numbered from 1.
    pub header_line: u64,
    /// Column with the number of the sensor, if the file has rows of several sensors.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub instance_column: String,
    /// Number of the sensor whose rows are read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instance: Option<u32>,
    /// Time of each row.
    pub time: TimeColumn,
    /// Angular rates, or increments of angle since the row before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gyro: Option<Triad<RateUnit>>,
    /// Specific force, or increments of velocity since the row before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accel: Option<Triad<ForceUnit>>,
    /// Gravity as specific force, added to a linear acceleration, of the same or of another file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gravity: Option<Triad<ForceUnit>>,
    /// Magnetic field.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mag: Option<Triad<MagneticUnit>>,
    /// Attitude of the IMU itself or of an onboard estimator.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub attitude: Option<AttitudeColumns>,
    /// Fixes of a receiver.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gps: Option<GpsColumns>,
    /// Velocity of the fixes of another file, such as `TwistStamped` of ROS.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<VelocityColumns>,
    /// Barometer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub baro: Option<BaroColumn>,
    /// The pilot's sticks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub controls: Option<StickColumns>,
}

/// `[table.time]`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct TimeColumn {
    /// Column of the time; without one, rows are `1 / rate_hz` apart.
    pub column: String,
    /// Unit of the time. `filetime` and `ticks`: 100 ns since 1601 and since the year 1. `excel`, `datenum` and `mjd`:
    /// days since 30 December 1899, since the year 0, and since 17 November 1858. `count`: numbers of samples, at
    /// `rate_hz` samples per second. `clock`: dates and times of day. `hhmmss`: times of day as one number, as in NMEA
    /// 0183.
    pub unit: TimeUnit,
    /// Column of the nanoseconds after the second in `column`, as in the stamps of ROS.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub nanoseconds: String,
    /// Column of the date that belongs to the time of day, as ddmmyy, yyyymmdd, 2025-07-08, 2025/07/08 or 08.07.2025.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub date: String,
    /// Column of the GPS week that belongs to the time, counted from 6 January 1980; with `scale = "gps"`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub week: String,
    /// Time scale. `own`: the logger's clock, or UTC since 1970. `gps`: GPS time since 6 January 1980, or
    /// as a date and time of day, which is converted to UTC with leap seconds.
    #[serde(skip_serializing_if = "TimeScale::is_own")]
    pub scale: TimeScale,
    /// Offset added to the time, s, to bring several files to one clock.
    #[serde(skip_serializing_if = "is_zero")]
    pub offset_s: f64,
    /// Rate of the rows in a file without a time column, or of the counts in `column`, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
}

/// Three columns along axes.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Triad<U> {
    /// Columns of the sensor's x, y and z axes.
    pub columns: [String; 3],
    /// Unit of the values.
    pub unit: U,
    /// Counts per unit, for values that are counts: 2048 for `acc_1G` of Betaflight with `unit = "g"`.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub counts_per_unit: f64,
    /// Sensor axes that point forward, right and down; `-` if the axis points the opposite way.
    #[serde(default)]
    pub axes: Axes,
    /// Whether rows repeat the last value until there is a new one.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub held: bool,
}

/// `[table.attitude]`: roll, pitch, yaw, or a quaternion.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct AttitudeColumns {
    /// Columns of roll, pitch and yaw; empty for a quaternion.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub columns: Vec<String>,
    /// Unit of the angles.
    pub unit: AngleUnit,
    /// Factor of each column: 1 or −1.
    pub signs: [f64; 3],
    /// Offset added to yaw after its sign is applied, °.
    pub yaw_offset_deg: f64,
    /// Columns of the quaternion from vehicle axes to navigation axes: scalar first, then x, y, z.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub quaternion: Vec<String>,
    /// Navigation axes of a quaternion: `ned` (vehicle axes forward-right-down) or `enu` (forward-left-up).
    pub world: World,
    /// Source of the attitude. `unit`: the IMU; the attitude is used as a measurement. `onboard`: another estimator;
    /// the attitude is only compared.
    pub role: AttitudeRole,
}

/// `[table.gps]`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct GpsColumns {
    /// Column of the latitude, north positive.
    pub latitude: String,
    /// Column of the longitude, east positive.
    pub longitude: String,
    /// Unit of latitude and longitude. `ddmm`: degrees and minutes as in NMEA 0183 (4807.038 is 48° 7.038′). `ecef`:
    /// latitude, longitude and height are x, y and z from the Earth's centre, in `height_unit`; north, east and down are
    /// velocities along them.
    pub unit: PlaceUnit,
    /// Column of the letters N and S, if the latitude has no sign.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub north_south: String,
    /// Column of the letters E and W, if the longitude has no sign.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub east_west: String,
    /// Column of the height.
    pub height: String,
    /// Unit of the height.
    pub height_unit: LengthUnit,
    /// Reference of the height.
    pub height_above: HeightAbove,
    /// Height of the geoid above the ellipsoid, m, added to a height above sea level.
    pub geoid_separation_m: f64,
    /// Column of the height of the geoid above the ellipsoid, in the unit of the height, instead of
    /// `geoid_separation_m`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub geoid_separation: String,
    /// Columns of the velocity north, east and down.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub north: String,
    /// See `north`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub east: String,
    /// See `north`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub down: String,
    /// Column of the upward velocity, instead of `down`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub up: String,
    /// Column of the speed over ground, instead of `north` and `east`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub speed: String,
    /// Column of the course, clockwise from north, with `speed`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub course: String,
    /// Unit of the course.
    pub course_unit: CourseUnit,
    /// Unit of the velocities.
    pub speed_unit: SpeedUnit,
    /// Unit of the vertical velocity, if it differs from `speed_unit`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vertical_unit: Option<SpeedUnit>,
    /// Columns of the one-sigma of horizontal and vertical position.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sigma_horizontal: String,
    /// See `sigma_horizontal`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sigma_vertical: String,
    /// Columns of the one-sigma of the position north, east and down, instead of `sigma_horizontal` and
    /// `sigma_vertical`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sigma_north: String,
    /// See `sigma_north`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sigma_east: String,
    /// See `sigma_north`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sigma_down: String,
    /// Column of the one-sigma of velocity, the same on every axis.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sigma_speed: String,
    /// Column of the one-sigma of vertical velocity, if it differs from that of horizontal velocity.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sigma_vertical_speed: String,
    /// Columns of the one-sigma of the velocity north, east and down, instead of `sigma_speed` and
    /// `sigma_vertical_speed`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sigma_velocity_north: String,
    /// See `sigma_velocity_north`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sigma_velocity_east: String,
    /// See `sigma_velocity_north`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sigma_velocity_down: String,
    /// Unit of the one-sigmas of position.
    pub sigma_unit: LengthUnit,
    /// Unit of the one-sigmas of velocity, if it differs from `speed_unit`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma_speed_unit: Option<SpeedUnit>,
    /// Column of the fix type: 0 or words such as `NO FIX` mean no fix, other words a three-dimensional one.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub fix_type: String,
    /// Column of the number of satellites used; 0 means no fix.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub satellites: String,
    /// Numbers that mean an unknown latitude or longitude, and so no fix.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unknown: Vec<f64>,
    /// Whether rows repeat the last fix until there is a new one.
    pub held: bool,
}

/// `[table.velocity]`: assigned to the nearest fix.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct VelocityColumns {
    /// Columns of the velocity along the axes of `world`.
    pub columns: [String; 3],
    /// Unit of the velocity.
    pub unit: SpeedUnit,
    /// Navigation axes: `ned` or `enu`.
    pub world: World,
}

/// `[table.baro]`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct BaroColumn {
    /// Column of the height or pressure.
    pub column: String,
    /// Unit of the height or pressure.
    pub unit: BaroUnit,
    /// Whether rows repeat the last value until there is a new one.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub held: bool,
}

/// `[table.controls]`: full right, nose-down, up and nose-right are positive, trim is zero.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct StickColumns {
    /// Columns of lateral, longitudinal, collective and pedal.
    pub columns: [String; 4],
    /// Unit of the stick positions; a `fraction` is −1 to 1.
    pub unit: StickUnit,
    /// Factor of each column: 1 or −1.
    pub signs: [f64; 4],
}

/// Sensor axes for forward, right and down: the index of each, 0 to 2, and its sign.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(try_from = "[String; 3]", into = "[String; 3]")]
pub struct Axes(pub [(usize, f64); 3]);

impl Axes {
    /// The sensor's axes are forward, right and down.
    pub const FORWARD_RIGHT_DOWN: Self = Self([(0, 1.0), (1, 1.0), (2, 1.0)]);
    /// The sensor's axes are forward, left and up.
    pub const FORWARD_LEFT_UP: Self = Self([(0, 1.0), (1, -1.0), (2, -1.0)]);

    /// The vector in body axes whose components along the sensor's axes are `values`.
    #[must_use]
    pub fn turned(&self, values: [f64; 3]) -> [f64; 3] {
        self.0.map(|(axis, sign)| sign * values[axis])
    }

    /// The same axes with all signs reversed.
    #[must_use]
    pub fn reversed(self) -> Self {
        Self(self.0.map(|(axis, sign)| (axis, -sign)))
    }
}

impl Default for Axes {
    fn default() -> Self {
        Self::FORWARD_RIGHT_DOWN
    }
}

impl TryFrom<[String; 3]> for Axes {
    type Error = String;

    fn try_from(names: [String; 3]) -> Result<Self, String> {
        let mut axes = [(0, 1.0); 3];
        for (axis, name) in axes.iter_mut().zip(&names) {
            let (sign, letter) = match name.strip_prefix('-') {
                Some(letter) => (-1.0, letter),
                None => (1.0, name.strip_prefix('+').unwrap_or(name)),
            };
            let found = ["x", "y", "z"].iter().position(|known| *known == letter);
            let place =
                found.ok_or_else(|| format!("found \"{name}\", expected x, y, z or -x …"))?;
            *axis = (place, sign);
        }
        let mut used = axes.map(|(axis, _)| axis);
        used.sort_unstable();
        if used == [0, 1, 2] {
            return Ok(Self(axes));
        }
        Err(format!("found {names:?}, expected each of x, y and z once"))
    }
}

impl From<Axes> for [String; 3] {
    fn from(axes: Axes) -> Self {
        axes.0.map(|(axis, sign)| {
            format!("{}{}", if sign < 0.0 { "-" } else { "" }, ["x", "y", "z"][axis])
        })
    }
}

const fn one() -> f64 {
    1.0
}

fn is_one(value: &f64) -> bool {
    *value == 1.0
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl GpsColumns {
    /// Unit of the vertical velocity.
    pub fn vertical_unit(&self) -> SpeedUnit {
        self.vertical_unit.unwrap_or(self.speed_unit)
    }
}

impl Mapping {
    /// Clock of the files, before any sensor has been read.
    pub fn clock(&self) -> ClockSteps {
        let is_of_day =
            |table: &TableMapping| table.time.unit.is_of_day() && table.time.date.is_empty();
        match self.table.iter().any(is_of_day) {
            true => ClockSteps::of_day(),
            false => ClockSteps::default(),
        }
    }

    /// Reads a mapping; the second value has one warning per unknown key.
    ///
    /// # Errors
    /// [`LogError::Toml`] if the file cannot be read, is not TOML, or has a value of the wrong type.
    pub fn read(path: &Path) -> Result<(Self, Vec<String>), LogError> {
        let (mapping, unknown): (Self, _) = hovernav_toml::read(path)?;
        if mapping.table.is_empty() {
            let reason = "found no [[table]], expected one for each file";
            return Err(TomlError::at(path, "", 0, reason).into());
        }
        let warning = |key| format!("{MAPPING_FILE}: key {key} is not known and has no effect");
        Ok((mapping, unknown.into_iter().map(warning).collect()))
    }
}
