//! Chooses one of several sensors of a kind.

/// The sensors of one kind in a log, in order of preference, each with its number of messages.
#[derive(Debug)]
pub(crate) struct Counts<K>(Vec<(K, usize)>);

/// Ratio of message counts above which a later sensor is preferred to an earlier one.
const MUCH_MORE: f64 = 1.5;

impl<K: Copy + PartialEq> Counts<K> {
    /// Sensors in order of preference.
    pub fn new(sensors: impl Iterator<Item = (K, usize)>) -> Self {
        Self(sensors.filter(|&(_, count)| count > 0).collect())
    }

    /// The sensor to read: the first with the number `wanted`, by `instance`; without `wanted`, the first unless
    /// another has many more messages. The second value lists the other sensors, if any, by `name`.
    ///
    /// # Errors
    /// A sentence where no sensor has the number `wanted`.
    pub fn choose(
        &self,
        wanted: Option<usize>,
        instance: impl Fn(K) -> usize,
        name: impl Fn(K) -> String,
    ) -> Result<(Option<K>, Option<String>), String> {
        let in_words =
            |&(sensor, count): &(K, usize)| format!("{} ({count} messages)", name(sensor));
        let listed = |sensors: &mut dyn Iterator<Item = &(K, usize)>| {
            sensors.map(in_words).collect::<Vec<_>>().join(", ")
        };
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
                let much_more = |count: usize, most: usize| count as f64 > MUCH_MORE * most as f64;
                let best = self
                    .0
                    .iter()
                    .reduce(|best, sensor| if much_more(sensor.1, best.1) { sensor } else { best });
                let Some(best) = best else { return Ok((None, None)) };
                best
            }
        };
        let mut others = self.0.iter().filter(|(sensor, _)| *sensor != taken.0).peekable();
        let sentence = others.peek().is_some().then(|| {
            let others = listed(&mut others);
            format!("{} is read; the log also has {others}", in_words(taken))
        });
        Ok((Some(taken.0), sentence))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_is_read_unless_another_has_many_more_or_is_asked_for() {
        let counts = Counts::new([(0, 100), (1, 140), (2, 151), (3, 0)].into_iter());
        let choose = |wanted| counts.choose(wanted, |sensor| sensor, |sensor| format!("S{sensor}"));
        assert_eq!(choose(None).unwrap().0, Some(2));
        assert_eq!(
            choose(Some(1)).unwrap(),
            (
                Some(1),
                Some(
                    "S1 (140 messages) is read; the log also has S0 (100 messages), S2 (151 \
                     messages)"
                        .to_owned()
                )
            )
        );
        let error = choose(Some(3)).unwrap_err();
        assert!(error.starts_with("found no instance 3; the log has S0 (100"), "{error}");
        let none = Counts::<u8>::new(std::iter::empty());
        assert_eq!(none.choose(None, |_| 0, |_| String::new()), Ok((None, None)));
    }
}
