//! The stored telemetry: channels over time, texts, markers.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use crate::channel::Id;
use crate::series::Series;

/// Values that arrived together.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// Time of validity, seconds since the start of 1970.
    pub time_s: f64,
    /// The values; NaN if unknown.
    pub values: Vec<(Id, f64)>,
}

/// A line of text from the vehicle, or about the link to it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TextLine {
    /// Seconds since the start of 1970.
    pub time_s: f64,
    /// `info`, `warning` or `error`.
    pub level: TextLevel,
    /// The text.
    pub text: String,
}

/// Severity of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TextLevel {
    /// Normal.
    Info,
    /// Degraded.
    Warning,
    /// Failure or loss.
    Error,
}

/// A marker set by a user.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Marker {
    /// Seconds since the start of 1970.
    pub time_s: f64,
    /// Text of the marker.
    pub note: String,
}

/// Largest number of stored texts and of stored markers.
const LINES: usize = 2000;

/// The channels that define the flight mode.
const MODES: [Id; 3] = [Id::SystemMode, Id::AutopilotMode, Id::CustomMode];

/// The stored telemetry.
#[derive(Clone, Debug)]
pub struct Store {
    series: Vec<Series>,
    texts: VecDeque<TextLine>,
    /// Number of dropped texts.
    texts_gone: u64,
    markers: VecDeque<Marker>,
    markers_gone: u64,
    span: Option<(f64, f64)>,
    home: Option<(f64, f64)>,
}

impl Store {
    /// A store with room for `room` values per channel.
    #[must_use]
    pub fn new(room: usize) -> Self {
        let series = |id: Id| match MODES.contains(&id) {
            true => Series::of_states(room),
            false => Series::new(room),
        };
        Self {
            series: Id::all().map(series).collect(),
            texts: VecDeque::new(),
            texts_gone: 0,
            markers: VecDeque::new(),
            markers_gone: 0,
            span: None,
            home: None,
        }
    }

    /// Stores values.
    pub fn push(&mut self, batch: &Batch) {
        let time_s = batch.time_s;
        if !time_s.is_finite() {
            return;
        }
        if self.home.is_none() {
            let of = |wanted| {
                let found = batch.values.iter().find(|(id, _)| *id == wanted);
                found.map(|(_, value)| *value).filter(|value| value.is_finite())
            };
            self.home = of(Id::Latitude).zip(of(Id::Longitude));
        }
        for &(id, value) in &batch.values {
            self.series[id as usize].push(time_s, value);
        }
        self.span = Some(self.span.map_or((time_s, time_s), |(from, to)| (from, to.max(time_s))));
    }

    /// The first known position: latitude and longitude, degrees.
    #[must_use]
    pub const fn home(&self) -> Option<(f64, f64)> {
        self.home
    }

    /// Stores a text.
    pub fn say(&mut self, line: TextLine) {
        if self.texts.len() == LINES {
            self.texts.pop_front();
            self.texts_gone += 1;
        }
        self.texts.push_back(line);
    }

    /// Stores a marker.
    pub fn mark(&mut self, marker: Marker) {
        if self.markers.len() == LINES {
            self.markers.pop_front();
            self.markers_gone += 1;
        }
        self.markers.push_back(marker);
    }

    /// One channel.
    #[must_use]
    pub fn series(&self, id: Id) -> &Series {
        &self.series[id as usize]
    }

    /// The newest value of a channel. NaN if the value is unknown, or if the channel is silent at `now_s`, seconds
    /// since the start of 1970.
    #[must_use]
    pub fn latest(&self, id: Id, now_s: f64) -> f64 {
        self.series(id).latest(now_s).map_or(f64::NAN, |(_, value)| value)
    }

    /// The value of a channel at `time_s`; NaN if unknown.
    #[must_use]
    pub fn at(&self, id: Id, time_s: f64) -> f64 {
        self.series(id).at(time_s).unwrap_or(f64::NAN)
    }

    /// The time, s, since which the flight mode at `time_s` has been unchanged: since all known mode channels have had
    /// their present values. The flag is true if this is the exact time of the change, and false if the mode may have
    /// begun earlier. `None` if no mode is known.
    #[must_use]
    pub fn in_mode_since(&self, time_s: f64) -> Option<(f64, bool)> {
        let begun = MODES.iter().filter_map(|id| self.series(*id).since(time_s));
        begun.max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Times of the first and last stored value.
    #[must_use]
    pub const fn span(&self) -> Option<(f64, f64)> {
        self.span
    }

    /// The texts from number `number` on, counted from the first text ever, and the number of the first returned text.
    /// This number is larger than `number` if texts were dropped.
    pub fn texts_from(&self, number: u64) -> (impl Iterator<Item = &TextLine>, u64) {
        let skip = usize::try_from(number.saturating_sub(self.texts_gone)).unwrap_or(usize::MAX);
        (self.texts.iter().skip(skip), number.max(self.texts_gone))
    }

    /// The markers from number `number` on, counted from the first marker ever, and the number of the first returned
    /// marker.
    pub fn markers_from(&self, number: u64) -> (impl Iterator<Item = &Marker>, u64) {
        let skip = usize::try_from(number.saturating_sub(self.markers_gone)).unwrap_or(usize::MAX);
        (self.markers.iter().skip(skip), number.max(self.markers_gone))
    }
}
