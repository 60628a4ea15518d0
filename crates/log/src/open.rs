//! Opening whatever log a user names.

use std::path::Path;

use super::dataset::Dataset;
use super::error::LogError;
use super::record::Record;

/// The dataset that `log` is, a directory or a flight record, and the record itself if it is one.
///
/// # Errors
/// [`LogError`] where the log cannot be read, with file and line or byte.
pub fn open(log: &Path) -> Result<(Dataset, Option<Record>), LogError> {
    if !Record::is_mcap(log) {
        return Ok((Dataset::open(log)?, None));
    }
    let record = Record::open(log)?;
    Ok((record.dataset()?, Some(record)))
}
