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
        let tee = Tee { source, kept: Vec::new(), offset: 0 };
        let reader = ReaderBuilder::new().has_headers(false).flexible(true).from_reader(tee);
        let record = ByteRecord::new();
        Self { reader, record, line: place.line, start: 0, origin: place.byte }
    }

    /// Start of the current record.
    pub fn place(&self) -> Place {
        Place { byte: self.origin + self.start as u64, line: self.line }
    }

    /// Moves to the next record; returns whether there is one.
    pub fn advance(&mut self) -> io::Result<bool> {
        if !self.reader.read_byte_record(&mut self.record)? {
            return Ok(false);
        }
        // The reader's own position is where its search began: before blank lines, and between the CR and LF that ended
        // the previous record.
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

/// UTF-8's byte order mark.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// Copy of the bytes read from a source, as long as they are needed.
struct Tee {
    source: Box<dyn Read + Send>,
    kept: Vec<u8>,
    /// Offset in the source at which `kept` begins.
    offset: usize,
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
        let count = self.source.read(buffer)?;
        self.kept.extend_from_slice(&buffer[..count]);
        Ok(count)
    }
}
