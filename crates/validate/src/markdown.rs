//! The table as a page.

use std::fmt::Write as _;

use crate::row::{Row, short};

/// Range of the ratio of error to sigma that is consistent; ratios outside are set in bold.
const CONSISTENT: std::ops::RangeInclusive<f64> = 0.8..=1.3;

const HEAD: &str = "# Every set

Written by `cargo run --release -p hovernav-validate -- --write`; [`sets.csv`](sets.csv) also has the smoothed runs,
the findings, and the runs without a reference. The page [Validation](../validation.md) explains the numbers.

";

const ERRORS: &str = "## Errors

Root mean square of solution less reference, causal, in m/s, degrees and m. The share within 3σ is that of the worst axis of
position, velocity and attitude. \"Onboard\" and \"not independent\" mark a reference that is another filter's estimate.
Fixes count as used and as rejected where the filter did so with any part of them.

";

const CONSISTENCY: &str = "## Error over sigma

Root mean square of the error over the stated one-sigma, causal: 1 of a consistent filter. Bold is outside 0.8 to 1.3.

";

const OUTAGES: &str = "## Windows without GPS

Largest horizontal distance from the reference in each window, m, as median / 90th percentile / worst, behind the number
of windows. Each window is flown by itself. The documented windows are those of [Validation](../validation.md); the
spaced ones start every 12 s over the whole log. Error over sigma is that of north and east within the windows.

";

/// The rows with a reference, as a Markdown page.
#[must_use]
pub fn markdown(rows: &[Row]) -> String {
    let mut page = HEAD.to_owned();
    let is_run = |row: &&Row| !row.reference.is_empty() && row.run == "causal";
    let scored = |row: &&Row| row.numbers.contains_key("position_within_3_sigma");
    table(
        &mut page,
        ERRORS,
        &[
            "set",
            "reference",
            "vn, ve, vd",
            "roll, pitch, yaw",
            "horizontal, down",
            "within 3σ",
            "fixes used, rejected",
        ],
        rows.iter().filter(is_run),
        |row| {
            vec![
                row.reference.clone(),
                numbers(row, &["vn_mps", "ve_mps", "vd_mps"], ", "),
                numbers(row, &["roll_deg", "pitch_deg", "yaw_deg"], ", "),
                numbers(row, &["horizontal_m", "down_m"], ", "),
                numbers(row, &GROUPS, ", "),
                numbers(row, &["fixes_used", "fixes_rejected"], ", "),
            ]
        },
    );
    table(
        &mut page,
        CONSISTENCY,
        &["set", "north", "east", "down", "vn", "ve", "vd", "roll", "pitch", "yaw"],
        rows.iter().filter(is_run).filter(scored),
        |row| {
            let axes = ["north", "east", "down", "vn", "ve", "vd", "roll", "pitch", "yaw"];
            axes.iter().map(|axis| over_sigma(row, axis)).collect()
        },
    );
    table(
        &mut page,
        OUTAGES,
        &["set", "run", "documented", "error over sigma", "spaced", "error over sigma"],
        rows.iter().filter(|row| row.run.starts_with("outages")),
        |row| {
            let of = |list| [drifts(row, list), over_sigma(row, list)];
            let run = row.run.clone();
            std::iter::once(run).chain(["documented", "spaced"].into_iter().flat_map(of)).collect()
        },
    );
    page.truncate(page.trim_end().len());
    page + "\n"
}

const GROUPS: [&str; 3] =
    ["position_within_3_sigma", "velocity_within_3_sigma", "attitude_within_3_sigma"];

/// Adds a table with a column for the set, followed by those of `cells`.
fn table<'a>(
    page: &mut String,
    intro: &str,
    head: &[&str],
    rows: impl Iterator<Item = &'a Row>,
    cells: impl Fn(&Row) -> Vec<String>,
) {
    let _ = writeln!(page, "{intro}| {} |\n|{}", head.join(" | "), "---|".repeat(head.len()));
    for row in rows {
        let cells = cells(row).join(" | ").replace('\n', " ");
        let _ = writeln!(page, "| {} | {cells} |", row.set);
    }
    page.push('\n');
}

/// The row's numbers in `columns`, joined by `between`, with a dash for each unknown number; empty where all are
/// unknown.
fn numbers(row: &Row, columns: &[&str], between: &str) -> String {
    let number = |column: &&str| row.numbers.get(*column);
    if columns.iter().all(|column| number(column).is_none()) {
        return String::new();
    }
    let words = |column| number(column).map_or("–".into(), |value| short(*value));
    columns.iter().map(words).collect::<Vec<String>>().join(between)
}

fn over_sigma(row: &Row, quantity: &str) -> String {
    let value = row.numbers.get(&format!("{quantity}_over_sigma"));
    let words = |value: &f64| match CONSISTENT.contains(value) {
        true => format!("{value:.2}"),
        false => format!("**{value:.2}**"),
    };
    value.map_or(String::new(), words)
}

fn drifts(row: &Row, list: &str) -> String {
    let column = |of: &str| format!("{list}_{of}");
    let [median, p90, worst] = ["median_m", "p90_m", "worst_m"].map(column);
    match row.numbers.get(&column("windows")) {
        Some(count) => format!("{count}: {}", numbers(row, &[&median, &p90, &worst], " / ")),
        None => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_page_shows_the_committed_table() {
        let rows = crate::read_csv(include_str!("../../../docs/validation/sets.csv")).unwrap();
        assert_eq!(markdown(&rows), include_str!("../../../docs/validation/sets.md"));
    }
}
