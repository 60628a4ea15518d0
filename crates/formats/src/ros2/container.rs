//! The records of an MCAP file, those in chunks too, with the memory of one chunk.

use std::io::Read as _;

use mcap::records::{ChunkHeader, Record, op};

use crate::window::Input;
use hovernav_log::LogError;

/// An opcode and the length of what follows.
const FRAME: usize = 9;
/// Records and chunks beyond this are no sensor's, bytes.
const LARGEST: usize = 1 << 28;
const CRC: crc::Crc<u32, crc::Table<16>> =
    crc::Crc::<u32, crc::Table<16>>::new(&crc::CRC_32_ISO_HDLC);

/// Why a file ended before its end; the bytes up to there were read.
#[derive(Debug)]
pub(super) struct CutOff {
    pub offset: u64,
    pub reason: String,
}

/// Gives every record of the file to `take`, with its byte in the file, or that of its chunk. What
/// was whole before damage has been given; the damage is returned.
///
/// # Errors
/// [`LogError::Io`], and what `take` returns.
pub(super) fn for_each_record(
    input: Input<'_>,
    mut take: impl FnMut(Record<'_>, u64) -> Result<(), LogError>,
) -> Result<Option<CutOff>, LogError> {
    let mut window = input.window()?;
    window.peek(mcap::MAGIC.len()).map_err(LogError::io(input.path))?;
    window.consume(mcap::MAGIC.len());
    loop {
        let offset = window.offset();
        let cut = |reason: String| Ok(Some(CutOff { offset, reason }));
        let head = window.peek(FRAME).map_err(LogError::io(input.path))?;
        let Some((opcode, length)) = frame(head) else {
            return cut("ends without the record that ends an MCAP file".into());
        };
        if length > LARGEST as u64 {
            return cut(format!("a record of {length} bytes, which is none"));
        }
        let length = length as usize;
        if opcode == op::DATA_END || opcode == op::FOOTER {
            return Ok(None);
        }
        let bytes = window.peek(FRAME + length).map_err(LogError::io(input.path))?;
        let Some(body) = bytes.get(FRAME..FRAME + length) else {
            return cut(format!("cut off within a record of {length} bytes"));
        };
        match parsed(opcode, body) {
            Some(Ok(Record::Chunk { header, data })) => {
                let records = match unpacked(&header, &data) {
                    Ok(records) => records,
                    Err(reason) => return cut(reason),
                };
                if let Some(reason) = of_chunk(&records, |record| take(record, offset))? {
                    return cut(reason);
                }
            }
            Some(Ok(record)) => take(record, offset)?,
            Some(Err(error)) => return cut(error.to_string()),
            None => {}
        }
        window.consume(FRAME + length);
    }
}

/// A record of a kind that tells something here; others are passed over unread, for the crate panics over
/// an attachment that ends within its own head.
fn parsed(opcode: u8, body: &[u8]) -> Option<mcap::McapResult<Record<'_>>> {
    let is_of_use = matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE | op::CHUNK);
    is_of_use.then(|| mcap::parse_record(opcode, body))
}

/// The opcode and length at the head of a record.
fn frame(bytes: &[u8]) -> Option<(u8, u64)> {
    let (&opcode, rest) = bytes.split_first()?;
    let (length, _) = rest.split_first_chunk()?;
    Some((opcode, u64::from_le_bytes(*length)))
}

/// The records of a chunk, unpacked and checked.
fn unpacked(header: &ChunkHeader, data: &[u8]) -> Result<Vec<u8>, String> {
    let size = header.uncompressed_size;
    if size > LARGEST as u64 {
        return Err(format!("a chunk of {size} bytes, which is none"));
    }
    let mut records = Vec::new();
    // One byte more than promised would show a chunk that is not what it says.
    let limit = size + 1;
    match header.compression.as_str() {
        "" => records.extend_from_slice(data),
        "lz4" => {
            let unpacking = lz4_flex::frame::FrameDecoder::new(data).take(limit);
            { unpacking }.read_to_end(&mut records).map_err(|error| format!("lz4: {error}"))?;
        }
        "zstd" => {
            let unpacking = ruzstd::decoding::StreamingDecoder::new(data)
                .map_err(|error| format!("zstd: {error}"))?;
            { unpacking.take(limit) }
                .read_to_end(&mut records)
                .map_err(|error| format!("zstd: {error}"))?;
        }
        other => return Err(format!("found a chunk packed by {other}, expected lz4 or zstd")),
    }
    if records.len() as u64 != size {
        return Err(format!("a chunk of {} bytes that promised {size}", records.len()));
    }
    if header.uncompressed_crc != 0 && CRC.checksum(&records) != header.uncompressed_crc {
        return Err("a chunk with a wrong checksum".into());
    }
    Ok(records)
}

/// Gives the records of a chunk to `take`; why they end early, if they do.
fn of_chunk(
    mut rest: &[u8],
    mut take: impl FnMut(Record<'_>) -> Result<(), LogError>,
) -> Result<Option<String>, LogError> {
    while let Some((opcode, length)) = frame(rest) {
        let body = usize::try_from(length).ok().and_then(|length| rest[FRAME..].get(..length));
        let Some(body) = body else {
            return Ok(Some(format!("a record of {length} bytes, beyond its chunk")));
        };
        match parsed(opcode, body) {
            Some(Ok(record)) => take(record)?,
            Some(Err(error)) => return Ok(Some(error.to_string())),
            None => {}
        }
        rest = &rest[FRAME + body.len()..];
    }
    Ok(None)
}
