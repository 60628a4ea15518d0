//! Signals between threads.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// A signal that threads of a [`Clock`](super::Clock) wait for.
#[derive(Debug)]
pub(super) struct Signal {
    /// For threads on the clock of the machine.
    pub condvar: Condvar,
    /// For threads of an emulation.
    pub number: u64,
}

impl Default for Signal {
    fn default() -> Self {
        static SIGNALS: AtomicU64 = AtomicU64::new(0);
        Self { condvar: Condvar::new(), number: SIGNALS.fetch_add(1, Ordering::Relaxed) }
    }
}

/// Locks `mutex`. A panic in another thread leaves the shared state of a flight consistent.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
