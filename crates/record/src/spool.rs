//! Buffer of bytes for a disk that may be full or gone.

use std::io::{self, ErrorKind, Write};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use crate::status::Progress;

/// Keeps the bytes that the disk does not accept and writes them again later. The MCAP writer therefore never gets an
/// error from a full disk.
pub struct Spool<W> {
    out: W,
    waiting: Vec<u8>,
    progress: Arc<Progress>,
}

impl<W> Spool<W> {
    pub fn new(out: W, progress: Arc<Progress>) -> Self {
        Self { out, waiting: Vec::new(), progress }
    }
}

impl<W: Write> Write for Spool<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.waiting.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        let mut taken = 0;
        let mut refusal = None;
        while taken < self.waiting.len() {
            let error = match self.out.write(&self.waiting[taken..]) {
                Ok(0) => ErrorKind::WriteZero.into(),
                Ok(count) => {
                    taken += count;
                    continue;
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                Err(error) => error,
            };
            refusal = Some(error);
            break;
        }
        self.waiting.drain(..taken);
        self.progress.written.fetch_add(taken as u64, Ordering::Relaxed);
        self.progress.waiting.store(self.waiting.len() as u64, Ordering::Relaxed);
        if let Some(error) = refusal {
            self.progress.write_failed(&error);
        }
        Ok(())
    }
}
