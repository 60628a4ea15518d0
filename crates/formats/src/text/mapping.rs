//! `mapping.toml`: what the columns of foreign text files are.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::decimal::TimeUnit;
use super::layout::Delimiter;
use super::scale::TimeScale;
use super::units::{
    AngleUnit, AttitudeRole, BaroUnit, CourseUnit, ForceUnit, HeightAbove, LengthUnit,
    MagneticUnit, PlaceUnit, RateUnit, SpeedUnit, StickUnit, World,
};
use hovernav_log::LogError;
use hovernav_toml::TomlError;

/// The file of a mapping in its directory.
pub const MAPPING_FILE: &str = "mapping.toml";

/// `mapping.toml`: where in which files the sensors' values stand, in what units and axes.
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
    /// The file, from the directory of the mapping.
    pub file: PathBuf,
    /// What parts the fields: `comma`, `semicolon`, `tab` or `spaces`.
    pub delimiter: Delimiter,
    /// Whether numbers have a decimal comma.
    pub decimal_comma: bool,
    /// Line of the names, from 1; 0 where there are none and columns go by their numbers from 1.
    pub header_line: u64,
    /// When each row was.
    pub time: TimeColumn,
    /// Angular rates, or increments of angle since the row before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gyro: Option<Triad<RateUnit>>,
    /// Specific force, or increments of velocity since the row before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accel: Option<Triad<ForceUnit>>,
    /// Magnetic field.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mag: Option<Triad<MagneticUnit>>,
    /// Attitude, of the unit itself or of an estimator on board.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub attitude: Option<AttitudeColumns>,
    /// Fixes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gps: Option<GpsColumns>,
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
    /// Its column; without one, rows follow each other at `rate_hz`.
    pub column: String,
    /// Its unit: `s`, `ms`, `us`, `ns`, `clock` for dates and times of day, or `hhmmss` for times of day as one
    /// number, as NMEA 0183 writes them.
    pub unit: TimeUnit,
    /// Column of the date, ddmmyy, yyyymmdd, 2025-07-08, 2025/07/08 or 08.07.2025, which the time of day is of.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub date: String,
    /// Column of the GPS week, counted from 6 January 1980, which the time is of; with `scale = "gps"`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub week: String,
    /// What it counts: `own`, the logger's clock or UTC since 1970, or `gps`, GPS time since 6 January
    /// 1980, which is brought to UTC since 1970 with the leap seconds of its day.
    #[serde(skip_serializing_if = "TimeScale::is_own")]
    pub scale: TimeScale,
    /// Added to it, s: what brings several files to one clock.
    #[serde(skip_serializing_if = "is_zero")]
    pub offset_s: f64,
    /// Rows a second where there is no column, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
}

/// Three columns along axes.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Triad<U> {
    /// The columns of the sensor's own x, y and z.
    pub columns: [String; 3],
    /// Their unit.
    pub unit: U,
    /// Which of its axes point forward, right and down: `x`, `y` or `z`, with `-` where the axis
    /// points the other way.
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
    /// Roll, pitch, yaw; empty of a quaternion.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub columns: Vec<String>,
    /// Their unit: `deg` or `rad`.
    pub unit: AngleUnit,
    /// What each is multiplied by: 1 or −1.
    pub signs: [f64; 3],
    /// Added to yaw after its sign, °.
    pub yaw_offset_deg: f64,
    /// Scalar first, then x, y, z: from the axes of the vehicle to those of the world.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub quaternion: Vec<String>,
    /// The axes of the world of a quaternion: `ned` (the vehicle's are forward-right-down) or `enu`
    /// (forward-left-up).
    pub world: World,
    /// Whose it is: `unit` is used as a measurement, `onboard` only compared with.
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
    /// Their unit: `deg`, `rad`, `deg1e7`, or `ddmm` for degrees and minutes as NMEA 0183 writes them,
    /// 4807.038 being 48° 7.038′.
    pub unit: PlaceUnit,
    /// Column of the letters N and S, where the latitude has no sign.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub north_south: String,
    /// Column of the letters E and W, where the longitude has no sign.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub east_west: String,
    /// Column of the height.
    pub height: String,
    /// Its unit: `m`, `cm`, `mm` or `ft`.
    pub height_unit: LengthUnit,
    /// What it is measured from: `ellipsoid` or `sea`.
    pub height_above: HeightAbove,
    /// The geoid's height above the ellipsoid, m, which is added to a height above the sea.
    pub geoid_separation_m: f64,
    /// Columns of the velocity north, east and down.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub north: String,
    /// See `north`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub east: String,
    /// See `north`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub down: String,
    /// Column of the velocity upwards, in place of `down`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub up: String,
    /// Column of the speed over ground, in place of `north` and `east`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub speed: String,
    /// Column of the course, clockwise from north, with `speed`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub course: String,
    /// Its unit: `deg`, `rad`, `cdeg` or `deg1e5`.
    pub course_unit: CourseUnit,
    /// Unit of the velocities: `m/s`, `cm/s`, `mm/s`, `km/h`, `kn` or `mph`.
    pub speed_unit: SpeedUnit,
    /// Columns of the one-sigma of horizontal and vertical position, m.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sigma_horizontal: String,
    /// See `sigma_horizontal`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sigma_vertical: String,
    /// Columns of the one-sigma of the position north, east and down, in place of `sigma_horizontal` and
    /// `sigma_vertical`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sigma_north: String,
    /// See `sigma_north`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sigma_east: String,
    /// See `sigma_north`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sigma_down: String,
    /// Column of the one-sigma of velocity on any axis.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sigma_speed: String,
    /// Column of the one-sigma of vertical velocity, where it differs.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sigma_vertical_speed: String,
    /// Columns of the one-sigma of the velocity north, east and down, in place of `sigma_speed` and
    /// `sigma_vertical_speed`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sigma_velocity_north: String,
    /// See `sigma_velocity_north`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sigma_velocity_east: String,
    /// See `sigma_velocity_north`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sigma_velocity_down: String,
    /// Unit of the sigmas of position.
    pub sigma_unit: LengthUnit,
    /// Unit of the sigmas of velocity, where it is not `speed_unit`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma_speed_unit: Option<SpeedUnit>,
    /// Column that is 0 where there is no fix.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub fix_type: String,
    /// Column of the number of satellites used.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub satellites: String,
    /// Whether rows repeat the last fix until there is a new one.
    pub held: bool,
}

/// `[table.baro]`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct BaroColumn {
    /// Its column.
    pub column: String,
    /// Its unit: `m` or `ft` of a height, `Pa`, `hPa` or `kPa` of a pressure.
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
    /// Their unit: `fraction` (−1 to 1) or `percent`.
    pub unit: StickUnit,
    /// What each is multiplied by: 1 or −1.
    pub signs: [f64; 4],
}

/// Which axis of a sensor, 0 to 2, and with which sign, points forward, right and down.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(try_from = "[String; 3]", into = "[String; 3]")]
pub struct Axes(pub [(usize, f64); 3]);

impl Axes {
    /// Forward, right, down as they are.
    pub const FORWARD_RIGHT_DOWN: Self = Self([(0, 1.0), (1, 1.0), (2, 1.0)]);
    /// The sensor's axes are forward, left and up.
    pub const FORWARD_LEFT_UP: Self = Self([(0, 1.0), (1, -1.0), (2, -1.0)]);

    /// The vector in body axes whose components along the sensor's axes are `values`.
    #[must_use]
    pub fn turned(&self, values: [f64; 3]) -> [f64; 3] {
        self.0.map(|(axis, sign)| sign * values[axis])
    }

    /// The same axes, every sign reversed: of a sensor that counts against its axes.
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

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl Mapping {
    /// Reads a mapping and lists the keys it does not know.
    ///
    /// # Errors
    /// [`LogError::Toml`] where it cannot be read, is no TOML, or a value is not of its key's kind.
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
