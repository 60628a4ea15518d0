//! The loop's side of the recorder: a queue that never makes it wait.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU64, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use super::Header;
use super::entry::{Entry, Line, Queued, RawBytes};
use super::writer::Writer;
use crate::LogError;
use hovernav::time::Time;

/// Entries the queue holds: some 15 s of a flight.
const QUEUE: usize = 4096;
/// Filled so far, the queue takes only what a replay needs.
const QUEUE_FOR_ALL: u64 = QUEUE as u64 * 3 / 4;
/// How often what is written is brought safely to the disk, against a loss of power.
const SYNC_INTERVAL: Duration = Duration::from_secs(1);

/// Records a flight. The loop [`push`](Self::push)es, a thread of its own writes.
///
/// No call but [`create`](Self::create) and [`finish`](Self::finish) waits for anything: entries go
/// into a bounded queue that is made once. When it fills up, because the disk is full or slow, what
/// a replay can compute again is left out first, raw bytes last; every loss is counted, and told
/// in the record as soon as there is room.
#[derive(Debug)]
pub struct Recorder {
    queue: Option<SyncSender<Queued>>,
    threads: Vec<JoinHandle<()>>,
    shared: Arc<Shared>,
    sequence: u32,
    sent: u64,
    untold: Lost,
    lost: Lost,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Lost {
    raw: u64,
    decoded: u64,
}

/// What both sides know of the writing.
#[derive(Debug, Default)]
pub(super) struct Shared {
    /// Entries the writer took from the queue.
    pub taken: AtomicU64,
    /// Bytes the disk took.
    pub written: AtomicU64,
    /// Bytes it has not taken yet.
    pub waiting: AtomicU64,
    pub failed_writes: AtomicU64,
    pub failed_syncs: AtomicU64,
    /// The system's number of the last error; 0 before any.
    pub os_error: AtomicI32,
    /// The writer is done; only a last sync is missing.
    pub finished: AtomicBool,
}

/// How the recording goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// Entries in the queue.
    pub queued: u64,
    /// Entries lost that a replay needs: with any, it cannot reproduce the flight.
    pub lost_raw: u64,
    /// Other entries lost.
    pub lost_decoded: u64,
    /// Bytes in the file.
    pub bytes_written: u64,
    /// Bytes in memory that the file has not taken yet: more than 0 for long means a disk that is
    /// full or gone.
    pub bytes_waiting: u64,
    /// Attempts to write that failed; the same bytes were tried again.
    pub failed_writes: u64,
    /// Attempts to bring the file safely to the disk that failed.
    pub failed_syncs: u64,
    /// The operating system's number of the last failure, for
    /// [`std::io::Error::from_raw_os_error`].
    pub os_error: Option<i32>,
}

impl Recorder {
    /// Begins the record `path` with `header`, which is in the file when this returns; until then
    /// the file has another name, so that whatever is called `path` can be read.
    ///
    /// # Errors
    /// [`LogError::Unusable`] where `path` exists: no record is ever written over;
    /// [`LogError::Io`].
    pub fn create(path: &Path, header: &Header) -> Result<Self, LogError> {
        if path.exists() {
            let reason = "exists already, and no record is written over".into();
            return Err(LogError::Unusable { path: path.into(), reason });
        }
        let mut unready = path.as_os_str().to_owned();
        unready.push(".part");
        let unready = Path::new(&unready);
        let file = File::create(unready).map_err(LogError::io(unready))?;
        let to_sync = file.try_clone().map_err(LogError::io(unready))?;
        let mut recorder = Self::start(file, header).map_err(LogError::io(unready))?;
        std::fs::rename(unready, path).map_err(LogError::io(path))?;
        // The new name outlives a loss of power once its directory is on the disk.
        if let Some(directory) = path.parent().and_then(|directory| File::open(directory).ok()) {
            directory.sync_all().map_err(LogError::io(path))?;
        }
        let shared = Arc::clone(&recorder.shared);
        let syncing = thread::Builder::new()
            .name("record sync".into())
            .spawn(move || sync(&to_sync, &shared))
            .map_err(LogError::io(path))?;
        recorder.threads.push(syncing);
        Ok(recorder)
    }

    /// Records to `out`, as [`create`](Self::create) does to a file.
    ///
    /// # Errors
    /// What `out` says to the first bytes, or the system to a new thread.
    pub fn start(out: impl Write + Send + 'static, header: &Header) -> io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let writer = Writer::begin(out, header, Arc::clone(&shared))?;
        let (queue, entries) = sync_channel(QUEUE);
        let writing =
            thread::Builder::new().name("record".into()).spawn(move || writer.run(&entries))?;
        Ok(Self {
            queue: Some(queue),
            threads: vec![writing],
            shared,
            sequence: 0,
            sent: 0,
            untold: Lost::default(),
            lost: Lost::default(),
        })
    }

    /// Records a call of the sensors with `bytes` of `line` at the time `now`, which
    /// [`Sensors`](hovernav::sensors::Sensors) was or will be told too; no bytes where it was called
    /// without any. Calls must be recorded in the order they are made.
    pub fn raw(&mut self, line: Line, bytes: &[u8], now: Time) {
        let mut rest = bytes;
        loop {
            let part;
            (part, rest) = RawBytes::first_of(line, rest);
            self.push(now, Entry::Raw(part));
            if rest.is_empty() {
                return;
            }
        }
    }

    /// Records `entry`, to which the loop came at `now`.
    pub fn push(&mut self, now: Time, entry: impl Into<Entry>) {
        let entry = entry.into();
        if !entry.is_recorded() {
            return;
        }
        // A replay must know of lost bytes before it meets the next ones.
        if self.untold.raw > 0 || self.untold.decoded > 0 && self.fill() < QUEUE_FOR_ALL {
            let few = |count: u64| u32::try_from(count).unwrap_or(u32::MAX);
            let Lost { raw, decoded } = self.untold;
            self.sequence += 1;
            if self.send(now, Entry::Lost { raw: few(raw), decoded: few(decoded) }) {
                self.untold = Lost::default();
            } else {
                self.sequence -= 1;
            }
        }
        let is_raw = entry.is_raw();
        self.sequence += 1;
        if !(is_raw || self.fill() < QUEUE_FOR_ALL) || !self.send(now, entry) {
            for lost in [&mut self.lost, &mut self.untold] {
                lost.raw += u64::from(is_raw);
                lost.decoded += u64::from(!is_raw);
            }
        }
    }

    fn fill(&self) -> u64 {
        self.sent - self.shared.taken.load(Ordering::Relaxed)
    }

    fn send(&mut self, now: Time, entry: Entry) -> bool {
        let sequence = self.sequence;
        let queued = Queued { sequence, now, entry };
        let sent = self.queue.as_ref().is_some_and(|queue| queue.try_send(queued).is_ok());
        self.sent += u64::from(sent);
        sent
    }

    /// How it goes.
    #[must_use]
    pub fn status(&self) -> Status {
        let shared = &self.shared;
        let of = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        Status {
            queued: self.fill(),
            lost_raw: self.lost.raw,
            lost_decoded: self.lost.decoded,
            bytes_written: of(&shared.written),
            bytes_waiting: of(&shared.waiting),
            failed_writes: of(&shared.failed_writes),
            failed_syncs: of(&shared.failed_syncs),
            os_error: Some(shared.os_error.load(Ordering::Relaxed)).filter(|&number| number != 0),
        }
    }

    /// Ends the record with what is still in the queue and an index, and waits until it is on the
    /// disk. What could not be written stays counted as waiting.
    pub fn finish(mut self) -> Status {
        self.end();
        self.status()
    }

    fn end(&mut self) {
        self.queue = None;
        for thread in self.threads.drain(..) {
            thread.thread().unpark();
            // A thread that panicked has told so itself; what it left unwritten is counted.
            let _ = thread.join();
        }
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        self.end();
    }
}

/// Brings `file` to the disk at intervals, on a thread of its own: it may take the disk long.
fn sync(file: &File, shared: &Shared) {
    loop {
        let is_last = shared.finished.load(Ordering::Acquire);
        if let Err(error) = file.sync_data() {
            shared.failed_syncs.fetch_add(1, Ordering::Relaxed);
            shared.os_error.store(error.raw_os_error().unwrap_or(0), Ordering::Relaxed);
        }
        if is_last {
            return;
        }
        thread::park_timeout(SYNC_INTERVAL);
    }
}
