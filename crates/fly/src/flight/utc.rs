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
    /// UTC since 1970 minus the flight clock, ns, as last reported from the receiver.
    reported_ns: Option<i64>,
}

impl UtcClock {
    /// A clock for which this computer's UTC was `unix_ns`, ns since 1970, at `now` on the flight clock.
    pub const fn new(now: Time, unix_ns: i64) -> Self {
        Self { system_ns: unix_ns.saturating_sub(now.nanoseconds()), reported_ns: None }
    }

    /// UTC minus the flight clock, ns, from a fix at UTC `unix_ns` that arrived at `arrival`. Returned only for the
    /// first fix and after a change.
    ///
    /// The offset is too small by the latency of the fix, tenths of a second.
    pub fn observe(&mut self, arrival: Time, unix_ns: i64) -> Option<i64> {
        let offset_ns = unix_ns.saturating_sub(arrival.nanoseconds());
        let moved = |before: i64| offset_ns.saturating_sub(before).saturating_abs() > MOVED_NS;
        let is_change = self.reported_ns.is_none_or(moved);
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

    #[test]
    fn utc_is_reported_once_and_again_after_a_change() {
        let at = |seconds: i64| Time::from_nanoseconds(seconds * 1_000_000_000);
        let unix_ns = 1_700_000_000_000_000_000;
        let mut utc = UtcClock::new(at(10), unix_ns);
        // The computer's clock is 100 s behind; the latency of fixes is 0.1 to 0.3 s.
        let heard = |utc: &mut UtcClock, second: i64, late_ms: i64, leap_s: i64| {
            let moment_ns = unix_ns + (second - 10 + 100 + leap_s) * 1_000_000_000;
            utc.observe(
                Time::from_nanoseconds(second * 1_000_000_000 + late_ms * 1_000_000),
                moment_ns,
            )
        };
        let offset_ns = heard(&mut utc, 20, 300, 0).expect("the first fix is reported");
        assert_eq!(heard(&mut utc, 21, 100, 0), None);
        assert_eq!(heard(&mut utc, 22, 300, 0), None);
        let (level, text) = utc.in_words(at(20), offset_ns);
        assert_eq!(level, Level::Warning);
        assert_eq!(
            text.as_str(),
            "UTC 2023-11-14T22:15:09Z from the receiver: this computer's clock is 100 s behind"
        );
        assert!(heard(&mut utc, 23, 100, -18).is_some(), "a change by the leap seconds");

        let offset_ns = UtcClock::new(at(10), unix_ns).observe(at(11), unix_ns).unwrap();
        let (level, _) = UtcClock::new(at(10), unix_ns).in_words(at(11), offset_ns);
        assert_eq!(level, Level::Info);
    }
}
