//! Recognises the format of a log from its content.

use std::io::{Error, ErrorKind};
use std::path::Path;

use crate::format::Format;
#[cfg(feature = "raw")]
use crate::raw::is_raw;
use crate::window::Input;
use hovernav_dataset::LogError;

/// Number of bytes at the start of a file that determine its format.
pub(crate) const HEAD: usize = 4096;

const MCAP: &[u8] = b"\x89MCAP0\r\n";
const ULOG: &[u8] = b"ULog\x01\x12\x35";
/// Two sync bytes and the type of the format message, with which every DataFlash log begins.
const DATAFLASH: &[u8] = &[0xA3, 0x95, 0x80];

/// The format of the file `log`, recognised from its first bytes.
pub(crate) fn recognise(log: &Path) -> Result<Format, LogError> {
    let metadata = std::fs::metadata(log).map_err(|error| {
        let error = match error.kind() {
            ErrorKind::NotFound => {
                Error::new(error.kind(), "no such file or directory, expected a log")
            }
            _ => error,
        };
        LogError::io(log)(error)
    })?;
    // A pipe may block the reader; a device may never end.
    if !metadata.is_file() {
        let reason = "found a pipe or a device, expected a file or a directory".to_owned();
        return Err(LogError::Unusable { path: log.to_path_buf(), reason });
    }
    let format = ensure_known(&head_of(log)?, log)?;
    let reads_packed = !matches!(format, Format::Text | Format::Record);
    if !reads_packed && Input::of(log).is_packed()? {
        let reason = format!("found a zstd file with {format}: unpack it first");
        return Err(LogError::Unusable { path: log.to_path_buf(), reason });
    }
    Ok(format)
}

/// The first [`HEAD`] bytes of a file, unpacked.
pub(crate) fn head_of(path: &Path) -> Result<Vec<u8>, LogError> {
    let input = Input::of(path);
    let mut window = input.window()?;
    let head = window.peek(HEAD).map_err(LogError::io(path))?;
    if head.is_empty() && input.is_packed()? {
        let reason = "the zstd file is cut off or damaged before its first block ends".to_owned();
        return Err(LogError::bytes(path, 0, reason));
    }
    Ok(head[..head.len().min(HEAD)].to_vec())
}

/// [`format_of`], or an error with the likely type of the file at `path`.
pub(crate) fn ensure_known(head: &[u8], path: &Path) -> Result<Format, LogError> {
    format_of(head).filter(|_| !is_unmappable(head)).ok_or_else(|| {
        let found = looks_like(head);
        let reason = format!(
            "found {found}, expected a log: a dataset directory, a flight record, a PX4 ULog, an \
             ArduPilot DataFlash log, a MAVLink telemetry log, MCAP, raw bytes of sensors or text in \
             columns"
        );
        LogError::bytes(path, 0, reason)
    })
}

/// The format of a file that begins with `head`, its first [`HEAD`] bytes or all of them.
pub(crate) fn format_of(head: &[u8]) -> Option<Format> {
    let head = without_mark(head);
    if head.starts_with(ULOG) {
        Some(Format::Ulog)
    } else if head.starts_with(DATAFLASH) {
        Some(Format::Dataflash)
    } else if head.starts_with(b"FMT,") || head.starts_with(b"FMT ,") {
        Some(Format::DataflashText)
    } else if is_export(head) {
        None
    } else if head.starts_with(MCAP) {
        Some(if is_own(head) { Format::Record } else { Format::Ros2 })
    } else if is_tlog(head) {
        Some(Format::Tlog)
    } else if is_raw(head) && !is_vectornav(head) {
        Some(Format::Raw)
    } else if is_dataflash_within(head) {
        Some(Format::Dataflash)
    } else if (1..head.len()).any(|at| is_dated_tlog(&head[at..])) {
        Some(Format::Tlog)
    } else if is_text_in_columns(head) {
        Some(Format::Text)
    } else {
        None
    }
}

/// Text without its byte order mark.
pub(crate) fn without_mark(text: &[u8]) -> &[u8] {
    text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text)
}

/// Whether the library in the header of an MCAP file is hovernav. True also for a truncated header: the reader of
/// flight records reports the missing part.
fn is_own(head: &[u8]) -> bool {
    // After the magic bytes: an opcode, a length, then two strings, each after its length.
    let strings = head.get(MCAP.len() + 9..).unwrap_or_default();
    let library = string(strings).and_then(|(_, rest)| string(rest));
    library.is_none_or(|(library, _)| library.starts_with(b"hovernav "))
}

/// Whether a file is a solution that hovernav exported: its library has no version.
fn is_export(head: &[u8]) -> bool {
    let strings = head.strip_prefix(MCAP).and_then(|rest| rest.get(9..)).unwrap_or_default();
    let library = string(strings).and_then(|(_, rest)| string(rest));
    library.is_some_and(|(library, _)| library == b"hovernav")
}

/// Whether every sentence of a file is one of VectorNav's.
fn is_vectornav(head: &[u8]) -> bool {
    let mut sentences =
        head.split(|byte| *byte == b'\n').filter(|line| line.starts_with(b"$")).peekable();
    sentences.peek().is_some() && sentences.all(|line| line.starts_with(b"$VN"))
}

/// Whether a file is NMEA 0183 without the checksums after `*`.
fn is_bare_nmea(head: &[u8]) -> bool {
    let is_sentence = |line: &&[u8]| {
        line.len() > 7
            && line[0] == b'$'
            && line[1..6].iter().all(u8::is_ascii_uppercase)
            && line[6] == b','
    };
    let mut sentences = head.split(|byte| *byte == b'\n').filter(is_sentence).peekable();
    sentences.peek().is_some() && sentences.all(|line| !line.contains(&b'*'))
}

/// The length-prefixed string at the start of `bytes`, and the rest.
fn string(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = bytes.split_first_chunk()?;
    rest.split_at_checked(u32::from_le_bytes(*length) as usize)
}

/// Whether `head` begins with two MAVLink frames, each after an eight-byte time.
fn is_tlog(head: &[u8]) -> bool {
    let Some(second) = frame_length(head).and_then(|length| head.get(length..)) else {
        return false;
    };
    second.is_empty() || frame_length(second).is_some()
}

/// Whether a file is RINEX, which names itself in its first line.
fn is_rinex(head: &[u8]) -> bool {
    let line = head.split(|byte| *byte == b'\n').next().unwrap_or_default();
    line.windows(20).any(|part| part == b"RINEX VERSION / TYPE" || part == b"CRINEX VERS   / TYPE")
}

/// Whether a file has the positions of RTKLIB in degrees, minutes and seconds.
fn is_in_seconds_of_arc(head: &[u8]) -> bool {
    let name = b"latitude(d'\")";
    head.windows(name.len()).any(|part| part == name)
}

/// Whether a file is text of a known kind that has no columns to map.
pub(crate) fn is_unmappable(head: &[u8]) -> bool {
    is_rinex(head) || is_in_seconds_of_arc(head) || is_vectornav(head)
}

/// Whether `head` begins with four MAVLink frames without times.
fn is_bare_mavlink(head: &[u8]) -> bool {
    const TIME: usize = 8;
    let mut rest = head;
    (0..4).all(|_| {
        let timed = [&[0; TIME], &rest[..rest.len().min(3)]].concat();
        let length = frame_length(&timed).map(|length| length - TIME);
        match length.and_then(|length| rest.get(length..)) {
            Some(after) if !rest.is_empty() => {
                rest = after;
                true
            }
            _ => false,
        }
    })
}

/// Whether `head` begins with three frames, the first with a plausible date. This check is for logs with a damaged
/// beginning: at an arbitrary offset, two frame marks alone may be accidental.
fn is_dated_tlog(head: &[u8]) -> bool {
    /// Plausible dates, µs since 1970: from 1990 to 2100.
    const DATES_US: std::ops::Range<u64> = 631_152_000_000_000..4_102_444_800_000_000;
    let dated = head.first_chunk().is_some_and(|at| DATES_US.contains(&u64::from_be_bytes(*at)));
    let next = || head.get(frame_length(head)?..);
    dated && next().is_some_and(|next| frame_length(next).is_some() && is_tlog(next))
}

/// Whether two consecutive format messages occur anywhere in `head`. This check is for logs with a damaged beginning.
fn is_dataflash_within(head: &[u8]) -> bool {
    const LENGTH: usize = 89;
    let begins = |at: usize| head.get(at..).is_some_and(|rest| rest.starts_with(DATAFLASH));
    (0..head.len()).any(|at| begins(at) && begins(at + LENGTH))
}

/// Length of a time and the frame after it, bytes, from the frame's length field.
fn frame_length(bytes: &[u8]) -> Option<usize> {
    const TIME: usize = 8;
    const SIGNATURE: usize = 13;
    let payload = usize::from(*bytes.get(TIME + 1)?);
    match bytes.get(TIME)? {
        0xFE => Some(TIME + 8 + payload),
        0xFD => {
            let is_signed = bytes.get(TIME + 2)? & 1 == 1;
            Some(TIME + 12 + payload + if is_signed { SIGNATURE } else { 0 })
        }
        _ => None,
    }
}

/// Without the feature `raw`, raw bytes are not recognised.
#[cfg(not(feature = "raw"))]
fn is_raw(_head: &[u8]) -> bool {
    false
}

/// Whether `head` is text with rows of numbers, or a mapping.
fn is_text_in_columns(head: &[u8]) -> bool {
    let is_row = |line: &[u8]| {
        let fields = line.split(|byte| matches!(byte, b',' | b';' | b'\t' | b' '));
        let fields: Vec<&[u8]> = fields.filter(|field| !field.is_empty()).collect();
        let begins_number = |field: &&&[u8]| {
            let unsigned = field.iter().find(|byte| !matches!(byte, b'-' | b'+' | b'.' | b'"'));
            unsigned.is_some_and(u8::is_ascii_digit)
        };
        let numbers = fields.iter().filter(begins_number).count();
        numbers >= 2 && 10 * numbers >= 7 * fields.len()
    };
    let lines = || head.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
    is_text(head) && lines().any(|line| is_row(line) || line == b"[[table]]")
}

/// Whether every byte can be part of text, in any encoding that extends ASCII.
pub(crate) fn is_text(head: &[u8]) -> bool {
    // Storage that was reserved but not written ends a file with zeros.
    let written = head.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
    (written > 0 || head.is_empty())
        && head[..written].iter().all(|byte| *byte >= b' ' || byte.is_ascii_whitespace())
}

/// First bytes and names of file types that are not logs.
const OTHERS: [(&[u8], &str); 18] = [
    (b"PK\x03\x04", "a zip archive or a spreadsheet: unpack it, or save it as CSV, first"),
    (b"\xff\xfe", "text in UTF-16: save it as UTF-8 first"),
    (b"\xfe\xff", "text in UTF-16: save it as UTF-8 first"),
    (b"\x1f\x8b", "a gzip file: unpack it first"),
    (b"\xfd7zXZ", "an xz file: unpack it first"),
    (b"\x28\xb5\x2f\xfd", "a zstd file: unpack it first"),
    (b"7z\xbc\xaf", "a 7z archive: unpack it first"),
    (b"BZh", "a bzip2 file: unpack it first"),
    (b"#ROSBAG V", "a ROS 1 bag: convert it to MCAP first"),
    (
        b"SQLite format 3",
        "a SQLite database, like a ROS 2 bag in .db3: convert it to MCAP with `rosbags-convert --src BAG \
         --dst OTHER --dst-storage mcap` (pip install rosbags) first",
    ),
    (b"\x89HDF", "an HDF5 file"),
    (b"MATLAB 5.0", "a MATLAB file"),
    (b"PAR1", "a Parquet file"),
    (b"%PDF", "a PDF document"),
    (b"\x7fELF", "a program"),
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"<", "an XML or HTML document"),
];

/// The likely type of a file of unknown format.
pub(crate) fn looks_like(head: &[u8]) -> &'static str {
    if head.is_empty() {
        return "an empty file";
    }
    if let Some((_, name)) = OTHERS.iter().find(|(magic, _)| head.starts_with(magic)) {
        return name;
    }
    if is_rinex(head) {
        return "RINEX, raw measurements without a position solution: solve them with RTKLIB, and read its .pos \
                file with `hovernav init`";
    }
    if is_in_seconds_of_arc(head) {
        return "positions in degrees, minutes and seconds, in three columns each: let RTKLIB write degrees (Lat/Lon \
                Format ddd.dddddddd)";
    }
    if is_export(head) {
        return "a solution that hovernav exported, which has no sensors' readings: open the log from which it was \
                estimated";
    }
    if is_vectornav(head) {
        return "VectorNav's text messages ($VNIMU, $VNINS), whose samples have no time: log the binary output, export \
                it as CSV from VectorNav's Control Center with TimeStartup, gyro, accelerometer, PosLla and VelNed, and \
                run `hovernav init` on it";
    }
    if is_bare_nmea(head) {
        return "NMEA 0183 without checksums, which damage would change unnoticed: log the receiver's sentences with \
                their checksums";
    }
    if is_bare_mavlink(head) {
        return "MAVLink without the times of a telemetry log: let the ground station write a .tlog, in which each \
                message follows eight bytes of time";
    }
    let is_text = |byte: &u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
    if head.iter().all(|byte| *byte == 0) {
        "nothing but zeros"
    } else if head.iter().filter(|byte| is_text(byte)).count() * 100 >= head.len() * 95 {
        "text of no known kind"
    } else {
        "binary data of no known kind"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_recognised_by_their_first_bytes() {
        let mut tlog = vec![0, 5, 0x9F, 0, 0, 0, 0, 0, 0xFE, 0, 1, 1, 1, 0, 0, 0];
        tlog.extend([0, 5, 0x9F, 0, 0, 0, 0, 1, 0xFD, 0, 0, 0, 1, 1, 1, 0, 0, 0, 0, 0]);
        for (head, format) in [
            (&b"ULog\x01\x12\x35\x01"[..], Some(Format::Ulog)),
            (&[0xA3, 0x95, 0x80, 0x80], Some(Format::Dataflash)),
            (b"FMT, 128, 89, FMT, BBnNZ, Type", Some(Format::DataflashText)),
            (&tlog, Some(Format::Tlog)),
            (b"\x89MCAP0\r\n", Some(Format::Record)),
            (b"t,x,y\n0.1,2,3\n", Some(Format::Text)),
            (b"# a mapping\n[[table]]\nfile = \"a\"\n", Some(Format::Text)),
            (&[&b"\x01"[..], &tlog, &tlog].concat(), Some(Format::Tlog)),
            (
                &[&b"\x01\xA3\x95\x80"[..], &[0; 86], b"\xA3\x95\x80"].concat(),
                Some(Format::Dataflash),
            ),
            (b"\xef\xbb\xbfFMT, 128, 89, FMT, BBnNZ, Type", Some(Format::DataflashText)),
            (b"ULog but not", None),
            (b"", None),
        ] {
            assert_eq!(format_of(head), format, "{head:?}");
        }
    }

    #[test]
    fn mcap_of_another_library_is_not_a_record() {
        let head = |library: &[u8]| {
            let mut head = MCAP.to_vec();
            head.extend([1, 0, 0, 0, 0, 0, 0, 0, 0]);
            head.extend([4, 0, 0, 0]);
            head.extend(b"ros2");
            head.extend((library.len() as u32).to_le_bytes());
            head.extend(library);
            head
        };
        assert_eq!(format_of(&head(b"libmcap 1.4")), Some(Format::Ros2));
        assert_eq!(format_of(&head(b"hovernav 0.1.0")), Some(Format::Record));
        assert_eq!(format_of(&head(b"hovernav")), None);
        assert!(looks_like(&head(b"hovernav")).starts_with("a solution that hovernav exported"));
    }

    #[test]
    fn files_that_are_not_logs_are_named() {
        assert_eq!(looks_like(b"\x1f\x8b\x08"), "a gzip file: unpack it first");
        assert_eq!(looks_like(b""), "an empty file");
        assert_eq!(looks_like(&[0; 20]), "nothing but zeros");
        let nmea = b"$GPGGA,100000.00,4700.0,N,00800.0,E,1,08,1.0,400.0,M,0.0,M,,\r\n";
        assert_eq!(format_of(nmea), None);
        assert!(looks_like(nmea).starts_with("NMEA 0183 without checksums"));
        assert_eq!(looks_like(b"the quick brown fox"), "text of no known kind");
        assert_eq!(looks_like(&[200; 20]), "binary data of no known kind");
    }
}
