//! Records: MCAP files of the telemetry, written by their own thread and readable up to the last moment before a crash.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Read as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use hovernav_record::{Piece, pieces, records};
use hovernav_toml::open_file;
use mcap::records::{MessageHeader, Record};
use mcap::write::NoSeek;
use mcap::{McapError, WriteOptions};
use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::channel::{CHANNELS, Id};
use crate::store::{Batch, Marker, Store, TextLine};

/// Entries that may wait for the disk: 10 s of telemetry.
const QUEUE: usize = 1024;
/// Longest time, from arrival, until data reach the operating system.
const FLUSH: Duration = Duration::from_millis(50);
/// Longest time, from arrival, until data reach the disk.
const SYNC: Duration = Duration::from_millis(200);
/// Largest file that is opened, bytes.
const LARGEST: u64 = 1 << 30;

const TELEMETRY: &str = "telemetry";
const TEXTS: &str = "texts";
const MARKERS: &str = "markers";

/// Errors of records.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// A record is being written already.
    #[error(
        "found the record {name} still being written, expected no active record: stop it first"
    )]
    Busy {
        /// Its name.
        name: String,
    },
    /// The file cannot be created, read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The file is too large.
    #[error("{}: found {found} bytes, expected {LARGEST} at most", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its size.
        found: u64,
    },
    /// The file is neither a record of a ground station nor a readable record of a flight computer.
    #[error("{source}")]
    Flight {
        /// The cause.
        source: hovernav_dataset::LogError,
    },
    /// The file is not a record of a ground station.
    #[error("{}: found {found}, expected the topic `{TELEMETRY}` of a ground station's record", path.display())]
    NotARecord {
        /// The file.
        path: PathBuf,
        /// Description of the file's contents.
        found: String,
    },
}

/// The progress of a record.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Recording {
    /// Name.
    pub name: String,
    /// Frames written.
    pub frames: u64,
    /// Entries dropped because the queue was full.
    pub lost: u64,
    /// The write error, if any.
    pub fault: Option<String>,
    /// Time since the start, s.
    pub duration_s: f64,
}

enum Entry {
    Batch(Batch),
    Text(TextLine),
    Marker(Marker),
}

#[derive(Default)]
struct Progress {
    frames: AtomicU64,
    lost: AtomicU64,
    fault: Mutex<Option<String>>,
    ending: AtomicBool,
}

impl Progress {
    fn failed(&self, error: &McapError) {
        let mut fault = self.fault.lock().unwrap_or_else(PoisonError::into_inner);
        *fault = Some(error.to_string());
    }
}

/// A record being written.
pub struct Recorder {
    name: String,
    begun: Instant,
    entries: SyncSender<Entry>,
    progress: Arc<Progress>,
    thread: Option<JoinHandle<()>>,
}

impl Recorder {
    /// Starts a record in a new file.
    ///
    /// # Errors
    /// If the file exists, or cannot be created.
    pub fn create(path: &Path, name: &str) -> Result<Self, RecordError> {
        let failed = |source| RecordError::Io { path: path.to_path_buf(), source };
        let file = OpenOptions::new().write(true).create_new(true).open(path).map_err(failed)?;
        let writer = Writer::new(file).map_err(|error| failed(io::Error::other(error)))?;
        let (entries, queue) = sync_channel(QUEUE);
        let progress = Arc::new(Progress::default());
        let theirs = Arc::clone(&progress);
        let thread = thread::Builder::new()
            .name("record".into())
            .spawn(move || writer.run(&queue, &theirs))
            .map_err(failed)?;
        let (name, begun) = (name.to_owned(), Instant::now());
        Ok(Self { name, begun, entries, progress, thread: Some(thread) })
    }

    /// Records values without waiting.
    pub fn push(&self, batch: Batch) {
        self.send(Entry::Batch(batch));
    }

    /// Records a text.
    pub fn say(&self, line: TextLine) {
        self.send(Entry::Text(line));
    }

    /// Records a marker.
    pub fn mark(&self, marker: Marker) {
        self.send(Entry::Marker(marker));
    }

    fn send(&self, entry: Entry) {
        if let Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) =
            self.entries.try_send(entry)
        {
            self.progress.lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// The progress of the record.
    #[must_use]
    pub fn recording(&self) -> Recording {
        let fault = self.progress.fault.lock().unwrap_or_else(PoisonError::into_inner);
        Recording {
            name: self.name.clone(),
            frames: self.progress.frames.load(Ordering::Relaxed),
            lost: self.progress.lost.load(Ordering::Relaxed),
            fault: fault.clone(),
            duration_s: self.begun.elapsed().as_secs_f64(),
        }
    }

    /// Ends the record after all data are on the disk.
    #[must_use]
    pub fn finish(mut self) -> Recording {
        self.end();
        self.recording()
    }

    fn end(&mut self) {
        self.progress.ending.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // The panic message was already printed.
            let _ = thread.join();
        }
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        self.end();
    }
}

/// The thread that writes.
struct Writer {
    mcap: mcap::Writer<NoSeek<BufWriter<File>>>,
    file: File,
    channels: [u16; 3],
    sequence: u32,
}

impl Writer {
    fn new(file: File) -> Result<Self, McapError> {
        let out = BufWriter::with_capacity(1 << 16, file.try_clone()?);
        let mut mcap = WriteOptions::new()
            .compression(None)
            .chunk_size(None)
            .disable_seeking(true)
            .library(concat!("hovernav-ground ", env!("CARGO_PKG_VERSION")))
            .create(NoSeek::new(out))?;
        let number =
            |unit: &str, label: &str| json!({"type": "number", "unit": unit, "title": label});
        let of_channels = CHANNELS.iter().map(|c| (c.name.to_owned(), number(c.unit, c.label)));
        let text = json!({"type": "string"});
        let time = number("s", "seconds since the start of 1970");
        let properties = [
            (TELEMETRY, "hovernav.Telemetry", Value::Object(of_channels.collect())),
            (TEXTS, "hovernav.Text", json!({"time_s": time, "level": text, "text": text})),
            (MARKERS, "hovernav.Marker", json!({"time_s": time, "note": text})),
        ];
        let mut channels = [0; 3];
        for (id, (topic, name, properties)) in channels.iter_mut().zip(properties) {
            let schema = json!({"type": "object", "title": name, "properties": properties});
            let schema = mcap.add_schema(name, "jsonschema", schema.to_string().as_bytes())?;
            *id = mcap.add_channel(schema, topic, "json", &BTreeMap::new())?;
        }
        mcap.flush()?;
        Ok(Self { mcap, file, channels, sequence: 0 })
    }

    fn run(mut self, queue: &Receiver<Entry>, progress: &Progress) {
        let (mut flushed, mut synced) = (Instant::now(), Instant::now());
        let mut dirty = false;
        loop {
            let entry = queue.recv_timeout(FLUSH);
            let result = match entry {
                Ok(entry) => {
                    dirty = true;
                    progress.frames.fetch_add(1, Ordering::Relaxed);
                    self.write(&entry)
                }
                Err(RecvTimeoutError::Timeout) if progress.ending.load(Ordering::Relaxed) => break,
                Err(RecvTimeoutError::Timeout) => Ok(()),
                Err(RecvTimeoutError::Disconnected) => break,
            };
            let result = result.and_then(|()| {
                if dirty && flushed.elapsed() >= FLUSH {
                    flushed = Instant::now();
                    self.mcap.flush()?;
                    if synced.elapsed() >= SYNC {
                        (synced, dirty) = (Instant::now(), false);
                        self.file.sync_data()?;
                    }
                }
                Ok(())
            });
            if let Err(error) = result {
                progress.failed(&error);
            }
        }
        let ended = self.mcap.finish().and_then(|_| Ok(self.file.sync_all()?));
        if let Err(error) = ended {
            progress.failed(&error);
        }
    }

    fn write(&mut self, entry: &Entry) -> Result<(), McapError> {
        let json = |message: Result<Vec<u8>, _>| message.map_err(io::Error::from);
        let (topic, time_s, message) = match entry {
            Entry::Batch(batch) => (0, batch.time_s, json(serde_json::to_vec(&values(batch)))?),
            Entry::Text(line) => (1, line.time_s, json(serde_json::to_vec(line))?),
            Entry::Marker(marker) => (2, marker.time_s, json(serde_json::to_vec(marker))?),
        };
        let time_ns = (time_s * 1e9) as u64;
        self.sequence = self.sequence.wrapping_add(1);
        let header = MessageHeader {
            channel_id: self.channels[topic],
            sequence: self.sequence,
            log_time: time_ns,
            publish_time: time_ns,
        };
        self.mcap.write_to_known_channel(&header, &message)
    }
}

/// The values of a batch by channel name; unknown values are `null`.
fn values(batch: &Batch) -> Map<String, Value> {
    let named = |&(id, value): &(Id, f64)| (CHANNELS[id as usize].name.to_owned(), json!(value));
    batch.values.iter().map(named).collect()
}

/// Reads a record, even if it was truncated at any byte. Returns whether it was truncated.
///
/// # Errors
/// If the file cannot be read, is too large, or contains no telemetry of a ground station.
pub fn read(path: &Path) -> Result<(Store, bool), RecordError> {
    let failed = |source| RecordError::Io { path: path.to_path_buf(), source };
    let found = std::fs::metadata(path).map_err(failed)?.len();
    if found > LARGEST {
        return Err(RecordError::TooLarge { path: path.to_path_buf(), found });
    }
    let mut bytes = Vec::new();
    let file = open_file(path, LARGEST).map_err(failed)?;
    file.take(LARGEST).read_to_end(&mut bytes).map_err(failed)?;
    let not = |found: String| RecordError::NotARecord { path: path.to_path_buf(), found };
    if !bytes.starts_with(mcap::MAGIC) {
        return Err(not("a file without the MCAP signature".into()));
    }
    let mut store = Store::new(usize::MAX);
    let mut names = BTreeMap::new();
    let mut topics = BTreeSet::new();
    let mut is_cut = false;
    for (_, piece) in pieces(&bytes) {
        let data = match piece {
            Piece::Chunk(data) => data,
            Piece::Damage { .. } => {
                is_cut = true;
                continue;
            }
            _ => continue,
        };
        for record in records(&data) {
            let (header, data) = match record {
                Record::Channel(channel) => {
                    names.insert(channel.id, channel.topic);
                    continue;
                }
                Record::Message { header, data } => (header, data),
                _ => continue,
            };
            let Some(topic) = names.get(&header.channel_id) else { continue };
            is_cut |= !take(&mut store, topic, header.log_time as f64 * 1e-9, &data);
            if topics.len() < 16 {
                topics.insert(topic.clone());
            }
        }
    }
    if store.span().is_none() {
        let topics: Vec<_> = topics.into_iter().collect();
        return Err(not(if topics.is_empty() {
            "no telemetry".into()
        } else {
            format!("the topics {}", topics.join(", "))
        }));
    }
    Ok((store, is_cut))
}

/// Adds a message to `store`. Returns `false` if its content is damaged.
fn take(store: &mut Store, topic: &str, time_s: f64, data: &[u8]) -> bool {
    match topic {
        TELEMETRY => {
            let Ok(values) = serde_json::from_slice::<Map<String, Value>>(data) else {
                return false;
            };
            let known = |(name, value): (&String, &Value)| {
                let id = Id::of(name)?;
                Some((id, CHANNELS[id as usize].plausible(value.as_f64())))
            };
            store.push(&Batch { time_s, values: values.iter().filter_map(known).collect() });
        }
        TEXTS => {
            if let Ok(text) = serde_json::from_slice(data) {
                store.say(text);
            }
        }
        MARKERS => {
            if let Ok(marker) = serde_json::from_slice(data) {
                store.mark(marker);
            }
        }
        _ => {}
    }
    true
}
