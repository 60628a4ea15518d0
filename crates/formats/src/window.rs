//! Reads a file forward with a window of bounded size in memory.

use std::fs::File;
use std::io::{self, Cursor, ErrorKind, Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

use hovernav_dataset::LogError;

/// Number of bytes per read.
const CHUNK: usize = 1 << 18;
/// First bytes of a file compressed by Zstandard.
const ZSTANDARD: [u8; 4] = [0x28, 0xB5, 0x2F, 0xFD];
/// Largest ratio of the unpacked to the packed length of a log.
const MAX_PACKED: u64 = 1000;

/// A log to be read, from a file or from memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Input<'a> {
    /// Path of the file, also its name in messages.
    pub path: &'a Path,
    /// Content of the log, if it is in memory.
    pub bytes: Option<&'a [u8]>,
}

impl<'a> Input<'a> {
    /// The file at `path`.
    pub fn of(path: &'a Path) -> Self {
        Self { path, bytes: None }
    }

    /// Upper limit of the length of the log, bytes.
    pub fn length(&self) -> Result<u64, LogError> {
        let Some(bytes) = self.bytes else {
            let length = std::fs::metadata(self.path).map_err(LogError::io(self.path))?.len();
            return Ok(if self.is_packed()? { length.saturating_mul(MAX_PACKED) } else { length });
        };
        Ok(bytes.len() as u64)
    }

    /// Whether the log is a file compressed by Zstandard, which is unpacked while it is read.
    pub fn is_packed(&self) -> Result<bool, LogError> {
        let mut magic = [0; ZSTANDARD.len()];
        if !cfg!(feature = "ros2") || self.bytes.is_some() {
            return Ok(false);
        }
        let mut file = File::open(self.path).map_err(LogError::io(self.path))?;
        Ok(file.read_exact(&mut magic).is_ok() && magic == ZSTANDARD)
    }

    /// A window at the start of the log.
    pub fn window(&self) -> Result<Window<'a>, LogError> {
        let source = match self.bytes {
            Some(bytes) => Source::Memory(Cursor::new(bytes)),
            None if self.is_packed()? => unpacked(self.path).map_err(LogError::io(self.path))?,
            None => Source::File(File::open(self.path).map_err(LogError::io(self.path))?),
        };
        let (bytes, start, offset, is_at_end) = (Vec::new(), 0, 0, false);
        Ok(Window { source, bytes, start, offset, is_at_end })
    }
}

enum Source<'a> {
    File(File),
    Memory(Cursor<&'a [u8]>),
    /// A file that is unpacked while it is read, and its path.
    Packed(Box<dyn io::Read>, PathBuf),
}

impl std::fmt::Debug for Source<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::File(_) => "File",
            Self::Memory(_) => "Memory",
            Self::Packed(..) => "Packed",
        })
    }
}

#[cfg(feature = "ros2")]
fn unpacked<'a>(path: &Path) -> io::Result<Source<'a>> {
    let unpacking = crate::unpacking::Unpacking::of(path)?;
    Ok(Source::Packed(Box::new(unpacking), path.to_path_buf()))
}

#[cfg(not(feature = "ros2"))]
fn unpacked<'a>(path: &Path) -> io::Result<Source<'a>> {
    Ok(Source::File(File::open(path)?))
}

impl Source<'_> {
    /// Upper limit of the number of bytes left.
    fn left(&self) -> usize {
        match self {
            Self::File(_) | Self::Packed(..) => usize::MAX,
            Self::Memory(memory) => {
                memory.get_ref().len().saturating_sub(memory.position() as usize)
            }
        }
    }
}

/// Part of a log from the read position on.
#[derive(Debug)]
pub(crate) struct Window<'a> {
    source: Source<'a>,
    bytes: Vec<u8>,
    /// Index of the read position in `bytes`.
    start: usize,
    /// Offset of the read position in the log.
    offset: u64,
    is_at_end: bool,
}

impl Window<'_> {
    /// Offset of the read position in the log.
    pub fn offset(&self) -> u64 {
        self.offset
    }

    /// The bytes at the read position: at least `wanted`, fewer only at the end of the log.
    pub fn peek(&mut self, wanted: usize) -> io::Result<&[u8]> {
        while self.bytes.len() - self.start < wanted && !self.is_at_end {
            self.bytes.drain(..self.start);
            self.start = 0;
            let kept = self.bytes.len();
            // A length field of a damaged file must not allocate memory. The buffer only grows with bytes that were
            // read.
            let room = CHUNK.max(kept).min(self.source.left());
            self.bytes.resize(kept + room, 0);
            let read = match &mut self.source {
                Source::File(file) => file.read(&mut self.bytes[kept..]),
                Source::Memory(memory) => memory.read(&mut self.bytes[kept..]),
                Source::Packed(file, _) => file.read(&mut self.bytes[kept..]),
            };
            let count = *read.as_ref().unwrap_or(&0);
            self.bytes.truncate(kept + count);
            match read {
                Ok(count) => self.is_at_end = count == 0,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(&self.bytes[self.start..])
    }

    /// Moves forward by `count` bytes, at most to the end of the window.
    pub fn consume(&mut self, count: usize) {
        let count = count.min(self.bytes.len() - self.start);
        self.start += count;
        self.offset += count as u64;
    }

    /// Moves forward by `count` bytes, also beyond the window.
    pub fn skip(&mut self, count: u64) -> io::Result<()> {
        match usize::try_from(count) {
            Ok(held) if held <= self.bytes.len() - self.start => {
                self.consume(held);
                Ok(())
            }
            _ => self.seek(self.offset.saturating_add(count)),
        }
    }

    /// Moves to `offset` in the log.
    pub fn seek(&mut self, offset: u64) -> io::Result<()> {
        match &mut self.source {
            Source::File(file) => file.seek(SeekFrom::Start(offset))?,
            Source::Memory(memory) => memory.seek(SeekFrom::Start(offset))?,
            Source::Packed(file, path) => {
                // The file's own read position is at the end of the window.
                let passed = self.offset + (self.bytes.len() - self.start) as u64;
                if offset < passed {
                    self.source = unpacked(&path.clone())?;
                    (self.offset, self.start) = (0, 0);
                    self.bytes.clear();
                    return self.seek(offset);
                }
                io::copy(&mut file.take(offset - passed), &mut io::sink())?
            }
        };
        self.bytes.clear();
        (self.start, self.offset, self.is_at_end) = (0, offset, false);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_request_allocates_no_more_than_the_file_length() {
        let bytes = [7; 100];
        let input = Input { path: Path::new("memory"), bytes: Some(&bytes) };
        let mut window = input.window().unwrap();
        assert_eq!(window.peek(1 << 28).unwrap(), bytes);
        assert!(window.bytes.capacity() <= 4 * CHUNK, "{}", window.bytes.capacity());
    }

    #[test]
    fn every_byte_is_read_once_at_its_offset() {
        let bytes: Vec<u8> = (0..3 * CHUNK as u32).map(|index| (index % 251) as u8).collect();
        let input = Input { path: Path::new("memory"), bytes: Some(&bytes) };
        let mut window = input.window().unwrap();
        let mut seen = 0;
        loop {
            assert_eq!(window.offset(), seen as u64);
            let found = window.peek(1000).unwrap();
            assert_eq!(found, &bytes[seen..seen + found.len()]);
            if found.is_empty() {
                break;
            }
            let step = found.len().min(997);
            window.consume(step);
            seen += step;
        }
        assert_eq!(seen, bytes.len());
        window.seek(5).unwrap();
        window.skip(1).unwrap();
        assert_eq!(window.peek(2).unwrap()[0], 6);
        window.skip(CHUNK as u64 * 2).unwrap();
        assert_eq!(window.offset(), 6 + CHUNK as u64 * 2);
        window.seek(7).unwrap();
        assert_eq!(window.peek(1).unwrap()[0], 7);
        assert_eq!(window.offset(), 7);
    }
}
