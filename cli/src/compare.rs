//! `hovernav compare`: differences between solutions.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::ensure;
use hovernav::earth::{Geodetic, Local};
use hovernav_formats::open_trajectory;
use hovernav_log::{LocalAxes, LogError, Reference, Score, Trajectory, score};
use serde_json::{Value, json};

use crate::arguments::AxesArgument;
use crate::memory;
use crate::output::{self, Working};
use crate::page::{
    Abscissa, Fact, Figure, Page, Role, Row, Section, Series, Table, TableRow, TimeAxis, digits,
};

#[derive(clap::Args)]
pub struct Arguments {
    /// Solution files, output directories of estimate, or directories that init made for other files; the others are
    /// compared with the first
    #[arg(required = true, num_args = 2..=4)]
    solution: Vec<PathBuf>,
    /// Directory to write
    #[arg(long, value_name = "DIR", default_value = "out/compare")]
    out: PathBuf,
    /// Align the others with the first: rotate about the vertical and translate, by least squares
    #[arg(long)]
    align: bool,
    /// Axes of trajectories in local metres: enu with a forward-left-up body, ned with a forward-right-down body
    #[arg(long, value_enum, default_value_t = AxesArgument::Enu)]
    axes: AxesArgument,
}

/// Origin of local coordinates where no solution has a geographic position. Any origin gives the same differences.
const NOWHERE: Geodetic = Geodetic { latitude_rad: 0.0, longitude_rad: 0.0, height_m: 0.0 };
const NED: [&str; 3] = ["North", "East", "Down"];
const ROLES: [Role; 4] = [Role::First, Role::Second, Role::Third, Role::Fourth];

/// A solution and its name.
struct Named {
    name: String,
    trajectory: Trajectory,
}

/// The difference between a later solution and an earlier one.
struct Difference<'a> {
    of: &'a Named,
    from: &'a Named,
    score: Score,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let started = Instant::now();
    let working = Working::on("comparing");
    let solutions = solutions(arguments)?;
    let mut differences = Vec::new();
    for (index, from) in solutions.iter().enumerate() {
        let reference = Reference::of_trajectory(&from.trajectory);
        for of in &solutions[index + 1..] {
            let moments = &of.trajectory.solutions;
            let Some(first) = moments.first() else { continue };
            let score = score(moments, &reference, first.time);
            ensure!(
                !score.axes.is_empty(),
                "{}: found no time in common with {}, expected solutions that overlap in time. Do they use the same clock?",
                of.name,
                from.name
            );
            differences.push(Difference { of, from, score });
        }
    }
    output::create(&arguments.out)?;
    write_page(&arguments.out.join(output::REPORT), &solutions, &differences)?;
    let mut summary = summary(arguments, &solutions, &differences);
    summary["wall_s"] = started.elapsed().as_secs_f64().into();
    output::write_json(&summary, &arguments.out.join("summary.json"))?;
    drop(working);
    for Difference { of, from, score } in &differences {
        output::say(format_args!("{} less {}", of.name, from.name));
        for axis in &score.axes {
            let (name, size) = (axis.axis.name(), &axis.statistics);
            output::say(format_args!("  {name:<30} {:>9.3} rms {:>9.3} max", size.rmse, size.max));
        }
    }
    output::say(format_args!("{:<32} {}", "written", arguments.out.display()));
    Ok(())
}

fn solutions(arguments: &Arguments) -> anyhow::Result<Vec<Named>> {
    let axes: LocalAxes = arguments.axes.into();
    let opened: Result<Vec<Trajectory>, LogError> =
        arguments.solution.iter().map(|path| open_trajectory(path, axes)).collect();
    let opened = opened.map_err(memory::in_terms_of_features)?;
    let all_are_placed = opened.iter().all(Trajectory::is_placed);
    let mut solutions: Vec<Named> = Vec::new();
    let mut first_is_local = None;
    for (path, mut trajectory) in arguments.solution.iter().zip(opened) {
        if all_are_placed {
            trajectory.place_as_named();
        }
        let is_local = trajectory.is_local();
        ensure!(
            arguments.align || is_local == *first_is_local.get_or_insert(is_local),
            "{}: found {}, unlike the first solution: expected --align",
            path.display(),
            if is_local { "local metres without an origin" } else { "geographic positions" }
        );
        match solutions.first() {
            Some(first) if arguments.align => {
                let reference = Reference::of_trajectory(&first.trajectory);
                ensure!(
                    trajectory.align(&reference).is_some(),
                    "{}: found no time in common with {}, expected solutions that overlap in time. Do they use the same clock?",
                    path.display(),
                    first.name
                );
            }
            _ => trajectory.place(&NOWHERE),
        }
        let short = called(path);
        let is_taken = solutions.iter().any(|one| one.name == short);
        let name = if is_taken { path.display().to_string() } else { short };
        solutions.push(Named { name, trajectory });
    }
    Ok(solutions)
}

/// The name of a solution: its file name, or the directory name if the file is called `solution`.
fn called(path: &Path) -> String {
    let name = output::name_of(path);
    let directory = path.canonicalize().ok().and_then(|full| full.parent().map(output::name_of));
    directory.filter(|_| name == "solution").unwrap_or(name)
}

fn summary(arguments: &Arguments, solutions: &[Named], differences: &[Difference<'_>]) -> Value {
    let input: Vec<String> =
        arguments.solution.iter().map(|one| one.display().to_string()).collect();
    let differences = differences.iter().map(|Difference { of, from, score }| {
        let sizes = score.axes.iter().map(|axis| (axis.axis.name().into(), json!(axis.statistics)));
        let sizes: serde_json::Map<String, Value> = sizes.collect();
        json!({"solution": of.name, "less": from.name, "difference": sizes})
    });
    let (start_s, end_s) = span(solutions);
    json!({
        "tool": "hovernav",
        "version": env!("CARGO_PKG_VERSION"),
        "input": input.join(" "),
        "duration_s": end_s - start_s,
        "imu_samples": 0,
        "gps_fixes_used": 0,
        "gps_fixes_rejected": 0,
        "aligned": arguments.align,
        "differences": differences.collect::<Vec<_>>(),
        "warnings": warnings(solutions),
    })
}

fn warnings(solutions: &[Named]) -> Vec<String> {
    solutions.iter().flat_map(|one| one.trajectory.warnings.clone()).collect()
}

/// First and last time of all solutions, s.
fn span(solutions: &[Named]) -> (f64, f64) {
    let times = solutions.iter().flat_map(|one| &one.trajectory.solutions);
    let times = times.map(|solution| solution.time.seconds());
    times.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), t| (low.min(t), high.max(t)))
}

/// One solution as columns: s from the start, m, m/s and degrees.
struct Columns {
    name: String,
    role: Role,
    time: Vec<f64>,
    quantities: [[Vec<f64>; 3]; 3],
}

fn columns(solutions: &[Named], start_s: f64) -> Vec<Columns> {
    let all = || solutions.iter().flat_map(|one| &one.trajectory.solutions);
    let origin = all().map(|one| one.position).find(|place| place.latitude_rad.is_finite());
    let origin = origin.unwrap_or(NOWHERE);
    let local = Local::at(&origin);
    let of = |(one, role): (&Named, Role)| {
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

fn write_page(
    path: &Path,
    solutions: &[Named],
    differences: &[Difference<'_>],
) -> anyhow::Result<()> {
    let (start_s, end_s) = span(solutions);
    let columns = columns(solutions, start_s);
    let row = |quantity: usize, axis: usize, name: &str, unit: &'static str| {
        let mut row = Row::new(name, unit);
        for one in &columns {
            let values = &one.quantities[quantity][axis];
            let line = if name == "Yaw" { Series::heading } else { Series::line };
            row = row.with(line(one.role, &one.time, values, None).named(&*one.name));
        }
        Row { reversed: quantity < 2 && axis == 2, ..row }
    };
    let rows = |quantity: usize, names: [&str; 3], unit: &'static str| {
        let rows: Vec<Row> = (0..3).map(|axis| row(quantity, axis, names[axis], unit)).collect();
        Figure::against_time(rows)
    };
    let mut map = Row::new("North", "m");
    for one in &columns {
        let [north, east, _] = &one.quantities[0];
        map = map.with(Series::track(one.role, &one.time, [north, east]).named(&*one.name));
    }
    let tables = differences.iter().fold(
        Section::new("differences", "Differences", "Later solution minus earlier solution."),
        |section, difference| section.with(table(difference)),
    );
    let facts: Vec<Fact> = columns
        .iter()
        .map(|one| Fact::new(&one.name, format!("{} samples", one.time.len())))
        .collect();
    let title: Vec<&str> = solutions.iter().map(|one| &*one.name).collect();
    let page = Page {
        title: &title.join(" and "),
        headlines: &[],
        verdict: None,
        warnings: &warnings(solutions),
        facts: &facts,
        table: None,
        sections: vec![
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
        ],
        time: Some(TimeAxis {
            label: format!("Time after {start_s:.3} s, s"),
            span: [0.0, end_s - start_s],
            outages: Vec::new(),
            marks: Vec::new(),
        }),
    };
    page.write(path)
}

fn table(Difference { of, from, score }: &Difference<'_>) -> Table {
    let rows = score.axes.iter().map(|axis| {
        let size = &axis.statistics;
        let numbers = [size.rmse, size.median, size.p95, size.max].map(digits);
        TableRow::new(axis.axis.name(), numbers.into())
    });
    Table {
        caption: format!("{} less {}", of.name, from.name),
        heads: ["", "RMS", "Median", "95 %", "Max"].map(Into::into).into(),
        rows: rows.collect(),
    }
}
