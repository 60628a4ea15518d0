//! The page of a comparison: the differences, and all solutions in one figure each.

use hovernav::earth::{Geodetic, LocalEarth};
use hovernav::time::Time;
use hovernav_formats::{Comparison, Difference, NamedTrajectory};
use hovernav_score::{Axis as ScoreAxis, RelativePoint};

use crate::document::{first_second, time_label};
use crate::flight::errors::{DRAWN, named};
use crate::{
    Abscissa, Fact, Figure, Page, Role, Row, Section, Series, Table, TableRow, TimeAxis, digits,
};

/// Origin of the figures without a geographic position.
const NOWHERE: Geodetic = Geodetic { latitude_rad: 0.0, longitude_rad: 0.0, height_m: 0.0 };
/// Names of the axes north, east, down.
const NED: [&str; 3] = ["North", "East", "Down"];
/// Roles of the solutions, in order.
const ROLES: [Role; 4] = [Role::First, Role::Second, Role::Third, Role::Fourth];

/// Largest number of solutions on a page; further ones are not drawn.
pub const MAX_SOLUTIONS: usize = ROLES.len();

/// The page of a comparison.
pub struct ComparisonPage<'a> {
    comparison: &'a Comparison,
    columns: Vec<Columns>,
    title: String,
    warnings: Vec<String>,
    facts: Vec<Fact>,
}

impl<'a> ComparisonPage<'a> {
    /// The page of `comparison`.
    #[must_use]
    pub fn new(comparison: &'a Comparison) -> Self {
        let columns = columns(&comparison.trajectories, zero_s(comparison));
        let names: Vec<&str> = comparison.trajectories.iter().map(|one| &*one.name).collect();
        let samples = |one: &Columns| Fact::new(&one.name, format!("{} samples", one.time.len()));
        Self {
            comparison,
            title: names.join(" and "),
            warnings: comparison.warnings(),
            facts: columns.iter().map(samples).collect(),
            columns,
        }
    }

    /// The page itself.
    #[must_use]
    pub fn page(&self) -> Page<'_> {
        let (start_s, end_s) = self.comparison.span_s();
        let zero_s = zero_s(self.comparison);
        Page {
            warnings: &self.warnings,
            facts: &self.facts,
            sections: self.sections(),
            time: Some(TimeAxis {
                label: time_label(zero_s),
                span: [start_s - zero_s, end_s - zero_s],
                outages: Vec::new(),
                marks: Vec::new(),
            }),
            ..Page::titled(&self.title)
        }
    }

    fn sections(&self) -> Vec<Section> {
        let columns = &self.columns;
        let row = |quantity: usize, axis: usize, name: &str, unit: &'static str| {
            let mut row = Row::new(name, unit);
            for one in columns {
                let values = &one.quantities[quantity][axis];
                let line = if name == "Yaw" { Series::heading } else { Series::line };
                row = row.with(line(one.role, &one.time, values, None).named(&*one.name));
            }
            Row { reversed: quantity < 2 && axis == 2, ..row }
        };
        let rows = |quantity: usize, names: [&str; 3], unit: &'static str| {
            let rows: Vec<Row> =
                (0..3).map(|axis| row(quantity, axis, names[axis], unit)).collect();
            Figure::against_time(rows)
        };
        let over_time = self.over_time();
        let mut map = Row::new("North", "m");
        for one in columns {
            let [north, east, _] = &one.quantities[0];
            map = map.with(Series::track(one.role, &one.time, [north, east]).named(&*one.name));
        }
        let tables = self.comparison.differences.iter().fold(
            Section::new("differences", "Differences", "Later solution minus earlier solution."),
            |section, difference| section.with(self.table(difference)),
        );
        let tables = tables.with(Figure::against_time(over_time));
        let shaded =
            self.comparison.differences.iter().filter(|one| one.from == 0).filter_map(|one| {
                let [of, from] = [one.of, one.from].map(|index| self.comparison.name(index));
                let row = Row::new("North", "m").with(self.shaded(one)?);
                let caption = format!("{of}, coloured by its distance from {from}");
                Some(Figure::new(Abscissa::EastM, [row]).captioned(caption))
            });
        vec![
            tables,
            Section::new(
                "map",
                "Map",
                "Top view of all solutions, in metres from the first point of the first solution.",
            )
            .with(Figure::new(Abscissa::EastM, [map])),
            shaded.fold(
                Section::new(
                    "distance",
                    "Distance on the map",
                    "Top view of each later solution. The colour is its horizontal distance from the first one, m.",
                ),
                Section::with,
            ),
            Section::new(
                "position",
                "Position",
                "Metres from the first point of the first solution.",
            )
            .with(rows(0, NED, "m")),
            Section::new(
                "velocity",
                "Velocity",
                "Velocity over ground, for the files that contain it.",
            )
            .with(rows(1, NED, "m/s")),
            Section::new("attitude", "Attitude", "Roll, pitch and yaw.").with(rows(
                2,
                ["Roll", "Pitch", "Yaw"],
                "°",
            )),
        ]
    }

    /// The differences from the first solution over time: each axis, and the motion over a second.
    fn over_time(&self) -> Vec<Row> {
        let zero_s = zero_s(self.comparison);
        let line = |row: Row, difference: &Difference, points: Vec<(Time, f64)>| {
            let time: Vec<f64> = points.iter().map(|(time, _)| time.seconds() - zero_s).collect();
            let values: Vec<f64> = points.into_iter().map(|(_, value)| value).collect();
            let name = self.comparison.name(difference.of);
            let role = ROLES[difference.of % ROLES.len()];
            row.with(Series::line(role, &time, &values, None).named(name))
        };
        let from_first = || self.comparison.differences.iter().filter(|one| one.from == 0);
        let mut rows = Vec::new();
        for (index, axis) in DRAWN.into_iter().enumerate() {
            let (name, unit) = named(axis);
            // The axes of position come first and have the short names of the other figures.
            let name = NED.get(index).copied().unwrap_or(name);
            let row = from_first().fold(Row::new(name, unit), |row, difference| {
                let Some(axis) = difference.score.axis(axis) else { return row };
                let points = axis.series.iter().map(|point| (point.time, point.error));
                line(row, difference, points.collect())
            });
            rows.push(row);
        }
        type OfPoint = fn(&RelativePoint) -> f64;
        let parts: [(&str, &str, OfPoint); 2] = [
            ("Motion over 1 s", "m", |point| point.translation_m),
            ("Turn over 1 s", "°", |point| point.rotation_deg),
        ];
        for (name, unit, value) in parts {
            let row = from_first().fold(Row::new(name, unit), |row, difference| {
                let Some(relative) = &difference.relative else { return row };
                let points = relative.series.iter().map(|point| (point.time, value(point)));
                let known: Vec<_> = points.filter(|(_, value)| value.is_finite()).collect();
                if known.is_empty() { row } else { line(row, difference, known) }
            });
            rows.push(row);
        }
        rows.retain(|row| !row.series.is_empty());
        rows
    }

    /// The track of the later solution, coloured by its horizontal distance from the first one, m.
    fn shaded(&self, difference: &Difference) -> Option<Series> {
        let points = &difference.score.axis(ScoreAxis::Horizontal)?.series;
        let zero_s = zero_s(self.comparison);
        let own = self.columns.get(difference.of)?;
        let [north, east, _] = &own.quantities[0];
        let (mut time, mut at, mut distance_m) = (Vec::new(), [Vec::new(), Vec::new()], Vec::new());
        for point in points {
            let time_s = point.time.seconds() - zero_s;
            let index = own.time.partition_point(|own_s| *own_s < time_s);
            if let (Some(north), Some(east)) = (north.get(index), east.get(index)) {
                time.push(time_s);
                at[0].push(*north);
                at[1].push(*east);
                distance_m.push(point.error);
            }
        }
        let [north, east] = &at;
        let track = Series::shaded_track(Role::Estimate, &time, [north, east], &distance_m, "m");
        Some(track.named(&*own.name))
    }

    fn table(&self, Difference { of, from, score, relative }: &Difference) -> Table {
        let rows = score.axes.iter().map(|axis| (axis.axis.name().to_owned(), axis.statistics));
        let relative = relative.iter().flat_map(|relative| {
            let name = |unit| format!("motion over {:.0} s, {unit}", relative.over_s);
            relative.sizes().map(move |(unit, size)| (name(unit), size))
        });
        let rows = rows.chain(relative).map(|(name, size)| {
            let numbers = [size.rmse, size.median, size.p95, size.max].map(digits);
            TableRow::new(name, numbers.into())
        });
        let (of, from) = (self.comparison.name(*of), self.comparison.name(*from));
        Table {
            caption: format!("{of} less {from}"),
            heads: ["", "RMS", "Median", "95 %", "Max"].map(Into::into).into(),
            rows: rows.collect(),
        }
    }
}

/// One solution as columns: time, s from the start, and values in m, m/s and degrees.
struct Columns {
    name: String,
    role: Role,
    time: Vec<f64>,
    quantities: [[Vec<f64>; 3]; 3],
}

/// The zero of the time axis, s: that of the clock or, if the clock values are large, the first whole second.
fn zero_s(comparison: &Comparison) -> f64 {
    first_second(comparison.span_s().0)
}

fn columns(solutions: &[NamedTrajectory], zero_s: f64) -> Vec<Columns> {
    let all = || solutions.iter().flat_map(|one| &one.trajectory.solutions);
    let origin = all().map(|one| one.position).find(|place| place.latitude_rad.is_finite());
    let origin = origin.unwrap_or(NOWHERE);
    let local = LocalEarth::at(&origin);
    let of = |(one, role): (&NamedTrajectory, Role)| {
        let mut quantities: [[Vec<f64>; 3]; 3] = Default::default();
        for solution in &one.trajectory.solutions {
            let rows = [
                local.displacement(&origin, &solution.position).to_array(),
                solution.velocity_mps.to_array(),
                solution.body_to_ned.euler().to_degrees(),
            ];
            for (columns, row) in quantities.iter_mut().zip(rows) {
                for (column, value) in columns.iter_mut().zip(row) {
                    column.push(value);
                }
            }
        }
        let times = one.trajectory.solutions.iter();
        let time = times.map(|solution| solution.time.seconds() - zero_s).collect();
        Columns { name: one.name.clone(), role, time, quantities }
    };
    solutions.iter().zip(ROLES).map(of).collect()
}
