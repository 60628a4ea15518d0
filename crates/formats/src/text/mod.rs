//! Text in columns, read with a mapping: CSV, KF-GINS, NaveGo.

mod apply;
mod columns;
pub(crate) mod decimal;
mod gps;
mod layout;
mod lines;
mod mapping;
mod scale;
mod table;
mod together;
mod units;

use std::path::{Path, PathBuf};

use crate::format::Format;
use crate::log::Log;
use hovernav_dataset::{LogError, Manifest, Trajectory};

pub(crate) use apply::dataset;
pub(crate) use decimal::TimeUnit;
pub(crate) use layout::{Delimiter, Layout, is_comment};
pub(crate) use lines::Lines;
pub(crate) use mapping::{
    AttitudeColumns, Axes, BaroColumn, GpsColumns, MAPPING_FILE, Mapping, StickColumns,
    TableMapping, TimeColumn, Triad, VelocityColumns,
};
pub(crate) use scale::TimeScale;
pub(crate) use units::{
    AngleUnit, AttitudeRole, BaroUnit, CourseUnit, ForceUnit, HeightAbove, LengthUnit,
    MagneticUnit, PlaceUnit, RateUnit, SpeedUnit, StickUnit, World,
};

/// Reads the files listed in the mapping `path`, or in the mapping of the directory `path`.
///
/// # Errors
/// [`LogError`]; for text without a mapping, an error that points to `hovernav init`.
pub(crate) fn read(path: &Path) -> Result<Log, LogError> {
    if path.is_file() && !is_mapping(path)? {
        let directory = directory_of(path);
        if directory.join("dataset.toml").is_file() {
            let reason = format!(
                "found one file of a dataset, expected its directory, {}",
                directory.display()
            );
            return Err(LogError::Unusable { path: path.to_path_buf(), reason });
        }
        let reason = format!(
            "found text with unknown columns. Run `hovernav init {}` to map them",
            path.display()
        );
        return Err(LogError::Unusable { path: path.to_path_buf(), reason });
    }
    let (file, mapping, manifest, warnings) = mapped(path)?;
    let (mut dataset, onboard) = dataset(directory_of(&file), &mapping, manifest, warnings)?;
    // The manifest contains the mounting angles of the IMU, which a mapping does not.
    dataset.normalise_imu();
    Ok(Log::of(Format::Text, dataset, onboard))
}

/// Reads the files listed in a mapping as a trajectory, in time order; missing values are NaN.
///
/// # Errors
/// [`LogError`] if the mapping or a file cannot be read, or the files contain neither position nor attitude.
pub fn trajectory(path: &Path) -> Result<Trajectory, LogError> {
    let (file, mapping, manifest, warnings) = mapped(path)?;
    apply::trajectory(directory_of(&file), &mapping, &manifest, warnings)
}

/// The mapping at `path` or in the directory `path`: its file, the mapping, the manifest next to it, and warnings.
fn mapped(path: &Path) -> Result<(PathBuf, Mapping, Manifest, Vec<String>), LogError> {
    let file = if path.is_dir() { path.join(MAPPING_FILE) } else { path.to_path_buf() };
    let (mapping, mut warnings) = mapping::Mapping::read(&file)?;
    let manifest = manifest(directory_of(&file), &mut warnings)?;
    Ok((file, mapping, manifest, warnings))
}

/// The directory to which a mapping's file paths are relative.
fn directory_of(mapping: &Path) -> &Path {
    mapping.parent().unwrap_or(Path::new("."))
}

/// The `dataset.toml` in the directory of a mapping.
fn manifest(directory: &Path, warnings: &mut Vec<String>) -> Result<Manifest, LogError> {
    let path = directory.join("dataset.toml");
    let mut manifest = Manifest::default();
    if path.exists() {
        let (read, unknown) = Manifest::read(&path)?;
        warnings.extend(unknown);
        manifest = read;
    } else {
        warnings.push("dataset.toml: not found, every key has its default".into());
    }
    if manifest.name.is_empty() {
        let name = directory.canonicalize().unwrap_or_else(|_| directory.to_path_buf());
        manifest.name = name.file_name().unwrap_or_default().to_string_lossy().into_owned();
    }
    Ok(manifest)
}

/// Whether a text file is a mapping: one of its first 200 lines is `[[table]]`.
fn is_mapping(path: &Path) -> Result<bool, LogError> {
    /// A mapping begins with at most this many lines of comments.
    const LINES: u64 = 200;
    let mut lines = Lines::open(path)?;
    while lines.number() < LINES
        && let Some(line) = lines.next()?
    {
        if line.trim_ascii() == b"[[table]]" {
            return Ok(true);
        }
    }
    Ok(false)
}
