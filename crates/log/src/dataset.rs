//! A dataset directory: `dataset.toml`, `imu.csv` and whatever lies beside them.

use std::path::Path;

use super::error::LogError;
use super::manifest::Manifest;
use super::{auxiliary, gps, imu};
use hovernav::frames::{Body, Vector};
use hovernav::gps::Fix;
use hovernav::imu::ImuSample;
use hovernav::time::Time;
use hovernav_toml::TomlError;

/// The manifest's file in a dataset directory.
pub(super) const MANIFEST_FILE: &str = "dataset.toml";

/// What a dataset holds events of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// [`Dataset::imu`].
    Imu,
    /// [`Dataset::fixes`].
    Gps,
    /// [`Dataset::baro`].
    Baro,
    /// [`Dataset::magnetometer`].
    Magnetometer,
}

/// A recorded flight in memory, in time order, and what was wrong with its files.
#[derive(Clone, Debug, Default)]
pub struct Dataset {
    /// What it is and how it was mounted.
    pub manifest: Manifest,
    /// Inertial samples, times strictly increasing.
    pub imu: Vec<ImuSample>,
    /// Fixes, times of validity strictly increasing.
    pub fixes: Vec<Fix>,
    /// Barometric heights, m.
    pub baro: Vec<(Time, f64)>,
    /// Samples of a magnetometer apart from the inertial unit, gauss.
    pub magnetometer: Vec<(Time, Vector<Body>)>,
    /// Stick positions: lateral, longitudinal, collective, pedal, each −1…1 about trim.
    pub controls: Vec<(Time, [f64; 4])>,
    /// Whose event came next, from the first to the last; a flight record knows. Where it does not
    /// tell of as many as there are, the events' times do.
    pub order: Vec<Source>,
    /// What was repaired or left out while reading, one plain sentence each.
    pub warnings: Vec<String>,
}

impl Dataset {
    /// Reads the dataset in the directory `log`, or what the sensors said in the flight record `log`,
    /// with the feature `record`. A `reference.csv` stays unread.
    ///
    /// Rows without a time or a value they need, out of time order, or beyond any vehicle's motion are
    /// left out; an unknown sigma or attitude is `None`. [`Dataset::warnings`] tells of each kind.
    ///
    /// # Errors
    /// A missing or empty `imu.csv`, missing columns, text where a number should stand, a clock that
    /// does not run forward, a manifest that is not valid, a file that is no flight record: see
    /// [`LogError`].
    pub fn open(log: &Path) -> Result<Self, LogError> {
        if log.is_file() { Self::open_file(log) } else { Self::open_directory(log) }
    }

    fn open_file(path: &Path) -> Result<Self, LogError> {
        super::record::Record::open(path)?.dataset()
    }

    fn open_directory(dir: &Path) -> Result<Self, LogError> {
        let manifest = dir.join(MANIFEST_FILE);
        let (mut manifest, mut warnings) = match Manifest::read(&manifest) {
            Err(LogError::Toml(TomlError::Io { source, .. }))
                if source.kind() == std::io::ErrorKind::NotFound =>
            {
                let defaults = format!("{MANIFEST_FILE}: no such file, so defaults for every key");
                (Manifest::default(), vec![defaults])
            }
            read => read?,
        };
        if manifest.name.is_empty() {
            manifest.name = dir.file_name().unwrap_or_default().to_string_lossy().into_owned();
        }
        let imu = imu::read(dir, &mut warnings)?;
        let fixes = gps::read(dir, manifest.gps.latency_s, &mut warnings)?;
        let baro = auxiliary::read_baro(dir, &mut warnings)?;
        let magnetometer = auxiliary::read_magnetometer(dir, &mut warnings)?;
        let controls = auxiliary::read_controls(dir, &mut warnings)?;
        let order = Vec::new();
        Ok(Self { manifest, imu, fixes, baro, magnetometer, controls, order, warnings })
    }

    /// Overrides keys of the manifest with those of the file `config`, and moves the fixes where that
    /// changes their latency.
    ///
    /// # Errors
    /// As [`Manifest::merged_with`].
    pub fn configure(&mut self, config: &Path) -> Result<(), LogError> {
        let (manifest, warnings) = self.manifest.merged_with(config)?;
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
        Ok(())
    }
}
