//! Opening any log.

use std::path::Path;

use crate::format::Format;
use crate::onboard::Onboard;
use hovernav_log::record::Record;
use hovernav_log::{Dataset, LogError};

/// What to take where a log leaves a choice.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Options {}

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
/// [`LogError`] where the log is of no known format or cannot be read, with line or byte.
pub fn open(log: &Path, _options: &Options) -> Result<Log, LogError> {
    let (dataset, record) = hovernav_log::open(log)?;
    let format = if record.is_some() { Format::Record } else { Format::Dataset };
    Ok(Log { format, dataset, record, onboard: None })
}
