//! Memory that a log takes.

use std::path::{Path, PathBuf};

use crate::bag::files_of_bag;
use crate::directory::format_of_log;
use crate::format::Format;
use crate::log::Options;
use crate::window::Input;
use hovernav_dataset::{Dataset, LogError};

/// Memory of a flight record or a log of another format, divided by its file size. Measured on ULog: 1.9.
const OF_A_FILE: u64 = 2;

/// Memory of a log compressed by Zstandard, divided by its file size.
const OF_A_PACKED_FILE: u64 = 20;

/// Approximate memory that [`open`](crate::open) needs for `log`, bytes: from the rows of a dataset directory,
/// otherwise from the file size.
///
/// # Errors
/// As [`open`](crate::open), for a log of unknown format.
pub fn bytes_of(log: &Path, options: &Options) -> Result<u64, LogError> {
    let in_bag = files_of_bag(log)?;
    let first = in_bag.as_ref().and_then(|bag| bag.files.first()).map_or(log, PathBuf::as_path);
    if format_of_log(first)? == Format::Dataset {
        return Ok(Dataset::bytes_of(log, options.samples_in_memory.unwrap_or(usize::MAX)));
    }
    let length = |path: &Path| std::fs::metadata(path).map_or(0, |metadata| metadata.len());
    let entries = std::fs::read_dir(log).into_iter().flatten().flatten();
    let files: u64 = entries.map(|entry| length(&entry.path())).sum();
    let times = if Input::of(first).is_packed()? { OF_A_PACKED_FILE } else { OF_A_FILE };
    Ok(times * if log.is_dir() { files } else { length(log) })
}
