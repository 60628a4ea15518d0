//! The station decodes, stores, records and evaluates the telemetry.

use std::time::{SystemTime, UNIX_EPOCH};

use serde::Serialize;

use crate::channel::{CHANNELS, Id};
use crate::clock::VehicleClock;
use crate::decode::{Arrived, Counts, Decoder, Protocol};
use crate::frames::Rigging;
use crate::lamps::OLD_FIX_S;
use crate::record::{RecordError, Recorder, Recording};
use crate::series::{SILENT_MARGIN_S, SILENT_PERIODS};
use crate::store::{Batch, Marker, Store, TextLevel, TextLine};
use crate::test_points::TestPoints;

/// Stored values per channel: 20 minutes at 33 Hz. Older values are only in the record.
const ROOM: usize = 40_000;
/// Shortest time without a frame after which the link is down, s.
const SILENT_S: f64 = 1.0;
/// Delay of the last frame relative to the fastest frame, s, above which the telemetry counts as past.
const LATE_S: f64 = 1.0;
/// Weight of the newest period in the usual period of the link.
const SHARE: f64 = 0.1;
/// Longest period that is used for the usual period, s.
const LONGEST_PERIOD_S: f64 = 3.0;

/// The present time, seconds since the start of 1970.
#[must_use]
pub fn now_s() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs_f64()
}

/// The clock by which a station determines the age of its telemetry.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Clock {
    /// The clock of this computer.
    #[default]
    System,
    /// A stopped clock: its time, seconds since the start of 1970, until it is set again.
    Stopped(f64),
}

/// A duration in words: whole seconds, and minutes from two minutes on.
fn lasted(seconds: f64) -> String {
    if seconds < 120.0 {
        format!("{seconds:.0} s")
    } else {
        format!("{:.0} min", (seconds / 60.0).floor())
    }
}

/// The state of the link.
#[derive(Clone, Debug, Default, Serialize)]
pub struct LinkState {
    /// Name of the link: a port or an address.
    pub name: String,
    /// State of the port or the socket.
    pub port: String,
    /// Protocol.
    pub protocol: Option<&'static str>,
    /// Whether frames are requested.
    pub wanted: bool,
    /// Time since the last frame, s; `None` before the first.
    pub age_s: Option<f64>,
    /// Frames in the last second.
    pub rate_hz: f64,
    /// Bytes in the last second.
    pub bytes_per_s: f64,
    /// Complete frames.
    pub frames: u64,
    /// Missing frames, including damaged ones.
    pub lost: u64,
    /// Damaged frames.
    pub damaged: u64,
    /// Frames that are more than 0.2 s later than the fastest.
    pub late: u64,
    /// Delay of the last frame relative to the fastest, s.
    pub delay_s: f64,
    /// Number of outages.
    pub outages: u64,
}

/// The complete ground station except its page.
pub struct Station {
    /// The stored telemetry.
    pub store: Store,
    /// The test points of the flight.
    pub test_points: TestPoints,
    /// The station's own clock.
    pub clock: Clock,
    decoder: Decoder,
    vehicle_clock: VehicleClock,
    recorder: Option<Recorder>,
    link: LinkState,
    last_frame_s: Option<f64>,
    /// Usual time between two arrivals of frames, s.
    period_s: Option<f64>,
    /// Arrival time minus ground time of the last frame with a time, s; zero for the fastest.
    behind_s: f64,
    silent: bool,
    /// The counts one second ago, and their time.
    before: (f64, Counts),
}

/// Channels of a fix, which an old fix leaves unknown.
const OF_FIX: [Id; 11] = [
    Id::GpsLatitude,
    Id::GpsLongitude,
    Id::GpsHeight,
    Id::GpsAltitude,
    Id::GpsVelE,
    Id::GpsVelN,
    Id::GpsVelU,
    Id::GpsFix,
    Id::Satellites,
    Id::Hdop,
    Id::Vdop,
];

impl Station {
    /// A station for a vehicle with this rigging, on a link called `link`.
    #[must_use]
    pub fn new(rigging: Rigging, protocol: Option<Protocol>, link: &str) -> Self {
        Self {
            store: Store::new(ROOM),
            test_points: TestPoints::default(),
            clock: Clock::System,
            decoder: Decoder::new(rigging, protocol),
            vehicle_clock: VehicleClock::default(),
            recorder: None,
            link: LinkState { name: link.to_owned(), wanted: true, ..LinkState::default() },
            last_frame_s: None,
            period_s: None,
            behind_s: 0.0,
            silent: true,
            before: (0.0, Counts::default()),
        }
    }

    /// The present time by the station's clock, seconds since the start of 1970.
    #[must_use]
    pub fn now_s(&self) -> f64 {
        match self.clock {
            Clock::System => now_s(),
            Clock::Stopped(at_s) => at_s,
        }
    }

    /// Decodes bytes that arrived at `arrival_s`, seconds since the start of 1970.
    pub fn receive(&mut self, bytes: &[u8], arrival_s: f64) {
        let mut arrived = Vec::new();
        self.decoder.receive(bytes, arrival_s, |what| arrived.push(what));
        // Among the vehicle's own frames, only snapshots show its present state.
        let has_frames = self.decoder.protocol() == Some(Protocol::Frames);
        let is_present = |what: &Arrived| match what {
            Arrived::Values(_, values) => values.iter().any(|(id, _)| *id == Id::Status),
            Arrived::Text(..) => false,
        };
        if arrived.iter().any(|what| !has_frames || is_present(what)) {
            if let Some(last_s) = self.last_frame_s {
                let since_s = (arrival_s - last_s).clamp(0.0, LONGEST_PERIOD_S);
                let period_s = self.period_s.get_or_insert(since_s);
                *period_s += SHARE * (since_s - *period_s);
            }
            self.last_frame_s = Some(arrival_s);
            if std::mem::take(&mut self.silent) {
                self.note(arrival_s, TextLevel::Info, "link: frames arrive");
            }
        }
        for what in arrived {
            match what {
                Arrived::Values(vehicle_s, values) => self.values(vehicle_s, &values, arrival_s),
                Arrived::Text(level, text) => self.note(arrival_s, level, &text),
            }
        }
    }

    fn values(&mut self, vehicle_s: Option<f64>, values: &[(Id, Option<f64>)], arrival_s: f64) {
        let time_s = match vehicle_s {
            Some(vehicle_s) => {
                let placed = self.vehicle_clock.place(vehicle_s, arrival_s);
                self.behind_s = arrival_s - placed.time_s;
                self.link.late += u64::from(placed.is_late);
                self.link.delay_s = placed.delay_s;
                if placed.jumped {
                    self.note(arrival_s, TextLevel::Warning, "link: the vehicle's clock was set");
                }
                placed.time_s
            }
            None => arrival_s - self.behind_s,
        };
        let age_s = values.iter().find(|(id, _)| *id == Id::GpsAge).and_then(|(_, age_s)| *age_s);
        let is_old = age_s.is_some_and(|age_s| age_s > OLD_FIX_S);
        let plausible = |&(id, value): &(Id, Option<f64>)| {
            let present = value.filter(|_| !(is_old && OF_FIX.contains(&id)));
            (id, CHANNELS[id as usize].plausible(present))
        };
        let batch = Batch { time_s, values: values.iter().map(plausible).collect() };
        self.store.push(&batch);
        self.test_points.observe(&batch);
        if let Some(recorder) = &self.recorder {
            recorder.push(batch);
        }
    }

    /// Updates rates and outages; call it several times a second.
    pub fn tick(&mut self, now_s: f64) {
        let counts = self.decoder.counts();
        let (before_s, before) = self.before;
        let elapsed_s = now_s - before_s;
        if elapsed_s >= 1.0 {
            let a_second = |now: u64, before: u64| now.saturating_sub(before) as f64 / elapsed_s;
            self.link.rate_hz = a_second(counts.frames, before.frames);
            self.link.bytes_per_s = a_second(counts.bytes, before.bytes);
            self.before = (now_s, counts);
        }
        if let Some(silent_s) = self.silent_s(now_s)
            && !std::mem::replace(&mut self.silent, true)
        {
            self.link.outages += 1;
            let text = format!("link: no frame for {}", lasted(silent_s));
            self.note(now_s, TextLevel::Warning, &text);
        }
        self.test_points.judge(&self.store);
    }

    /// The state of the link at `now_s`.
    #[must_use]
    pub fn link(&self, now_s: f64) -> LinkState {
        let Counts { frames, damaged, lost, .. } = self.decoder.counts();
        LinkState {
            protocol: self.decoder.protocol().map(|protocol| match protocol {
                Protocol::Frames => "packed frames",
                Protocol::Mavlink => "MAVLink 2",
            }),
            age_s: self.last_frame_s.map(|last_s| (now_s - last_s).max(0.0)),
            frames,
            damaged,
            lost,
            ..self.link.clone()
        }
    }

    /// Time since the last frame, s, if the link is down at `now_s`. The link is down after two usual periods, and
    /// after at least one second. `None` before the first frame.
    fn silent_s(&self, now_s: f64) -> Option<f64> {
        let periods_s = SILENT_PERIODS * self.period_s.unwrap_or(0.0) + SILENT_MARGIN_S;
        self.last_frame_s
            .map(|last_s| now_s - last_s)
            .filter(|since_s| *since_s > periods_s.max(SILENT_S))
    }

    /// Reason, in words, why all telemetry is past at `now_s`; `None` while telemetry arrives.
    #[must_use]
    pub fn silence(&self, now_s: f64) -> Option<String> {
        let paused = if self.link.wanted { "" } else { "paused: " };
        if self.last_frame_s.is_none() {
            return Some(format!("{paused}no telemetry yet"));
        }
        if let Some(silent_s) = self.silent_s(now_s) {
            return Some(format!("{paused}no telemetry for {}", lasted(silent_s)));
        }
        let late_s = self.link.delay_s;
        (late_s > LATE_S).then(|| format!("telemetry arrives {} late", lasted(late_s)))
    }

    /// The time of validity, seconds since the start of 1970, of a value that leaves the vehicle at `now_s`. Stored
    /// values are older.
    #[must_use]
    pub fn present_s(&self, now_s: f64) -> f64 {
        let late_s = if self.link.delay_s > LATE_S { self.link.delay_s } else { 0.0 };
        now_s - self.behind_s + late_s
    }

    /// The value of a channel at `now_s`, seconds since the start of 1970. NaN if the value is unknown, or older than
    /// two usual periods of the channel.
    #[must_use]
    pub fn latest(&self, id: Id, now_s: f64) -> f64 {
        match self.silent_s(now_s) {
            Some(_) => f64::NAN,
            None => self.store.latest(id, self.present_s(now_s)),
        }
    }

    /// Whether no frames arrive.
    #[must_use]
    pub const fn is_silent(&self) -> bool {
        self.silent
    }

    /// Whether frames are requested.
    #[must_use]
    pub const fn wants_frames(&self) -> bool {
        self.link.wanted
    }

    /// The protocol, once it is known.
    #[must_use]
    pub const fn protocol(&self) -> Option<Protocol> {
        self.decoder.protocol()
    }

    /// Requests frames, or pauses them.
    pub fn want_frames(&mut self, wanted: bool) {
        self.link.wanted = wanted;
    }

    /// Stores the state of the port or the socket.
    pub fn report_port(&mut self, level: TextLevel, text: &str) {
        if self.link.port != text {
            self.link.port = text.to_owned();
            self.note(self.now_s(), level, &format!("link: {text}"));
        }
    }

    /// Stores a line of text.
    pub fn note(&mut self, time_s: f64, level: TextLevel, text: &str) {
        let line = TextLine { time_s, level, text: text.to_owned() };
        if let Some(recorder) = &self.recorder {
            recorder.say(line.clone());
        }
        self.store.say(line);
    }

    /// Adds a marker at `now_s`, seconds since the start of 1970.
    pub fn mark(&mut self, now_s: f64, note: &str) {
        let time_s = self.present_s(now_s);
        let marker = Marker { time_s, note: note.to_owned() };
        if let Some(recorder) = &self.recorder {
            recorder.mark(marker.clone());
        }
        self.store.mark(marker);
    }

    /// Starts a record in `file`.
    ///
    /// # Errors
    /// If a record is being written, or the file cannot be created. An existing file is never overwritten.
    pub fn record(&mut self, file: &std::path::Path, name: &str) -> Result<(), RecordError> {
        if let Some(recorder) = &self.recorder {
            return Err(RecordError::Busy { name: recorder.recording().name });
        }
        self.recorder = Some(Recorder::create(file, name)?);
        self.note(self.now_s(), TextLevel::Info, &format!("recording to {name}"));
        Ok(())
    }

    /// Ends the record. Returns its summary, if there was one.
    pub fn stop_recording(&mut self) -> Option<Recording> {
        let recorder = self.recorder.take()?;
        let recording = recorder.finish();
        self.note(self.now_s(), TextLevel::Info, &format!("recorded {}", recording.name));
        Some(recording)
    }

    /// The record being written.
    #[must_use]
    pub fn recording(&self) -> Option<Recording> {
        self.recorder.as_ref().map(Recorder::recording)
    }
}
