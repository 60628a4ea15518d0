//! Opening any log.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use crate::format::{Format, HEAD, looks_like};
use crate::onboard::Onboard;
use crate::window::Input;
use hovernav_log::record::Record;
use hovernav_log::{Dataset, LogError};

/// What to take where a log leaves a choice.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Options {
    /// Which inertial unit, counted as the log counts them; unless given, the first or the one with
    /// most samples.
    pub imu: Option<usize>,
    /// Which GPS receiver, likewise.
    pub gps: Option<usize>,
    /// Which magnetometer, likewise.
    pub magnetometer: Option<usize>,
    /// Which barometer, likewise.
    pub baro: Option<usize>,
    /// Which topic of a ROS 2 log has the receiver's own velocity, by its name, or `none`; unless given, one
    /// that names a receiver, shares the fixes' frame or has a message for each fix.
    pub velocity: Option<String>,
}

/// A log in memory.
#[derive(Debug)]
#[non_exhaustive]
pub struct Log {
    /// What it was.
    pub format: Format,
    /// What the sensors measured.
    pub dataset: Dataset,
    /// The flight record, where the log is one.
    pub record: Option<Record>,
    /// What the estimator on board said, where the log has it.
    pub onboard: Option<Onboard>,
}

/// Opens `log`, whatever its format.
///
/// # Errors
/// [`LogError::Io`] where the file system refuses; [`LogError::Bytes`] where the file is of no known
/// format, with what it looks like, or damaged, with the byte; [`LogError::LeftOut`] where this crate
/// was built without the feature that reads it; else as the format's own reader.
pub fn open(log: &Path, options: &Options) -> Result<Log, LogError> {
    let in_bag = file_of_bag(log)?;
    let log = in_bag.as_deref().unwrap_or(log);
    let format = recognise(log)?;
    ensure_choice(format, log, options)?;
    match format {
        format @ (Format::Dataset | Format::Record) => {
            let (dataset, record) = hovernav_log::open(log)?;
            Ok(Log { format, dataset, record, onboard: None })
        }
        format => read(format, Input { path: log, bytes: None }, options),
    }
}

/// Opens a log of another program that is in memory; `path` names it in messages.
///
/// # Errors
/// As [`open`].
pub fn open_bytes(bytes: &[u8], path: &Path, options: &Options) -> Result<Log, LogError> {
    let format = format_of(&bytes[..bytes.len().min(HEAD)], path)?;
    ensure_choice(format, path, options)?;
    read(format, Input { path, bytes: Some(bytes) }, options)
}

/// The format of `log`: a directory is a dataset, or a mapping of foreign files where it has no inertial
/// samples in hovernav's own columns; a file what it holds.
fn recognise(log: &Path) -> Result<Format, LogError> {
    let metadata = std::fs::metadata(log).map_err(LogError::io(log))?;
    if metadata.is_dir() {
        let is_mapped = log.join("mapping.toml").exists() && !is_own(&log.join("imu.csv"));
        return Ok(if is_mapped { Format::Text } else { Format::Dataset });
    }
    // A pipe would keep the reader waiting, a device may never end.
    if !metadata.is_file() {
        let reason = "a pipe or a device, expected a file or a directory".to_owned();
        return Err(LogError::Unusable { path: log.to_path_buf(), reason });
    }
    format_of(&head_of(log)?, log)
}

/// Refuses a choice among sensors where a log has one of each, and of a topic where it has none.
fn ensure_choice(format: Format, path: &Path, options: &Options) -> Result<(), LogError> {
    let Options { imu, gps, magnetometer, baro, velocity } = options;
    let numbers = [imu, gps, magnetometer, baro].into_iter().flatten();
    let has_one = matches!(format, Format::Dataset | Format::Record | Format::Raw | Format::Text);
    let reason = match numbers.max() {
        Some(wanted @ 1..) if has_one => {
            format!("found no instance {wanted}; {} has one of each sensor", format.with_article())
        }
        _ if velocity.is_some() && format != Format::Ros2 => {
            format!("found no topic of velocity; {} has no topics", format.with_article())
        }
        _ => return Ok(()),
    };
    Err(LogError::Unusable { path: path.to_path_buf(), reason })
}

/// The one file of messages of a ROS 2 bag, a directory that says what its files are; nothing of anything
/// else.
fn file_of_bag(log: &Path) -> Result<Option<PathBuf>, LogError> {
    let has = |name: &str| log.join(name).is_file();
    if !has("metadata.yaml") || has("imu.csv") || has("mapping.toml") {
        return Ok(None);
    }
    let entries = std::fs::read_dir(log).map_err(LogError::io(log))?;
    let files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    let with = |extension: &str| {
        let is_such = |file: &&PathBuf| file.extension().is_some_and(|found| found == extension);
        files.iter().filter(is_such).cloned().collect::<Vec<_>>()
    };
    let reason = match (&with("mcap")[..], &with("db3")[..]) {
        // One in SQLite is refused by what it holds, with what to do about it.
        ([file], _) | ([], [file, ..]) => return Ok(Some(file.clone())),
        ([], []) => "found a ROS 2 bag without an .mcap file".to_owned(),
        (files, _) => {
            format!(
                "found a ROS 2 bag of {} files, expected one: give them one by one",
                files.len()
            )
        }
    };
    Err(LogError::Unusable { path: log.to_path_buf(), reason })
}

/// Whether a file's first line has the name of our own column of times: a foreign `imu.csv` may stand beside
/// its mapping.
fn is_own(file: &Path) -> bool {
    let head = if file.is_file() { head_of(file).unwrap_or_default() } else { Vec::new() };
    let line = head.split(|byte| *byte == b'\n').next().unwrap_or_default();
    line.split(|byte| *byte == b',').any(|name| name.trim_ascii().ends_with(b"t_s"))
}

/// The first bytes of a file, from which its format is told.
pub(crate) fn head_of(path: &Path) -> Result<Vec<u8>, LogError> {
    let mut head = Vec::with_capacity(HEAD);
    let file = File::open(path).map_err(LogError::io(path))?;
    file.take(HEAD as u64).read_to_end(&mut head).map_err(LogError::io(path))?;
    Ok(head)
}

/// The format of a file that begins with `head`.
fn format_of(head: &[u8], path: &Path) -> Result<Format, LogError> {
    Format::of(head).ok_or_else(|| {
        let found = looks_like(head);
        let reason = format!(
            "found {found}, expected a log: a dataset directory, a flight record, a PX4 ULog, an \
             ArduPilot DataFlash log, a MAVLink telemetry log, MCAP, raw bytes of sensors or text in \
             columns"
        );
        LogError::bytes(path, 0, reason)
    })
}

/// Reads a log with the reader of its `format`.
fn read(format: Format, input: Input<'_>, options: &Options) -> Result<Log, LogError> {
    match format {
        #[cfg(feature = "ulog")]
        Format::Ulog => crate::ulog::read(input, options),
        #[cfg(feature = "tlog")]
        Format::Tlog => crate::tlog::read(input, options),
        #[cfg(feature = "dataflash")]
        Format::Dataflash | Format::DataflashText => crate::dataflash::read(input, format, options),
        #[cfg(feature = "ros2")]
        Format::Ros2 => crate::ros2::read(input, options),
        #[cfg(feature = "raw")]
        Format::Raw => crate::raw::read(input, options),
        #[cfg(feature = "text")]
        Format::Text if input.bytes.is_some() => Err(LogError::Unusable {
            path: input.path.to_path_buf(),
            reason: "text in columns is read from its files, and these are bytes".into(),
        }),
        #[cfg(feature = "text")]
        Format::Text => crate::text::read(input.path, options),
        left_out => Err(LogError::LeftOut {
            path: PathBuf::from(input.path),
            format: left_out.to_string(),
            feature: left_out.feature().unwrap_or_default(),
        }),
    }
}
