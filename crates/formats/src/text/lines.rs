//! Reads a text file line by line, with the memory of one line.

use std::fs::File;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};

use hovernav_log::LogError;

/// The longest line that is accepted, bytes.
const LONGEST_LINE: u64 = 65_536;

/// A text file, read forward once.
pub(crate) struct Lines {
    path: PathBuf,
    reader: BufReader<File>,
    line: Vec<u8>,
    number: u64,
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
        Ok(Self { path: path.to_path_buf(), reader, line: Vec::new(), number: 0 })
    }

    /// The next line without its line end and without a byte order mark; `None` at the end of the file.
    ///
    /// # Errors
    /// [`LogError::Io`]; [`LogError::Unusable`] for a line that is too long.
    pub fn next(&mut self) -> Result<Option<&[u8]>, LogError> {
        self.line.clear();
        let read = (&mut self.reader).take(LONGEST_LINE).read_until(b'\n', &mut self.line);
        let read = read.map_err(|source| LogError::Io { path: self.path.clone(), source })?;
        if read == 0 {
            return Ok(None);
        }
        // Storage that was reserved but not written.
        if self.line.iter().all(|byte| *byte == 0) {
            return Ok(None);
        }
        self.number += 1;
        if read as u64 == LONGEST_LINE && self.line.last() != Some(&b'\n') {
            let ends = if self.line.contains(&b'\r') { ", lines that end with LF" } else { "" };
            let reason = format!(
                "line {} is longer than {LONGEST_LINE} bytes, expected rows of text{ends}",
                self.number
            );
            return Err(LogError::Unusable { path: self.path.clone(), reason });
        }
        while matches!(self.line.last(), Some(b'\n' | b'\r' | 0)) {
            self.line.pop();
        }
        if self.number == 1 && self.line.starts_with(b"\xef\xbb\xbf") {
            self.line.drain(..3);
        }
        Ok(Some(&self.line))
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
