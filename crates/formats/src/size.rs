//! How much memory a log takes.

use std::path::Path;

use crate::format::Format;
use crate::log::Options;
use crate::recognise::{file_of_bag, recognise};
use hovernav_log::{Dataset, LogError};

/// What is in memory of a log of another format, and of a flight record, as a multiple of its file: measured on
/// ULog, 1.9.
const OF_A_FILE: u64 = 2;

/// About how much memory [`open`](crate::open) takes of `log`, bytes: by the rows of a dataset directory, else by
/// the size of what is read.
///
/// # Errors
/// As [`open`](crate::open), of a log that cannot be recognised.
pub fn bytes_of(log: &Path, options: &Options) -> Result<u64, LogError> {
    let in_bag = file_of_bag(log)?;
    let log = in_bag.as_deref().unwrap_or(log);
    if recognise(log)? == Format::Dataset {
        return Ok(Dataset::bytes_of(log, options.samples_in_memory.unwrap_or(usize::MAX)));
    }
    let length = |path: &Path| std::fs::metadata(path).map_or(0, |metadata| metadata.len());
    let entries = std::fs::read_dir(log).into_iter().flatten().flatten();
    let files: u64 = entries.map(|entry| length(&entry.path())).sum();
    Ok(OF_A_FILE * if log.is_dir() { files } else { length(log) })
}
