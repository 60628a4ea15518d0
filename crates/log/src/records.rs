//! The records of a CSV file in memory, each with the line it begins on.

use std::io::{self, Cursor};

use csv::{ByteRecord, Position, Reader, ReaderBuilder};

/// Records of fields in a file, read forward once.
pub(crate) struct Records {
    reader: Reader<Cursor<Vec<u8>>>,
    record: ByteRecord,
    line: u64,
    start: usize,
}

impl Records {
    /// Those in `bytes`, past a byte order mark.
    pub fn new(mut bytes: Vec<u8>) -> Self {
        if bytes.starts_with(b"\xef\xbb\xbf") {
            bytes.drain(..3);
        }
        let reader =
            ReaderBuilder::new().has_headers(false).flexible(true).from_reader(Cursor::new(bytes));
        Self { reader, record: ByteRecord::new(), line: 1, start: 0 }
    }

    /// Moves on to the next record; whether there is one.
    pub fn advance(&mut self) -> io::Result<bool> {
        if !self.reader.read_byte_record(&mut self.record)? {
            return Ok(false);
        }
        // The reader's own position is where it began to look: before blank lines, and between the
        // CR and LF that ended the record before.
        let looked = self.record.position().map_or(0, Position::byte) as usize;
        let bytes = self.reader.get_ref().get_ref();
        let blanks = bytes[looked..].iter().take_while(|byte| matches!(byte, b'\r' | b'\n'));
        let start = looked + blanks.count();
        self.line += bytes[self.start..start].iter().filter(|&&byte| byte == b'\n').count() as u64;
        self.start = start;
        Ok(true)
    }

    /// The record moved on to.
    pub fn current(&self) -> &ByteRecord {
        &self.record
    }

    /// Line on which it begins, from 1.
    pub fn line(&self) -> u64 {
        self.line
    }

    /// Whether it ends with the file, without the newline that would vouch for it.
    pub fn is_cut_off(&self) -> bool {
        let bytes = self.reader.get_ref().get_ref();
        self.reader.position().byte() as usize >= bytes.len()
            && !matches!(bytes.last(), Some(b'\n' | b'\r'))
    }
}
