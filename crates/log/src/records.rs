//! The records of a CSV file, each with the line it begins on; no more of it in memory than a record and
//! what the reader has looked ahead.

use std::io::{self, Cursor, Read};

use csv::{ByteRecord, Position, Reader, ReaderBuilder};

/// Records of fields in a file, read forward once.
pub(crate) struct Records {
    reader: Reader<Tee>,
    record: ByteRecord,
    line: u64,
    start: usize,
    /// Where in the file the source begins.
    origin: u64,
}

/// Where a record begins: byte in the file, from 0, and line, from 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub byte: u64,
    line: u64,
}

impl Records {
    /// Those in `source`, past a byte order mark.
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

    /// Those from the one at `place` on, where `source` begins.
    pub fn from(source: Box<dyn Read + Send>, place: Place) -> Self {
        let tee = Tee { source, kept: Vec::new(), offset: 0 };
        let reader = ReaderBuilder::new().has_headers(false).flexible(true).from_reader(tee);
        let record = ByteRecord::new();
        Self { reader, record, line: place.line, start: 0, origin: place.byte }
    }

    /// Where the record moved on to begins.
    pub fn place(&self) -> Place {
        Place { byte: self.origin + self.start as u64, line: self.line }
    }

    /// Moves on to the next record; whether there is one.
    pub fn advance(&mut self) -> io::Result<bool> {
        if !self.reader.read_byte_record(&mut self.record)? {
            return Ok(false);
        }
        // The reader's own position is where it began to look: before blank lines, and between the
        // CR and LF that ended the record before.
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
        let tee = self.reader.get_ref();
        self.reader.position().byte() as usize >= tee.offset + tee.kept.len()
            && !matches!(tee.kept.last(), Some(b'\n' | b'\r'))
    }
}

/// UTF-8's byte order mark.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// Remembers what was read of a source, as far as it is still wanted.
struct Tee {
    source: Box<dyn Read + Send>,
    kept: Vec<u8>,
    /// Where in the source `kept` begins.
    offset: usize,
}

impl Tee {
    /// What was read from the byte `place` on.
    fn from(&self, place: usize) -> &[u8] {
        self.kept.get(place.saturating_sub(self.offset)..).unwrap_or_default()
    }

    /// Lets go of what was read before the byte `place`, now and then.
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
