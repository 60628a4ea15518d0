//! The loop's side of the recorder: a queue that never blocks the loop.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::drain::{Drain, MAX_WAITING};
use crate::entry::{Entry, Line, Queued, RawBytes};
use crate::header::Header;
use crate::status::{Progress, Status};
use hovernav::time::Time;
use hovernav_dataset::LogError;
use hovernav_toml::fresh_file;

/// Length of the queue, entries: about 15 s of a flight.
const QUEUE: usize = 4096;
/// Fill level above which the queue accepts only entries that a replay needs.
const QUEUE_FOR_ALL: u64 = QUEUE as u64 * 3 / 4;
/// Interval at which written data are synchronised to the disk, against a loss of power.
const SYNC_INTERVAL: Duration = Duration::from_secs(1);

/// Longest time that the end of a record waits for an unresponsive disk.
const LONGEST_END: Duration = Duration::from_secs(10);

/// Records a flight. The loop [`push`](Self::push)es, a thread of its own writes.
///
/// Only [`create`](Self::create), [`catch_up`](Self::catch_up) and [`finish`](Self::finish) block. Entries go into a
/// preallocated queue of bounded length. If it fills up, because the disk is full or slow, entries that a replay can
/// compute again are dropped first, raw bytes last. Every loss is counted, and reported in the record as soon as there
/// is room.
#[derive(Debug)]
pub struct Recorder {
    queue: Option<SyncSender<Queued>>,
    /// Whether there is no file.
    is_absent: bool,
    threads: Vec<JoinHandle<()>>,
    progress: Arc<Progress>,
    sequence: u32,
    sent: u64,
    unreported: Lost,
    lost: Lost,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Lost {
    raw: u64,
    decoded: u64,
}

impl Recorder {
    /// Begins the record `path` with `header`, which is in the file when this returns. Until then the file has another
    /// name, so that any file named `path` is readable.
    ///
    /// # Errors
    /// [`LogError::Unusable`] if `path` exists, for no record is ever overwritten; [`LogError::Io`].
    pub fn create(path: &Path, header: &Header) -> Result<Self, LogError> {
        if path.exists() {
            let reason = "exists already; records are never overwritten".into();
            return Err(LogError::Unusable { path: path.into(), reason });
        }
        let mut unready = path.as_os_str().to_owned();
        unready.push(".part");
        let unready = Path::new(&unready);
        let file = fresh_file(unready).map_err(LogError::io(unready))?;
        let to_sync = file.try_clone().map_err(LogError::io(unready))?;
        let mut recorder = Self::start(file, header).map_err(|error| {
            // The incomplete file cannot be read and would block its name. The first error is reported, not that of the
            // removal.
            let _ = std::fs::remove_file(unready);
            LogError::io(unready)(error)
        })?;
        std::fs::rename(unready, path).map_err(LogError::io(path))?;
        // The new name survives a loss of power once its directory is on the disk.
        if let Some(directory) = path.parent().and_then(|directory| File::open(directory).ok()) {
            directory.sync_all().map_err(LogError::io(path))?;
        }
        let progress = Arc::clone(&recorder.progress);
        let syncing = thread::Builder::new()
            .name("record sync".into())
            .spawn(move || sync(&to_sync, &progress))
            .map_err(LogError::io(path))?;
        recorder.threads.push(syncing);
        Ok(recorder)
    }

    /// A recorder without a file, after `error`: every entry is lost and counted.
    #[must_use]
    pub fn absent(error: &LogError) -> Self {
        let progress = Arc::new(Progress::default());
        if let LogError::Io { source, .. } = error {
            progress.os_error.store(source.raw_os_error().unwrap_or(0), Ordering::Relaxed);
        }
        Self {
            queue: None,
            is_absent: true,
            threads: Vec::new(),
            progress,
            sequence: 0,
            sent: 0,
            unreported: Lost::default(),
            lost: Lost::default(),
        }
    }

    /// Records to `out` as [`create`](Self::create) does to a file.
    ///
    /// # Errors
    /// Errors of `out` for the first bytes, or of the system for a new thread.
    pub fn start(out: impl Write + Send + 'static, header: &Header) -> io::Result<Self> {
        let progress = Arc::new(Progress::default());
        let drain = Drain::begin(out, header, Arc::clone(&progress))?;
        let (queue, entries) = sync_channel(QUEUE);
        let writing =
            thread::Builder::new().name("record".into()).spawn(move || drain.run(&entries))?;
        Ok(Self {
            queue: Some(queue),
            is_absent: false,
            threads: vec![writing],
            progress,
            sequence: 0,
            sent: 0,
            unreported: Lost::default(),
            lost: Lost::default(),
        })
    }

    /// Records a call of [`Sensors`](hovernav::sensors::Sensors) with `bytes` of `line` at the time `now`; a call
    /// without bytes has empty `bytes`. Calls must be recorded in the order in which they are made.
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

    /// Records `entry`, which the loop received at `now`.
    pub fn push(&mut self, now: Time, entry: impl Into<Entry>) {
        let entry = entry.into();
        if !entry.is_recorded() {
            return;
        }
        // A replay must see the loss of raw bytes before the next bytes.
        if self.unreported.raw > 0 || self.unreported.decoded > 0 && self.fill() < QUEUE_FOR_ALL {
            let few = |count: u64| u32::try_from(count).unwrap_or(u32::MAX);
            let Lost { raw, decoded } = self.unreported;
            self.sequence += 1;
            if self.send(now, Entry::Lost { raw: few(raw), decoded: few(decoded) }) {
                self.unreported = Lost::default();
            } else {
                self.sequence -= 1;
            }
        }
        let is_raw = entry.is_raw();
        self.sequence += 1;
        if !(is_raw || self.fill() < QUEUE_FOR_ALL) || !self.send(now, entry) {
            for lost in [&mut self.lost, &mut self.unreported] {
                lost.raw += u64::from(is_raw);
                lost.decoded += u64::from(!is_raw);
            }
        }
    }

    fn fill(&self) -> u64 {
        self.sent - self.progress.taken.load(Ordering::Relaxed)
    }

    fn send(&mut self, now: Time, entry: Entry) -> bool {
        let sequence = self.sequence;
        let queued = Queued { sequence, now, entry };
        let sent = self.queue.as_ref().is_some_and(|queue| queue.try_send(queued).is_ok());
        self.sent += u64::from(sent);
        sent
    }

    /// Waits until the queue has room again, for flights that run faster than real time. Does not wait if the disk
    /// refuses permanently.
    pub fn catch_up(&self) {
        while self.fill() > QUEUE_FOR_ALL / 2
            && self.progress.waiting.load(Ordering::Relaxed) < MAX_WAITING
        {
            self.threads.iter().for_each(|thread| thread.thread().unpark());
            thread::sleep(Duration::from_millis(1));
        }
    }

    /// Status of the recording.
    #[must_use]
    pub fn status(&self) -> Status {
        let progress = &self.progress;
        let of = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        let failed_writes = progress.failed_writes.load(Ordering::Acquire);
        Status {
            is_absent: self.is_absent,
            queued: self.fill(),
            lost_raw: self.lost.raw,
            lost_decoded: self.lost.decoded,
            bytes_written: of(&progress.written),
            bytes_waiting: of(&progress.waiting),
            failed_writes,
            failed_syncs: of(&progress.failed_syncs),
            os_error: progress.os_error(),
        }
    }

    /// Ends the record with the rest of the queue and an index. Waits at most 10 s until the record is on the disk.
    /// `bytes_waiting` of the status still includes data that were not written.
    pub fn finish(mut self) -> Status {
        self.end();
        self.status()
    }

    fn end(&mut self) {
        self.queue = None;
        self.progress.ending.store(true, Ordering::Release);
        let asked = Instant::now();
        for thread in self.threads.drain(..) {
            thread.thread().unpark();
            while !thread.is_finished() && asked.elapsed() < LONGEST_END {
                thread::sleep(Duration::from_millis(2));
            }
            // An unresponsive disk does not block the process: its thread is abandoned.
            if thread.is_finished() {
                // A thread that panicked has printed the reason; its unwritten data are counted.
                let _ = thread.join();
            }
        }
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        self.end();
    }
}

/// Synchronises `file` to the disk at intervals, on a separate thread because it may take long.
fn sync(file: &File, progress: &Progress) {
    loop {
        let is_last = progress.finished.load(Ordering::Acquire);
        if let Err(error) = file.sync_data() {
            progress.sync_failed(&error);
        }
        if is_last {
            return;
        }
        thread::park_timeout(SYNC_INTERVAL);
    }
}
