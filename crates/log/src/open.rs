//! Opening a log: a dataset directory, or a flight record.

use std::path::Path;

use crate::dataset::Dataset;
use crate::error::LogError;
use crate::imu::{self, ImuRows};
use crate::manifest::{MANIFEST_FILE, Manifest};
use crate::ordered::TimedRows as _;
use crate::record::Record;
use crate::sample_file::{self, Opened};
use crate::{aids, auxiliary, controls, gps};
use hovernav::time::Time;
use hovernav_toml::TomlError;

/// The dataset that `log` is, a directory or a flight record, and the record itself if it is one. Of a directory
/// at most `most` inertial samples and rows of controls are held in memory: see [`Dataset::open_within`].
///
/// # Errors
/// [`LogError`] where the log cannot be read, with file and line or byte.
pub fn open(log: &Path, most: usize) -> Result<(Dataset, Option<Record>), LogError> {
    if !Record::is_mcap(log) {
        return Ok((Dataset::open_within(log, most)?, None));
    }
    let record = Record::open(log)?;
    Ok((record.dataset()?, Some(record)))
}

impl Dataset {
    /// Reads the dataset in the directory `log`, or what the sensors sent in the flight record `log`.
    /// A `reference.csv` stays unread.
    ///
    /// Rows without a time or a value they need, out of time order, or beyond any vehicle's motion are
    /// left out, and [`Dataset::warnings`] names each kind; an unknown sigma or attitude is `None`.
    ///
    /// # Errors
    /// A missing or empty `imu.csv`, missing columns, text where a number should stand, a clock that
    /// does not run forward, a manifest that is not valid, a file that is no flight record: see
    /// [`LogError`].
    pub fn open(log: &Path) -> Result<Self, LogError> {
        Self::open_within(log, usize::MAX)
    }

    /// [`open`](Self::open), a directory's inertial samples left in their file where there are more than `most`,
    /// and so the rows of `controls.csv`: the memory that the dataset takes does not grow with them. Each time that
    /// they are gone over the file is read anew, so it has to stay as it is.
    ///
    /// Where time goes back in a file, the times of all rows are in memory while it is opened.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_within(log: &Path, most: usize) -> Result<Self, LogError> {
        if log.is_file() { Self::open_file(log) } else { Self::open_directory(log, most) }
    }

    fn open_file(path: &Path) -> Result<Self, LogError> {
        Record::open(path)?.dataset()
    }

    /// The manifest of the dataset in the directory `dir`, every key at its default where there is none,
    /// and what is to be said of it, one plain sentence each.
    ///
    /// # Errors
    /// [`LogError::Toml`] where it cannot be read or is not valid.
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

    /// When the inertial samples of the dataset in the directory `dir` begin, from where `[reference] skip_s` counts;
    /// `None` where it has none.
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

    fn open_directory(dir: &Path, most: usize) -> Result<Self, LogError> {
        let (mut manifest, mut warnings) = Self::manifest_of(dir)?;
        let reading = manifest.imu.take_reading();
        let (imu, imu_file) = match sample_file::open(dir, reading, most, &mut warnings)? {
            Opened::InMemory(samples) => (samples, None),
            Opened::InFile(file) => (Vec::new(), Some(file)),
        };
        let fixes = gps::read(dir, manifest.gps.latency_s, &mut warnings)?;
        let baro = auxiliary::read_baro(dir, &mut warnings)?;
        let magnetometer = auxiliary::read_magnetometer(dir, &mut warnings)?;
        let headings = aids::read_headings(dir, &mut warnings)?;
        let ranges = aids::read_ranges(dir, &mut warnings)?;
        let rotor = aids::read_rotor(dir, &mut warnings)?;
        let controls = controls::read(dir, most, &mut warnings)?;
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
}
