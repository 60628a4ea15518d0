//! UTC: from this computer's clock until the receiver sends it.

use chrono::{DateTime, SecondsFormat};
use hovernav::time::Time;
use hovernav_record::{Level, ShortText};

/// Change of the receiver's UTC that is reported, ns: more than the variation of the latency of fixes.
const MOVED_NS: i64 = 1_000_000_000;
/// Smallest error of this computer's clock, s, that causes a warning.
const OFF_S: f64 = 2.0;

/// UTC from the receiver, relative to the flight clock.
#[derive(Clone, Copy, Debug)]
pub struct UtcClock {
    /// UTC since 1970 minus the flight clock, ns, according to this computer.
    system_ns: i64,
    /// UTC since 1970 minus the flight clock, ns, of the last fix.
    last_ns: Option<i64>,
    /// UTC since 1970 minus the flight clock, ns, as last reported from the receiver.
    reported_ns: Option<i64>,
}

impl UtcClock {
    /// A clock for which this computer's UTC was `unix_ns`, ns since 1970, at `now` on the flight clock.
    pub const fn new(now: Time, unix_ns: i64) -> Self {
        let system_ns = unix_ns.saturating_sub(now.nanoseconds());
        Self { system_ns, last_ns: None, reported_ns: None }
    }

    /// UTC minus the flight clock, ns, from a fix at UTC `unix_ns` that arrived at `arrival`. Returned only for the
    /// second fix and after a change, once two successive fixes agree: a single fix may be late by seconds.
    ///
    /// The offset is too small by the latency of the fix, tenths of a second.
    pub fn observe(&mut self, arrival: Time, unix_ns: i64) -> Option<i64> {
        let offset_ns = unix_ns.saturating_sub(arrival.nanoseconds());
        let moved = |before: i64| offset_ns.saturating_sub(before).saturating_abs() > MOVED_NS;
        let is_confirmed = self.last_ns.replace(offset_ns).is_some_and(|last| !moved(last));
        let is_change = is_confirmed && self.reported_ns.is_none_or(moved);
        if is_change {
            self.reported_ns = Some(offset_ns);
        }
        is_change.then_some(offset_ns)
    }

    /// The message: UTC at `now`, and the error of this computer's clock.
    pub fn in_words(&self, now: Time, offset_ns: i64) -> (Level, ShortText) {
        let utc = DateTime::from_timestamp_nanos(offset_ns.saturating_add(now.nanoseconds()));
        let utc = utc.to_rfc3339_opts(SecondsFormat::Secs, true);
        let ahead_s = offset_ns.saturating_sub(self.system_ns) as f64 * 1e-9;
        if ahead_s.abs() <= OFF_S {
            return (Level::Info, ShortText::new(format_args!("UTC {utc} from the receiver")));
        }
        let side = if ahead_s > 0.0 { "behind" } else { "ahead" };
        let text = format_args!(
            "UTC {utc} from the receiver: this computer's clock is {:.0} s {side}",
            ahead_s.abs()
        );
        (Level::Warning, ShortText::new(text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIX_S: i64 = 1_700_000_000;

    fn at_s(seconds: i64) -> Time {
        Time::from_nanoseconds(seconds * 1_000_000_000)
    }

    /// Offset reported for a fix of UTC second `second` that arrives `late_ms` later. The flight clock starts at `UNIX_S`.
    fn observed(utc: &mut UtcClock, second: i64, late_ms: i64) -> Option<i64> {
        let arrival = Time::from_nanoseconds(second * 1_000_000_000 + late_ms * 1_000_000);
        utc.observe(arrival, (UNIX_S + second) * 1_000_000_000)
    }

    #[test]
    fn utc_is_reported_once_and_again_after_a_change() {
        // The computer's clock is 100 s behind; the latency of fixes is 0.1 to 0.3 s.
        let mut utc = UtcClock::new(at_s(10), (UNIX_S - 90) * 1_000_000_000);
        assert_eq!(observed(&mut utc, 20, 100), None);
        let offset_ns = observed(&mut utc, 21, 300).expect("two fixes agree");
        assert_eq!(observed(&mut utc, 22, 100), None);
        let (level, text) = utc.in_words(at_s(21), offset_ns);
        assert_eq!(level, Level::Warning);
        assert_eq!(
            text.as_str(),
            "UTC 2023-11-14T22:13:40Z from the receiver: this computer's clock is 100 s behind"
        );
        // The leap seconds arrive.
        assert_eq!(observed(&mut utc, 23, 18_100), None);
        assert!(observed(&mut utc, 24, 18_200).is_some());
        let utc = UtcClock::new(at_s(10), UNIX_S * 1_000_000_000);
        let (level, _) = utc.in_words(at_s(11), (UNIX_S - 10) * 1_000_000_000);
        assert_eq!(level, Level::Info);
    }

    #[test]
    fn a_single_late_fix_reports_nothing() {
        let mut utc = UtcClock::new(at_s(0), UNIX_S * 1_000_000_000);
        assert_eq!(observed(&mut utc, 1, 2_500), None);
        assert_eq!(observed(&mut utc, 2, 200), None);
        let offset_ns = observed(&mut utc, 3, 200).expect("two fixes agree");
        assert_eq!(utc.in_words(at_s(3), offset_ns).0, Level::Info);
        assert_eq!(observed(&mut utc, 4, 2_500), None);
        assert_eq!(observed(&mut utc, 5, 200), None);
    }
}
