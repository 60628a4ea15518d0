//! Telemetry: sends the newest snapshot to the ground in a thread of its own.

use std::collections::VecDeque;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, TryLockError};

use super::ground_line::GroundLine;
use super::port_name::PortName;
use crate::Mavlink;
use crate::serial::{Clock, PortEvent, Task};
use hovernav::telemetry::{Flow, Severity, Snapshot, Supplement, Text, frame};
use hovernav::time::Time;
use hovernav_record::{FlyConfig, Level, ShortText};

/// Time that the thread waits for data from the ground before it checks for a snapshot, s.
const LISTEN_S: f64 = 0.005;

/// Timeout for writing a frame to the line, s: less than a cycle.
const WRITE_S: f64 = 0.025;

/// Longest and shortest interval between supplements, s.
const SUPPLEMENT_S: [f64; 2] = [2.0, 0.1];
/// Shortest interval, s, from a supplement to the next one if its content has changed.
const CHANGE_S: f64 = 0.1;
/// Rate of snapshots, Hz, that is assumed to compute the capacity left for supplements.
const SNAPSHOTS_HZ: f64 = 33.0;
/// Interval of empty frames from a paused vehicle on UDP, s. They inform the ground of the vehicle's address.
const PRESENCE_S: f64 = 1.0;

/// Format of the telemetry on a line.
enum Encoder {
    /// Packed frames; they are sent only while the ground has enabled them.
    Packed(Box<Packed>),
    /// MAVLink 2; always sent.
    Mavlink(Box<Mavlink>),
}

/// Statistics of the snapshots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DownlinkCounts {
    /// Number of snapshots written to the line.
    pub sent: u64,
    /// Number of snapshots that were not sent: replaced by a newer one, offered while the thread read an earlier one,
    /// or not accepted by the line.
    pub dropped: u64,
}

/// Length of the queue of texts.
const TEXTS: usize = 32;

/// Encoder of packed frames: snapshots, with supplements and texts in between.
struct Packed {
    flow: Flow,
    sequence: u8,
    /// Interval between supplements, s.
    interval_s: f64,
    /// The last supplement sent.
    reported: Option<Supplement>,
    /// Remaining pieces of texts.
    texts: VecDeque<Text>,
    /// Time of the last empty frame of a paused vehicle; `None` on a line that does not need them.
    presence: Option<Time>,
}

impl Packed {
    /// An encoder for a line with a capacity of `budget` bytes per second.
    fn new(budget: Option<f64>, now: Time) -> Self {
        let [max_s, min_s] = SUPPLEMENT_S;
        let interval_s = budget.map_or(min_s, |budget| {
            let left = budget - SNAPSHOTS_HZ * frame::LENGTH as f64;
            if left > 0.0 { frame::SUPPLEMENT_LENGTH as f64 / left } else { max_s }
        });
        Self {
            flow: Flow::default(),
            sequence: 0,
            interval_s: interval_s.clamp(min_s, max_s),
            reported: None,
            texts: VecDeque::new(),
            presence: budget.is_none().then_some(now),
        }
    }

    fn encode(&mut self, snapshot: &Snapshot, supplement: &Supplement, bytes: &mut Vec<u8>) {
        if !self.flow.is_on() {
            self.reported = None;
            self.texts.clear();
            if let Some(last) = &mut self.presence
                && snapshot.time - *last > PRESENCE_S
            {
                *last = snapshot.time;
                // An empty frame, which every decoder skips.
                bytes.push(0);
            }
            return;
        }
        bytes.extend_from_slice(&frame::pack(snapshot, self.number()));
        let due = self.reported.is_none_or(|reported| {
            let since_s = supplement.time - reported.time;
            since_s >= self.interval_s || since_s >= CHANGE_S && supplement.differs_from(&reported)
        });
        if due {
            bytes.extend_from_slice(&frame::pack_supplement(supplement, self.number()));
            self.reported = Some(*supplement);
        } else if let Some(text) = self.texts.pop_front() {
            bytes.extend_from_slice(&frame::pack_text(&text, self.number()));
        }
    }

    fn say(&mut self, time: Time, level: Level, line: &str) {
        let severity = match level {
            Level::Info => Severity::Info,
            Level::Warning => Severity::Warning,
            // `Error` is the highest severity in a packed frame.
            Level::Error | Level::Critical => Severity::Error,
        };
        let mut rest = line.trim();
        while !rest.is_empty() {
            let (text, left) = Text::first_of(time, severity, rest);
            self.texts.push_back(text);
            rest = left;
        }
    }

    fn number(&mut self) -> u8 {
        let number = self.sequence;
        self.sequence = number.wrapping_add(1);
        number
    }
}

struct Shared {
    /// UTC since 1970 minus the flight clock, ns.
    utc_offset_ns: AtomicI64,
    newest: Mutex<Option<(Snapshot, Supplement)>>,
    texts: Mutex<VecDeque<(Time, Level, ShortText)>>,
    /// Changes of the line's port.
    changes: Mutex<VecDeque<PortEvent>>,
    sent: AtomicU64,
    dropped: AtomicU64,
    stop: AtomicBool,
}

/// One line to the ground.
struct Downlink {
    name: PortName,
    shared: Arc<Shared>,
    task: Option<Task<()>>,
}

/// The configured lines to the ground.
pub struct Downlinks {
    packed: Option<Downlink>,
    mavlink: Option<Downlink>,
}

impl Downlinks {
    /// Opens the lines in `config` for a flight that starts at `start` on `clock`; `unix_ns` is UTC at the start,
    /// ns since 1970.
    ///
    /// # Errors
    /// A thread cannot be started.
    pub fn open(config: &FlyConfig, clock: &Clock, start: Time, unix_ns: i64) -> io::Result<Self> {
        let utc_offset_ns = unix_ns.saturating_sub(start.nanoseconds());
        let packed = config.telemetry.as_ref().map(|section| {
            let (port, udp) = (section.port.as_ref(), section.udp.as_ref());
            let line = GroundLine::new(port, section.baud, udp, clock);
            let packed = Packed::new(line.budget(), start);
            let name = PortName::new("telemetry", "[telemetry] port", path(port));
            Downlink::spawn(name, line, clock, Encoder::Packed(Box::new(packed)), utc_offset_ns)
        });
        let mavlink = config.mavlink.as_ref().map(|section| {
            let mavlink = Mavlink::new(section.speaker, start);
            let (port, udp) = (section.port.as_ref(), section.udp.as_ref());
            let line = GroundLine::new(port, section.baud, udp, clock);
            let name = PortName::new("mavlink", "[mavlink] port", path(port));
            Downlink::spawn(name, line, clock, Encoder::Mavlink(Box::new(mavlink)), utc_offset_ns)
        });
        Ok(Self { packed: packed.transpose()?, mavlink: mavlink.transpose()? })
    }

    /// Passes the newest snapshot and supplement to each line; never waits.
    pub fn offer(&self, snapshot: &Snapshot, supplement: &Supplement) {
        for downlink in self.packed.iter().chain(&self.mavlink) {
            downlink.offer(snapshot, supplement);
        }
    }

    /// Sets UTC minus the flight clock, ns.
    pub fn report_utc(&self, offset_ns: i64) {
        for downlink in self.packed.iter().chain(&self.mavlink) {
            downlink.shared.utc_offset_ns.store(offset_ns, Ordering::Relaxed);
        }
    }

    /// Passes a text to each line; never waits. A full queue drops its oldest text.
    pub fn say(&self, time: Time, level: Level, text: ShortText) {
        for downlink in self.packed.iter().chain(&self.mavlink) {
            if let Ok(mut texts) = downlink.shared.texts.try_lock() {
                if texts.len() == TEXTS {
                    texts.pop_front();
                }
                texts.push_back((time, level, text));
            }
        }
    }

    /// The next unreported change of a port; never waits.
    pub fn change(&self) -> Option<(&PortName, PortEvent)> {
        self.packed.iter().chain(&self.mavlink).find_map(|downlink| {
            let event = downlink.shared.changes.try_lock().ok()?.pop_front()?;
            Some((&downlink.name, event))
        })
    }

    /// Statistics of the snapshots: packed frames, MAVLink.
    pub fn counts(&self) -> (DownlinkCounts, DownlinkCounts) {
        let counts = |downlink: &Option<Downlink>| {
            downlink.as_ref().map(Downlink::counts).unwrap_or_default()
        };
        (counts(&self.packed), counts(&self.mavlink))
    }
}

impl Shared {
    fn new(utc_offset_ns: i64) -> Self {
        Self {
            utc_offset_ns: AtomicI64::new(utc_offset_ns),
            newest: Mutex::default(),
            texts: Mutex::default(),
            changes: Mutex::default(),
            sent: AtomicU64::default(),
            dropped: AtomicU64::default(),
            stop: AtomicBool::default(),
        }
    }
}

impl Downlink {
    /// Starts the thread that encodes snapshots with `encoder` and sends them on `line`.
    ///
    /// # Errors
    /// A thread cannot be started.
    fn spawn(
        name: PortName,
        line: GroundLine,
        clock: &Clock,
        encoder: Encoder,
        utc_offset_ns: i64,
    ) -> io::Result<Self> {
        let shared = Arc::new(Shared::new(utc_offset_ns));
        let theirs = Arc::clone(&shared);
        let its_clock = clock.clone();
        let task =
            clock.spawn("telemetry", move || transmit(line, &its_clock, encoder, &theirs))?;
        Ok(Self { name, shared, task: Some(task) })
    }

    /// Passes the newest snapshot to the thread; never waits.
    fn offer(&self, snapshot: &Snapshot, supplement: &Supplement) {
        let mut newest = match self.shared.newest.try_lock() {
            Ok(newest) => newest,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            // The thread is reading the previous snapshot.
            Err(TryLockError::WouldBlock) => {
                self.shared.dropped.fetch_add(1, Ordering::Relaxed);
                return;
            }
        };
        if newest.replace((*snapshot, *supplement)).is_some() {
            self.shared.dropped.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Statistics of the snapshots.
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
        if let Some(task) = self.task.take() {
            // A panic has already printed its message.
            let _ = task.join();
        }
    }
}

/// Path of `port`; empty without a port.
fn path(port: Option<&PathBuf>) -> &Path {
    port.map_or(Path::new(""), PathBuf::as_path)
}

fn transmit(mut line: GroundLine, clock: &Clock, mut encoder: Encoder, shared: &Shared) {
    let mut received = [0; 2048];
    let mut bytes = Vec::with_capacity(2048);
    while !shared.stop.load(Ordering::Relaxed) {
        let count = line.read_until(&mut received, clock.now() + LISTEN_S);
        if let Some(event) = line.take_change() {
            let mut changes = shared.changes.lock().unwrap_or_else(PoisonError::into_inner);
            if changes.len() < TEXTS {
                changes.push_back(event);
            }
        }
        match &mut encoder {
            Encoder::Packed(packed) => packed.flow.receive(&received[..count]),
            Encoder::Mavlink(mavlink) => mavlink.receive(&received[..count], clock.now()),
        }
        let newest = shared.newest.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some((snapshot, supplement)) = newest.filter(|_| line.is_open()) else { continue };
        bytes.clear();
        // At most one text per snapshot leaves capacity for the other data.
        let text = shared.texts.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
        match &mut encoder {
            Encoder::Packed(packed) => {
                if let Some((time, level, text)) = text {
                    packed.say(time, level, text.as_str());
                }
                packed.encode(&snapshot, &supplement, &mut bytes);
            }
            Encoder::Mavlink(mavlink) => {
                mavlink.set_utc(shared.utc_offset_ns.load(Ordering::Relaxed), Time::ZERO);
                mavlink.encode(&snapshot, &mut bytes);
                if let Some((_, level, text)) = text {
                    mavlink.encode_text(level, text.as_str(), &mut bytes);
                }
                mavlink.answer(&mut bytes);
            }
        }
        if bytes.is_empty() {
            continue;
        }
        let taken = line.write(&bytes, clock.now() + WRITE_S);
        let counter = if taken { &shared.sent } else { &shared.dropped };
        counter.fetch_add(1, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hovernav::autopilot::Mode;
    use hovernav::telemetry::frame::{Decoder, Message};
    use std::time::Instant;

    /// The number of bytes and the messages of a flight of `seconds` on a line of `baud`.
    fn flown(baud: u32, seconds: u32, mode_at: impl Fn(u32) -> Mode) -> (usize, Vec<Message>) {
        let mut packed = Packed::new(Some(0.85 * f64::from(baud) / 10.0), Time::ZERO);
        packed.flow.receive(b"#");
        let mut bytes = Vec::new();
        for cycle in 0..33 * seconds {
            let time = Time::ZERO + f64::from(cycle) / 33.0;
            let supplement = Supplement { mode: Some(mode_at(cycle)), ..Supplement::at(time) };
            packed.encode(&Snapshot::at(time), &supplement, &mut bytes);
        }
        let mut decoder = Decoder::default();
        let messages = bytes.iter().filter_map(|byte| decoder.push_message(*byte));
        let messages = messages.map(Result::unwrap).collect();
        assert_eq!(decoder.counts().missing, 0);
        (bytes.len(), messages)
    }

    #[test]
    fn snapshots_and_supplements_leave_15_percent_of_a_modem_free() {
        let (bytes, messages) = flown(57_600, 20, |_| Mode::Manual);
        assert!(bytes as f64 * 10.0 / 20.0 <= 0.85 * 57_600.0, "{bytes} bytes in 20 s");
        let count = |wanted: fn(&Message) -> bool| messages.iter().filter(|m| wanted(m)).count();
        assert_eq!(count(|message| matches!(message, Message::Snapshot(_))), 660);
        assert!(count(|message| matches!(message, Message::Supplement(_))) >= 35);
        let (_, fast) = flown(115_200, 20, |_| Mode::Manual);
        assert!(fast.len() > 660 + 160, "{} messages", fast.len());
    }

    #[test]
    fn a_change_of_mode_is_sent_within_a_tenth_of_a_second() {
        let (_, messages) = flown(57_600, 4, |cycle| match cycle {
            0..40 => Mode::Manual,
            _ => Mode::Position,
        });
        let changed = messages.iter().find_map(|message| match message {
            Message::Supplement(reported) if reported.mode == Some(Mode::Position) => {
                Some(reported.time)
            }
            _ => None,
        });
        let after_s = (changed.unwrap() - Time::ZERO) - 40.0 / 33.0;
        assert!((-1e-6..0.11).contains(&after_s), "{after_s}");
    }

    #[test]
    fn a_long_text_arrives_complete_in_pieces() {
        let mut packed = Packed::new(None, Time::ZERO);
        packed.flow.receive(b"#");
        let line = "one-sigma of horizontal velocity, m/s: 0.812, at most 0.4; age of the last \
                    fix, s: über";
        packed.say(Time::ZERO, Level::Warning, line);
        let mut bytes = Vec::new();
        for cycle in 0..5 {
            let time = Time::ZERO + f64::from(cycle) / 33.0;
            packed.encode(&Snapshot::at(time), &Supplement::at(time), &mut bytes);
        }
        let mut decoder = Decoder::default();
        let said: String = bytes
            .iter()
            .filter_map(|byte| decoder.push_message(*byte))
            .filter_map(|message| match message {
                Ok(Message::Text(text)) => Some(text.as_str().to_owned()),
                _ => None,
            })
            .collect();
        assert_eq!(said, line);
    }

    #[test]
    fn a_paused_vehicle_on_udp_sends_only_empty_frames() {
        let mut packed = Packed::new(None, Time::ZERO);
        let mut bytes = Vec::new();
        for cycle in 0..330 {
            let time = Time::ZERO + f64::from(cycle) / 33.0;
            packed.encode(&Snapshot::at(time), &Supplement::at(time), &mut bytes);
        }
        assert!((8..=10).contains(&bytes.len()) && bytes.iter().all(|byte| *byte == 0));
    }

    #[test]
    fn a_ground_port_that_cannot_be_opened_is_reported_with_its_key() {
        let text =
            "[dmu]\nport = 'a'\n[receiver]\nport = 'b'\n[telemetry]\nport = '/nowhere/radio'\n";
        let config = FlyConfig::parse(text, "fly.toml".as_ref()).unwrap();
        let downlinks = Downlinks::open(&config, &Clock::start(), Time::ZERO, 0).unwrap();
        let started = Instant::now();
        let reported = std::iter::repeat_with(|| downlinks.change())
            .take_while(|_| started.elapsed().as_secs() < 20)
            .find_map(|change| change.map(|(name, event)| name.changed(&event).to_string()));
        let expected = "telemetry: port cannot be opened: there is no such device \
                        ([telemetry] port = \"/nowhere/radio\")";
        assert_eq!(reported.as_deref(), Some(expected));
    }
}
