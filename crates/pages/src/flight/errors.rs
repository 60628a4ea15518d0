//! Errors of the estimate against the reference, compared with the filter's uncertainty.

use hovernav_score::{Axis, AxisScore, Score};

use super::motion::Clock;
use crate::{Figure, Role, Row, Section, Series, Table, TableRow};

/// The name of an axis and its unit.
pub(crate) fn named(axis: Axis) -> (&'static str, &'static str) {
    match axis {
        Axis::North => ("Position north", "m"),
        Axis::East => ("Position east", "m"),
        Axis::Down => ("Position down", "m"),
        Axis::Horizontal => ("Position horizontal", "m"),
        Axis::VelocityNorth => ("Velocity north", "m/s"),
        Axis::VelocityEast => ("Velocity east", "m/s"),
        Axis::VelocityDown => ("Velocity down", "m/s"),
        Axis::U => ("Forward u", "m/s"),
        Axis::V => ("Right v", "m/s"),
        Axis::W => ("Down w", "m/s"),
        Axis::Roll => ("Roll", "°"),
        Axis::Pitch => ("Pitch", "°"),
        Axis::Yaw => ("Yaw", "°"),
    }
}

/// The table of errors.
pub fn table(score: &Score, clock: Clock) -> Table {
    let row = |AxisScore { axis, statistics, .. }: &AxisScore| {
        let (name, unit) = named(*axis);
        let numbers = [statistics.rmse, statistics.median, statistics.p95, statistics.max];
        TableRow::new(format!("{name}, {unit}"), numbers.map(three_digits).into())
    };
    Table {
        caption: format!(
            "Error against the reference from {:.1} s on: root mean square; then median, 95th \
             percentile and maximum of its magnitude",
            clock.seconds(score.from)
        ),
        heads: ["", "RMSE", "Median", "95 %", "Max"].map(Into::into).into(),
        rows: score.axes.iter().map(row).collect(),
    }
}

/// The axes whose errors are drawn over time.
pub(crate) const DRAWN: [Axis; 9] = [
    Axis::North,
    Axis::East,
    Axis::Down,
    Axis::VelocityNorth,
    Axis::VelocityEast,
    Axis::VelocityDown,
    Axis::Roll,
    Axis::Pitch,
    Axis::Yaw,
];

/// The errors of position, velocity and attitude over time, with the filter's 3σ bounds.
pub fn section(score: &Score, clock: Clock) -> Section {
    let rows = DRAWN.into_iter().filter_map(|axis| {
        let score = score.axis(axis)?;
        let (name, unit) = named(axis);
        let points = &score.series;
        let times: Vec<f64> = points.iter().map(|point| clock.seconds(point.time)).collect();
        let errors: Vec<f64> = points.iter().map(|point| point.error).collect();
        let bounds: Vec<f64> =
            points.iter().map(|point| point.sigma.map_or(f64::NAN, |sigma| 3.0 * sigma)).collect();
        let note = score
            .within_3_sigma
            .zip(score.error_over_sigma)
            .map(|(share, ratio)| format!("{:.1} % inside ±3σ, error/σ {ratio:.2}", 100.0 * share));
        let row = Row { note, ..Row::new(name, unit) };
        Some(row.with(Series::bound(&times, &bounds)).with(Series::line(
            Role::Error,
            &times,
            &errors,
            None,
        )))
    });
    Section::new(
        "errors",
        "Error against the reference",
        "Estimate minus reference, with the 3σ bounds of the filter. \
                      The errors of a consistent filter are inside for 99.7 % of the time.",
    )
    .with(Figure::against_time(rows))
}

/// A number with three significant digits; a dash if unknown.
fn three_digits(value: f64) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    let whole_digits = value.abs().max(1e-3).log10().floor();
    format!("{value:.*}", (2.0 - whole_digits).clamp(0.0, 4.0) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_numbers_have_three_digits() {
        let written = [0.0, 0.012_345, 1.2345, 12.345, 12_345.6, f64::NAN].map(three_digits);
        assert_eq!(written, ["0.0000", "0.0123", "1.23", "12.3", "12346", "–"]);
    }
}
