//! Reads a text file line by line, with memory for one line.

use std::fs::File;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};

use hovernav_dataset::LogError;

/// The longest line that is accepted, bytes.
const LONGEST_LINE: usize = 65_536;

/// A text file, read forward once.
pub(crate) struct Lines {
    path: PathBuf,
    reader: BufReader<File>,
    line: Vec<u8>,
    number: u64,
    unwritten: Option<(u64, u64)>,
}

impl Lines {
    /// Opens `path`, which must be an ordinary file: a pipe may block the reader, a device may never end.
    ///
    /// # Errors
    /// [`LogError::Io`]; [`LogError::Unusable`] for a pipe, device or directory.
    pub fn open(path: &Path) -> Result<Self, LogError> {
        let io = |source| LogError::Io { path: path.to_path_buf(), source };
        if !std::fs::metadata(path).map_err(io)?.is_file() {
            let reason = "found a pipe, device or directory, expected a text file with rows".into();
            return Err(LogError::Unusable { path: path.to_path_buf(), reason });
        }
        let reader = BufReader::with_capacity(1 << 16, File::open(path).map_err(io)?);
        Ok(Self { path: path.to_path_buf(), reader, line: Vec::new(), number: 0, unwritten: None })
    }

    /// The next line without its line end and without a byte order mark; `None` at the end of the file. Zero bytes come
    /// from storage that was reserved but not written. A line is skipped if it has other bytes after zero bytes.
    ///
    /// # Errors
    /// [`LogError::Io`]; [`LogError::Unusable`] for a line that is too long.
    pub fn next(&mut self) -> Result<Option<&[u8]>, LogError> {
        loop {
            self.line.clear();
            let (zeros, is_whole) = self.read()?;
            if self.line.is_empty() {
                return Ok(None);
            }
            self.number += 1;
            if self.line.len() >= LONGEST_LINE {
                let ends = if self.line.contains(&b'\r') { ", lines that end with LF" } else { "" };
                let reason = format!(
                    "line {} is longer than {LONGEST_LINE} bytes, expected rows of text{ends}",
                    self.number
                );
                return Err(LogError::Unusable { path: self.path.clone(), reason });
            }
            if is_whole {
                break;
            }
            let (_, unwritten) = self.unwritten.get_or_insert((self.number, 0));
            *unwritten += zeros;
        }
        while matches!(self.line.last(), Some(b'\n' | b'\r')) {
            self.line.pop();
        }
        if self.number == 1 && self.line.starts_with(b"\xef\xbb\xbf") {
            self.line.drain(..3);
        }
        Ok(Some(&self.line))
    }

    /// Reads a line without its zero bytes, up to the largest accepted length. Returns the number of zero bytes, and
    /// whether they are only at the end of the line.
    fn read(&mut self) -> Result<(u64, bool), LogError> {
        let (mut zeros, mut is_whole) = (0, true);
        loop {
            let read = self.reader.fill_buf();
            let bytes = read.map_err(|source| LogError::Io { path: self.path.clone(), source })?;
            let end = bytes.iter().position(|byte| *byte == b'\n').map(|end| end + 1);
            let piece = &bytes[..end.unwrap_or(bytes.len())];
            let length = piece.len();
            for run in piece.split(|byte| *byte == 0) {
                is_whole &= zeros == 0 || matches!(run, [] | [b'\n'] | [b'\r', b'\n']);
                let room = LONGEST_LINE - self.line.len();
                self.line.extend_from_slice(&run[..run.len().min(room)]);
                zeros += 1;
            }
            // Each run of bytes, except the first, follows a zero.
            zeros -= 1;
            self.reader.consume(length);
            if length == 0 || end.is_some() || self.line.len() >= LONGEST_LINE {
                return Ok((zeros, is_whole));
            }
        }
    }

    /// Line of the first skipped zero bytes, and their number.
    pub fn unwritten(&self) -> Option<(u64, u64)> {
        self.unwritten
    }

    /// The line last read.
    pub fn current(&self) -> &[u8] {
        &self.line
    }

    /// Number of the line last read, from 1.
    pub fn number(&self) -> u64 {
        self.number
    }

    pub fn path(&self) -> &Path {
        &self.path
    }
}
