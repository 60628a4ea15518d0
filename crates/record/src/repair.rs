//! Repair of a record that was cut off or damaged: a new file with its index.

use std::io::{BufWriter, ErrorKind};
use std::path::Path;

use mcap::records::Record as McapRecord;

use crate::chunks::{LARGEST_BYTES, Piece, Topics, pieces, records};
use crate::damage::Repair;
use crate::read::Record;
use crate::writer::MessageWriter;
use hovernav_dataset::LogError;
use hovernav_toml::{WholeFile, read_bytes};

/// Result of a repair.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Repaired {
    /// Number of messages copied unchanged.
    pub messages: u64,
    /// Description of the repair in the new record.
    pub repair: Repair,
    /// Missing and damaged parts, one plain sentence each.
    pub warnings: Vec<String>,
}

/// Writes the intact parts of the record `path` to the new file `out`, with the index and the summary for other
/// programs. Messages are copied byte for byte, in their order. Metadata state the repair and the losses.
///
/// # Errors
/// As [`Record::open`]; [`LogError::Unusable`] if `out` exists, [`LogError::Io`] if it cannot be written.
pub fn repair(path: &Path, out: &Path) -> Result<Repaired, LogError> {
    let bytes = read_bytes(path, LARGEST_BYTES).map_err(LogError::io(path))?;
    let Record { header, warnings, damages, repair, is_ended, .. } = Record::read(&bytes, path)?;
    let repair = Repair::new(bytes.len() as u64, &damages, is_ended, repair);
    let file = WholeFile::create_new(out).map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => LogError::Unusable {
            path: out.to_path_buf(),
            reason: "found a file of that name, expected none: a repaired record is a new file"
                .into(),
        },
        _ => LogError::io(out)(error),
    })?;
    let written = |error: mcap::McapError| LogError::io(out)(std::io::Error::other(error));
    let mut buffer = BufWriter::new(file);
    let mut writer = MessageWriter::new(&mut buffer, &header).map_err(written)?;
    // Before the messages, so that the metadata survive another cut.
    writer.metadata(&repair.metadata()).map_err(written)?;
    let mut topics = Topics::default();
    let mut messages = 0;
    for (_, piece) in pieces(&bytes) {
        let Piece::Chunk(data) = piece else { continue };
        for record in records(&data) {
            match record {
                McapRecord::Channel(channel) => topics.learn(&channel),
                McapRecord::Message { header, data } => {
                    let Some(channel) = topics.of(header.channel_id) else { continue };
                    writer.copy(channel, header, &data).map_err(written)?;
                    messages += 1;
                }
                _ => {}
            }
        }
        writer.flush().map_err(LogError::io(out))?;
    }
    writer.finish().map_err(LogError::io(out))?;
    drop(writer);
    let file = buffer.into_inner().map_err(|error| LogError::io(out)(error.into_error()))?;
    file.finish().map_err(LogError::io(out))?;
    Ok(Repaired { messages, repair, warnings })
}
