//! Reads raw bytes of a DMU or a receiver with the decoders of the flight software.

mod dmu;
mod frames;
mod pieces;
mod receiver;

use crate::assembly::Assembly;
use crate::format::Format;
use crate::log::Log;
use crate::window::Input;
use hovernav::dmu::{Decoder, Mode};
use hovernav::gps::{Protocol, Receiver};
use hovernav::time::Time;
use hovernav_dataset::{LogError, Manifest};
use pieces::{CHUNK, begin};

/// The device that sent a capture.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Speaker {
    Dmu(Mode),
    Receiver,
}

/// Whether a file that begins with `head` is a capture. After comment lines, it must contain complete messages with
/// correct checksums. TSIP has no checksums; it must contain plausible reports.
pub(crate) fn is_raw(head: &[u8]) -> bool {
    speaker(without_remarks(head)).is_some()
}

fn speaker(bytes: &[u8]) -> Option<Speaker> {
    // The frames of TSIP have no checksums and cannot be recognised alone.
    if (0..bytes.len()).any(|at| frames::at(&bytes[at..]).is_some()) {
        return Some(Speaker::Receiver);
    }
    let mut receiver = Receiver::new(Protocol::Tsip);
    let mut rest = bytes;
    while receiver.read(&mut rest, Time::ZERO).is_some() {}
    let tsip = receiver.counts();
    let packets = |mode: Mode| {
        let mut decoder = Decoder::new(mode);
        let mut rest = bytes;
        while decoder.next_packet(&mut rest).is_some() {}
        decoder.counts().packets * mode.packet_length() as u64
    };
    let modes = [Mode::Angle, Mode::Scaled].map(|mode| (packets(mode), mode));
    let [(angle, _), (scaled, _)] = modes;
    if 2 * angle.max(scaled) > bytes.len() as u64 && !bytes.is_empty() {
        return Some(Speaker::Dmu(if angle >= scaled { Mode::Angle } else { Mode::Scaled }));
    }
    let is_tsip = bytes.contains(&0x10)
        && (tsip.read >= 2 && tsip.read > 4 * (tsip.damaged + tsip.impossible)
            || tsip.unknown >= 4 && tsip.damaged + tsip.impossible == 0);
    is_tsip.then_some(Speaker::Receiver)
}

/// `bytes` without the leading lines that begin with `#`.
fn without_remarks(mut bytes: &[u8]) -> &[u8] {
    while bytes.first() == Some(&b'#') {
        let line = bytes.iter().position(|byte| *byte == b'\n');
        bytes = line.map_or(&[], |end| &bytes[end + 1..]);
    }
    bytes
}

/// Reads a capture of one serial line.
///
/// # Errors
/// [`LogError`] if the file cannot be read or contains no packets.
pub(crate) fn read(input: Input<'_>) -> Result<Log, LogError> {
    let (assembly, manifest) = assembled(input)?;
    assembly.finish(input.path, Format::Raw, manifest, "")
}

/// The rows of a capture with times as logged, and its manifest.
///
/// # Errors
/// [`LogError`] if the file cannot be read or contains no packets.
pub(crate) fn assembled(input: Input<'_>) -> Result<(Assembly, Manifest), LogError> {
    let mut window = begin(input)?;
    let io = LogError::io(input.path);
    let bytes = window.peek(CHUNK).map_err(io)?;
    // Only the bytes that determined the format are passed; the rest may be anything.
    match speaker(&bytes[..bytes.len().min(CHUNK)]) {
        Some(Speaker::Dmu(mode)) => dmu::read(input, mode),
        Some(Speaker::Receiver) => receiver::read(input),
        None => {
            let reason = format!("found no whole packet, expected {}", Format::Raw);
            Err(LogError::bytes(input.path, window.offset() as usize, reason))
        }
    }
}
