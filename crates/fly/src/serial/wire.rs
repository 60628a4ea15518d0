//! A serial line of an emulation, in memory.

use std::collections::VecDeque;
use std::sync::Mutex;

use super::signal::Signal;

/// Buffer size of each direction, bytes, as of a pseudo-terminal.
const CAPACITY: usize = 4096;

/// A serial line between two threads of an emulation.
#[derive(Debug, Default)]
pub(super) struct Wire {
    pub state: Mutex<State>,
    pub changed: Signal,
}

#[derive(Debug, Default)]
pub(super) struct State {
    pub to_host: VecDeque<u8>,
    pub to_device: VecDeque<u8>,
    /// Whether the host has opened the line.
    pub is_open: bool,
    /// Whether the device's end was removed.
    pub is_gone: bool,
}

/// Appends the bytes that `queue` has room for; returns their number.
pub(super) fn put(bytes: &[u8], queue: &mut VecDeque<u8>) -> usize {
    let count = bytes.len().min(CAPACITY.saturating_sub(queue.len()));
    queue.extend(bytes.iter().take(count));
    count
}

/// Moves bytes from `queue` to `buffer`; returns their number.
pub(super) fn take(queue: &mut VecDeque<u8>, buffer: &mut [u8]) -> usize {
    let count = queue.len().min(buffer.len());
    for (slot, byte) in buffer.iter_mut().zip(queue.drain(..count)) {
        *slot = byte;
    }
    count
}
