//! `controls.csv`: stick positions and injected test inputs.

use std::path::{Path, PathBuf};

use crate::clock::Order;
use crate::clock::ordered::{self, Gathered, TimedRows};
use crate::clock::steps::ClockSteps;
use crate::error::LogError;
use crate::table::remarks::Remarks;
use crate::table::{TIME, Table};
use hovernav::controls::Sticks;
use hovernav::time::Time;

pub(crate) const FILE: &str = "controls.csv";
/// Columns of the stick positions about trim, -1 to 1.
pub const STICKS: [&str; 4] = Sticks::NAMES;
/// Columns of the injected test inputs.
pub(crate) const INJECTED: [&str; 4] =
    ["injected_lateral", "injected_longitudinal", "injected_collective", "injected_pedal"];

/// Largest stroke from trim, in fractions of full travel: it may exceed 1 if trim is off centre.
const LONGEST_STROKE: f64 = 2.0;
/// Largest valid value in any unit, such as the pulse length of a servo in nanoseconds.
const LARGEST: f64 = 1e7;

/// Rows of a `controls.csv` that has been read once to its end; each pass reads them again.
#[derive(Clone, Debug)]
pub struct ControlFile {
    dir: PathBuf,
    order: Order,
    steps: ClockSteps,
    count: usize,
    /// Largest valid value.
    largest: f64,
}

/// Content of `controls.csv`.
#[derive(Default)]
pub(crate) struct Controls {
    pub sticks: Vec<(Time, [f64; 4])>,
    /// Injected test inputs, one for each of `sticks`, or empty.
    pub injected: Vec<[f64; 4]>,
    /// File that replaces `sticks` and `injected` if they have too many rows.
    pub file: Option<ControlFile>,
}

/// Reads `controls.csv` of `dir`; its rows stay in memory if there are no more than `most`.
///
/// A few rows beyond full travel are rejected as damaged. If there are more, they have another unit, and all rows are
/// read.
pub(crate) fn read(
    dir: &Path,
    most: usize,
    steps: &mut ClockSteps,
    warnings: &mut Vec<String>,
) -> Result<Controls, LogError> {
    let Some(first) = ControlRows::open(dir, LONGEST_STROKE)? else {
        return Ok(Controls::default());
    };
    let has_injected = first.injected.is_some();
    drop(first);
    let read_up_to =
        |largest, steps: &mut ClockSteps| read_up_to(dir, has_injected, largest, most, steps);
    let (controls, rows, count) = read_up_to(LONGEST_STROKE, &mut steps.clone())?;
    let (beyond, furthest, all) = (rows.beyond, rows.furthest, count + rows.beyond);
    if beyond <= 10 || 100 * beyond <= all {
        warnings.extend(rows.remarks.into_warnings());
        return Ok(controls);
    }
    let (controls, rows, _) = read_up_to(LARGEST, steps)?;
    warnings.extend(rows.remarks.into_warnings());
    warnings.push(format!(
        "{FILE}: sticks up to {furthest:.0} in {beyond} of {all} rows, expected fractions of full travel, −1 to 1. An \
         identified derivative is per unit of the file, and an autopilot needs it per full travel"
    ));
    Ok(controls)
}

/// Reads `controls.csv` in `dir` without the rows that contain a value beyond `largest`. Returns the rows, the reader
/// at the end of the file, and the number of rows.
fn read_up_to(
    dir: &Path,
    has_injected: bool,
    largest: f64,
    most: usize,
    steps: &mut ClockSteps,
) -> Result<(Controls, ControlRows, usize), LogError> {
    let Gathered { made: (mut controls, count), order, rows } = ordered::gather(
        || again(dir, largest),
        |_| (Controls::default(), 0_usize),
        |(controls, count), _, Row { time, sticks, injected }| {
            *count += 1;
            if *count <= most {
                controls.sticks.push((time, sticks));
                controls.injected.extend(has_injected.then_some(injected));
            } else if *count == most.saturating_add(1) {
                *controls = Controls::default();
            }
        },
        steps,
    )?;
    if count > most {
        let steps = steps.clone();
        controls.file = Some(ControlFile { dir: dir.into(), order, steps, count, largest });
    }
    Ok((controls, rows, count))
}

impl ControlFile {
    /// Reads all rows into memory.
    pub(crate) fn whole(&self) -> Result<Controls, LogError> {
        read(&self.dir, usize::MAX, &mut self.steps.clone(), &mut Vec::new())
    }

    /// Passes every row to `each`: its time, and the sticks as in [`Dataset::controls`](crate::Dataset::controls).
    pub(crate) fn each(&self, mut each: impl FnMut(Time, [f64; 4])) -> Result<(), LogError> {
        let mut given = 0;
        let rows = again(&self.dir, self.largest)?;
        ordered::go_over(rows, &self.order, |_, Row { time, sticks, .. }| {
            given += 1;
            // Rows that a logger has appended since are ignored.
            if given <= self.count {
                each(time, sticks);
            }
        })?;
        if given < self.count { Err(changed(&self.dir)) } else { Ok(()) }
    }
}

fn changed(dir: &Path) -> LogError {
    LogError::changed(dir.join(FILE))
}

/// Opens `controls.csv` again; an error if it no longer exists.
fn again(dir: &Path, largest: f64) -> Result<ControlRows, LogError> {
    ControlRows::open(dir, largest)?.ok_or_else(|| changed(dir))
}

/// A row of the file.
#[derive(Debug)]
struct Row {
    time: Time,
    sticks: [f64; 4],
    /// Injected test inputs; zero if the file has no such columns.
    injected: [f64; 4],
}

/// Reader of the rows of `controls.csv`.
struct ControlRows {
    table: Table,
    time: usize,
    sticks: [usize; 4],
    injected: Option<[usize; 4]>,
    remarks: Remarks,
    /// Largest valid value.
    largest: f64,
    /// Number of rows with a value beyond `largest`.
    beyond: usize,
    /// Largest absolute value of all rows.
    furthest: f64,
}

impl ControlRows {
    /// Opens `controls.csv` of `dir`; `None` without such a file.
    fn open(dir: &Path, largest: f64) -> Result<Option<Self>, LogError> {
        let Some(mut table) = Table::open(dir, FILE)? else { return Ok(None) };
        let (sticks, injected) = (table.require(STICKS)?, table.find(INJECTED));
        let [time] = table.require([TIME])?;
        let mut remarks = Remarks::new(FILE);
        table.remark_unused(&["temp_degc"], &mut remarks);
        Ok(Some(Self { table, time, sticks, injected, remarks, largest, beyond: 0, furthest: 0.0 }))
    }
}

impl TimedRows for ControlRows {
    type Row = Row;

    fn next(&mut self) -> Result<Option<(u64, Row)>, LogError> {
        while let Some(row) = self.table.next(&mut self.remarks)? {
            let time = row.time(self.time)?;
            let sticks = row.finite(Some(self.sticks))?;
            let injected = match self.injected {
                Some(columns) => row.finite(Some(columns))?,
                None => Some([0.0; 4]),
            };
            let (Some(time), Some(sticks), Some(injected)) = (time, sticks, injected) else {
                self.remarks.count("skipped: a value is missing", row.line);
                continue;
            };
            let all = sticks.iter().chain(&injected);
            let furthest = all.fold(0.0, |furthest: f64, stick| furthest.max(stick.abs()));
            self.furthest = self.furthest.max(furthest);
            if furthest > self.largest {
                self.beyond += 1;
                self.remarks.count("rejected: a value is out of range", row.line);
                continue;
            }
            return Ok(Some((row.line, Row { time, sticks, injected })));
        }
        Ok(None)
    }

    fn time(row: &mut Row) -> &mut Time {
        &mut row.time
    }

    fn path(&self) -> &Path {
        self.table.path()
    }

    fn remarks(&mut self) -> &mut Remarks {
        &mut self.remarks
    }
}
