//! A row of the table, and the table as CSV.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use hovernav_findings::Finding;
use hovernav_score::{Axis, AxisScore, Score, Statistics};

/// The columns of numbers, in the order of the file. Errors are root mean squares.
pub const NUMBERS: [&str; 33] = [
    "vn_mps",
    "ve_mps",
    "vd_mps",
    "roll_deg",
    "pitch_deg",
    "yaw_deg",
    "horizontal_m",
    "down_m",
    "position_within_3_sigma",
    "velocity_within_3_sigma",
    "attitude_within_3_sigma",
    "north_over_sigma",
    "east_over_sigma",
    "down_over_sigma",
    "vn_over_sigma",
    "ve_over_sigma",
    "vd_over_sigma",
    "roll_over_sigma",
    "pitch_over_sigma",
    "yaw_over_sigma",
    "documented_windows",
    "documented_median_m",
    "documented_p90_m",
    "documented_worst_m",
    "documented_over_sigma",
    "spaced_windows",
    "spaced_median_m",
    "spaced_p90_m",
    "spaced_worst_m",
    "spaced_over_sigma",
    "fixes_used",
    "fixes_rejected",
    "findings",
];

/// Columns of text before the numbers.
const BEFORE: [&str; 3] = ["set", "run", "reference"];
/// Columns of text after the numbers.
const BEHIND: [&str; 2] = ["kinds", "refused"];

/// Axes with a one-sigma of the filter: position, velocity, attitude.
const GROUPS: [(&str, [Axis; 3]); 3] = [
    ("position", [Axis::North, Axis::East, Axis::Down]),
    ("velocity", [Axis::VelocityNorth, Axis::VelocityEast, Axis::VelocityDown]),
    ("attitude", [Axis::Roll, Axis::Pitch, Axis::Yaw]),
];

/// One run of one set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// The set's name.
    pub set: String,
    /// Name of the run: `causal`, `smoothed`, `outages` with the length of the windows, or `estimate` where the log was
    /// rejected.
    pub run: String,
    /// Description of the reference; empty without a reference.
    pub reference: String,
    /// Numbers by column, one of [`NUMBERS`]; unknown numbers are absent.
    pub numbers: BTreeMap<String, f64>,
    /// Kinds of the findings, each with its count.
    pub kinds: String,
    /// Reason why the log was rejected; empty if it was not.
    pub refused: String,
}

impl Row {
    /// A row without numbers.
    #[must_use]
    pub fn new(set: &str, run: &str) -> Self {
        Self { set: set.to_owned(), run: run.to_owned(), ..Self::default() }
    }

    pub(crate) fn set(&mut self, column: &str, value: Option<f64>) {
        debug_assert!(NUMBERS.contains(&column), "{column}");
        self.numbers.extend(value.map(|value| (column.to_owned(), value)));
    }

    /// Sets the errors by [`Axis::name`]; errors without a column are ignored.
    pub(crate) fn set_errors(&mut self, errors: impl Iterator<Item = (&'static str, Statistics)>) {
        for (name, statistics) in errors.filter(|(name, _)| NUMBERS.contains(name)) {
            self.set(name, Some(statistics.rmse));
        }
    }

    pub(crate) fn set_score(&mut self, score: &Score) {
        self.set_errors(score.axes.iter().map(|axis| (axis.axis.name(), axis.statistics)));
        for (group, axes) in GROUPS {
            let scored = || axes.iter().filter_map(|axis| score.axis(*axis));
            let worst = scored().filter_map(|axis| axis.within_3_sigma).min_by(f64::total_cmp);
            self.set(&format!("{group}_within_3_sigma"), worst);
            for AxisScore { axis, error_over_sigma, .. } in scored() {
                let (quantity, _) = axis.name().split_once('_').unwrap_or_default();
                self.set(&format!("{quantity}_over_sigma"), *error_over_sigma);
            }
        }
    }

    pub(crate) fn set_findings(&mut self, findings: &[Finding]) {
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        for finding in findings {
            *counts.entry(finding.kind.name()).or_default() += 1;
        }
        self.kinds = counts.iter().fold(String::new(), |mut kinds, (kind, count)| {
            let comma = if kinds.is_empty() { "" } else { ", " };
            let _ = write!(kinds, "{comma}{kind} {count}");
            kinds
        });
        self.set("findings", Some(findings.len() as f64));
    }
}

/// A number with four significant digits, as an integer from 1000 on.
pub(crate) fn short(value: f64) -> String {
    if value.fract() == 0.0 {
        return format!("{value}");
    }
    let magnitude = value.abs().log10().floor();
    format!("{value:.*}", (3.0 - magnitude).clamp(0.0, 12.0) as usize)
}

/// The rows as CSV with a header, numbers with four significant digits.
#[must_use]
pub fn write_csv(rows: &[Row]) -> String {
    let quoted = |text: &str| match text.contains([',', '"', '\n']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    };
    let header: Vec<String> =
        BEFORE.iter().chain(&NUMBERS).chain(&BEHIND).map(ToString::to_string).collect();
    let lines = rows.iter().map(|row| {
        let number = |column: &&str| row.numbers.get(*column).copied().map(short);
        let numbers = NUMBERS.iter().map(|column| number(column).unwrap_or_default());
        let before = [&row.set, &row.run, &row.reference].map(|text| quoted(text));
        let behind = [&row.kinds, &row.refused].map(|text| quoted(text));
        before.into_iter().chain(numbers).chain(behind).collect()
    });
    std::iter::once(header).chain(lines).map(|fields| fields.join(",") + "\n").collect()
}

/// The rows of a table that [`write_csv`] wrote. Columns are found by their name.
///
/// # Errors
/// Text that is not CSV.
pub fn read_csv(text: &str) -> Result<Vec<Row>, csv::Error> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let rows = reader.deserialize().map(|fields| {
        let fields: BTreeMap<String, String> = fields?;
        let text = |column: &str| fields.get(column).cloned().unwrap_or_default();
        let number = |column: &str| Some((column.to_owned(), fields.get(column)?.parse().ok()?));
        Ok(Row {
            set: text("set"),
            run: text("run"),
            reference: text("reference"),
            numbers: NUMBERS.into_iter().filter_map(number).collect(),
            kinds: text("kinds"),
            refused: text("refused"),
        })
    });
    rows.collect()
}
