//! `dataset.toml`: what a vehicle and its sensors are.

use std::path::Path;

use serde::{Deserialize, Deserializer, Serialize, de};
use toml::value::Datetime;

use crate::aid_sections::{RangefinderSection, SecondAntennaSection, notch};
use crate::axes::{AccelUnit, Axes, GyroUnit, Reading, rotation_of};
use crate::error::LogError;
use crate::lever_arm;
use hovernav::ekf::EstimatorConfig;
use hovernav::frames::{Body, Vector};
use hovernav::imu::NotchConfig;
use hovernav::scalar::Readable;
use hovernav_toml::TomlError;

/// The manifest's file in a dataset directory.
pub(crate) const MANIFEST_FILE: &str = "dataset.toml";

/// `dataset.toml`: what the vehicle is, how its sensors are mounted and how good they are.
///
/// Every key has a default. Lever arms lead from the centre of gravity, in body axes.
///
/// ```
/// use hovernav_log::Manifest;
/// let text = "name = 'hop'\n[gps]\nantenna_lever_arm_m = [-0.35, 0, 0.2]\nlatency = 0.1\n";
/// let (manifest, warnings) = Manifest::parse(text, "dataset.toml".as_ref())?;
/// assert_eq!(manifest.gps.antenna_lever_arm_m.x(), -0.35);
/// assert_eq!(warnings, ["dataset.toml: key gps.latency is not known and has no effect"]);
/// # Ok::<(), hovernav_log::LogError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct Manifest {
    /// Name of the dataset.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// The vehicle and what it did.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub vehicle: String,
    /// `recorded` or `simulated`.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub kind: String,
    /// Where the data come from.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub origin: String,
    /// The terms they come under.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub licence: String,
    /// A note on the clock.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub time: String,
    /// Day of the flight, which the magnetic model asks for; with a time of day, when the log's clock reads zero, in
    /// UTC, which the dates in exports ask for.
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
    /// The reference to score against.
    pub reference: ReferenceSection,
    /// What the solution speaks of.
    pub solution: SolutionSection,
    /// Settings of the alignment, as found.
    #[serde(skip_serializing_if = "toml::Table::is_empty")]
    pub alignment: toml::Table,
    /// Settings of the aiding, as found.
    #[serde(skip_serializing_if = "toml::Table::is_empty")]
    pub aiding: toml::Table,
    /// Settings of the filter, as found.
    #[serde(skip_serializing_if = "toml::Table::is_empty")]
    pub filter: toml::Table,
}

/// `[imu]`: the inertial unit.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct ImuSection {
    /// Nominal sample rate, Hz; the times in the file are what counts.
    #[serde(deserialize_with = "positive", skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// The unit from the centre of gravity, m.
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
    /// What the unit's own yaw is measured from.
    pub heading_reference: HeadingReference,
    /// Magnetic declination at the site, east positive, °; where absent, the magnetic model's.
    #[serde(deserialize_with = "declination", skip_serializing_if = "Option::is_none")]
    pub magnetic_declination_deg: Option<f64>,
    /// Full scale of the gyros, °/s.
    #[serde(deserialize_with = "positive", skip_serializing_if = "Option::is_none")]
    pub gyro_range_degps: Option<f64>,
    /// Full scale of the accelerometers, g.
    #[serde(deserialize_with = "positive", skip_serializing_if = "Option::is_none")]
    pub accel_range_g: Option<f64>,
    /// Where the axes x, y, z of `imu.csv` point; forward, right, down (`frd`) in memory. The unit's own
    /// roll, pitch and yaw are not turned.
    #[serde(skip_serializing_if = "Axes::are_body")]
    pub axes: Axes,
    /// Roll, pitch and yaw of the unit in the vehicle, °: by how much its axes, once they are forward,
    /// right and down by `axes`, are turned from the vehicle's; each within ±360, 270 is −90. Samples, field and
    /// the unit's own attitude are turned back by it.
    #[serde(deserialize_with = "mounting", skip_serializing_if = "is_default")]
    pub mounting_deg: [f64; 3],
    /// The unit of the accelerations in `imu.csv`, whatever its columns are called.
    #[serde(skip_serializing_if = "is_default")]
    pub accel_unit: AccelUnit,
    /// The unit of the angular rates in `imu.csv`.
    #[serde(skip_serializing_if = "is_default")]
    pub gyro_unit: GyroUnit,
    /// Whether the accelerations in `imu.csv` have the sign of gravity, down at rest, and not that of
    /// specific force.
    #[serde(skip_serializing_if = "is_default")]
    pub accel_is_gravity: bool,
    /// A notch that takes the rotor's vibration out of the samples: at one frequency, or at that of `rotor.csv`.
    #[serde(deserialize_with = "notch", skip_serializing_if = "Option::is_none")]
    pub notch: Option<NotchConfig>,
}

impl ImuSection {
    /// How samples have to be read, which from now on are as they should be.
    pub(crate) fn take_reading(&mut self) -> Reading {
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

/// `[gps]`: the receiver.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct GpsSection {
    /// Nominal rate of fixes, Hz; the times in the file are what counts.
    #[serde(deserialize_with = "positive", skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// The antenna from the centre of gravity, m.
    #[serde(with = "lever_arm")]
    pub antenna_lever_arm_m: Vector<Body>,
    /// How much earlier than its arrival a fix is valid, s, within ±10; in a log, than its time stamp, where the filter is
    /// given it no later than 0.2 s after it was valid.
    #[serde(deserialize_with = "latency")]
    pub latency_s: f64,
}

/// `[reference]`: what to score against, and how.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct ReferenceSection {
    /// Whose position and velocity the reference gives.
    pub point: Point,
    /// How good the reference is.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub quality: String,
    /// How long after the first inertial sample scoring begins, s.
    #[serde(deserialize_with = "skip")]
    pub skip_s: f64,
    /// One-sigma of the reference's own position, each axis, m; what it errs is not held against the filter's sigmas.
    #[serde(deserialize_with = "own_sigma")]
    pub position_sigma_m: f64,
    /// One-sigma of its own velocity, each axis, m/s.
    #[serde(deserialize_with = "own_sigma")]
    pub velocity_sigma_mps: f64,
    /// One-sigma of its own roll, pitch and yaw, degrees.
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

/// `[solution]`: what the solution speaks of.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct SolutionSection {
    /// Whose position and velocity the solution gives.
    pub point: SolutionPoint,
}

/// A point whose position and velocity a solution can give.
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

/// The north that a heading is measured from.
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
    /// Reads a manifest or configuration, and lists the keys it does not know where those have no effect.
    ///
    /// # Errors
    /// [`LogError::Toml`], as [`Manifest::parse`].
    pub fn read(path: &Path) -> Result<(Self, Vec<String>), LogError> {
        Self::parse(&hovernav_toml::read_text(path)?, path)
    }

    /// The manifest that `text` spells, and a warning for each key it does not know; `path` names it
    /// in messages.
    ///
    /// # Errors
    /// [`LogError::Toml`] where the text is not TOML, a value is not of its key's kind, or a number
    /// is out of its range, and for an unknown key of `[alignment]`, `[aiding]`, `[filter]` and the sections below it:
    /// settings that somebody believes in must not be without effect.
    pub fn parse(text: &str, path: &Path) -> Result<(Self, Vec<String>), LogError> {
        let (manifest, unknown): (Self, _) = hovernav_toml::parse(text, path)?;
        // Only here is the text at hand that tells the line.
        manifest
            .overlay(&mut EstimatorConfig::default())
            .map_err(|error| error.in_text(text, path))?;
        let file = path.file_name().unwrap_or_default().to_string_lossy();
        let warning = |key| format!("{file}: key {key} is not known and has no effect");
        Ok((manifest, unknown.into_iter().map(warning).collect()))
    }

    /// This manifest with the keys that the file `config`, of the same form, sets; and what of that
    /// file is not known.
    ///
    /// # Errors
    /// As [`Manifest::read`].
    pub fn merged_with(&self, config: &Path) -> Result<(Self, Vec<String>), LogError> {
        let text = hovernav_toml::read_text(config)?;
        let (_, warnings) = Self::parse(&text, config)?;
        let refused = |reason: &str| TomlError::at(config, "", 0, reason);
        let manifest = hovernav_toml::overlaid(self, hovernav_toml::parse_table(&text, config)?)
            .map_err(|error| refused(&error.to_string()))?;
        Ok((manifest, warnings))
    }

    /// Where `point` is from the centre of gravity, m.
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

/// No latency of a log is longer, s.
pub(crate) const LONGEST_LATENCY_S: f64 = 10.0;

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

/// The same turn with roll and yaw within ±180° and pitch within ±90°; angles that are so already keep their bits.
fn principal_deg([mut roll, mut pitch, mut yaw]: [f64; 3]) -> [f64; 3] {
    let wrap = |angle: &mut f64| {
        if angle.abs() > 180.0 {
            *angle -= 360.0_f64.copysign(*angle);
        }
    };
    wrap(&mut pitch);
    if pitch.abs() > 90.0 {
        // Over the top: the nose points back, the unit lies on its other side.
        pitch = 180.0_f64.copysign(pitch) - pitch;
        roll += 180.0;
        yaw += 180.0;
    }
    for angle in [&mut roll, &mut yaw] {
        wrap(angle);
        // Up to 540° by now.
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

/// A date as TOML writes it, bare or in quotes; the reader hands on both as text.
fn date<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Datetime>, D::Error> {
    let date = String::deserialize(deserializer).ok().and_then(|text| text.parse().ok());
    match date {
        Some(Datetime { date: Some(_), .. }) => Ok(date),
        _ => Err(de::Error::custom("expected a date such as 2025-07-08")),
    }
}
