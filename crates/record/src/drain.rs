//! The writer's side of the recorder, from the queue to the disk.

use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, TryRecvError};
use std::thread;
use std::time::Duration;

use crate::entry::{Level, Queued};
use crate::header::Header;
use crate::spool::Spool;
use crate::status::Progress;
use crate::writer::MessageWriter;
use hovernav::time::Time;

/// Interval at which a chunk ends and goes to the disk. It is a quarter of the 200 ms that may be lost, so a busy
/// machine has time left. Each chunk needs 260 bytes of memory for the index at the end of the file: 19 MB an hour.
const INTERVAL: Duration = Duration::from_millis(50);
/// Largest number of bytes in memory that wait for a full or slow disk. Above it, entries stay in the queue.
pub(super) const MAX_WAITING: u64 = 8 << 20;

/// Largest number of entries in a chunk.
const MAX_IN_CHUNK: usize = 8192;

/// Moves entries from the queue to the file.
pub struct Drain<W: Write> {
    writer: MessageWriter<Spool<W>>,
    progress: Arc<Progress>,
    /// Time since which the disk has refused to write.
    rejected_since: Option<Time>,
}

impl<W: Write> Drain<W> {
    /// Writes the beginning of the record, before the flight.
    ///
    /// # Errors
    /// Errors of `out`.
    pub fn begin(out: W, header: &Header, progress: Arc<Progress>) -> io::Result<Self> {
        let writer = MessageWriter::begin(Spool::new(out, Arc::clone(&progress)), header)?;
        if progress.waiting.load(Ordering::Relaxed) > 0 {
            return Err(progress.os_error().map_or_else(
                || io::Error::other("cannot be written"),
                io::Error::from_raw_os_error,
            ));
        }
        Ok(Self { writer, progress, rejected_since: None })
    }

    /// Writes the entries until the loop ends the queue.
    pub fn run(mut self, entries: &Receiver<Queued>) {
        loop {
            let ended = self.empty(entries);
            let is_done = ended || self.writer.flush().is_err() || self.is_hopeless();
            self.report_refusals();
            if is_done {
                break;
            }
            thread::park_timeout(INTERVAL);
        }
        if self.writer.finish().is_err() {
            self.progress.failed_writes.fetch_add(1, Ordering::Relaxed);
        }
        self.progress.finished.store(true, Ordering::Release);
    }

    /// Whether the record ends and memory is full, because the disk has accepted too few bytes. The entries in the
    /// queue are then lost, and stay counted as queued.
    fn is_hopeless(&self) -> bool {
        self.progress.ending.load(Ordering::Acquire)
            && self.progress.waiting.load(Ordering::Relaxed) >= MAX_WAITING
    }

    /// Moves entries from the queue as long as there is memory. Returns whether the queue has ended.
    fn empty(&mut self, entries: &Receiver<Queued>) -> bool {
        // The content of a chunk does not count as waiting for the disk, so its length is limited too.
        for _ in 0..MAX_IN_CHUNK {
            if self.progress.waiting.load(Ordering::Relaxed) >= MAX_WAITING {
                break;
            }
            match entries.try_recv() {
                Ok(queued) => {
                    self.progress.taken.fetch_add(1, Ordering::Relaxed);
                    if self.writer.entry(&queued).is_err() {
                        self.progress.failed_writes.fetch_add(1, Ordering::Relaxed);
                    }
                }
                Err(TryRecvError::Empty) => return false,
                Err(TryRecvError::Disconnected) => return true,
            }
        }
        false
    }

    /// Records when the disk began to refuse, and when it continued.
    fn report_refusals(&mut self) {
        let now = self.writer.now;
        let is_refusing = self.progress.waiting.load(Ordering::Relaxed) > 0;
        let written = match (self.rejected_since, is_refusing) {
            (None, true) => {
                self.rejected_since = Some(now);
                let number = self.progress.os_error().unwrap_or(0);
                let error = io::Error::from_raw_os_error(number).to_string();
                self.writer.event(now, Level::Error, "record_refused", &error)
            }
            (Some(since), false) => {
                self.rejected_since = None;
                let text = format!("the record is being written again after {:.1} s", now - since);
                self.writer.event(now, Level::Info, "record_resumed", &text)
            }
            _ => Ok(()),
        };
        if written.is_err() {
            self.progress.failed_writes.fetch_add(1, Ordering::Relaxed);
        }
    }
}
