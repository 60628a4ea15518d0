//! Status of a recording, shared by the loop and the writing threads.

use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU64, Ordering};

/// Status of a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// Whether there is no file: every entry is lost.
    pub is_absent: bool,
    /// Number of entries in the queue.
    pub queued: u64,
    /// Number of lost entries that a replay needs. Above 0, the replay cannot reproduce the flight.
    pub lost_raw: u64,
    /// Number of other lost entries.
    pub lost_decoded: u64,
    /// Number of bytes in the file.
    pub bytes_written: u64,
    /// Number of bytes in memory that are not in the file yet; a lasting number above 0 means a disk that is full or
    /// gone.
    pub bytes_waiting: u64,
    /// Number of failed writes; each was repeated with the same bytes.
    pub failed_writes: u64,
    /// Number of failed synchronisations of the file to the disk.
    pub failed_syncs: u64,
    /// The operating system's error number of the last failure, for [`std::io::Error::from_raw_os_error`].
    pub os_error: Option<i32>,
}

/// State shared by the loop and the writing threads.
#[derive(Debug, Default)]
pub(super) struct Progress {
    /// Number of entries that the writer has taken from the queue.
    pub taken: AtomicU64,
    /// Number of bytes that the disk has accepted.
    pub written: AtomicU64,
    /// Number of bytes that the disk has not accepted yet.
    pub waiting: AtomicU64,
    pub failed_writes: AtomicU64,
    pub failed_syncs: AtomicU64,
    /// The operating system's number of the last error; 0 without one.
    pub os_error: AtomicI32,
    /// The queue has ended: the writer does not wait for a disk that refuses permanently.
    pub ending: AtomicBool,
    /// The writer has finished, except for a last synchronisation.
    pub finished: AtomicBool,
}

impl Progress {
    /// Counts a write that failed with `error`; its bytes are written again. The counter changes last, so that a thread
    /// that reads it also sees the bytes written before.
    pub fn write_failed(&self, error: &std::io::Error) {
        self.os_error.store(error.raw_os_error().unwrap_or(0), Ordering::Relaxed);
        self.failed_writes.fetch_add(1, Ordering::Release);
    }

    /// Counts a synchronisation to the disk that failed with `error`.
    pub fn sync_failed(&self, error: &std::io::Error) {
        self.failed_syncs.fetch_add(1, Ordering::Relaxed);
        self.os_error.store(error.raw_os_error().unwrap_or(0), Ordering::Relaxed);
    }

    /// The last error of the operating system; `None` without one.
    pub fn os_error(&self) -> Option<i32> {
        Some(self.os_error.load(Ordering::Relaxed)).filter(|&number| number != 0)
    }
}
