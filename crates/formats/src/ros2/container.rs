//! Reads the records of an MCAP file, also those in chunks, with the memory of one chunk.

use std::borrow::Cow;
use std::io::Read as _;

use mcap::records::{ChunkHeader, Record, op};

use crate::damages::Damages;
use crate::window::Input;
use hovernav_log::LogError;

/// Bytes of the opcode and the length of a record.
const FRAME: usize = 9;
/// Largest record or chunk that is read, bytes. Recorders write chunks of at most about 4 MB, or of one message.
const LARGEST: usize = 1 << 26;
/// Largest message that is read, bytes.
const LONGEST_MESSAGE: u64 = 4096;
const CRC: crc::Crc<u32, crc::Table<16>> =
    crc::Crc::<u32, crc::Table<16>>::new(&crc::CRC_32_ISO_HDLC);

/// A channel of one of the files of a log.
pub(super) type ChannelId = (usize, u16);

/// Passes every record of the files to `take`, with the index of its file and a byte offset. The offset is that of the
/// record or of its chunk, counted through all files. A record or chunk with damaged content is skipped; reading of a file ends at
/// an impossible length.
///
/// # Errors
/// [`LogError::Io`].
pub(super) fn for_each_record(
    inputs: &[Input<'_>],
    mut take: impl FnMut(usize, Record<'_>, u64),
) -> Result<Damages, LogError> {
    let (mut damages, mut base) = (Damages::default(), 0);
    for (index, input) in inputs.iter().enumerate() {
        let end = of_file(*input, base, &mut damages, &mut |record, offset| {
            take(index, record, offset);
        })?;
        base += end;
    }
    Ok(damages)
}

/// Passes every record of a file to `take`, its offset after `base` bytes of other files. Returns where reading ended.
fn of_file(
    input: Input<'_>,
    base: u64,
    damages: &mut Damages,
    take: &mut dyn FnMut(Record<'_>, u64),
) -> Result<u64, LogError> {
    let total = input.length()?;
    let mut window = input.window()?;
    window.peek(mcap::MAGIC.len()).map_err(LogError::io(input.path))?;
    window.consume(mcap::MAGIC.len());
    loop {
        let offset = window.offset();
        let mut end = |reason: String| {
            damages.add(base + offset, format!("{reason}; only the data before it is used"));
        };
        let head = window.peek(FRAME).map_err(LogError::io(input.path))?;
        let Some((opcode, length)) = frame(head) else {
            end("the file ends without the footer of an MCAP file".into());
            return Ok(offset);
        };
        // An impossible length is mostly longer than any file.
        if opcode == 0 || length > i64::MAX as u64 {
            end(format!("found an impossible record of kind {opcode} and {length} bytes"));
            return Ok(offset);
        }
        if opcode == op::FOOTER {
            return Ok(offset);
        }
        if offset + FRAME as u64 + length > total {
            end(format!("the file ends within a record of {length} bytes"));
            return Ok(offset);
        }
        if !is_of_use(opcode) || length > LARGEST as u64 {
            if is_of_use(opcode) {
                let reason =
                    format!("found a record of {length} bytes, expected at most {LARGEST}");
                damages.add(base + offset, format!("{reason}; ignored"));
            }
            window.skip(FRAME as u64 + length).map_err(LogError::io(input.path))?;
            continue;
        }
        let length = length as usize;
        let bytes = window.peek(FRAME + length).map_err(LogError::io(input.path))?;
        // Shorter only if the file is truncated while it is read.
        let body = bytes.get(FRAME..FRAME + length).unwrap_or_default();
        if let Err(reason) = of_record(opcode, body, &mut |record| take(record, base + offset)) {
            damages.add(base + offset, format!("{reason}; ignored"));
        }
        window.consume(FRAME + length);
    }
}

/// Whether records of this kind are used. Others are skipped unread: they may be long, and the `mcap` crate panics
/// on an attachment that ends within its header.
const fn is_of_use(opcode: u8) -> bool {
    matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE | op::CHUNK)
}

/// Passes a record, or the records of a chunk, to `take`. The error describes damage.
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

/// A record of a kind that is used.
fn parsed(opcode: u8, body: &[u8]) -> Option<mcap::McapResult<Record<'_>>> {
    is_of_use(opcode).then(|| mcap::parse_record(opcode, body))
}

/// The opcode and length at the start of a record.
fn frame(bytes: &[u8]) -> Option<(u8, u64)> {
    let (&opcode, rest) = bytes.split_first()?;
    let (length, _) = rest.split_first_chunk()?;
    Some((opcode, u64::from_le_bytes(*length)))
}

/// The bytes of a chunk, decompressed and checked.
fn unpacked(header: &ChunkHeader, data: &[u8]) -> Result<Vec<u8>, String> {
    let size = header.uncompressed_size;
    if size > LARGEST as u64 {
        return Err(format!(
            "found a chunk of {size} bytes uncompressed, expected at most {LARGEST}"
        ));
    }
    let mut records = Vec::new();
    // Reading one byte more than stated detects a wrong size.
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
        other => {
            return Err(format!("found a chunk compressed with {other}, expected lz4 or zstd"));
        }
    }
    if records.len() as u64 != size {
        return Err(format!("found {} bytes in a chunk, expected {size}", records.len()));
    }
    if header.uncompressed_crc != 0 && CRC.checksum(&records) != header.uncompressed_crc {
        return Err("found a chunk with a wrong checksum".into());
    }
    Ok(records)
}

/// A message, decompressed if rosbag2 compressed it individually (`--compression-mode message`), up to
/// [`LONGEST_MESSAGE`].
pub(super) fn unpacked_message(data: &[u8]) -> Cow<'_, [u8]> {
    const ZSTANDARD: &[u8] = &[0x28, 0xB5, 0x2F, 0xFD];
    if !data.starts_with(ZSTANDARD) {
        return Cow::Borrowed(data);
    }
    let mut message = Vec::new();
    if let Ok(unpacking) = ruzstd::decoding::StreamingDecoder::new(data) {
        // A message that cannot be decompressed is too short for its type and is counted as such.
        let _ = unpacking.take(LONGEST_MESSAGE).read_to_end(&mut message);
    }
    Cow::Owned(message)
}

/// Passes the records of a chunk to `take`. The error tells why they end early.
fn of_chunk(mut rest: &[u8], take: &mut dyn FnMut(Record<'_>)) -> Result<(), String> {
    while let Some((opcode, length)) = frame(rest) {
        let body = usize::try_from(length).ok().and_then(|length| rest[FRAME..].get(..length));
        let body = body.ok_or_else(|| {
            format!(
                "found a record of {length} bytes that ends beyond \
                                               its chunk"
            )
        })?;
        match parsed(opcode, body) {
            Some(Ok(record)) => take(record),
            Some(Err(error)) => return Err(error.to_string()),
            None => {}
        }
        rest = &rest[FRAME + body.len()..];
    }
    Ok(())
}
