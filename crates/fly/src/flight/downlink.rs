//! Telemetry: the newest snapshot to the ground, from a thread of its own.

use std::collections::VecDeque;
use std::io;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, TryLockError};
use std::thread::{self, JoinHandle};

use crate::Mavlink;
use crate::serial::{Clock, Port, PortConfig, Read};
use hovernav::telemetry::{Flow, Snapshot, frame};
use hovernav::time::Time;
use hovernav_log::FlyConfig;
use hovernav_log::record::{Level, ShortText};

/// How long the thread listens to the ground before it looks for a snapshot, s.
const LISTEN_S: f64 = 0.005;

/// How long a frame may take to be handed to the line, s: less than a cycle.
const WRITE_S: f64 = 0.025;

/// What is sent on the line.
enum Encoder {
    /// Packed frames, while the ground has switched them on.
    Packed(Flow),
    /// MAVLink 2, always.
    Mavlink(Box<Mavlink>),
}

/// What became of the snapshots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DownlinkCounts {
    /// Handed to the line.
    pub sent: u64,
    /// Due to be sent, and lost to a newer one or to a line that took no more.
    pub dropped: u64,
}

/// Texts that may wait for the line.
const TEXTS: usize = 32;

#[derive(Default)]
struct Shared {
    newest: Mutex<Option<Snapshot>>,
    texts: Mutex<VecDeque<(Level, ShortText)>>,
    sent: AtomicU64,
    dropped: AtomicU64,
    stop: AtomicBool,
}

/// One line to the ground.
struct Downlink {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// The lines to the ground that the configuration names.
pub struct Downlinks {
    packed: Option<Downlink>,
    mavlink: Option<Downlink>,
}

impl Downlinks {
    /// Opens the lines that `config` names, of a flight that starts at `start` on `clock`, `unix_ns`
    /// after the start of 1970.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn open(config: &FlyConfig, clock: Clock, start: Time, unix_ns: i64) -> io::Result<Self> {
        let packed = config.telemetry.as_ref().map(|section| {
            let port = Port::new(PortConfig::new(&section.port, section.baud), clock);
            Downlink::spawn(port, clock, Encoder::Packed(Flow::default()))
        });
        let mavlink = config.mavlink.as_ref().map(|section| {
            let mut mavlink = Mavlink::new(section.speaker, start);
            mavlink.set_utc(unix_ns, start);
            let port = Port::new(PortConfig::new(&section.port, section.baud), clock);
            Downlink::spawn(port, clock, Encoder::Mavlink(Box::new(mavlink)))
        });
        Ok(Self { packed: packed.transpose()?, mavlink: mavlink.transpose()? })
    }

    /// Offers the newest snapshot to each; never waits.
    pub fn offer(&self, snapshot: &Snapshot) {
        for downlink in self.packed.iter().chain(&self.mavlink) {
            downlink.offer(snapshot);
        }
    }

    /// Offers a text to the line that carries texts; never waits. Where too many wait, the oldest goes.
    pub fn say(&self, level: Level, text: ShortText) {
        let Some(downlink) = &self.mavlink else { return };
        if let Ok(mut texts) = downlink.shared.texts.try_lock() {
            if texts.len() == TEXTS {
                texts.pop_front();
            }
            texts.push_back((level, text));
        }
    }

    /// What became of the snapshots: in packed frames, in MAVLink.
    pub fn counts(&self) -> (DownlinkCounts, DownlinkCounts) {
        let counts = |downlink: &Option<Downlink>| {
            downlink.as_ref().map(Downlink::counts).unwrap_or_default()
        };
        (counts(&self.packed), counts(&self.mavlink))
    }
}

impl Downlink {
    /// Sends what `encoder` makes of the snapshots on `port` from now on.
    ///
    /// # Errors
    /// The system gives no thread.
    fn spawn(port: Port, clock: Clock, encoder: Encoder) -> io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let theirs = Arc::clone(&shared);
        let thread = thread::Builder::new()
            .name("telemetry".into())
            .spawn(move || transmit(port, clock, encoder, &theirs))?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Offers the newest snapshot; never waits.
    fn offer(&self, snapshot: &Snapshot) {
        let mut newest = match self.shared.newest.try_lock() {
            Ok(newest) => newest,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            // The thread is taking the one before.
            Err(TryLockError::WouldBlock) => {
                self.shared.dropped.fetch_add(1, Ordering::Relaxed);
                return;
            }
        };
        if newest.replace(*snapshot).is_some() {
            self.shared.dropped.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// What became of the snapshots.
    fn counts(&self) -> DownlinkCounts {
        DownlinkCounts {
            sent: self.shared.sent.load(Ordering::Relaxed),
            dropped: self.shared.dropped.load(Ordering::Relaxed),
        }
    }
}

impl Drop for Downlink {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has already said so.
            let _ = thread.join();
        }
    }
}

fn transmit(mut port: Port, clock: Clock, mut encoder: Encoder, shared: &Shared) {
    let mut received = [0; 64];
    let (mut sequence, mut bytes) = (0u8, Vec::with_capacity(2048));
    while !shared.stop.load(Ordering::Relaxed) {
        let read = port.read_until(&mut received, clock.now() + LISTEN_S);
        if let (Read::Bytes { count, .. }, Encoder::Packed(flow)) = (read, &mut encoder) {
            flow.receive(&received[..count]);
        }
        let newest = shared.newest.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some(snapshot) = newest.filter(|_| port.is_open()) else { continue };
        bytes.clear();
        match &mut encoder {
            Encoder::Packed(flow) => {
                if flow.is_on() {
                    bytes.extend_from_slice(&frame::pack(&snapshot, sequence));
                    sequence = sequence.wrapping_add(1);
                }
            }
            Encoder::Mavlink(mavlink) => {
                mavlink.encode(&snapshot, &mut bytes);
                // One text a snapshot leaves the line to the others.
                let text = shared.texts.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
                if let Some((level, text)) = text {
                    mavlink.encode_text(level, text.as_str(), &mut bytes);
                }
            }
        }
        if bytes.is_empty() {
            continue;
        }
        let counter = match port.write(&bytes, clock.now() + WRITE_S) {
            Ok(()) => &shared.sent,
            Err(_) => &shared.dropped,
        };
        counter.fetch_add(1, Ordering::Relaxed);
    }
}
