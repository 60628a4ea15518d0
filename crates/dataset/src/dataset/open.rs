//! Opening a dataset directory.

use std::path::Path;

use crate::clock::ordered::TimedRows as _;
use crate::clock::steps::ClockSteps;
use crate::dataset::Dataset;
use crate::error::LogError;
use crate::manifest::{MANIFEST_FILE, Manifest};
use crate::sensors::imu::{self, ImuRows};
use crate::sensors::sample_file::{self, Opened};
use crate::sensors::{aids, auxiliary, controls, gps};
use hovernav::time::Time;
use hovernav_toml::TomlError;

impl Dataset {
    /// Reads the dataset in the directory `dir`. Does not read `reference.csv`.
    ///
    /// Skips rows without a time or a required value, rows out of time order, and rows beyond any vehicle's motion;
    /// [`Dataset::warnings`] counts each kind. An unknown sigma or attitude is `None`.
    ///
    /// # Errors
    /// A file instead of a directory, a missing or empty `imu.csv`, missing columns, text instead of a number. A clock
    /// that does not run forward, an invalid manifest. See [`LogError`].
    pub fn open(dir: &Path) -> Result<Self, LogError> {
        Self::open_within(dir, usize::MAX)
    }

    /// [`open`](Self::open) with bounded memory. If there are more than `most` inertial samples, they stay in their
    /// file, and likewise the rows of `controls.csv`. Each pass over them reads the file again, so the file must not
    /// change.
    ///
    /// If time goes back in a file, opening it needs memory for the times of all rows.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_within(dir: &Path, most: usize) -> Result<Self, LogError> {
        if dir.is_file() {
            let reason = "found a file, expected the directory of a dataset".into();
            return Err(LogError::Unusable { path: dir.to_path_buf(), reason });
        }
        let (mut manifest, mut warnings) = Self::manifest_of(dir)?;
        let reading = manifest.imu.take_reading();
        let mut steps = ClockSteps::default();
        let imu = sample_file::open(dir, reading, most, &mut steps, &mut warnings)?;
        let (imu, imu_file) = match imu {
            Opened::InMemory(samples) => (samples, None),
            Opened::InFile(file) => (Vec::new(), Some(file)),
        };
        let fixes = gps::read(dir, manifest.gps.latency_s, &mut steps, &mut warnings)?;
        let baro = auxiliary::read_baro(dir, &mut steps, &mut warnings)?;
        let magnetometer = auxiliary::read_magnetometer(dir, &mut steps, &mut warnings)?;
        let headings = aids::read_headings(dir, &mut steps, &mut warnings)?;
        let ranges = aids::read_ranges(dir, &mut steps, &mut warnings)?;
        let rotor = aids::read_rotor(dir, &mut steps, &mut warnings)?;
        let controls = controls::read(dir, most, &mut steps, &mut warnings)?;
        Ok(Self {
            manifest,
            imu,
            imu_file,
            fixes,
            baro,
            magnetometer,
            headings,
            ranges,
            rotor,
            controls: controls.sticks,
            injected: controls.injected,
            controls_file: controls.file,
            warnings,
            ..Self::default()
        })
    }

    /// Manifest of the dataset in the directory `dir`, with notes on it, one sentence each. Without a manifest every
    /// key has its default.
    ///
    /// # Errors
    /// [`LogError::Toml`] if it cannot be read or is not valid.
    pub fn manifest_of(dir: &Path) -> Result<(Manifest, Vec<String>), LogError> {
        let manifest = dir.join(MANIFEST_FILE);
        let (mut manifest, warnings) = match Manifest::read(&manifest) {
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
        Ok((manifest, warnings))
    }

    /// Time of the first inertial sample of the dataset in the directory `dir`, from which `[reference] skip_s` counts;
    /// `None` without samples.
    ///
    /// # Errors
    /// As [`open`](Self::open), for `dataset.toml` and the first rows of `imu.csv`.
    pub fn first_sample_of(dir: &Path) -> Result<Option<Time>, LogError> {
        if !dir.join(imu::FILE).exists() {
            return Ok(None);
        }
        let reading = Self::manifest_of(dir)?.0.imu.take_reading();
        Ok(ImuRows::open(dir, reading)?.next()?.map(|(_, sample)| sample.time))
    }
}
