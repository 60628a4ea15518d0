//! Comparison of two tables.

use crate::row::{NUMBERS, Row, short};

/// Largest relative change of a number that counts as unchanged.
const SHARE: f64 = 0.02;

/// Changes from `old` to `new`, one line each: numbers by more than 2 %, text, and rows without a counterpart.
#[must_use]
pub fn moved(old: &[Row], new: &[Row]) -> Vec<String> {
    let name = |row: &Row| format!("{}, {}", row.set, row.run);
    let same = |a: &Row, b: &Row| a.set == b.set && a.run == b.run;
    let mut lines = Vec::new();
    for row in new {
        let Some(before) = old.iter().find(|before| same(before, row)) else {
            let colon = if row.refused.is_empty() { "" } else { ": " };
            lines.push(format!("{}: new{colon}{}", name(row), row.refused));
            continue;
        };
        for column in NUMBERS {
            let pair = (before.numbers.get(column), row.numbers.get(column));
            lines
                .extend(number_moved(pair).map(|words| format!("{}: {column} {words}", name(row))));
        }
        for (column, was, is) in [
            ("reference", &before.reference, &row.reference),
            ("kinds", &before.kinds, &row.kinds),
            ("refused", &before.refused, &row.refused),
        ] {
            if was != is {
                lines.push(format!("{}: {column} \"{was}\" → \"{is}\"", name(row)));
            }
        }
    }
    let gone = old.iter().filter(|row| !new.iter().any(|other| same(row, other)));
    lines.extend(gone.map(|row| format!("{}: missing", name(row))));
    lines
}

/// Old value, new value and ratio of a number that changed by more than 2 %; `None` otherwise.
fn number_moved(pair: (Option<&f64>, Option<&f64>)) -> Option<String> {
    match pair {
        (Some(&old), Some(&new)) => {
            let is_moved = (new - old).abs() > SHARE * old.abs();
            is_moved.then(|| format!("{} → {} (× {:.3})", short(old), short(new), new / old))
        }
        (None, Some(&new)) => Some(format!("unknown → {}", short(new))),
        (Some(&old), None) => Some(format!("{} → unknown", short(old))),
        (None, None) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::{read_csv, write_csv};

    fn table() -> Vec<Row> {
        let mut row = Row::new("a, \"b\"", "causal");
        row.set("vn_mps", Some(0.123_456_7));
        row.set("fixes_used", Some(12_345.0));
        row.kinds = "gap 1, refused 2".into();
        vec![row, Row { refused: "found nothing".into(), ..Row::new("c", "estimate") }]
    }

    #[test]
    fn a_table_read_back_has_not_moved() {
        let table = table();
        assert_eq!(moved(&read_csv(&write_csv(&table)).unwrap(), &table), [""; 0]);
    }

    #[test]
    fn numbers_beyond_two_percent_text_and_rows_move() {
        let (old, mut new) = (table(), table());
        new[0].set("vn_mps", Some(0.125));
        assert_eq!(moved(&old, &new), [""; 0]);
        new[0].set("vn_mps", Some(0.13));
        new[0].set("yaw_deg", Some(1.0));
        new[0].kinds = "gap 1".into();
        new[1].run = "causal".into();
        assert_eq!(
            moved(&old, &new),
            [
                "a, \"b\", causal: vn_mps 0.1235 → 0.1300 (× 1.053)",
                "a, \"b\", causal: yaw_deg unknown → 1",
                "a, \"b\", causal: kinds \"gap 1, refused 2\" → \"gap 1\"",
                "c, causal: new: found nothing",
                "c, estimate: missing",
            ]
        );
    }
}
