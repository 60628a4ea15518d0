//! The page of a comparison: the differences, and all solutions in one figure each.

use hovernav::earth::{Geodetic, Local};
use hovernav_formats::{Comparison, Difference, NamedTrajectory};

use crate::{
    Abscissa, Fact, Figure, Page, Role, Row, Section, Series, Table, TableRow, TimeAxis, digits,
};

/// Origin of the figures without a geographic position.
const NOWHERE: Geodetic = Geodetic { latitude_rad: 0.0, longitude_rad: 0.0, height_m: 0.0 };
const NED: [&str; 3] = ["North", "East", "Down"];
const ROLES: [Role; 4] = [Role::First, Role::Second, Role::Third, Role::Fourth];

/// Largest number of solutions on a page; further ones are not drawn.
pub const MOST_SOLUTIONS: usize = ROLES.len();

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
        let (start_s, _) = comparison.span_s();
        let columns = columns(&comparison.trajectories, start_s);
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
        Page {
            warnings: &self.warnings,
            facts: &self.facts,
            sections: self.sections(),
            time: Some(TimeAxis {
                label: format!("Time after {start_s:.3} s, s"),
                span: [0.0, end_s - start_s],
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
        let mut map = Row::new("North", "m");
        for one in columns {
            let [north, east, _] = &one.quantities[0];
            map = map.with(Series::track(one.role, &one.time, [north, east]).named(&*one.name));
        }
        let tables = self.comparison.differences.iter().fold(
            Section::new("differences", "Differences", "Later solution minus earlier solution."),
            |section, difference| section.with(self.table(difference)),
        );
        vec![
            tables,
            Section::new(
                "map",
                "Map",
                "Top view of all solutions, in metres from the first point of the first solution.",
            )
            .with(Figure::new(Abscissa::EastM, [map])),
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

    fn table(&self, Difference { of, from, score }: &Difference) -> Table {
        let rows = score.axes.iter().map(|axis| {
            let size = &axis.statistics;
            let numbers = [size.rmse, size.median, size.p95, size.max].map(digits);
            TableRow::new(axis.axis.name(), numbers.into())
        });
        let (of, from) = (self.comparison.name(*of), self.comparison.name(*from));
        Table {
            caption: format!("{of} less {from}"),
            heads: ["", "RMS", "Median", "95 %", "Max"].map(Into::into).into(),
            rows: rows.collect(),
        }
    }
}

/// One solution as columns: s from the start, m, m/s and degrees.
struct Columns {
    name: String,
    role: Role,
    time: Vec<f64>,
    quantities: [[Vec<f64>; 3]; 3],
}

fn columns(solutions: &[NamedTrajectory], start_s: f64) -> Vec<Columns> {
    let all = || solutions.iter().flat_map(|one| &one.trajectory.solutions);
    let origin = all().map(|one| one.position).find(|place| place.latitude_rad.is_finite());
    let origin = origin.unwrap_or(NOWHERE);
    let local = Local::at(&origin);
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
        let time = times.map(|solution| solution.time.seconds() - start_s).collect();
        Columns { name: one.name.clone(), role, time, quantities }
    };
    solutions.iter().zip(ROLES).map(of).collect()
}
