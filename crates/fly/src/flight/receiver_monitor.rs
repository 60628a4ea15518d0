//! Monitors the arrival of fixes: lost, recovered, or never received.

use hovernav::time::Time;
use hovernav_record::Level;

/// Age of the last good fix from which on the receiver counts as lost, s.
const FIX_FRESH_S: f64 = 3.0;
/// Time to the first fix of a receiver with a valid almanac, s.
const FIRST_FIX_S: f64 = 30.0;

/// Times of good fixes, and the reported state.
#[derive(Debug)]
pub struct ReceiverMonitor {
    start: Time,
    last_fix: Option<Time>,
    is_good: bool,
    is_reported_absent: bool,
}

impl ReceiverMonitor {
    pub const fn new(start: Time) -> Self {
        Self { start, last_fix: None, is_good: false, is_reported_absent: false }
    }

    /// Reports the arrival of a good fix.
    pub fn observe_fix(&mut self, now: Time) {
        self.last_fix = Some(now);
    }

    /// Arrival of the last good fix.
    pub const fn last_fix(&self) -> Option<Time> {
        self.last_fix
    }

    /// Whether good fixes arrive.
    pub const fn is_good(&self) -> bool {
        self.is_good
    }

    /// The message due at `now`, if any.
    pub fn look(&mut self, now: Time) -> Option<(Level, &'static str)> {
        let is_good = self.last_fix.is_some_and(|arrival| now - arrival < FIX_FRESH_S);
        if std::mem::replace(&mut self.is_good, is_good) != is_good {
            return Some(match is_good {
                true => (Level::Info, "good fixes arrive"),
                false => (Level::Warning, "no good fix for 3 s"),
            });
        }
        let is_absent = self.last_fix.is_none() && now - self.start >= FIRST_FIX_S;
        (is_absent && !std::mem::replace(&mut self.is_reported_absent, true)).then_some((
            Level::Warning,
            "no fix in 30 s; check the receiver's power, antenna and line, and [receiver] protocol \
             and baud",
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(fixes_s: &[f64], until_s: u32) -> Vec<(u32, &'static str)> {
        let start = Time::ZERO + 100.0;
        let mut watch = ReceiverMonitor::new(start);
        let at = |second: u32| start + f64::from(second);
        (0..=until_s)
            .filter_map(|second| {
                if fixes_s.contains(&f64::from(second)) {
                    watch.observe_fix(at(second));
                }
                watch.look(at(second)).map(|(_, text)| (second, text))
            })
            .collect()
    }

    #[test]
    fn a_receiver_that_never_sends_a_fix_is_reported_once() {
        let told = told(&[], 300);
        assert!(matches!(told[..], [(30, text)] if text.starts_with("no fix in 30 s")), "{told:?}");
    }

    #[test]
    fn lost_and_recovered_fixes_are_reported() {
        let told = told(&[2.0, 3.0, 50.0], 60);
        let expected = [
            "good fixes arrive",
            "no good fix for 3 s",
            "good fixes arrive",
            "no good fix for 3 s",
        ];
        assert_eq!(told.iter().map(|(second, _)| *second).collect::<Vec<_>>(), [2, 6, 50, 53]);
        assert_eq!(told.iter().map(|(_, text)| *text).collect::<Vec<_>>(), expected);
    }
}
