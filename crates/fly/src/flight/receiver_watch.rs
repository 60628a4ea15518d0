//! Whether fixes come: when they stay away, when they are back, and where none ever came.

use hovernav::time::Time;
use hovernav_log::record::Level;

/// The receiver counts as lost when its last good fix came longer ago than this, s.
const FIX_FRESH_S: f64 = 3.0;
/// A receiver that knows its almanac has its first fix after this, s.
const FIRST_FIX_S: f64 = 30.0;

/// When good fixes came, and what has been said of it.
#[derive(Debug)]
pub struct ReceiverWatch {
    start: Time,
    last_fix: Option<Time>,
    is_good: bool,
    is_told_absent: bool,
}

impl ReceiverWatch {
    pub const fn new(start: Time) -> Self {
        Self { start, last_fix: None, is_good: false, is_told_absent: false }
    }

    /// A good fix has arrived.
    pub fn hear_fix(&mut self, now: Time) {
        self.last_fix = Some(now);
    }

    /// Arrival of the last good fix.
    pub const fn last_fix(&self) -> Option<Time> {
        self.last_fix
    }

    /// Whether fixes come.
    pub const fn is_good(&self) -> bool {
        self.is_good
    }

    /// What there is to say `now`.
    pub fn look(&mut self, now: Time) -> Option<(Level, &'static str)> {
        let is_good = self.last_fix.is_some_and(|arrival| now - arrival < FIX_FRESH_S);
        if std::mem::replace(&mut self.is_good, is_good) != is_good {
            return Some(match is_good {
                true => (Level::Info, "fixes come"),
                false => (Level::Warning, "no good fix for 3 s"),
            });
        }
        let is_absent = self.last_fix.is_none() && now - self.start >= FIRST_FIX_S;
        (is_absent && !std::mem::replace(&mut self.is_told_absent, true)).then_some((
            Level::Warning,
            "no fix in 30 s; look at the receiver's power, antenna and line, [receiver] protocol and baud",
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(fixes_s: &[f64], until_s: u32) -> Vec<(u32, &'static str)> {
        let start = Time::ZERO + 100.0;
        let mut watch = ReceiverWatch::new(start);
        let at = |second: u32| start + f64::from(second);
        (0..=until_s)
            .filter_map(|second| {
                if fixes_s.contains(&f64::from(second)) {
                    watch.hear_fix(at(second));
                }
                watch.look(at(second)).map(|(_, text)| (second, text))
            })
            .collect()
    }

    #[test]
    fn a_receiver_that_never_gives_a_fix_is_told_once() {
        let told = told(&[], 300);
        assert!(matches!(told[..], [(30, text)] if text.starts_with("no fix in 30 s")), "{told:?}");
    }

    #[test]
    fn fixes_that_stay_away_and_come_back_are_told() {
        let told = told(&[2.0, 3.0, 50.0], 60);
        let expected = ["fixes come", "no good fix for 3 s", "fixes come", "no good fix for 3 s"];
        assert_eq!(told.iter().map(|(second, _)| *second).collect::<Vec<_>>(), [2, 6, 50, 53]);
        assert_eq!(told.iter().map(|(_, text)| *text).collect::<Vec<_>>(), expected);
    }
}
