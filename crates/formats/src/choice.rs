//! Chooses one of several sensors of a kind.

use hovernav::time::Time;
use hovernav_dataset::{Dimensions, StatedFix};

/// Number of messages of a sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Tally {
    pub messages: usize,
    /// Number of messages with a measurement that may be used.
    pub good: usize,
    /// Digest of the last reading, and the number of messages that have repeated it.
    last: (u64, usize),
}

impl Tally {
    /// A sensor with `good` messages out of all `messages`.
    pub fn of(messages: usize, good: usize) -> Self {
        Self { messages, good, ..Self::default() }
    }

    /// Counts a message with these values. A message is bad if many messages before it have the same reading.
    pub fn count(&mut self, is_good: bool, reading: &[&[f64]]) {
        let mix = |digest: u64, value: &f64| (digest ^ value.to_bits()).wrapping_mul(PRIME);
        let digest = reading.iter().copied().flatten().fold(SEED, mix);
        let is_repeated = digest == self.last.0 && digest != SEED;
        let repeats = if is_repeated { self.last.1 + 1 } else { 0 };
        self.last = (digest, repeats);
        self.messages += 1;
        self.good += usize::from(is_good && repeats < FROZEN);
    }

    /// The tally without `count` of its good messages.
    pub fn without(self, count: usize) -> Self {
        Self { good: self.good.saturating_sub(count), ..self }
    }

    fn bad(self) -> usize {
        self.messages - self.good
    }

    /// Whether a sensor with this tally replaces an `other` sensor that precedes it. It needs more good messages by the
    /// factor [`MUCH_MORE`]. Any larger number is sufficient if many of the other's messages are bad, or only the other
    /// has bad ones.
    fn replaces(self, other: Self) -> bool {
        let is_bad = other.bad() as f64 > BAD * other.messages as f64;
        let is_healthy = self.bad() == 0 && other.bad() > 0;
        self.good as f64 > MUCH_MORE * other.good as f64
            || (is_bad || is_healthy) && self.good > other.good
    }
}

/// Whether a message with this latitude and longitude, degrees, is a fix.
pub(crate) fn is_fix(dimensions: Dimensions, [lat, lon]: [f64; 2]) -> bool {
    StatedFix { dimensions, ..StatedFix::at(Some(Time::ZERO), [lat, lon, f64::NAN]) }.is_fix()
}

/// Whether a sensor of three axes measures: a dead one repeats exact zeros.
pub(crate) fn is_alive(values: [f64; 3]) -> bool {
    values != [0.0; 3] && values.iter().all(|value| value.is_finite())
}

/// The sensors of one kind in a log, in order of preference, each with its number of messages.
#[derive(Debug)]
pub(crate) struct Counts<K>(Vec<(K, Tally)>);

/// Ratio of message counts above which a later sensor is preferred to an earlier one.
const MUCH_MORE: f64 = 1.5;
/// Number of messages with the same reading from which on a sensor is frozen. Loggers that are faster than the sensor
/// repeat each reading less often.
const FROZEN: usize = 50;
/// Initial value of the FNV-1a hash.
const SEED: u64 = 0xCBF2_9CE4_8422_2325;
/// Factor of the FNV-1a hash.
const PRIME: u64 = 0x0100_0000_01B3;
/// Fraction of bad messages from which on a sensor with more good ones is preferred.
const BAD: f64 = 0.1;

/// Largest number of names in a sentence.
const MAX_NAMES: usize = 12;

/// The first `names` in one sentence, and the number of the others.
pub(crate) fn listed(mut names: impl Iterator<Item = String>) -> String {
    let mut listed = names.by_ref().take(MAX_NAMES).collect::<Vec<_>>().join(", ");
    let more = names.count();
    if more > 0 {
        listed += &format!(" and {more} more");
    }
    listed
}

impl<K: Copy + PartialEq> Counts<K> {
    /// Sensors in order of preference.
    pub fn new(sensors: impl Iterator<Item = (K, Tally)>) -> Self {
        Self(sensors.filter(|&(_, tally)| tally.messages > 0).collect())
    }

    /// The sensor to read. It is the first with the number `wanted`, by `instance`. Without `wanted`, it is the first,
    /// unless another has many more good messages. The second value lists the other sensors, if any, by `name`, with
    /// the command's `option` that selects one.
    ///
    /// # Errors
    /// A sentence if no sensor has the number `wanted`.
    pub fn choose(
        &self,
        (option, wanted): (&str, Option<usize>),
        instance: impl Fn(K) -> usize,
        name: impl Fn(K) -> String,
    ) -> Result<(Option<K>, Option<String>), String> {
        let in_words = |&(sensor, tally): &(K, Tally)| match (tally.messages, tally.bad()) {
            (messages, 0) => format!("{} ({messages} messages)", name(sensor)),
            (messages, bad) => format!("{} ({messages} messages, {bad} of them bad)", name(sensor)),
        };
        let listed = |sensors: &mut dyn Iterator<Item = &(K, Tally)>| listed(sensors.map(in_words));
        let taken = match wanted {
            Some(wanted) => {
                let taken = self.0.iter().find(|&&(sensor, _)| instance(sensor) == wanted);
                let Some(taken) = taken else {
                    let present = match &self.0[..] {
                        [] => "none".to_owned(),
                        sensors => listed(&mut sensors.iter()),
                    };
                    return Err(format!("found no instance {wanted}; the log has {present}"));
                };
                taken
            }
            None => {
                let best = self
                    .0
                    .iter()
                    .reduce(|best, sensor| if sensor.1.replaces(best.1) { sensor } else { best });
                let Some(best) = best else { return Ok((None, None)) };
                best
            }
        };
        let mut others = self.0.iter().filter(|(sensor, _)| *sensor != taken.0).peekable();
        let sentence = others.peek().is_some().then(|| {
            let others = listed(&mut others);
            let select = if option.is_empty() {
                String::new()
            } else {
                format!("; {option} selects another")
            };
            format!("{} is read; the log also has {others}{select}", in_words(taken))
        });
        Ok((Some(taken.0), sentence))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tally(messages: usize, bad: usize) -> Tally {
        Tally::of(messages, messages - bad)
    }

    #[test]
    fn the_first_is_read_unless_another_has_many_more_or_is_asked_for() {
        let all = [(0, tally(100, 0)), (1, tally(140, 0)), (2, tally(151, 0)), (3, tally(0, 0))];
        let counts = Counts::new(all.into_iter());
        let choose = |wanted| {
            counts.choose(("--imu", wanted), |sensor| sensor, |sensor| format!("S{sensor}"))
        };
        assert_eq!(choose(None).unwrap().0, Some(2));
        assert_eq!(
            choose(Some(1)).unwrap(),
            (
                Some(1),
                Some(
                    "S1 (140 messages) is read; the log also has S0 (100 messages), S2 (151 \
                     messages); --imu selects another"
                        .to_owned()
                )
            )
        );
        let error = choose(Some(3)).unwrap_err();
        assert!(error.starts_with("found no instance 3; the log has S0 (100"), "{error}");
        let none = Counts::<u8>::new(std::iter::empty());
        assert_eq!(none.choose(("", None), |_| 0, |_| String::new()), Ok((None, None)));
    }

    #[test]
    fn a_frozen_first_sensor_is_not_read_where_another_is_good() {
        let of = |frozen_from: u32, each: u32| {
            let mut tally = Tally::default();
            (0..1000).for_each(|k| tally.count(true, &[&[f64::from(k.min(frozen_from) / each)]]));
            tally
        };
        for (first, second, expected) in [
            (of(0, 1), of(1000, 1), 1),
            (of(300, 1), of(1000, 1), 1),
            (of(300, 1), of(300, 1), 0),
            // Readings that a fast logger repeats.
            (of(1000, 20), of(1000, 1), 0),
        ] {
            let counts = Counts::new([(0, first), (1, second)].into_iter());
            let taken = counts.choose(("", None), |sensor| sensor, |sensor| format!("S{sensor}"));
            assert_eq!(taken.unwrap().0, Some(expected), "{first:?} {second:?}");
        }
    }

    #[test]
    fn a_dead_or_often_bad_first_sensor_is_not_read_where_another_is_good() {
        for (first, second, expected) in [
            (tally(100, 100), tally(100, 0), 1),
            (tally(100, 30), tally(100, 0), 1),
            (tally(100, 5), tally(100, 0), 1),
            (tally(100, 5), tally(100, 3), 0),
            (tally(100, 5), tally(50, 0), 0),
            (tally(100, 50), tally(100, 50), 0),
            (tally(100, 100), tally(100, 100), 0),
        ] {
            let counts = Counts::new([(0, first), (1, second)].into_iter());
            let taken = counts.choose(("", None), |sensor| sensor, |sensor| format!("S{sensor}"));
            assert_eq!(taken.unwrap().0, Some(expected), "{first:?} {second:?}");
        }
    }
}
