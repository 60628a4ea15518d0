//! The records of an MCAP file, those in chunks too, with the memory of one chunk.

use std::borrow::Cow;
use std::io::Read as _;

use mcap::records::{ChunkHeader, Record, op};

use crate::damages::Damages;
use crate::window::Input;
use hovernav_log::LogError;

/// An opcode and the length of what follows.
const FRAME: usize = 9;
/// Records and chunks beyond this are not read, bytes: recorders pack chunks of under one to four million, or
/// of one message, and a sensor's are no pictures.
const LARGEST: usize = 1 << 26;
/// No message that is read is longer, bytes.
const LONGEST_MESSAGE: u64 = 4096;
const CRC: crc::Crc<u32, crc::Table<16>> =
    crc::Crc::<u32, crc::Table<16>>::new(&crc::CRC_32_ISO_HDLC);

/// Gives every record of the file to `take`, with its byte in the file, or that of its chunk. A record or a
/// chunk that is damaged within its length is passed over; where a length is none the file ends for us.
///
/// # Errors
/// [`LogError::Io`].
pub(super) fn for_each_record(
    input: Input<'_>,
    mut take: impl FnMut(Record<'_>, u64),
) -> Result<Damages, LogError> {
    let mut damages = Damages::default();
    let total = input.length()?;
    let mut window = input.window()?;
    window.peek(mcap::MAGIC.len()).map_err(LogError::io(input.path))?;
    window.consume(mcap::MAGIC.len());
    loop {
        let offset = window.offset();
        let mut end = |reason: String| {
            damages.add(offset, format!("{reason}; what came before is used"));
        };
        let head = window.peek(FRAME).map_err(LogError::io(input.path))?;
        let Some((opcode, length)) = frame(head) else {
            end("ends without the record that ends an MCAP file".into());
            return Ok(damages);
        };
        // Of a length that is none, most are longer than any file.
        if opcode == 0 || length > i64::MAX as u64 {
            end(format!("a record of kind {opcode} and {length} bytes, which is none"));
            return Ok(damages);
        }
        if opcode == op::FOOTER {
            return Ok(damages);
        }
        if offset + FRAME as u64 + length > total {
            end(format!("cut off within a record of {length} bytes"));
            return Ok(damages);
        }
        if !is_of_use(opcode) || length > LARGEST as u64 {
            if is_of_use(opcode) {
                let reason = format!("{length} bytes in one record, expected at most {LARGEST}");
                damages.add(offset, format!("{reason}; passed over"));
            }
            window.skip(FRAME as u64 + length).map_err(LogError::io(input.path))?;
            continue;
        }
        let length = length as usize;
        let bytes = window.peek(FRAME + length).map_err(LogError::io(input.path))?;
        // Shorter only of a file that is being cut off as it is read.
        let body = bytes.get(FRAME..FRAME + length).unwrap_or_default();
        if let Err(reason) = of_record(opcode, body, &mut |record| take(record, offset)) {
            damages.add(offset, format!("{reason}; passed over"));
        }
        window.consume(FRAME + length);
    }
}

/// Whether a record of this kind tells something here. Others are passed over unread: they may be long, and
/// the crate panics over an attachment that ends within its own head.
const fn is_of_use(opcode: u8) -> bool {
    matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE | op::CHUNK)
}

/// Gives a record, or those of a chunk, to `take`; why it is damaged, if it is.
fn of_record(opcode: u8, body: &[u8], take: &mut dyn FnMut(Record<'_>)) -> Result<(), String> {
    match parsed(opcode, body) {
        Some(Ok(Record::Chunk { header, data })) => of_chunk(&unpacked(&header, &data)?, take),
        Some(Ok(record)) => {
            take(record);
            Ok(())
        }
        Some(Err(error)) => Err(error.to_string()),
        None => Ok(()),
    }
}

/// A record of a kind that is of use.
fn parsed(opcode: u8, body: &[u8]) -> Option<mcap::McapResult<Record<'_>>> {
    is_of_use(opcode).then(|| mcap::parse_record(opcode, body))
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
        return Err(format!("a chunk that unpacks to {size} bytes, expected at most {LARGEST}"));
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

/// What a message says, where rosbag2 packed it by itself (`--compression-mode message`); no more of it than
/// any message that is read.
pub(super) fn unpacked_message(data: &[u8]) -> Cow<'_, [u8]> {
    const ZSTANDARD: &[u8] = &[0x28, 0xB5, 0x2F, 0xFD];
    if !data.starts_with(ZSTANDARD) {
        return Cow::Borrowed(data);
    }
    let mut message = Vec::new();
    if let Ok(unpacking) = ruzstd::decoding::StreamingDecoder::new(data) {
        // What cannot be unpacked is too short for its type, and counted as such.
        let _ = unpacking.take(LONGEST_MESSAGE).read_to_end(&mut message);
    }
    Cow::Owned(message)
}

/// Gives the records of a chunk to `take`; why they end early, if they do.
fn of_chunk(mut rest: &[u8], take: &mut dyn FnMut(Record<'_>)) -> Result<(), String> {
    while let Some((opcode, length)) = frame(rest) {
        let body = usize::try_from(length).ok().and_then(|length| rest[FRAME..].get(..length));
        let body = body.ok_or_else(|| format!("a record of {length} bytes, beyond its chunk"))?;
        match parsed(opcode, body) {
            Some(Ok(record)) => take(record),
            Some(Err(error)) => return Err(error.to_string()),
            None => {}
        }
        rest = &rest[FRAME + body.len()..];
    }
    Ok(())
}
