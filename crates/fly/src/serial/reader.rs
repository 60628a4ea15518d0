//! Reads a port in a thread of its own.

use std::collections::VecDeque;
use std::io;
use std::sync::{Arc, Mutex};

use super::clock::{Clock, Task};
use super::port::{Port, PortCounts, PortEvent, Read, WriteError};
use super::signal::{Signal, lock};
use hovernav::time::Time;

/// Largest number of bytes per read.
const PIECE: usize = 256;

/// Shortest silence after data that is reported, s: receivers do not pause for this time within an epoch.
const SILENCE_S: f64 = 0.05;

/// Longest interval, s, at which the thread checks for a command or the end.
const ATTENTION_S: f64 = 0.02;

/// Timeout for writing a command, s.
const WRITE_S: f64 = 0.2;

/// Length of the queue of commands; in practice there is at most one.
const COMMANDS: usize = 16;

/// Data or an event of a port.
#[derive(Clone, Debug, PartialEq, Eq)]
#[expect(clippy::large_enum_variant, reason = "nearly all items are bytes, and none is allocated")]
pub enum Item {
    /// Bytes; empty when the line has been silent for 50 ms.
    Bytes {
        /// Arrival time.
        arrival: Time,
        /// The bytes.
        bytes: Piece,
    },
    /// The port changed.
    Changed(PortEvent),
    /// A command was not written completely.
    NotWritten(WriteError),
}

/// Bytes of one read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    bytes: [u8; PIECE],
    length: usize,
}

impl std::ops::Deref for Piece {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.bytes[..self.length]
    }
}

/// Data lost from a full queue.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    /// Number of items.
    pub items: u64,
    /// Number of bytes in the lost items.
    pub bytes: u64,
}

#[derive(Debug, Default)]
struct Shared {
    items: VecDeque<Item>,
    commands: VecDeque<Vec<u8>>,
    dropped: Dropped,
    counts: PortCounts,
    stop: bool,
}

/// A thread that reads a port into a queue of bounded length. A full queue drops and counts its oldest item.
/// Dropping this ends the thread.
#[derive(Debug)]
pub struct Reader {
    shared: Arc<(Mutex<Shared>, Signal)>,
    clock: Clock,
    task: Option<Task<()>>,
}

impl Reader {
    /// Starts reading `port`; the queue holds the last `capacity` items, at least one.
    ///
    /// # Errors
    /// A thread cannot be started.
    pub fn spawn(mut port: Port, clock: &Clock, capacity: usize) -> io::Result<Self> {
        let capacity = capacity.max(1);
        let items = VecDeque::with_capacity(capacity);
        let shared =
            Arc::new((Mutex::new(Shared { items, ..Default::default() }), Signal::default()));
        let theirs = Arc::clone(&shared);
        let name = format!("read {}", port.config().path);
        let its_clock = clock.clone();
        let task = clock.spawn(name, move || pump(&mut port, &its_clock, capacity, &theirs))?;
        Ok(Self { shared, clock: clock.clone(), task: Some(task) })
    }

    /// The oldest item, waiting until `deadline`.
    #[must_use]
    pub fn receive(&self, deadline: Time) -> Option<Item> {
        let (mutex, arrived) = &*self.shared;
        let mut shared = lock(mutex);
        loop {
            if let Some(item) = shared.items.pop_front() {
                return Some(item);
            }
            if self.clock.now() >= deadline {
                return None;
            }
            shared = self.clock.wait(arrived, mutex, shared, deadline);
        }
    }

    /// Queues `bytes` to be written within about 20 ms. False if the queue of commands is full.
    pub fn write(&self, bytes: &[u8]) -> bool {
        let mut shared = lock(&self.shared.0);
        let room = shared.commands.len() < COMMANDS;
        if room {
            shared.commands.push_back(bytes.to_vec());
        }
        room
    }

    /// Data lost from a full queue.
    #[must_use]
    pub fn dropped(&self) -> Dropped {
        lock(&self.shared.0).dropped
    }

    /// Statistics of the port.
    #[must_use]
    pub fn counts(&self) -> PortCounts {
        lock(&self.shared.0).counts
    }
}

impl Drop for Reader {
    fn drop(&mut self) {
        lock(&self.shared.0).stop = true;
        if let Some(task) = self.task.take() {
            // A panic has already printed its message.
            let _ = task.join();
        }
    }
}

fn pump(port: &mut Port, clock: &Clock, capacity: usize, shared: &(Mutex<Shared>, Signal)) {
    let (shared, arrived) = shared;
    let mut buffer = [0; PIECE];
    // Time at which silence is to be reported.
    let mut silent_at = None;
    loop {
        let attention = clock.now() + ATTENTION_S;
        let deadline = silent_at.map_or(attention, |silent: Time| silent.min(attention));
        let item = match port.read_until(&mut buffer, deadline) {
            Read::Bytes { count, arrival } => {
                silent_at = Some(arrival + SILENCE_S);
                Some(Item::Bytes { arrival, bytes: Piece { bytes: buffer, length: count } })
            }
            Read::Silent => {
                let now = clock.now();
                silent_at.take_if(|silent| *silent <= now).map(|_| Item::Bytes {
                    arrival: now,
                    bytes: Piece { bytes: [0; PIECE], length: 0 },
                })
            }
            Read::Changed(event) => Some(Item::Changed(event)),
        };
        let mut queue = lock(shared);
        if let Some(item) = item {
            queue.push(item, capacity);
            clock.raise(arrived);
        }
        if queue.stop {
            return;
        }
        while let Some(command) = queue.commands.pop_front() {
            drop(queue);
            let written = port.write(&command, clock.now() + WRITE_S);
            queue = lock(shared);
            if let Err(error) = written {
                queue.push(Item::NotWritten(error), capacity);
                clock.raise(arrived);
            }
        }
        queue.counts = port.counts();
    }
}

impl Shared {
    fn push(&mut self, item: Item, capacity: usize) {
        if self.items.len() >= capacity {
            // Old bytes are useless, but changes of the port must be reported.
            let oldest = self.items.iter().position(|item| matches!(item, Item::Bytes { .. }));
            if let Some(Item::Bytes { bytes, .. }) = self.items.remove(oldest.unwrap_or(0)) {
                self.dropped.bytes += bytes.len() as u64;
            }
            self.dropped.items += 1;
        }
        self.items.push_back(item);
    }
}
