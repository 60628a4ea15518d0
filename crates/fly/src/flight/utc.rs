//! The time of day: by this computer's clock until the receiver says it.

use chrono::{DateTime, SecondsFormat};
use hovernav::time::Time;
use hovernav_log::record::{Level, ShortText};

/// By how much the receiver's time of day has to move to be told again, ns: more than fixes differ in how
/// late they come.
const MOVED_NS: i64 = 1_000_000_000;
/// A computer whose clock is off by more than this is told so, s.
const OFF_S: f64 = 2.0;

/// UTC from what comes of the receiver, at the flight's own clock.
#[derive(Clone, Copy, Debug)]
pub struct UtcClock {
    /// UTC since the start of 1970 less the flight's clock, ns: by this computer, and as the receiver was last
    /// told to have it.
    system_ns: i64,
    told_ns: Option<i64>,
}

impl UtcClock {
    /// By this computer it is `unix_ns` after the start of 1970 at `now` of the flight's clock.
    pub const fn new(now: Time, unix_ns: i64) -> Self {
        Self { system_ns: unix_ns.saturating_sub(now.nanoseconds()), told_ns: None }
    }

    /// UTC less the flight's clock, ns, where a fix of the moment `unix_ns`, which came at `arrival`, is the
    /// first to tell it or to tell it otherwise.
    ///
    /// It is behind by what the fix took to come: tenths of a second.
    pub fn hear(&mut self, arrival: Time, unix_ns: i64) -> Option<i64> {
        let offset_ns = unix_ns.saturating_sub(arrival.nanoseconds());
        let moved = |before: i64| offset_ns.saturating_sub(before).saturating_abs() > MOVED_NS;
        let is_news = self.told_ns.is_none_or(moved);
        if is_news {
            self.told_ns = Some(offset_ns);
        }
        is_news.then_some(offset_ns)
    }

    /// The news in words: what time it is at `now`, and how far this computer's clock is off.
    pub fn in_words(&self, now: Time, offset_ns: i64) -> (Level, ShortText) {
        let utc = DateTime::from_timestamp_nanos(offset_ns.saturating_add(now.nanoseconds()));
        let utc = utc.to_rfc3339_opts(SecondsFormat::Secs, true);
        let ahead_s = offset_ns.saturating_sub(self.system_ns) as f64 * 1e-9;
        if ahead_s.abs() <= OFF_S {
            return (Level::Info, ShortText::new(format_args!("UTC {utc} by the receiver")));
        }
        let side = if ahead_s > 0.0 { "behind" } else { "ahead" };
        let text = format_args!(
            "UTC {utc} by the receiver: this computer's clock is {:.0} s {side}",
            ahead_s.abs()
        );
        (Level::Warning, ShortText::new(text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_told_once_and_again_where_the_receiver_changes_its_mind() {
        let at = |seconds: i64| Time::from_nanoseconds(seconds * 1_000_000_000);
        let unix_ns = 1_700_000_000_000_000_000;
        let mut utc = UtcClock::new(at(10), unix_ns);
        // The computer's clock is 100 s behind, and fixes come 0.1 to 0.3 s late.
        let heard = |utc: &mut UtcClock, second: i64, late_ms: i64, leap_s: i64| {
            let moment_ns = unix_ns + (second - 10 + 100 + leap_s) * 1_000_000_000;
            utc.hear(
                Time::from_nanoseconds(second * 1_000_000_000 + late_ms * 1_000_000),
                moment_ns,
            )
        };
        let offset_ns = heard(&mut utc, 20, 300, 0).expect("the first tells it");
        assert_eq!(heard(&mut utc, 21, 100, 0), None);
        assert_eq!(heard(&mut utc, 22, 300, 0), None);
        let (level, text) = utc.in_words(at(20), offset_ns);
        assert_eq!(level, Level::Warning);
        assert_eq!(
            text.as_str(),
            "UTC 2023-11-14T22:15:09Z by the receiver: this computer's clock is 100 s behind"
        );
        assert!(heard(&mut utc, 23, 100, -18).is_some(), "leap seconds that it has learned of");

        let offset_ns = UtcClock::new(at(10), unix_ns).hear(at(11), unix_ns).unwrap();
        let (level, _) = UtcClock::new(at(10), unix_ns).in_words(at(11), offset_ns);
        assert_eq!(level, Level::Info);
    }
}
