//! Time window of a fault.

/// A time span on a log's clock.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Window {
    /// Start, s; minus infinity for the beginning of the log.
    #[serde(serialize_with = "finite")]
    pub start_s: f64,
    /// Duration, s; infinite to the end of the log.
    #[serde(serialize_with = "finite")]
    pub duration_s: f64,
}

/// Serialises `seconds`, or null for an infinite value, which means an end of the log.
fn finite<S: serde::Serializer>(seconds: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    serde::Serialize::serialize(&seconds.is_finite().then_some(*seconds), serializer)
}

impl Window {
    /// The whole log.
    pub const ALL: Self = Self { start_s: f64::NEG_INFINITY, duration_s: f64::INFINITY };

    /// Whether a time is in the window, excluding its end.
    #[must_use]
    pub fn covers(&self, time_s: f64) -> bool {
        time_s >= self.start_s && time_s < self.end_s()
    }

    /// End of the window, s.
    #[must_use]
    pub fn end_s(&self) -> f64 {
        if self.duration_s.is_finite() { self.start_s + self.duration_s } else { f64::INFINITY }
    }
}

/// Time at the log's beginning without random faults, s: for alignment and convergence.
const BEFORE_S: f64 = 60.0;
/// Time at the log's end without random faults, s: for recovery.
const AFTER_S: f64 = 30.0;

/// Random start of a window of `duration_s` in a log from `first_s` to `last_s`. The start is between the excluded
/// beginning and the excluded end; each of them is at most a quarter of the log. `share`, 0 to 1, selects the start in
/// this range.
pub(super) fn drawn_start_s((first_s, last_s): (f64, f64), duration_s: f64, share: f64) -> f64 {
    let length_s = last_s - first_s;
    let earliest_s = first_s + BEFORE_S.min(0.25 * length_s);
    let latest_s = last_s - AFTER_S.min(0.25 * length_s) - duration_s;
    earliest_s + share * (latest_s - earliest_s).max(0.0)
}
