//! What has been heard: every channel over time, texts, markers.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use crate::channel::Id;
use crate::series::Series;

/// Values that arrived together.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// When they were true, seconds since the start of 1970.
    pub time_s: f64,
    /// The values; NaN of what is not known.
    pub values: Vec<(Id, f64)>,
}

/// A line of text from the vehicle, or about the link to it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TextLine {
    /// Seconds since the start of 1970.
    pub time_s: f64,
    /// `info`, `warning` or `error`.
    pub level: TextLevel,
    /// What happened.
    pub text: String,
}

/// How much a text matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TextLevel {
    /// As it should be.
    Info,
    /// Less well.
    Warning,
    /// Something is lost.
    Error,
}

/// A moment that somebody marked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Marker {
    /// Seconds since the start of 1970.
    pub time_s: f64,
    /// What was said of it.
    pub note: String,
}

/// Texts and markers that are kept.
const LINES: usize = 2000;

/// Together they say who flies, and how.
const MODES: [Id; 3] = [Id::SystemMode, Id::AutopilotMode, Id::CustomMode];

/// Everything that has been heard, as far as it is kept.
#[derive(Clone, Debug)]
pub struct Store {
    series: Vec<Series>,
    texts: VecDeque<TextLine>,
    /// Texts that came before those kept.
    texts_gone: u64,
    markers: VecDeque<Marker>,
    markers_gone: u64,
    span: Option<(f64, f64)>,
}

impl Store {
    /// Room for so many values of each channel.
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
        }
    }

    /// Takes values in.
    pub fn push(&mut self, batch: &Batch) {
        let time_s = batch.time_s;
        if !time_s.is_finite() {
            return;
        }
        for &(id, value) in &batch.values {
            self.series[id as usize].push(time_s, value);
        }
        self.span = Some(self.span.map_or((time_s, time_s), |(from, to)| (from, to.max(time_s))));
    }

    /// Takes a text in.
    pub fn say(&mut self, line: TextLine) {
        if self.texts.len() == LINES {
            self.texts.pop_front();
            self.texts_gone += 1;
        }
        self.texts.push_back(line);
    }

    /// Takes a marker in.
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

    /// The newest value of a channel; NaN where it is not known, or was not sent for long while others were.
    #[must_use]
    pub fn latest(&self, id: Id) -> f64 {
        let now_s = self.span.map_or(f64::NEG_INFINITY, |(_, to_s)| to_s);
        self.series(id).latest(now_s).map_or(f64::NAN, |(_, value)| value)
    }

    /// The value of a channel at a moment; NaN where it is not known.
    #[must_use]
    pub fn at(&self, id: Id, time_s: f64) -> f64 {
        self.series(id).at(time_s).unwrap_or(f64::NAN)
    }

    /// Since when whoever flies at `time_s` has flown, and as then, s: since when all modes that are known
    /// then are what they are. With it whether that is known or at least so long; `None` where none is.
    #[must_use]
    pub fn in_mode_since(&self, time_s: f64) -> Option<(f64, bool)> {
        let begun = MODES.iter().filter_map(|id| self.series(*id).since(time_s));
        begun.max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// First and last moment of which anything is known.
    #[must_use]
    pub const fn span(&self) -> Option<(f64, f64)> {
        self.span
    }

    /// Texts from the one with this number on, counted from the first ever, and the number of the first
    /// of them: a later one where those in between are gone.
    pub fn texts_from(&self, number: u64) -> (impl Iterator<Item = &TextLine>, u64) {
        let skip = usize::try_from(number.saturating_sub(self.texts_gone)).unwrap_or(usize::MAX);
        (self.texts.iter().skip(skip), number.max(self.texts_gone))
    }

    /// The same of markers.
    pub fn markers_from(&self, number: u64) -> (impl Iterator<Item = &Marker>, u64) {
        let skip = usize::try_from(number.saturating_sub(self.markers_gone)).unwrap_or(usize::MAX);
        (self.markers.iter().skip(skip), number.max(self.markers_gone))
    }
}
