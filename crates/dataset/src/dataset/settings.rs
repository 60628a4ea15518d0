//! The estimator's settings from a manifest.

use std::fmt;
use std::path::Path;

use serde::Serialize;
use serde::de::{DeserializeOwned, Error as _};

use crate::dataset::Dataset;
use crate::error::LogError;
use crate::magnetic_field::{MagneticField, decimal_year};
use crate::manifest::axes::Reading;
use crate::manifest::{HeadingReference, MANIFEST_FILE, Manifest, Point};
use hovernav::earth::{Geodetic, STANDARD_GRAVITY_MPS2};
use hovernav::ekf::{EstimatorConfig, OutOfRange};
use hovernav::ins::{AlignmentConfig, Mounting};
use hovernav::scalar::Readable;
use hovernav_toml::{TomlError, ValueError};

impl Dataset {
    /// The estimator's settings for this dataset: see [`Manifest::settings`]. Magnetic headings are corrected by the
    /// declination at the first fix. A note states the origin of the declination; a
    /// warning states that it is unknown.
    ///
    /// # Errors
    /// As [`Manifest::settings`].
    pub fn settings(&mut self) -> Result<EstimatorConfig, LogError> {
        let (config, remark) = self.configuration()?;
        match remark {
            Some(Declination::Model(note)) => self.notes.push(note),
            Some(Declination::None(warning)) => self.warnings.push(warning),
            None => {}
        }
        Ok(config)
    }

    /// The settings, with the origin of the declination: see [`Manifest::settings`].
    ///
    /// # Errors
    /// As [`Manifest::settings`].
    pub fn configuration(&self) -> Result<(EstimatorConfig, Option<Declination>), LogError> {
        let magnetic = !self.magnetometer.is_empty() || self.has_magnetic_samples();
        let place = self.fixes.first().map(|fix| fix.position);
        self.manifest.settings(magnetic, place.as_ref())
    }

    /// Overrides keys of the manifest by those of the file `config`, and shifts the fixes if their latency changes.
    ///
    /// # Errors
    /// As [`Manifest::merged_with`], and for a file that cannot be read.
    pub fn configure(&mut self, config: &Path) -> Result<(), LogError> {
        self.configure_with(&hovernav_toml::read_text(config)?, config)
    }

    /// [`configure`](Self::configure) with the `text` of a settings file; `config` names it in messages.
    ///
    /// # Errors
    /// As [`Manifest::merged_with`].
    pub fn configure_with(&mut self, text: &str, config: &Path) -> Result<(), LogError> {
        let (manifest, warnings) = self.manifest.merged_with(text, config)?;
        self.warnings.extend(warnings);
        let (before_s, after_s) = (self.manifest.gps.latency_s, manifest.gps.latency_s);
        for fix in &mut self.fixes {
            fix.time = fix.time.offset_by(before_s).offset_by(-after_s);
        }
        let mut probe = Self { manifest, ..Self::default() };
        probe.settings().map_err(|error| match error {
            LogError::Toml(TomlError::Text { line, reason, .. }) => {
                TomlError::Text { path: config.to_path_buf(), line, reason }.into()
            }
            other => other,
        })?;
        self.manifest = probe.manifest;
        self.normalise_imu();
        Ok(())
    }

    /// Converts inertial samples by the manifest's `axes`, `mounting_deg`, `accel_unit`, `gyro_unit` and
    /// `accel_is_gravity` to the vehicle's forward, right, down, rad/s and m/s². Then resets these keys, as the samples
    /// are converted.
    pub fn normalise_imu(&mut self) {
        let reading = self.manifest.imu.take_reading();
        self.turn(reading);
    }

    /// Removes the magnetic field from every inertial sample.
    pub fn remove_sample_fields(&mut self) {
        self.turn(Reading { without_field: true, ..Reading::default() });
    }

    /// Removes the inertial unit's own attitude from every inertial sample.
    pub fn remove_sample_attitudes(&mut self) {
        self.turn(Reading { without_attitude: true, ..Reading::default() });
    }

    /// Converts every inertial sample by `reading` (axes, units), in addition to the earlier conversions.
    fn turn(&mut self, reading: Reading) {
        for sample in &mut self.imu {
            *sample = reading.applied(*sample);
        }
        if let Some(file) = &mut self.imu_file {
            file.turn(reading);
        }
    }
}

impl Manifest {
    /// The estimator's settings for a vehicle. They begin with the defaults. The manifest's mounting and sensors
    /// override them, and then the keys of its sections `[alignment]`, `[aiding]` and `[filter.*]`.
    ///
    /// `magnetic` is whether there is a magnetometer. If there is one, or if the inertial unit's heading is magnetic,
    /// the filter needs the declination. The World Magnetic Model gives it at `place` if the manifest has none. The
    /// remark states the date of the model, or why the model gives no declination.
    ///
    /// # Errors
    /// [`LogError::Toml`] for an unknown key or an invalid value in those sections.
    pub fn settings(
        &self,
        magnetic: bool,
        place: Option<&Geodetic>,
    ) -> Result<(EstimatorConfig, Option<Declination>), LogError> {
        let mut config = EstimatorConfig::default();
        let (imu, cg) = (&self.imu, self.lever_arm_m(self.solution.point));
        config.vehicle_kind = self.vehicle_kind;
        let model = &mut config.ekf.imu;
        // °/√h to rad/√s and m/s/√h to m/s/√s: the square root of an hour is 60 √s.
        set(
            &mut model.angle_random_walk_rad,
            imu.angle_random_walk_deg_per_sqrt_h.map(|walk| walk.to_radians() / 60.0),
        );
        set(
            &mut model.velocity_random_walk_mps,
            imu.velocity_random_walk_mps_per_sqrt_h.map(|walk| walk / 60.0),
        );
        set(&mut model.gyro_bias_sigma_radps, imu.gyro_bias_sigma_degps.map(f64::to_radians));
        set(&mut model.accel_bias_sigma_mps2, imu.accel_bias_sigma_mps2);
        set(&mut model.gyro_range_radps, imu.gyro_range_degps.map(f64::to_radians));
        set(
            &mut model.accel_range_mps2,
            imu.accel_range_g.map(|range_g| range_g * STANDARD_GRAVITY_MPS2),
        );

        self.overlay(&mut config).map_err(|error| rejected(&error.to_string()))?;

        config.mounting = Mounting::default()
            .with_imu_lever_arm_m(self.lever_arm_m(Point::Imu) - cg)
            .with_antenna_lever_arm_m(self.lever_arm_m(Point::Antenna) - cg);

        config.rangefinder.lever_arm_m = self.rangefinder.lever_arm_m - cg;
        config.rangefinder.beam = self.rangefinder.beam;
        config.alignment.baseline_m =
            self.second_antenna.baseline_m(self.lever_arm_m(Point::Antenna));

        let attitude_magnetic = imu.heading_reference == HeadingReference::Magnetic;
        // A declared declination applies to any data, so that settings before and after a flight are equal.
        if !magnetic && !attitude_magnetic && imu.magnetic_declination_deg.is_none() {
            return Ok((config, None));
        }
        let (declination_rad, remark) = match (imu.magnetic_declination_deg, place) {
            (Some(declination_deg), _) => (declination_deg.to_radians(), None),
            (None, None) => (0.0, None),
            (None, Some(place)) => {
                let (declination_rad, remark) = model_declination(self, place);
                (declination_rad, Some(remark))
            }
        };
        config.alignment.declination_rad = declination_rad;
        if attitude_magnetic {
            config.alignment.attitude_declination_rad = declination_rad;
        }
        Ok((config, remark))
    }
}

impl Manifest {
    /// Applies the sections `[alignment]`, `[aiding]` and `[filter.*]` to `config`.
    ///
    /// # Errors
    /// An unknown key, or a value of the wrong kind or out of range, also in the aids' models.
    pub(crate) fn overlay(&self, config: &mut EstimatorConfig) -> Result<(), ValueError> {
        config.alignment = overlaid(&config.alignment, &self.alignment)
            .and_then(within_range)
            .map_err(|error| error.below("alignment"))?;
        config.aiding =
            overlaid(&config.aiding, &self.aiding).map_err(|error| error.below("aiding"))?;
        let ekf = &mut config.ekf;
        for (key, value) in &self.filter {
            let mut of_section = || {
                let section = value.as_table().ok_or_else(|| {
                    ValueError::custom(format_args!("found {value}, expected a section"))
                })?;
                match key.as_str() {
                    "imu" => ekf.imu = overlaid(&ekf.imu, section)?,
                    "gps" => ekf.gps = overlaid(&ekf.gps, section)?,
                    "attitude" => ekf.attitude = overlaid(&ekf.attitude, section)?,
                    "magnetometer" => ekf.magnetometer = overlaid(&ekf.magnetometer, section)?,
                    "baro" => ekf.baro = overlaid(&ekf.baro, section)?,
                    "gate" => ekf.gate = overlaid(&ekf.gate, section)?,
                    "mechanisms" => ekf.mechanisms = overlaid(&ekf.mechanisms, section)?,
                    _ => return Err(ValueError::unknown_field(key, FILTER_SECTIONS)),
                }
                Ok(())
            };
            of_section().map_err(|error: ValueError| error.below(key).below("filter"))?;
        }
        config.rangefinder.model = self.rangefinder.model;
        config.antenna_heading = self.second_antenna.model;
        config.out_of_range().map_or(Ok(()), |OutOfRange { group, name, found, expected }| {
            let (outer, inner) = group.split_once('.').unwrap_or(("filter", group));
            let reason = format!("found {}, expected {expected}", Readable(found));
            Err(ValueError::of_key(name, &reason).below(inner).below(outer))
        })
    }
}

/// Subsections of `[filter]`.
const FILTER_SECTIONS: &[&str] =
    &["imu", "gps", "attitude", "magnetometer", "baro", "gate", "mechanisms"];

/// Checks that the numbers of `aligned` are within their ranges.
fn within_range(aligned: AlignmentConfig) -> Result<AlignmentConfig, ValueError> {
    for (key, value, most) in [
        ("duration_s", aligned.duration_s, 600.0),
        ("attitude_tilt_sigma_rad", aligned.attitude_tilt_sigma_rad, 3.0),
        ("heading_sigma_rad", aligned.heading_sigma_rad, 3.0),
        ("level_sigma_rad", aligned.level_sigma_rad, 3.0),
        ("moving_level_sigma_rad", aligned.moving_level_sigma_rad, 3.0),
        ("position_sigma_m", aligned.position_sigma_m, 1e6),
        ("velocity_sigma_mps", aligned.velocity_sigma_mps, 1e3),
        ("course_speed_mps", aligned.course_speed_mps, 1e3),
    ] {
        if !(0.0..=most).contains(&value) {
            let reason = format!("found {}, expected 0 to {most}", Readable(value));
            return Err(ValueError::of_key(key, &reason));
        }
    }
    Ok(aligned)
}

/// Origin of a declination that was not declared, in a sentence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Declination {
    /// From the World Magnetic Model.
    Model(String),
    /// The model gives no declination, so 0 is used.
    None(String),
}

impl fmt::Display for Declination {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Self::Model(sentence) | Self::None(sentence)) = self;
        f.write_str(sentence)
    }
}

/// Declination, rad, and its origin. If the date of the flight is unknown or not covered, the start of 2025 replaces
/// it: declination changes by about 0.1° a year.
fn model_declination(manifest: &Manifest, place: &Geodetic) -> (f64, Declination) {
    let date = manifest.date.and_then(|date| date.date);
    let year = date.map(|date| decimal_year(date.year, date.month, date.day));
    let at = |year| MagneticField::at(place, year).map(|field| field.declination_rad());
    let (found, day) = match (date, year.map(at)) {
        (Some(date), Some(Ok(found))) => (Ok(found), date.to_string()),
        (Some(date), _) => {
            (at(2025.0), format!("2025-01-01, because the model is not valid on {date}"))
        }
        (None, _) => (at(2025.0), "2025-01-01, because the log has no date".to_owned()),
    };
    match found {
        Ok(declination_rad) => {
            let declination_deg = declination_rad.to_degrees();
            let model = "by the World Magnetic Model for";
            let text = format!("magnetic declination {declination_deg:.2}° {model} {day}");
            (declination_rad, Declination::Model(text))
        }
        Err(_) => {
            let text = "magnetic declination 0° used: the World Magnetic Model has none here";
            (0.0, Declination::None(text.to_owned()))
        }
    }
}

fn set(setting: &mut f64, value: Option<f64>) {
    if let Some(value) = value {
        *setting = value;
    }
}

fn rejected(reason: &str) -> LogError {
    TomlError::at(MANIFEST_FILE.as_ref(), "", 0, reason).into()
}

/// `base` overridden by the keys of a configuration's section.
fn overlaid<S: Clone + Serialize + DeserializeOwned>(
    base: &S,
    section: &toml::Table,
) -> Result<S, ValueError> {
    if section.is_empty() {
        return Ok(base.clone());
    }
    hovernav_toml::overlaid(base, section.clone())
}
