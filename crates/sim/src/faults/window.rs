//! When a fault is there.

/// A span of a log's clock.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Window {
    /// First moment, s; minus infinity for the beginning of the log.
    #[serde(serialize_with = "finite")]
    pub start_s: f64,
    /// How long, s; infinite to the end of the log.
    #[serde(serialize_with = "finite")]
    pub duration_s: f64,
}

/// An end of the log is written as null.
fn finite<S: serde::Serializer>(seconds: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    serde::Serialize::serialize(&seconds.is_finite().then_some(*seconds), serializer)
}

impl Window {
    /// All of a log.
    pub const ALL: Self = Self { start_s: f64::NEG_INFINITY, duration_s: f64::INFINITY };

    /// Whether a moment falls into it, the end excluded.
    #[must_use]
    pub fn covers(&self, time_s: f64) -> bool {
        time_s >= self.start_s && time_s < self.end_s()
    }

    /// The first moment after it.
    #[must_use]
    pub fn end_s(&self) -> f64 {
        if self.duration_s.is_finite() { self.start_s + self.duration_s } else { f64::INFINITY }
    }
}

/// What is left alone at a log's beginning and its end when a window is drawn, s: the alignment and
/// the first minute's convergence, and room to recover in.
const BEFORE_S: f64 = 60.0;
const AFTER_S: f64 = 30.0;

/// A start for a window of `duration_s` in a log that spans `first_s` to `last_s`: `share` from 0 to 1
/// runs through what is left of it beside its beginning and its end, each at most a quarter of it.
pub(super) fn drawn_start_s((first_s, last_s): (f64, f64), duration_s: f64, share: f64) -> f64 {
    let length_s = last_s - first_s;
    let earliest_s = first_s + BEFORE_S.min(0.25 * length_s);
    let latest_s = last_s - AFTER_S.min(0.25 * length_s) - duration_s;
    earliest_s + share * (latest_s - earliest_s).max(0.0)
}
