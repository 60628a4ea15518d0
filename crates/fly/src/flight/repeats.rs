//! Repeated messages: reported at once, then with growing pauses and the count of the suppressed ones.

use hovernav::time::Time;
use hovernav_record::{Level, Part, ShortText};

/// Number of texts tracked at a time; a new one replaces the one with the oldest occurrence.
const TRACKED: usize = 16;
/// Shortest pause from the first report to the second, s; it doubles with each report.
const FIRST_PAUSE_S: f64 = 2.0;
/// Longest pause between reports, s.
const LONGEST_PAUSE_S: f64 = 60.0;
/// Longest pause between reports of a critical message, s.
const LONGEST_CRITICAL_PAUSE_S: f64 = 4.0;
/// Time without an occurrence after which a message is over, s.
const OVER_S: f64 = 10.0;

/// A repeated text.
#[derive(Clone, Copy, Debug)]
struct Repeated {
    key: u64,
    level: Level,
    part: Part,
    text: ShortText,
    /// Time of the last report and of the last occurrence.
    reported: Time,
    occurred: Time,
    pause_s: f64,
    /// Number of occurrences since the last report.
    unreported: u32,
}

/// The final report of a text that has stopped repeating.
#[derive(Clone, Copy, Debug)]
pub struct Rest {
    pub level: Level,
    pub part: Part,
    pub text: ShortText,
}

/// The repeated texts.
#[derive(Clone, Debug, Default)]
pub struct Repeats([Option<Repeated>; TRACKED]);

impl Repeats {
    /// Counts `text` at `now`; returns the text to report, if any.
    pub fn observe(
        &mut self,
        now: Time,
        level: Level,
        part: Part,
        text: ShortText,
    ) -> Option<ShortText> {
        let key = key(text.as_str());
        let known = self.0.iter_mut().flatten().find(|one| one.key == key);
        if let Some(one) = known {
            (one.occurred, one.text, one.level) = (now, text, level);
            if now - one.reported < one.pause_s {
                one.unreported += 1;
                return None;
            }
            one.reported = now;
            let longest_s = match level {
                Level::Critical => LONGEST_CRITICAL_PAUSE_S,
                _ => LONGEST_PAUSE_S,
            };
            one.pause_s = (2.0 * one.pause_s).min(longest_s);
            return Some(match std::mem::take(&mut one.unreported) {
                0 => text,
                unreported => ShortText::new(format_args!("{text} ({unreported} more before)")),
            });
        }
        let one = Repeated {
            key,
            level,
            part,
            text,
            reported: now,
            occurred: now,
            pause_s: FIRST_PAUSE_S,
            unreported: 0,
        };
        let longest_ago =
            self.0.iter_mut().min_by_key(|slot| slot.map(|one| one.occurred.nanoseconds()));
        if let Some(slot) = longest_ago {
            *slot = Some(one);
        }
        Some(text)
    }

    /// Removes texts that are over at `now`, up to the first with unreported occurrences, and returns that one.
    pub fn over(&mut self, now: Time) -> Option<Rest> {
        let Rest { part, text, .. } = self.end(|one| now - one.occurred > OVER_S)?;
        // A fault that is over is no fault.
        Some(Rest { level: Level::Info, part, text: ShortText::new(format_args!("over: {text}")) })
    }

    /// As [`over`](Self::over), for all texts at the end of a flight.
    pub fn last(&mut self) -> Option<Rest> {
        self.end(|_| true)
    }

    fn end(&mut self, is_over: impl Fn(&Repeated) -> bool) -> Option<Rest> {
        self.0.iter_mut().find_map(|slot| {
            let one = slot.take_if(|one| is_over(one)).filter(|one| one.unreported > 0)?;
            let Repeated { level, part, text, occurred, unreported, .. } = one;
            let at_s = occurred.seconds();
            let text =
                ShortText::new(format_args!("{text} ({unreported} more, the last at {at_s:.1} s)"));
            Some(Rest { level, part, text })
        })
    }
}

/// A hash (FNV-1a) that is equal for texts that differ only in their digits.
fn key(text: &str) -> u64 {
    let letters = text.bytes().filter(|byte| !byte.is_ascii_digit());
    letters.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(seconds: f64) -> Time {
        Time::from_seconds(seconds)
    }

    fn observe(repeats: &mut Repeats, seconds: f64, text: &str) -> Option<String> {
        let text = ShortText::new(text);
        let reported = repeats.observe(at(seconds), Level::Warning, Part::InertialUnit, text);
        reported.map(|text| text.as_str().to_owned())
    }

    #[test]
    fn a_repeated_fault_is_reported_with_growing_pauses_and_counted() {
        let mut repeats = Repeats::default();
        let mut reported: Vec<(f64, String)> = Vec::new();
        let faults: u32 = 400;
        for fault in 0..faults {
            let seconds = 1.65 * f64::from(fault);
            let text = format!("inertial unit: no packet for {seconds:.1} s");
            reported.extend(observe(&mut repeats, seconds, &text).map(|text| (seconds, text)));
        }
        assert_eq!(reported[0], (0.0, "inertial unit: no packet for 0.0 s".into()));
        assert!(reported.len() < 20, "{reported:?}");
        let pauses: Vec<f64> = reported.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
        assert!(pauses.iter().is_sorted_by(|a, b| **a < **b + 1.7), "{pauses:?}");
        assert!(pauses[0] < 4.0 && pauses.iter().all(|pause_s| *pause_s < 62.0), "{pauses:?}");
        let rest = repeats.last().map(|rest| rest.text.as_str().to_owned());
        let counted = reported.iter().map(|(_, text)| text.clone()).chain(rest);
        let unreported = |text: &String| {
            let number = text.rsplit_once('(').and_then(|(_, more)| more.split_once(' '));
            number.map_or(0, |(number, _)| number.parse::<usize>().unwrap())
        };
        let all: usize = counted.map(|text| unreported(&text)).sum::<usize>() + reported.len();
        assert_eq!(all, faults as usize);
    }

    /// Critical messages are repeated at least every 4 s.
    #[test]
    fn critical_messages_are_repeated_soon() {
        let mut repeats = Repeats::default();
        let text = ShortText::new("the attitude is not known");
        let reported: Vec<i32> = (0..60)
            .filter(|&second| {
                let now = at(f64::from(second));
                repeats.observe(now, Level::Critical, Part::InertialUnit, text).is_some()
            })
            .collect();
        assert!(reported.starts_with(&[0, 2, 6]), "{reported:?}");
        assert!(reported.windows(2).all(|pair| pair[1] - pair[0] <= 4), "{reported:?}");
    }

    #[test]
    fn another_fault_is_reported_at_once_and_one_that_is_over_with_its_count() {
        let mut repeats = Repeats::default();
        assert!(observe(&mut repeats, 0.0, "fix refused: a jump of 30 m").is_some());
        assert!(observe(&mut repeats, 1.0, "fix refused: a jump of 31 m").is_none());
        assert!(observe(&mut repeats, 1.0, "inertial unit: sample stuck").is_some());
        assert!(repeats.over(at(5.0)).is_none());
        let rest = repeats.over(at(11.5)).unwrap();
        let text = "over: fix refused: a jump of 31 m (1 more, the last at 1.0 s)";
        assert_eq!((rest.level, rest.text.as_str()), (Level::Info, text));
        assert!(repeats.over(at(12.0)).is_none());
        // A message that is over is reported at once when it occurs again.
        assert!(observe(&mut repeats, 12.0, "fix refused: a jump of 29 m").is_some());
    }

    #[test]
    fn more_faults_than_are_tracked_are_still_reported() {
        let mut repeats = Repeats::default();
        for (index, letter) in ('a'..='z').enumerate() {
            assert!(observe(&mut repeats, index as f64, &letter.to_string()).is_some());
        }
    }
}
