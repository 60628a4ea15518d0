//! Reads the records of an MCAP file, also those in chunks, with memory for one chunk.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::io::{self, Read as _};

use hovernav_record::unpacked;
use mcap::records::{Record, op};

use crate::damages::Damages;
use crate::window::{Input, Window};
use hovernav_dataset::LogError;

/// Bytes of the opcode and the length of a record.
const FRAME: usize = 9;
/// Largest record or chunk that is read, bytes. Recorders write chunks of at most about 4 MB, or of one message.
const LARGEST: usize = 1 << 26;
/// Bytes of the footer after its frame.
const FOOTER: u64 = 20;
/// Bytes of a message record before its data.
const MESSAGE_HEADER: usize = 22;
/// Largest record of an unexpected kind, bytes, for which the reader checks whether a record follows.
const LONGEST_CHECKED: u64 = 1 << 20;
/// Largest message that is read, bytes.
const LONGEST_MESSAGE: u64 = 4096;

/// A channel of one of the files of a log.
pub(super) type ChannelId = (usize, u16);

/// Passes every record of the files to `take`, with the index of its file and a byte offset. The offset is that of the
/// record or of its chunk, counted through all files. A record or chunk with damaged content is skipped. So are the
/// bytes from an impossible record to the next plausible one.
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

/// Passes every record of a file to `take`. Offsets count from `base`, the number of bytes in the files before. Returns
/// the offset at which reading ended.
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
    let mut channels = BTreeSet::new();
    loop {
        let offset = window.offset();
        let head = window.peek(FRAME).map_err(LogError::io(input.path))?;
        let Some((opcode, length)) = frame(head) else {
            let reason = "the file ends without the footer of an MCAP file";
            damages.add(base + offset, format!("{reason}; only the data before it is used"));
            return Ok(offset);
        };
        if opcode == op::FOOTER {
            return Ok(offset);
        }
        // An impossible length is mostly longer than any file.
        let is_impossible = opcode == 0 || length > i64::MAX as u64;
        let reason = if is_impossible
            || is_misleading(&mut window, opcode, length).map_err(LogError::io(input.path))?
        {
            format!("found an impossible record of kind {opcode} and {length} bytes")
        // The record is also shorter if the file is truncated while it is read, or if a packed file is damaged.
        } else if offset + FRAME as u64 + length > total
            || is_read(opcode, length)
                && window.peek(FRAME + length as usize).map_err(LogError::io(input.path))?.len()
                    < FRAME + length as usize
        {
            format!("the file ends within a record of {length} bytes")
        } else {
            String::new()
        };
        if !reason.is_empty() {
            let found = resume(&mut window, total, &channels).map_err(LogError::io(input.path))?;
            let what = match found {
                true => format!("{} bytes skipped up to the next record", window.offset() - offset),
                false => "only the data before it is used".to_owned(),
            };
            damages.add(base + offset, format!("{reason}; {what}"));
            if found {
                continue;
            }
            return Ok(offset);
        }
        if !is_read(opcode, length) {
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
        let body = bytes.get(FRAME..FRAME + length).unwrap_or_default();
        let mut passed = |record: Record<'_>| {
            if let Record::Channel(channel) = &record {
                channels.insert(channel.id);
            }
            take(record, base + offset);
        };
        if let Err(reason) = of_record(opcode, body, &mut passed) {
            damages.add(base + offset, format!("{reason}; ignored"));
        }
        window.consume(FRAME + length);
    }
}

/// Whether a short record of an unexpected kind is followed by no record. Then its length is damaged.
fn is_misleading(window: &mut Window<'_>, opcode: u8, length: u64) -> io::Result<bool> {
    if (op::SCHEMA..=op::DATA_END).contains(&opcode) || length > LONGEST_CHECKED {
        return Ok(false);
    }
    let bytes = window.peek(2 * FRAME + length as usize)?;
    let next = bytes.get(FRAME + length as usize..).and_then(frame);
    Ok(next.is_some_and(|(opcode, length)| opcode == 0 || length > i64::MAX as u64))
}

/// Whether a record is used and small enough.
fn is_read(opcode: u8, length: u64) -> bool {
    is_of_use(opcode) && length <= LARGEST as u64
}

/// Moves to the next plausible record; returns whether there is one. A plausible record is followed by another record
/// or by the end of the file. If it is a message, its channel is known.
fn resume(window: &mut Window<'_>, total: u64, channels: &BTreeSet<u16>) -> io::Result<bool> {
    loop {
        window.consume(1);
        let left = total.saturating_sub(window.offset());
        let Some((opcode, length)) = frame(window.peek(FRAME)?) else { return Ok(false) };
        let fits = |opcode: u8, length: u64, left: u64| {
            (op::HEADER..=op::DATA_END).contains(&opcode)
                && (1..=left.saturating_sub(FRAME as u64)).contains(&length)
                && (opcode != op::FOOTER || length == FOOTER)
        };
        if !fits(opcode, length, left) || length > LARGEST as u64 {
            continue;
        }
        let bytes = window.peek(2 * FRAME + length as usize)?;
        let Some(body) = bytes.get(FRAME..FRAME + length as usize) else { continue };
        let is_known = match body.first_chunk() {
            Some(channel) if opcode == op::MESSAGE => {
                body.len() >= MESSAGE_HEADER && channels.contains(&u16::from_le_bytes(*channel))
            }
            _ => opcode != op::MESSAGE,
        };
        let after = left - FRAME as u64 - length;
        let next = frame(&bytes[FRAME + body.len()..]);
        if is_known && next.is_none_or(|(opcode, length)| fits(opcode, length, after)) {
            return Ok(true);
        }
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
        Some(Ok(Record::Chunk { header, data })) => of_chunk(&unpacked(&header, data)?, take),
        Some(Ok(record)) => {
            take(record);
            Ok(())
        }
        Some(Err(_)) => Err(invalid(opcode)),
        None => Ok(()),
    }
}

fn invalid(opcode: u8) -> String {
    format!("found a record of kind {opcode} with invalid content")
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

/// Passes the records of a chunk to `take`. The error states why they end early.
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
            Some(Err(_)) => return Err(invalid(opcode)),
            None => {}
        }
        rest = &rest[FRAME + body.len()..];
    }
    Ok(())
}
