//! The writer's side of the recorder: from the queue to the disk.

use std::collections::BTreeMap;
use std::io::{self, ErrorKind, Write};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, TryRecvError};
use std::thread;
use std::time::Duration;

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{McapError, McapResult, WriteOptions};
use serde::Serialize;

use super::Header;
use super::channel::Channel;
use super::entry::{Level, Queued};
use super::message::ConfigurationMessage;
use super::recorder::Shared;
use hovernav::time::Time;

/// What came in one interval makes one chunk, on its way to the disk at the end of it. A quarter of
/// the 200 ms that may be lost leaves the rest to a busy machine. A chunk costs 260 bytes of memory,
/// for the index at the end of the file: 19 MB an hour.
const INTERVAL: Duration = Duration::from_millis(50);
/// As much may wait in memory for a disk that is full or slow; beyond, entries stay in the queue.
const MOST_WAITING: u64 = 8 << 20;

/// Writes entries as messages.
pub struct Writer<W: Write> {
    mcap: mcap::Writer<NoSeek<Spool<W>>>,
    channels: [u16; Channel::ALL.len()],
    pub header: Header,
    shared: Arc<Shared>,
    json: Vec<u8>,
    /// Of the entry being written, or the last one.
    sequence: u32,
    now: Time,
    /// Since when the disk refuses.
    refused_since: Option<Time>,
}

impl<W: Write> Writer<W> {
    /// Writes all that stands before the flight.
    ///
    /// # Errors
    /// What `out` says.
    pub fn begin(out: W, header: &Header, shared: Arc<Shared>) -> io::Result<Self> {
        let refused = Arc::clone(&shared);
        let mut writer = Self::new(out, header, shared).map_err(into_io)?;
        writer.configuration().map_err(into_io)?;
        writer.mcap.flush().map_err(into_io)?;
        if refused.waiting.load(Ordering::Relaxed) > 0 {
            return Err(match refused.os_error.load(Ordering::Relaxed) {
                0 => io::Error::other("cannot be written"),
                number => io::Error::from_raw_os_error(number),
            });
        }
        Ok(writer)
    }

    fn new(out: W, header: &Header, shared: Arc<Shared>) -> McapResult<Self> {
        let spool = Spool { out, waiting: Vec::new(), shared: Arc::clone(&shared) };
        let mut mcap = WriteOptions::new()
            .compression(None)
            .library(format!("hovernav {}", header.version))
            .chunk_size(None)
            .disable_seeking(true)
            .create(NoSeek::new(spool))?;
        let mut channels = [0; Channel::ALL.len()];
        for (id, channel) in channels.iter_mut().zip(Channel::ALL) {
            let schema = channel.schema().to_string();
            let schema = mcap.add_schema(channel.schema_name(), "jsonschema", schema.as_bytes())?;
            *id = mcap.add_channel(schema, channel.topic(), "json", &BTreeMap::new())?;
        }
        Ok(Self {
            mcap,
            channels,
            header: header.clone(),
            shared,
            json: Vec::new(),
            sequence: 0,
            now: header.start,
            refused_since: None,
        })
    }

    fn configuration(&mut self) -> McapResult<()> {
        let fly_toml = self.header.config.to_toml().map_err(io::Error::other)?;
        let message = ConfigurationMessage {
            version: self.header.version.clone(),
            start_ns: self.header.start.nanoseconds(),
            start_unix_ns: self.header.start_unix_ns,
            fly_toml,
        };
        self.message(Channel::Configuration, self.header.start, &message)
    }

    /// Writes a message that was true at `time`.
    pub fn message(
        &mut self,
        channel: Channel,
        time: Time,
        message: &impl Serialize,
    ) -> McapResult<()> {
        self.json.clear();
        serde_json::to_writer(&mut self.json, message).map_err(io::Error::from)?;
        let header = MessageHeader {
            channel_id: self.channels[channel as usize],
            sequence: self.sequence,
            log_time: self.header.unix_ns(self.now),
            publish_time: self.header.unix_ns(time),
        };
        self.mcap.write_to_known_channel(&header, &self.json)
    }

    /// Writes what comes, until the loop ends the queue.
    pub fn run(mut self, entries: &Receiver<Queued>) {
        loop {
            let ended = self.drain(entries);
            let is_done = ended || self.mcap.flush().is_err();
            self.tell_refusals();
            if is_done {
                break;
            }
            thread::park_timeout(INTERVAL);
        }
        if self.mcap.finish().is_err() {
            self.shared.failed_writes.fetch_add(1, Ordering::Relaxed);
        }
        self.shared.finished.store(true, Ordering::Release);
    }

    /// Takes what is in the queue, but no more than there is memory for. Whether the queue has ended.
    fn drain(&mut self, entries: &Receiver<Queued>) -> bool {
        while self.shared.waiting.load(Ordering::Relaxed) < MOST_WAITING {
            match entries.try_recv() {
                Ok(queued) => {
                    self.shared.taken.fetch_add(1, Ordering::Relaxed);
                    (self.sequence, self.now) = (queued.sequence, queued.now);
                    if self.entry(&queued).is_err() {
                        self.shared.failed_writes.fetch_add(1, Ordering::Relaxed);
                    }
                }
                Err(TryRecvError::Empty) => return false,
                Err(TryRecvError::Disconnected) => return true,
            }
        }
        false
    }

    /// Tells in the record when the disk began to refuse, and when it went on.
    fn tell_refusals(&mut self) {
        let is_refusing = self.shared.waiting.load(Ordering::Relaxed) > 0;
        let told = match (self.refused_since, is_refusing) {
            (None, true) => {
                self.refused_since = Some(self.now);
                let number = self.shared.os_error.load(Ordering::Relaxed);
                let error = io::Error::from_raw_os_error(number).to_string();
                self.event(self.now, Level::Error, "record_refused", &error)
            }
            (Some(since), false) => {
                self.refused_since = None;
                let text = format!("the record is written again after {:.1} s", self.now - since);
                self.event(self.now, Level::Info, "record_resumed", &text)
            }
            _ => Ok(()),
        };
        if told.is_err() {
            self.shared.failed_writes.fetch_add(1, Ordering::Relaxed);
        }
    }
}

fn into_io(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}

/// Keeps what the disk does not take, and tries again: to MCAP, the disk is never full.
struct Spool<W> {
    out: W,
    waiting: Vec<u8>,
    shared: Arc<Shared>,
}

impl<W: Write> Write for Spool<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.waiting.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        let mut taken = 0;
        while taken < self.waiting.len() {
            let error = match self.out.write(&self.waiting[taken..]) {
                Ok(0) => ErrorKind::WriteZero.into(),
                Ok(count) => {
                    taken += count;
                    continue;
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                Err(error) => error,
            };
            self.shared.failed_writes.fetch_add(1, Ordering::Relaxed);
            self.shared.os_error.store(error.raw_os_error().unwrap_or(0), Ordering::Relaxed);
            break;
        }
        self.waiting.drain(..taken);
        self.shared.written.fetch_add(taken as u64, Ordering::Relaxed);
        self.shared.waiting.store(self.waiting.len() as u64, Ordering::Relaxed);
        Ok(())
    }
}
