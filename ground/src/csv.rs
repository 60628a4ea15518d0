//! A time range of some channels as CSV, written in pieces: the whole table is never in memory.

use std::fmt::{self, Write as _};

use crate::channel::{CHANNELS, Id};
use crate::series::Point;
use crate::store::Store;

/// Size of a piece, bytes; the piece ends after the row that exceeds it.
const PIECE: usize = 64 * 1024;

/// A partly written table. The first column is `t_s`, seconds since the start of 1970, followed by one column per
/// channel. An empty field means no value at that time, or an unknown value.
#[derive(Clone, Debug)]
pub struct Table {
    channels: Vec<Id>,
    /// Per channel, the time up to which the store had already dropped values when the table was begun, s. Empty before
    /// the header is written.
    gone_s: Vec<f64>,
    /// Time of the last written row, s; `None` before the header is written.
    written_s: Option<f64>,
    is_whole: bool,
    from_s: f64,
    to_s: f64,
}

/// Error: values were dropped from the store before they were written. The message is also the last line of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrokenOff {
    /// Time up to which the table is complete, s.
    pub whole_to_s: f64,
}

impl fmt::Display for BrokenOff {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { whole_to_s } = self;
        write!(
            f,
            "broken off after {whole_to_s:.6} s: the download was too slow, later values were dropped"
        )
    }
}

impl Table {
    /// A table of `channels` from `from_s` to `to_s`, both inclusive.
    #[must_use]
    pub const fn new(channels: Vec<Id>, from_s: f64, to_s: f64) -> Self {
        Self { channels, gone_s: Vec::new(), written_s: None, is_whole: false, from_s, to_s }
    }

    /// The next rows. The store must be the same each time. `None` after the last row.
    ///
    /// # Errors
    /// [`BrokenOff`] if the store has dropped values of these rows since the table was begun.
    pub fn piece(&mut self, store: &Store) -> Result<Option<String>, BrokenOff> {
        if self.is_whole {
            return Ok(None);
        }
        let mut text = String::new();
        let gone_s = || self.channels.iter().map(|id| store.series(*id).gone_s());
        if let Some(whole_to_s) = self.written_s {
            let lost = |(now_s, then_s): (f64, &f64)| now_s > whole_to_s.max(*then_s);
            if gone_s().zip(&self.gone_s).any(lost) {
                return Err(BrokenOff { whole_to_s });
            }
        } else {
            self.gone_s = gone_s().collect();
            text.push_str("t_s");
            for id in &self.channels {
                text.push(',');
                text.push_str(CHANNELS[*id as usize].name);
            }
            text.push('\n');
        }
        let mut written_s = self.written_s.unwrap_or_else(|| self.from_s.next_down());
        let values = |id: &Id| store.series(*id).between(written_s, self.to_s).peekable();
        let mut left: Vec<_> = self.channels.iter().map(values).collect();
        while text.len() <= PIECE {
            let next = left.iter_mut().filter_map(|points| points.peek()).map(|point| point.0);
            let time_s = next.fold(f64::INFINITY, f64::min);
            if time_s.is_infinite() {
                self.is_whole = true;
                break;
            }
            written_s = time_s;
            // Frames of a burst differ by less than a millisecond, but by more than a microsecond.
            let _ = write!(text, "{time_s:.6}");
            for points in &mut left {
                text.push(',');
                let now = points.next_if(|&(other_s, _): &Point| other_s <= time_s);
                if let Some((_, value)) = now.filter(|(_, value)| !value.is_nan()) {
                    let _ = write!(text, "{value}");
                }
            }
            text.push('\n');
        }
        drop(left);
        self.written_s = Some(written_s);
        Ok((!text.is_empty()).then_some(text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::Batch;

    #[test]
    fn rows_hold_what_came_together_and_gaps_are_empty() {
        let mut store = Store::new(100);
        for (time_s, values) in [
            (1.0, vec![(Id::Roll, 1.5), (Id::Pitch, -2.0)]),
            (1.1, vec![(Id::Roll, f64::NAN)]),
            (1.2, vec![(Id::Pitch, 3.0)]),
            (9.0, vec![(Id::Roll, 7.0)]),
        ] {
            store.push(&Batch { time_s, values });
        }
        let mut table = Table::new(vec![Id::Pitch, Id::Roll], 1.0, 2.0);
        let text = table.piece(&store).unwrap().unwrap();
        let expected = "t_s,pitch_deg,roll_deg\n1.000000,-2,1.5\n1.100000,,\n1.200000,3,\n";
        assert_eq!((text.as_str(), table.piece(&store)), (expected, Ok(None)));
    }

    #[test]
    fn pieces_put_together_are_the_table() {
        let mut store = Store::new(100_000);
        for k in 0..20_000 {
            let values = vec![(Id::Roll, f64::from(k)), (Id::Pitch, 0.5)];
            store.push(&Batch { time_s: 100.0 + 0.01 * f64::from(k), values });
        }
        let mut table = Table::new(vec![Id::Roll, Id::Pitch], 100.0, 290.0);
        let pieces: Vec<_> = std::iter::from_fn(|| table.piece(&store).unwrap()).collect();
        assert!(pieces.len() > 3 && pieces.iter().all(|piece| piece.len() < PIECE + 100));
        let text = pieces.concat();
        assert_eq!(text.lines().count(), 19_002);
        for (k, line) in text.lines().skip(1).enumerate() {
            assert_eq!(line, format!("{:.6},{k},0.5", 100.0 + 0.01 * k as f64));
        }
    }

    #[test]
    fn a_table_taken_more_slowly_than_values_come_is_broken_off_where_they_are_gone() {
        let mut store = Store::new(10_000);
        let fly = |store: &mut Store, cycles: std::ops::Range<u32>| {
            for k in cycles {
                let mut values = vec![(Id::Roll, f64::from(k))];
                values.extend((k % 10 == 0).then_some((Id::Satellites, 9.0)));
                store.push(&Batch { time_s: f64::from(k), values });
            }
        };
        fly(&mut store, 0..30_000);
        // Values that were dropped before the table was begun do not count as missing, nor do values after its end.
        let mut short = Table::new(vec![Id::Roll, Id::Satellites], 20_000.0, 20_100.0);
        let mut slow = Table::new(vec![Id::Roll, Id::Satellites], 0.0, 1e9);
        assert!(short.piece(&store).unwrap().unwrap().ends_with("\n20100.000000,20100,9\n"));
        let (first, second) = (slow.piece(&store).unwrap(), slow.piece(&store).unwrap());
        assert!(first.is_some() && second.is_some());
        let written_s = slow.written_s.unwrap();
        assert!((20_000.0..29_000.0).contains(&written_s), "{written_s}");
        fly(&mut store, 30_000..written_s as u32 + 10_000);
        assert!(slow.clone().piece(&store).is_ok());
        fly(&mut store, written_s as u32 + 10_000..written_s as u32 + 10_010);
        assert_eq!(slow.piece(&store), Err(BrokenOff { whole_to_s: written_s }));
        assert_eq!(short.piece(&store), Ok(None));
    }
}
