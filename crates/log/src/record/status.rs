//! How a recording goes, for both of its sides.

use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU64, Ordering};

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

/// What the loop and the threads that write know of each other.
#[derive(Debug, Default)]
pub(super) struct Progress {
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
    /// Nothing more comes: the writer need not wait for a disk that refuses for good.
    pub ending: AtomicBool,
    /// The writer is done; only a last sync is missing.
    pub finished: AtomicBool,
}

impl Progress {
    /// Counts a write that failed with `error`; what it did not take is tried again. It is counted
    /// last: whoever has read of it reads what the disk took before it, too.
    pub fn write_failed(&self, error: &std::io::Error) {
        self.os_error.store(error.raw_os_error().unwrap_or(0), Ordering::Relaxed);
        self.failed_writes.fetch_add(1, Ordering::Release);
    }

    /// Counts an attempt to bring the file safely to the disk that failed with `error`.
    pub fn sync_failed(&self, error: &std::io::Error) {
        self.failed_syncs.fetch_add(1, Ordering::Relaxed);
        self.os_error.store(error.raw_os_error().unwrap_or(0), Ordering::Relaxed);
    }

    /// The last error of the operating system; `None` before any.
    pub fn os_error(&self) -> Option<i32> {
        Some(self.os_error.load(Ordering::Relaxed)).filter(|&number| number != 0)
    }
}
