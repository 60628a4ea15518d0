//! Moments gathered into spans.

/// Moments that lie close together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    pub start_s: f64,
    pub end_s: f64,
    /// How many moments.
    pub count: usize,
    /// The largest size among them.
    pub largest: f64,
}

/// The `(time, size)` of moments in order of time, gathered where no more than `apart_s` lie between
/// one and the next.
pub(super) fn spans(moments: impl IntoIterator<Item = (f64, f64)>, apart_s: f64) -> Vec<Span> {
    let mut spans: Vec<Span> = Vec::new();
    for (time_s, size) in moments {
        match spans.last_mut() {
            Some(span) if time_s - span.end_s <= apart_s => {
                span.end_s = time_s;
                span.count += 1;
                span.largest = span.largest.max(size);
            }
            _ => spans.push(Span { start_s: time_s, end_s: time_s, count: 1, largest: size }),
        }
    }
    spans
}

/// Runs of `values` that repeat to the last bit by more than chance: first and last index of each.
///
/// How often a value repeats the one before, shortly before and after a run, is what chance may do; a
/// coarse sensor at rest repeats itself all the time.
pub(super) fn improbable_runs<T: PartialEq>(values: &[T]) -> Vec<(usize, usize)> {
    /// Values before and after a run that chance is judged by.
    const NEAR: usize = 60;
    /// A run less likely than e to minus this is none of chance.
    const UNLIKELY: f64 = 18.0;
    let repeats: Vec<bool> = values.windows(2).map(|pair| pair[0] == pair[1]).collect();
    let mut runs = Vec::new();
    let mut first = 0;
    while first < repeats.len() {
        let length = repeats[first..].iter().take_while(|repeats| **repeats).count();
        if length > 1 {
            let before = &repeats[first.saturating_sub(NEAR)..first];
            let after = &repeats[first + length..(first + length + NEAR).min(repeats.len())];
            let near = before.iter().chain(after);
            let repeated = near.clone().filter(|repeats| **repeats).count();
            let known = before.len() + after.len();
            let chance = (repeated as f64 + 1.0) / (known as f64 + 2.0);
            if known >= NEAR / 4 && length as f64 * -chance.ln() > UNLIKELY {
                runs.push((first, first + length));
            }
        }
        first += length + 1;
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_close_together_are_one_span() {
        let found = spans([(1.0, 2.0), (1.5, 5.0), (4.0, 1.0)], 1.0);
        let first = Span { start_s: 1.0, end_s: 1.5, count: 2, largest: 5.0 };
        assert_eq!(found, [first, Span { start_s: 4.0, end_s: 4.0, count: 1, largest: 1.0 }]);
    }

    #[test]
    fn a_run_is_improbable_only_where_its_neighbours_do_not_repeat() {
        let mut values: Vec<usize> = (0..200).collect();
        values[100..115].fill(7);
        assert_eq!(improbable_runs(&values), [(100, 114)]);
        let coarse: Vec<usize> = (0..400).map(|k| k / 13).collect();
        assert_eq!(improbable_runs(&coarse), []);
    }
}
