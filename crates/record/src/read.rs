//! Reading of a record, intact or damaged.

use std::path::Path;

use mcap::records::{MessageHeader, Record as McapRecord};
use serde::de::DeserializeOwned;

use crate::channel::Channel;
use crate::chunks::{LARGEST_BYTES, Piece, Topics, pieces, records};
use crate::damage::{Damage, Repair};
use crate::entry::{Cycle, Level};
use crate::header::Header;
use crate::message::{
    ConfigurationMessage, ControlsMessage, CycleMessage, LostMessage, RawMessage, ReadLogMessage,
    SolutionMessage,
};
use crate::setup::FlyConfig;
use hovernav::ekf::Solution;
use hovernav::time::Time;
use hovernav_dataset::{LogError, spelt_out};
use hovernav_toml::read_bytes;

/// A call from the flight loop to the sensors' drivers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Call {
    /// [`Sensors::dmu`](hovernav::sensors::Sensors::dmu) with these bytes.
    Dmu(Vec<u8>),
    /// [`Sensors::gps`](hovernav::sensors::Sensors::gps) with these bytes.
    Gps(Vec<u8>),
    /// [`Sensors::restart_gps`](hovernav::sensors::Sensors::restart_gps).
    RestartGps,
    /// Bytes from the line of the servo pulses.
    Servo(Vec<u8>),
}

/// An event of a flight, from the record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordedEvent {
    /// Time of the event.
    pub time: Time,
    /// Severity.
    pub level: Level,
    /// Kind, for programs.
    pub kind: String,
    /// Sensor or function that caused the event or is at fault; empty if the record does not contain it.
    pub part: String,
    /// Text for people.
    pub text: String,
}

/// A cycle of flight control, from the record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordedCycle {
    /// Time on the flight's clock.
    pub time: Time,
    /// Number of [`Record::calls`] before this cycle.
    pub calls_before: usize,
    /// Inputs and results of the cycle.
    pub cycle: Cycle,
}

/// Content of a flight record, in the order of the loop.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Beginning of the record.
    pub header: Header,
    /// The calls from the flight loop to the sensors' drivers, with their times.
    pub calls: Vec<(Time, Call)>,
    /// The solutions computed in flight.
    pub solutions: Vec<Solution>,
    /// Stick positions: lateral, longitudinal, collective, pedal, each −1…1 about trim.
    pub controls: Vec<(Time, [f64; 4])>,
    /// The cycles of flight control, if an autopilot was configured.
    pub cycles: Vec<RecordedCycle>,
    /// The events.
    pub events: Vec<RecordedEvent>,
    /// Number of lost entries that a replay needs; the replay cannot reproduce the flight after such a loss.
    pub lost_raw: u64,
    /// Number of other lost entries.
    pub lost_decoded: u64,
    /// The last time of the loop.
    pub end: Time,
    /// Whether the record was ended regularly, not cut off; for a repaired record, whether the original was.
    pub is_ended: bool,
    /// Description of the repair that made this file; `None` for an original record.
    pub repair: Option<Repair>,
    /// Damaged parts of the file.
    pub damages: Vec<Damage>,
    /// Missing and damaged parts, one plain sentence each.
    pub warnings: Vec<String>,
}

impl Record {
    /// Whether the file `path` begins like an MCAP file; false if it cannot be read.
    #[must_use]
    pub fn is_mcap(path: &Path) -> bool {
        let mut magic = [0; mcap::MAGIC.len()];
        // Reading a pipe would block.
        path.is_file()
            && std::fs::File::open(path)
                .and_then(|mut file| std::io::Read::read_exact(&mut file, &mut magic))
                .is_ok_and(|()| magic == mcap::MAGIC)
    }

    /// Reads the record `path`. If the record was cut off or damaged, the intact parts are read, and
    /// [`warnings`](Self::warnings) describe the rest.
    ///
    /// # Errors
    /// [`LogError::Io`]; [`LogError::Bytes`] if the file is empty, not MCAP, from another program, or cut off or
    /// damaged before the end of its configuration; [`LogError::Unusable`] for a configuration that this version
    /// rejects.
    pub fn open(path: &Path) -> Result<Self, LogError> {
        Self::read(&read_bytes(path, LARGEST_BYTES).map_err(LogError::io(path))?, path)
    }

    /// Reads a record from memory; `path` names it in messages.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn read(bytes: &[u8], path: &Path) -> Result<Self, LogError> {
        let magic = mcap::MAGIC.len();
        if !bytes.starts_with(mcap::MAGIC) {
            let shown = bytes[..bytes.len().min(magic)].escape_ascii();
            let found = if bytes.is_empty() { "nothing".into() } else { format!("\"{shown}\"") };
            return Err(LogError::bytes(path, 0, format!("found {found}, expected an MCAP file")));
        }
        let mut reader = Reader { record: configured(bytes, path)?, ..Reader::default() };
        for (offset, piece) in pieces(bytes) {
            match piece {
                Piece::Chunk(data) => reader.chunk(&data, path)?,
                Piece::Damage { reason, bytes } => {
                    reader.begun = Default::default();
                    reader.damages.push(Damage { offset, bytes, reason });
                }
                Piece::Metadata(metadata) => {
                    reader.repair = Repair::of(&metadata).or(reader.repair);
                }
                Piece::Statistics(messages) => reader.expected_messages = Some(messages),
                Piece::End => reader.is_ended = true,
            }
        }
        reader.finish(path, bytes.len())
    }
}

/// An empty record with the first intact configuration of the file. If the first chunk is damaged, a later chunk
/// contains the configuration too.
fn configured(bytes: &[u8], path: &Path) -> Result<Option<Record>, LogError> {
    let mut finder = Reader::default();
    for (_, piece) in pieces(bytes) {
        // Damage is reported in the pass over all pieces.
        if let Piece::Chunk(data) = piece {
            finder.chunk(&data, path)?;
        }
        if finder.record.is_some() {
            break;
        }
    }
    let empty = |record: Record| Record {
        calls: Vec::new(),
        solutions: Vec::new(),
        controls: Vec::new(),
        cycles: Vec::new(),
        events: Vec::new(),
        lost_raw: 0,
        lost_decoded: 0,
        end: record.header.start,
        warnings: Vec::new(),
        damages: Vec::new(),
        ..record
    };
    Ok(finder.record.map(empty))
}

#[derive(Default)]
struct Reader {
    topics: Topics,
    record: Option<Record>,
    /// An incomplete call for each line.
    begun: [Option<Vec<u8>>; 3],
    /// Number of the last entry.
    sequence: u32,
    /// Count of different entry numbers.
    entries: u32,
    /// Number of messages read.
    messages: u64,
    /// Number of messages according to the writer.
    expected_messages: Option<u64>,
    unreadable: usize,
    damages: Vec<Damage>,
    repair: Option<Repair>,
    is_ended: bool,
}

impl Reader {
    /// Reads the content of an intact chunk; an error if the configuration is wrong.
    fn chunk(&mut self, data: &[u8], path: &Path) -> Result<(), LogError> {
        for record in records(data) {
            match record {
                McapRecord::Channel(channel) => self.topics.learn(&channel),
                McapRecord::Message { header, data } => self.message(header, &data, path)?,
                _ => {}
            }
        }
        Ok(())
    }

    fn message(&mut self, header: MessageHeader, data: &[u8], path: &Path) -> Result<(), LogError> {
        self.messages += 1;
        let Some(channel) = self.topics.of(header.channel_id) else { return Ok(()) };
        if header.sequence > self.sequence {
            self.sequence = header.sequence;
            self.entries += 1;
        }
        let Some(record) = &mut self.record else {
            if channel == Channel::Configuration
                && let Some(message) = parse(data)
            {
                self.record = Some(begin(message, path)?);
            }
            return Ok(());
        };
        let now = record.header.time(header.log_time);
        record.end = record.end.max(now);
        let taken = match channel {
            Channel::DmuRaw => raw(&mut self.begun[0], data, Call::Dmu, record),
            Channel::GpsRaw => raw(&mut self.begun[1], data, Call::Gps, record),
            Channel::ServoRaw => raw(&mut self.begun[2], data, Call::Servo, record),
            Channel::GpsRestart => {
                record.calls.push((now, Call::RestartGps));
                Some(())
            }
            Channel::Solution => {
                parse::<SolutionMessage>(data).map(|message| record.solutions.push(message.into()))
            }
            Channel::Controls => parse::<ControlsMessage>(data).map(|message| {
                let ControlsMessage { lateral, longitudinal, collective, pedal } = message;
                record.controls.push((now, [lateral, longitudinal, collective, pedal]));
            }),
            Channel::Autopilot => parse(data).and_then(CycleMessage::cycle).map(|(time, cycle)| {
                let calls_before = record.calls.len();
                record.cycles.push(RecordedCycle { time, calls_before, cycle });
            }),
            Channel::Events => parse::<ReadLogMessage>(data).map(|message| {
                let time = record.header.time(header.publish_time);
                let ReadLogMessage { level, message, name, part } = message;
                // A line end in one event must not look like a second event.
                let [text, kind, part] = [message, name, part]
                    .map(|text| spelt_out(&text, char::is_control).into_owned());
                let level = match level {
                    ..=2 => Level::Info,
                    3 => Level::Warning,
                    4 => Level::Error,
                    5.. => Level::Critical,
                };
                record.events.push(RecordedEvent { time, level, kind, part, text });
            }),
            Channel::Lost => parse::<LostMessage>(data).map(|LostMessage { raw, decoded }| {
                record.lost_raw += u64::from(raw);
                record.lost_decoded += u64::from(decoded);
                if raw > 0 {
                    self.begun = Default::default();
                    record.warnings.push(format!(
                        "the recorder had no room for {raw} raw entries before {now}: \
                         a replay differs from there on"
                    ));
                }
            }),
            Channel::Configuration
            | Channel::Imu
            | Channel::GpsFix
            | Channel::GpsLocation
            | Channel::SolutionLocation
            | Channel::Innovations
            | Channel::Servo => Some(()),
        };
        self.unreadable += usize::from(taken.is_none());
        Ok(())
    }

    fn finish(self, path: &Path, length: usize) -> Result<Record, LogError> {
        let Some(mut record) = self.record else {
            let (offset, reason) = self.damages.into_iter().next().map_or_else(
                || (length, "the file ends, and no topic was a flight's configuration".into()),
                |first| (first.offset, first.reason),
            );
            let reason = format!("{reason}; expected a flight record of hovernav");
            return Err(LogError::bytes(path, offset, reason));
        };
        record.is_ended = self.is_ended;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if let Some(repair) = &self.repair {
            // The repaired file is intact, but earlier losses remain.
            record.is_ended &= repair.was_ended;
            record.warnings.extend(repair.warnings(&name));
        }
        record.repair = self.repair;
        for damage in &self.damages {
            record.warnings.push(format!("{name}: {damage}"));
        }
        record.damages = self.damages;
        // A chunk with a damaged kind is skipped like an unknown record, so only the count reveals it.
        if let Some(expected) = self.expected_messages.filter(|&expected| expected != self.messages)
        {
            let reason = format!("found {} messages, expected {expected}", self.messages);
            let damage = Damage { offset: length, bytes: 0, reason };
            record.warnings.push(format!("{name}: {damage}"));
            record.damages.push(damage);
        }
        if self.unreadable > 0 {
            let count = self.unreadable;
            record.warnings.push(format!("{name}: {count} messages do not match their topic"));
        }
        let missing = u64::from(self.sequence - self.entries);
        let unexplained = missing.saturating_sub(record.lost_raw + record.lost_decoded);
        if unexplained > 0 {
            record.warnings.push(format!(
                "{name}: {unexplained} entries are missing in between: a replay may differ"
            ));
        }
        Ok(record)
    }
}

fn parse<M: DeserializeOwned>(data: &[u8]) -> Option<M> {
    serde_json::from_slice(data).ok()
}

fn begin(message: ConfigurationMessage, path: &Path) -> Result<Record, LogError> {
    let ConfigurationMessage { version, start_ns, start_unix_ns, fly_toml } = message;
    let mut config =
        FlyConfig::parse_flown(&fly_toml, "its fly.toml".as_ref()).map_err(|error| {
            let reason = format!("recorded by hovernav {version}: {error}");
            LogError::Unusable { path: path.into(), reason }
        })?;
    let name = &mut config.navigation.name;
    if name.is_empty() {
        *name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    }
    let start = Time::from_nanoseconds(start_ns);
    Ok(Record {
        header: Header { config, start, start_unix_ns, version },
        calls: Vec::new(),
        solutions: Vec::new(),
        controls: Vec::new(),
        cycles: Vec::new(),
        events: Vec::new(),
        lost_raw: 0,
        lost_decoded: 0,
        end: start,
        is_ended: false,
        repair: None,
        damages: Vec::new(),
        warnings: Vec::new(),
    })
}

/// Joins the parts of a call.
fn raw(
    begun: &mut Option<Vec<u8>>,
    data: &[u8],
    call: fn(Vec<u8>) -> Call,
    record: &mut Record,
) -> Option<()> {
    let message: RawMessage = parse(data)?;
    let mut bytes = begun.take().unwrap_or_default();
    bytes.extend(message.bytes()?);
    if message.goes_on {
        *begun = Some(bytes);
    } else {
        record.calls.push((Time::from_nanoseconds(message.time_ns), call(bytes)));
    }
    Some(())
}
