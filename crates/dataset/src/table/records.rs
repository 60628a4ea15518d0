//! Records of a CSV file, each with its first line. Memory holds one record and the reader's look-ahead.

use std::io::{self, Cursor, Read};

use csv::{ByteRecord, Position, Reader, ReaderBuilder};

/// Reader of the records of a file.
pub(crate) struct Records {
    reader: Reader<Tee>,
    record: ByteRecord,
    line: u64,
    start: usize,
    /// Byte offset in the file at which the source begins.
    origin: u64,
}

/// Start of a record: byte offset in the file, from 0, and line, from 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub byte: u64,
    line: u64,
}

impl Records {
    /// Reader of the records of `source`, after a byte order mark if there is one.
    pub fn new(mut source: Box<dyn Read + Send>) -> io::Result<Self> {
        let mut head = Vec::with_capacity(MARK.len());
        source.by_ref().take(MARK.len() as u64).read_to_end(&mut head)?;
        let mut place = Place { byte: 0, line: 1 };
        if head == MARK {
            head.clear();
            place.byte = MARK.len() as u64;
        }
        Ok(Self::from(Box::new(Cursor::new(head).chain(source)), place))
    }

    /// Reader of the records from `place` on, at which `source` begins.
    pub fn from(source: Box<dyn Read + Send>, place: Place) -> Self {
        let tee = Tee { source, kept: Vec::new(), offset: 0, begun: 0, is_ended: false };
        let reader = ReaderBuilder::new().has_headers(false).flexible(true).from_reader(tee);
        let record = ByteRecord::new();
        Self { reader, record, line: place.line, start: 0, origin: place.byte }
    }

    /// Start of the current record.
    pub fn place(&self) -> Place {
        Place { byte: self.origin + self.start as u64, line: self.line }
    }

    /// Moves to the next record; returns whether there is one.
    ///
    /// # Errors
    /// Errors of the source; a record that is longer than [`LONGEST`], which an open quote also makes.
    pub fn advance(&mut self) -> io::Result<bool> {
        let begun = self.reader.position().byte() as usize;
        self.reader.get_mut().begun = begun;
        if !self.reader.read_byte_record(&mut self.record).map_err(|error| self.in_words(error))? {
            return Ok(false);
        }
        // The reader reports the offset at which it started to search for the record. This offset is before blank
        // lines, and between the CR and LF that ended the previous record.
        let looked = self.record.position().map_or(0, Position::byte) as usize;
        let tee = self.reader.get_mut();
        let blanks = tee.from(looked).iter().take_while(|byte| matches!(byte, b'\r' | b'\n'));
        let start = looked + blanks.count();
        let passed = &tee.from(self.start)[..start - self.start];
        self.line += passed.iter().filter(|&&byte| byte == b'\n').count() as u64;
        self.start = start;
        tee.forget(start);
        Ok(true)
    }

    /// The reader's error; that of a record that is too long names its line.
    fn in_words(&self, error: csv::Error) -> io::Error {
        match error.into_kind() {
            csv::ErrorKind::Io(error) if error.kind() == io::ErrorKind::FileTooLarge => {}
            csv::ErrorKind::Io(error) => return error,
            other => return io::Error::other(format!("{other:?}")),
        }
        let tee = self.reader.get_ref();
        let lines = tee.from(self.start)[..tee.begun - self.start].iter();
        let line = self.line + lines.filter(|&&byte| byte == b'\n').count() as u64;
        let reason = format!(
            "line {line} is longer than {LONGEST} bytes, expected a row of numbers; a quote without its end makes one \
             row of many"
        );
        io::Error::new(io::ErrorKind::InvalidData, reason)
    }

    /// The current record.
    pub fn current(&self) -> &ByteRecord {
        &self.record
    }

    /// First line of the current record, from 1.
    pub fn line(&self) -> u64 {
        self.line
    }

    /// Whether the file ends with this record, without the newline that proves it complete.
    pub fn is_cut_off(&self) -> bool {
        let tee = self.reader.get_ref();
        self.reader.position().byte() as usize >= tee.offset + tee.kept.len()
            && !matches!(tee.kept.last(), Some(b'\n' | b'\r'))
    }
}

/// Largest length of a record, bytes.
const LONGEST: usize = 65_536;

/// UTF-8's byte order mark.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// Copy of the bytes read from a source, as long as they are needed.
struct Tee {
    source: Box<dyn Read + Send>,
    kept: Vec<u8>,
    /// Offset in the source at which `kept` begins.
    offset: usize,
    /// Offset at which the reader begins the record that it reads.
    begun: usize,
    /// Whether padding has ended the file.
    is_ended: bool,
}

impl Tee {
    /// The bytes read from offset `place` on.
    fn from(&self, place: usize) -> &[u8] {
        self.kept.get(place.saturating_sub(self.offset)..).unwrap_or_default()
    }

    /// Drops the bytes before offset `place` once there are enough of them.
    fn forget(&mut self, place: usize) {
        const WORTH_IT: usize = 1 << 16;
        let count = place.saturating_sub(self.offset).min(self.kept.len());
        if count >= WORTH_IT {
            self.kept.drain(..count);
            self.offset += count;
        }
    }
}

impl Read for Tee {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.offset + self.kept.len() > self.begun + LONGEST {
            // After a loss of power, the file system fills the end of the file with zero bytes.
            let is_padding =
                self.from(self.begun).iter().all(|byte| matches!(byte, 0 | b'\r' | b'\n'));
            self.is_ended = is_padding;
            if !is_padding {
                return Err(io::ErrorKind::FileTooLarge.into());
            }
        }
        if self.is_ended {
            return Ok(0);
        }
        let count = self.source.read(buffer)?;
        self.kept.extend_from_slice(&buffer[..count]);
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number of records of `text`, and the reader's error.
    fn read(text: Vec<u8>) -> (usize, Option<String>) {
        let mut records = Records::new(Box::new(Cursor::new(text))).unwrap();
        let mut count = 0;
        loop {
            match records.advance() {
                Ok(true) => count += 1,
                Ok(false) => return (count, None),
                Err(error) => return (count, Some(error.to_string())),
            }
        }
    }

    #[test]
    fn a_record_that_is_too_long_is_refused_with_its_line() {
        let rows = b"1,2,3\n".repeat(30_000);
        assert_eq!(read(rows.clone()), (30_000, None));
        assert_eq!(
            read([&rows, &b"1".repeat(LONGEST - 10)[..], b"\n", &rows].concat()),
            (60_001, None)
        );
        for long in [b"1".repeat(2 * LONGEST), b"\"1,2\n".to_vec()] {
            let (count, error) = read([&rows, &long[..], b"\n", &rows].concat());
            let error = error.unwrap();
            assert_eq!(count, 30_000);
            assert!(error.contains("line 30001 is longer than 65536 bytes"), "{error}");
        }
    }

    #[test]
    fn padding_ends_a_file() {
        let rows = b"1,2,3\n".repeat(30_000);
        for padding in [0, b'\n'] {
            let (count, error) = read([&rows[..], &vec![padding; 10 * LONGEST]].concat());
            assert!((30_000..=30_001).contains(&count) && error.is_none(), "{count} {error:?}");
        }
    }
}
