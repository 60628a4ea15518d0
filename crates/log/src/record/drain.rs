//! The writer's side of the recorder: from the queue to the disk.

use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, TryRecvError};
use std::thread;
use std::time::Duration;

use super::entry::{Level, Queued};
use super::header::Header;
use super::spool::Spool;
use super::status::Progress;
use super::writer::MessageWriter;
use hovernav::time::Time;

/// What came in one interval makes one chunk, on its way to the disk at the end of it. A quarter of
/// the 200 ms that may be lost leaves the rest to a busy machine. A chunk costs 260 bytes of memory,
/// for the index at the end of the file: 19 MB an hour.
const INTERVAL: Duration = Duration::from_millis(50);
/// As much may wait in memory for a disk that is full or slow; beyond, entries stay in the queue.
pub(super) const MOST_WAITING: u64 = 8 << 20;

/// Entries that make one chunk at most.
const MOST_IN_CHUNK: usize = 8192;

/// Empties the queue into the file.
pub struct Drain<W: Write> {
    writer: MessageWriter<Spool<W>>,
    progress: Arc<Progress>,
    /// Since when the disk refuses.
    refused_since: Option<Time>,
}

impl<W: Write> Drain<W> {
    /// Writes all that stands before the flight.
    ///
    /// # Errors
    /// What `out` says.
    pub fn begin(out: W, header: &Header, progress: Arc<Progress>) -> io::Result<Self> {
        let writer = MessageWriter::begin(Spool::new(out, Arc::clone(&progress)), header)?;
        if progress.waiting.load(Ordering::Relaxed) > 0 {
            return Err(progress.os_error().map_or_else(
                || io::Error::other("cannot be written"),
                io::Error::from_raw_os_error,
            ));
        }
        Ok(Self { writer, progress, refused_since: None })
    }

    /// Writes what comes, until the loop ends the queue.
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

    /// Whether the record is to end and the disk has taken so little that there is no memory for the rest:
    /// what is left in the queue is lost, and counted as queued.
    fn is_hopeless(&self) -> bool {
        self.progress.ending.load(Ordering::Acquire)
            && self.progress.waiting.load(Ordering::Relaxed) >= MOST_WAITING
    }

    /// Takes what is in the queue, but no more than there is memory for. Whether the queue has ended.
    fn empty(&mut self, entries: &Receiver<Queued>) -> bool {
        // What a chunk holds does not wait for the disk yet, so that its length is bounded too.
        for _ in 0..MOST_IN_CHUNK {
            if self.progress.waiting.load(Ordering::Relaxed) >= MOST_WAITING {
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

    /// Writes into the record when the disk began to refuse, and when it went on.
    fn report_refusals(&mut self) {
        let now = self.writer.now;
        let is_refusing = self.progress.waiting.load(Ordering::Relaxed) > 0;
        let written = match (self.refused_since, is_refusing) {
            (None, true) => {
                self.refused_since = Some(now);
                let number = self.progress.os_error().unwrap_or(0);
                let error = io::Error::from_raw_os_error(number).to_string();
                self.writer.event(now, Level::Error, "record_refused", &error)
            }
            (Some(since), false) => {
                self.refused_since = None;
                let text = format!("the record is written again after {:.1} s", now - since);
                self.writer.event(now, Level::Info, "record_resumed", &text)
            }
            _ => Ok(()),
        };
        if written.is_err() {
            self.progress.failed_writes.fetch_add(1, Ordering::Relaxed);
        }
    }
}
