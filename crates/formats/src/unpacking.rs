//! Unpacks a file compressed by Zstandard, up to damage.

use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::mem;
use std::path::{Path, PathBuf};

use ruzstd::decoding::{BlockDecodingStrategy, FrameDecoder};

/// Empty last block, and a checksum that is not verified.
const END: [u8; 7] = [1, 0, 0, 0, 0, 0, 0];

/// A file that is unpacked while it is read. It ends with the last intact block.
pub(crate) struct Unpacking {
    decoder: FrameDecoder,
    source: Box<dyn Read>,
    path: PathBuf,
    /// Number of bytes that have been read.
    passed: u64,
    /// Whether the source ends where the file is damaged.
    is_cut: bool,
}

impl Unpacking {
    /// The file at `path`.
    pub fn of(path: &Path) -> io::Result<Self> {
        let (decoder, source) = (FrameDecoder::new(), Box::new(File::open(path)?));
        let path = path.to_path_buf();
        let mut unpacking = Self { decoder, source, path, passed: 0, is_cut: false };
        unpacking.begin()?;
        Ok(unpacking)
    }

    fn begin(&mut self) -> io::Result<()> {
        self.decoder.init(&mut self.source).map_err(|_| {
            io::Error::new(ErrorKind::InvalidData, "the header of the zstd file is damaged")
        })
    }

    /// Restarts the decoder on the intact first `length` bytes, closed by an empty last block, and skips the bytes
    /// already delivered. Without an end of the frame, the decoder would keep back its last megabytes.
    fn cut(&mut self, length: u64) -> io::Result<()> {
        self.is_cut = true;
        self.source = Box::new(File::open(&self.path)?.take(length).chain(&END[..]));
        self.decoder = FrameDecoder::new();
        self.begin()?;
        let passed = mem::take(&mut self.passed);
        io::copy(&mut self.take(passed), &mut io::sink())?;
        Ok(())
    }
}

impl Read for Unpacking {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        while self.decoder.can_collect() == 0 && !self.decoder.is_finished() {
            let intact = self.decoder.bytes_read_from_source();
            let strategy = BlockDecodingStrategy::UptoBlocks(1);
            match self.decoder.decode_blocks(&mut self.source, strategy) {
                Ok(_) => {}
                Err(_) if self.is_cut => return Ok(0),
                Err(_) => self.cut(intact)?,
            }
        }
        let count = self.decoder.read(bytes)?;
        self.passed += count as u64;
        Ok(count)
    }
}
