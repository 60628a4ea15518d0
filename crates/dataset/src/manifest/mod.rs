//! `dataset.toml`: properties of a vehicle and its sensors.

pub(crate) mod aid_sections;
pub(crate) mod axes;
pub(crate) mod lever_arm;

use std::path::Path;

use serde::{Deserialize, Deserializer, Serialize, de};
use toml::value::Datetime;

use crate::error::LogError;
use crate::manifest::aid_sections::{RangefinderSection, SecondAntennaSection, notch};
use crate::manifest::axes::{AccelUnit, Axes, GyroUnit, Reading, rotation_of};
use hovernav::ekf::{EstimatorConfig, VehicleKind};
use hovernav::frames::{Body, Vector};
use hovernav::imu::NotchConfig;
use hovernav::scalar::Readable;
use hovernav_toml::TomlError;

/// Name of the manifest in a dataset directory.
pub(crate) const MANIFEST_FILE: &str = "dataset.toml";

/// `dataset.toml`: the vehicle, the mounting and accuracy of its sensors, and the filter's settings.
///
/// Every key has a default. Lever arms lead from the centre of gravity, in body axes.
///
/// ```
/// use hovernav_dataset::Manifest;
/// let text = "name = 'hop'\n[gps]\nantenna_lever_arm_m = [-0.35, 0, 0.2]\nlatency = 0.1\n";
/// let (manifest, warnings) = Manifest::parse(text, "dataset.toml".as_ref())?;
/// assert_eq!(manifest.gps.antenna_lever_arm_m.x(), -0.35);
/// assert_eq!(warnings, ["dataset.toml: key gps.latency is not known and has no effect"]);
/// # Ok::<(), hovernav_dataset::LogError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct Manifest {
    /// Name of the dataset.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Description of the vehicle and its flight.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub vehicle: String,
    /// Kind of the vehicle. A wheeled vehicle is held to its road while fixes are absent; without a kind, the fixes
    /// show whether it rolls.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vehicle_kind: Option<VehicleKind>,
    /// `recorded` or `simulated`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub kind: String,
    /// Origin of the data.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub origin: String,
    /// Licence of the data.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub licence: String,
    /// Description of the log's clock.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub time: String,
    /// Date of the flight, for the magnetic model. With a time of day, it is the time of zero on the log's clock, for
    /// the dates in exports. It is UTC unless it has an offset.
    #[serde(deserialize_with = "date", skip_serializing_if = "Option::is_none")]
    pub date: Option<Datetime>,
    /// The inertial unit.
    pub imu: ImuSection,
    /// The GPS receiver.
    pub gps: GpsSection,
    /// The second GPS antenna.
    #[serde(skip_serializing_if = "is_default")]
    pub second_antenna: SecondAntennaSection,
    /// The rangefinder.
    #[serde(skip_serializing_if = "is_default")]
    pub rangefinder: RangefinderSection,
    /// The reference for scores.
    pub reference: ReferenceSection,
    /// Settings of the solution.
    pub solution: SolutionSection,
    /// Settings of the alignment, unparsed.
    #[serde(skip_serializing_if = "toml::Table::is_empty")]
    pub alignment: toml::Table,
    /// Settings of the aiding, unparsed.
    #[serde(skip_serializing_if = "toml::Table::is_empty")]
    pub aiding: toml::Table,
    /// Settings of the filter, unparsed.
    #[serde(skip_serializing_if = "toml::Table::is_empty")]
    pub filter: toml::Table,
}

/// `[imu]`: the inertial unit.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct ImuSection {
    /// Nominal sample rate, Hz; the times in the file determine the actual rate.
    #[serde(deserialize_with = "positive", skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// Position of the inertial unit relative to the centre of gravity, m.
    #[serde(with = "lever_arm")]
    pub lever_arm_m: Vector<Body>,
    /// Angle random walk, °/√h.
    #[serde(deserialize_with = "positive", skip_serializing_if = "Option::is_none")]
    pub angle_random_walk_deg_per_sqrt_h: Option<f64>,
    /// Velocity random walk, m/s/√h.
    #[serde(deserialize_with = "positive", skip_serializing_if = "Option::is_none")]
    pub velocity_random_walk_mps_per_sqrt_h: Option<f64>,
    /// One-sigma of the gyro bias at power-up, °/s.
    #[serde(deserialize_with = "positive", skip_serializing_if = "Option::is_none")]
    pub gyro_bias_sigma_degps: Option<f64>,
    /// One-sigma of the accelerometer bias at power-up, m/s².
    #[serde(deserialize_with = "positive", skip_serializing_if = "Option::is_none")]
    pub accel_bias_sigma_mps2: Option<f64>,
    /// North to which the inertial unit's own yaw refers.
    pub heading_reference: HeadingReference,
    /// Magnetic declination at the site, east positive, °; without it, that of the magnetic model.
    #[serde(deserialize_with = "declination", skip_serializing_if = "Option::is_none")]
    pub magnetic_declination_deg: Option<f64>,
    /// Full scale of the gyros, °/s.
    #[serde(deserialize_with = "positive", skip_serializing_if = "Option::is_none")]
    pub gyro_range_degps: Option<f64>,
    /// Full scale of the accelerometers, g.
    #[serde(deserialize_with = "positive", skip_serializing_if = "Option::is_none")]
    pub accel_range_g: Option<f64>,
    /// Directions of the axes x, y, z of `imu.csv`; in memory they are forward, right, down (`frd`). The inertial
    /// unit's own roll, pitch and yaw are not converted.
    #[serde(skip_serializing_if = "Axes::are_body")]
    pub axes: Axes,
    /// Attitude of the inertial unit in the vehicle: roll, pitch and yaw, °, each within ±360. It applies after the
    /// conversion by `axes`. These angles convert samples, field and the inertial unit's own attitude to the axes of
    /// the vehicle.
    #[serde(deserialize_with = "mounting", skip_serializing_if = "is_default")]
    pub mounting_deg: [f64; 3],
    /// Unit of the accelerations in `imu.csv`; the names of the columns do not matter.
    #[serde(skip_serializing_if = "is_default")]
    pub accel_unit: AccelUnit,
    /// Unit of the angular rates in `imu.csv`.
    #[serde(skip_serializing_if = "is_default")]
    pub gyro_unit: GyroUnit,
    /// Whether the accelerations in `imu.csv` have the sign of gravity, down at rest, instead of that of specific
    /// force.
    #[serde(skip_serializing_if = "is_default")]
    pub accel_is_gravity: bool,
    /// A notch filter for the rotor's vibration in the samples, at a fixed frequency or at that of `rotor.csv`.
    #[serde(deserialize_with = "notch", skip_serializing_if = "Option::is_none")]
    pub notch: Option<NotchConfig>,
}

impl ImuSection {
    /// Takes the conversion of the samples out of the section. From then on the section describes converted samples.
    #[must_use]
    pub fn take_reading(&mut self) -> Reading {
        Reading {
            axes: std::mem::take(&mut self.axes),
            mounting: rotation_of(std::mem::take(&mut self.mounting_deg)),
            accel_unit: std::mem::take(&mut self.accel_unit),
            gyro_unit: std::mem::take(&mut self.gyro_unit),
            accel_is_gravity: std::mem::take(&mut self.accel_is_gravity),
            without_field: false,
            without_attitude: false,
        }
    }
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// `[gps]`: the GPS receiver.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct GpsSection {
    /// Nominal rate of fixes, Hz; the times in the file determine the actual rate.
    #[serde(deserialize_with = "positive", skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// Position of the antenna relative to the centre of gravity, m.
    #[serde(with = "lever_arm")]
    pub antenna_lever_arm_m: Vector<Body>,
    /// Time from the validity of a fix to its arrival, s, within ±30. In a log, arrival means the time stamp. The
    /// filter receives the fixes of a log at most 0.2 s after their time of validity.
    #[serde(deserialize_with = "latency")]
    pub latency_s: f64,
}

/// `[reference]`: the reference and the scores against it.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct ReferenceSection {
    /// Point whose position and velocity the reference contains.
    pub point: Point,
    /// Description of the reference's accuracy.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub quality: String,
    /// Time from the first inertial sample to the start of scoring, s.
    #[serde(deserialize_with = "skip")]
    pub skip_s: f64,
    /// One-sigma of the reference's own position, each axis, m; scores add it to the filter's sigmas.
    #[serde(deserialize_with = "own_sigma")]
    pub position_sigma_m: f64,
    /// One-sigma of the reference's own velocity, each axis, m/s.
    #[serde(deserialize_with = "own_sigma")]
    pub velocity_sigma_mps: f64,
    /// One-sigma of the reference's own roll, pitch and yaw, degrees.
    #[serde(deserialize_with = "own_sigma")]
    pub attitude_sigma_deg: f64,
}

impl Default for ReferenceSection {
    fn default() -> Self {
        Self {
            point: Point::default(),
            quality: String::new(),
            skip_s: 30.0,
            position_sigma_m: 0.0,
            velocity_sigma_mps: 0.0,
            attitude_sigma_deg: 0.0,
        }
    }
}

/// `[solution]`: settings of the solution.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct SolutionSection {
    /// Point whose position and velocity the solution contains.
    pub point: SolutionPoint,
}

/// Point of a solution's position and velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SolutionPoint {
    /// The centre of gravity.
    #[default]
    Cg,
    /// The inertial unit.
    Imu,
}

impl From<SolutionPoint> for Point {
    fn from(point: SolutionPoint) -> Self {
        match point {
            SolutionPoint::Cg => Self::Cg,
            SolutionPoint::Imu => Self::Imu,
        }
    }
}

/// A point of the vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Point {
    /// The centre of gravity.
    #[default]
    Cg,
    /// The inertial unit.
    Imu,
    /// The GPS antenna.
    Antenna,
}

/// North to which a heading refers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum HeadingReference {
    /// True north.
    #[default]
    True,
    /// Magnetic north: true heading is this plus the declination.
    Magnetic,
}

impl Manifest {
    /// Reads a manifest or configuration, and lists the unknown keys that have no effect.
    ///
    /// # Errors
    /// [`LogError::Toml`], as [`Manifest::parse`].
    pub fn read(path: &Path) -> Result<(Self, Vec<String>), LogError> {
        Self::parse(&hovernav_toml::read_text(path)?, path)
    }

    /// Parses the manifest in `text`, with a warning for each unknown key; `path` names the file in messages.
    ///
    /// # Errors
    /// [`LogError::Toml`] if the text is not TOML, a value is of the wrong kind, or a number is out of range. Also for
    /// an unknown key of `[alignment]`, `[aiding]`, `[filter]` and their subsections: a misspelt setting must not
    /// silently have no effect.
    pub fn parse(text: &str, path: &Path) -> Result<(Self, Vec<String>), LogError> {
        let (manifest, unknown): (Self, _) = hovernav_toml::parse(text, path)?;
        // The line of an error follows from the text, which only this function has.
        manifest
            .overlay(&mut EstimatorConfig::default())
            .map_err(|error| error.in_text(text, path))?;
        let file = path.file_name().unwrap_or_default().to_string_lossy();
        let warning = |key| format!("{file}: key {key} is not known and has no effect");
        Ok((manifest, unknown.into_iter().map(warning).collect()))
    }

    /// This manifest with the keys that `text` sets, the text of a file of the same form; and warnings on its unknown
    /// keys. `config` names the file in messages.
    ///
    /// # Errors
    /// As [`Manifest::parse`].
    pub fn merged_with(&self, text: &str, config: &Path) -> Result<(Self, Vec<String>), LogError> {
        let (_, warnings) = Self::parse(text, config)?;
        let rejected = |reason: &str| TomlError::at(config, "", 0, reason);
        let manifest = hovernav_toml::overlaid(self, hovernav_toml::parse_table(text, config)?)
            .map_err(|error| rejected(&error.to_string()))?;
        Ok((manifest, warnings))
    }

    /// Position of `point` relative to the centre of gravity, m.
    #[must_use]
    pub fn lever_arm_m(&self, point: impl Into<Point>) -> Vector<Body> {
        match point.into() {
            Point::Cg => Vector::ZERO,
            Point::Imu => self.imu.lever_arm_m,
            Point::Antenna => self.gps.antenna_lever_arm_m,
        }
    }
}

fn in_range<'de, D: Deserializer<'de>>(
    deserializer: D,
    range: std::ops::RangeInclusive<f64>,
) -> Result<f64, D::Error> {
    let value = f64::deserialize(deserializer)?;
    if range.contains(&value) {
        return Ok(value);
    }
    let (low, high) = range.into_inner();
    Err(de::Error::custom(format!("found {}, expected {low} to {high}", Readable(value))))
}

fn positive<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    let value = f64::deserialize(deserializer)?;
    if value > 0.0 && value.is_finite() {
        return Ok(Some(value));
    }
    Err(de::Error::custom(format!("found {}, expected a number above 0", Readable(value))))
}

fn declination<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    in_range(deserializer, -180.0..=180.0).map(Some)
}

/// Largest latency of a log, s. It exceeds the 18 s between GPS time and UTC.
pub const LONGEST_LATENCY_S: f64 = 30.0;

fn latency<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    in_range(deserializer, -LONGEST_LATENCY_S..=LONGEST_LATENCY_S)
}

fn mounting<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 3], D::Error> {
    let angles = <[f64; 3]>::deserialize(deserializer)?;
    if angles.iter().all(|angle| angle.abs() <= 360.0) {
        return Ok(principal_deg(angles));
    }
    Err(de::Error::custom(format!("found {angles:?}, expected roll, pitch and yaw within ±360°")))
}

/// The same rotation with roll and yaw within ±180° and pitch within ±90°; such angles stay bit-identical.
fn principal_deg([mut roll, mut pitch, mut yaw]: [f64; 3]) -> [f64; 3] {
    let wrap = |angle: &mut f64| {
        if angle.abs() > 180.0 {
            *angle -= 360.0_f64.copysign(*angle);
        }
    };
    wrap(&mut pitch);
    if pitch.abs() > 90.0 {
        // Pitch beyond the vertical: the nose points backward and roll is turned by half a circle.
        pitch = 180.0_f64.copysign(pitch) - pitch;
        roll += 180.0;
        yaw += 180.0;
    }
    for angle in [&mut roll, &mut yaw] {
        wrap(angle);
        // The angle is up to 540° here.
        wrap(angle);
    }
    [roll, pitch, yaw]
}

fn skip<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    in_range(deserializer, 0.0..=1e6)
}

fn own_sigma<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    in_range(deserializer, 0.0..=1e3)
}

/// A TOML date, bare or in quotes; the reader passes both as text.
fn date<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Datetime>, D::Error> {
    let date = String::deserialize(deserializer).ok().and_then(|text| text.parse().ok());
    match date {
        Some(Datetime { date: Some(_), .. }) => Ok(date),
        _ => Err(de::Error::custom("expected a date such as 2025-07-08")),
    }
}
