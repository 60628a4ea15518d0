//! Opens a log of any format.

use std::path::{Path, PathBuf};

use crate::bag::files_of_bag;
use crate::directory::format_of_log;
use crate::format::Format;
use crate::log::{Log, Options};
use crate::recognise::{HEAD, ensure_known};
use crate::window::Input;
use hovernav_dataset::{Dataset, LogError};
#[cfg(feature = "record")]
use hovernav_record::Record;

/// Opens `log`; its format is recognised from its content.
///
/// # Errors
/// [`LogError::Io`] for a failed read. [`LogError::Bytes`] for an unknown format, with the likely type of the file, or
/// for damage, with the byte offset. [`LogError::MissingFeature`] if this crate was built without the feature for the
/// format. Otherwise the errors of the format's reader.
pub fn open(log: &Path, options: &Options) -> Result<Log, LogError> {
    let in_bag = files_of_bag(log)?;
    let files = in_bag.as_ref().map_or(&[][..], |bag| &bag.files);
    let first = files.first().map_or(log, PathBuf::as_path);
    let format = format_of_log(first)?;
    ensure_choice(format, first, options)?;
    match format {
        Format::Dataset => {
            let most = options.samples_in_memory.unwrap_or(usize::MAX);
            Ok(Log::of(format, Dataset::open_within(log, most)?, None))
        }
        #[cfg(feature = "record")]
        Format::Record => flight(first),
        #[cfg(feature = "ros2")]
        Format::Ros2 => {
            let inputs: Vec<Input<'_>> = files.iter().map(|file| Input::of(file)).collect();
            let alone = [Input::of(first)];
            let path = if inputs.len() > 1 { log } else { first };
            let inputs = if inputs.is_empty() { &alone } else { &inputs[..] };
            let mut log = match crate::ros2::read(path, inputs, options) {
                // A flight record that another program has copied is recognised by its topic `dmu/raw`.
                #[cfg(feature = "record")]
                Err(_) if crate::ros2::has_topic(inputs, "dmu/raw")? => return flight(first),
                log => log?,
            };
            let missing = in_bag.iter().flat_map(|bag| &bag.missing);
            log.dataset.warnings.extend(missing.map(|name| {
                format!("metadata.yaml: {name} is missing, its part of the flight is not read")
            }));
            let unlisted = in_bag.iter().flat_map(|bag| &bag.unlisted);
            log.dataset.warnings.extend(
                unlisted.map(|name| format!("metadata.yaml: {name} is not listed and is not read")),
            );
            Ok(log)
        }
        format => read(format, Input::of(first), options),
    }
}

/// Opens a flight record.
#[cfg(feature = "record")]
fn flight(path: &Path) -> Result<Log, LogError> {
    let record = Record::open(path)?;
    let log = Log::of(Format::Record, record.dataset()?, None);
    Ok(Log { record: Some(record), ..log })
}

/// Opens a log of another program from memory; `path` is its name in messages.
///
/// # Errors
/// As [`open`].
pub fn open_bytes(bytes: &[u8], path: &Path, options: &Options) -> Result<Log, LogError> {
    let format = ensure_known(&bytes[..bytes.len().min(HEAD)], path)?;
    ensure_choice(format, path, options)?;
    read(format, Input { path, bytes: Some(bytes) }, options)
}

/// Rejects options that the format does not support. Examples: a sensor number if the log has one sensor of each kind,
/// or a topic if the format has none.
fn ensure_choice(format: Format, path: &Path, options: &Options) -> Result<(), LogError> {
    let Options { imu, gps, magnetometer, baro, velocity, input, .. } = options;
    let numbers = [imu, gps, magnetometer, baro].into_iter().flatten();
    let has_one = matches!(format, Format::Dataset | Format::Record | Format::Raw | Format::Text);
    let has_inputs =
        matches!(format, Format::Ulog | Format::Dataflash | Format::DataflashText | Format::Tlog);
    let reason = match numbers.max() {
        Some(wanted @ 1..) if has_one => {
            format!("found no instance {wanted}; {} has one of each sensor", format.with_article())
        }
        _ if input.is_some() && !has_inputs => format!(
            "found no inputs to choose from; {} has one set of sticks",
            format.with_article()
        ),
        _ if velocity.is_some() && format != Format::Ros2 => {
            format!("found no topic of velocity; {} has no topics", format.with_article())
        }
        _ => return Ok(()),
    };
    Err(LogError::Unusable { path: path.to_path_buf(), reason })
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
        Format::Ros2 => crate::ros2::read(input.path, &[input], options),
        #[cfg(feature = "raw")]
        Format::Raw => crate::raw::read(input),
        #[cfg(feature = "text")]
        Format::Text if input.bytes.is_some() => Err(LogError::Unusable {
            path: input.path.to_path_buf(),
            reason: "found text in columns in memory, expected a file".into(),
        }),
        #[cfg(feature = "text")]
        Format::Text => crate::text::read(input.path),
        missing => Err(LogError::MissingFeature {
            path: PathBuf::from(input.path),
            format: missing.to_string(),
            feature: missing.feature().unwrap_or_default(),
        }),
    }
}
