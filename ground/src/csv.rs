//! A stretch of some channels as CSV.

use std::fmt::Write as _;

use crate::channel::{CHANNELS, Id};
use crate::series::Point;
use crate::store::Store;

/// A longer table is not written, rows.
pub const LONGEST: usize = 500_000;

/// A channel, and its values in order of time.
pub type Column = (Id, Vec<Point>);

/// A stretch of some channels, to be written when whoever holds the store goes on.
#[must_use]
pub fn columns(store: &Store, channels: &[Id], from_s: f64, to_s: f64) -> Vec<Column> {
    let points = |id| store.series(id).between(from_s.next_down(), to_s).take(LONGEST + 1);
    channels.iter().map(|&id| (id, points(id).collect())).collect()
}

/// The table's first column is `t_s`, seconds since the start of 1970, then one for each channel; an
/// empty field is a value that did not come at that moment, or is not known. `None` where it would be
/// longer than [`LONGEST`].
#[must_use]
pub fn table(columns: Vec<Column>) -> Option<String> {
    let mut text = String::from("t_s");
    let mut left = Vec::with_capacity(columns.len());
    for (id, points) in columns {
        text.push(',');
        text.push_str(CHANNELS[id as usize].name);
        left.push(points.into_iter().peekable());
    }
    text.push('\n');
    let mut rows = 0;
    loop {
        let next = left.iter_mut().filter_map(|points| points.peek()).map(|&(time_s, _)| time_s);
        let time_s = next.fold(f64::INFINITY, f64::min);
        if time_s.is_infinite() {
            return Some(text);
        }
        if rows == LONGEST {
            return None;
        }
        rows += 1;
        // Milliseconds are not enough to tell two frames of a burst apart, microseconds are.
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
        let text = table(columns(&store, &[Id::Pitch, Id::Roll], 1.0, 2.0)).unwrap();
        let expected = "t_s,pitch_deg,roll_deg\n1.000000,-2,1.5\n1.100000,,\n1.200000,3,\n";
        assert_eq!(text, expected);
    }
}
