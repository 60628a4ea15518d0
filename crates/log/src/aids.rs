//! Tables `range.csv`, `heading.csv` and `rotor.csv`: readings of the rangefinder, the second antenna and the rotor
//! speed sensor.

use std::path::Path;

use crate::clock::Rows;
use crate::clock_steps::ClockSteps;
use crate::dataset::Dataset;
use crate::error::LogError;
use crate::remarks::Remarks;
use crate::table::Table;
use crate::write::write_table;
use hovernav::event::RangeReading;
use hovernav::gps::AntennaHeading;
use hovernav::time::Time;

pub(crate) const RANGE_FILE: &str = "range.csv";
pub(crate) const HEADING_FILE: &str = "heading.csv";
pub(crate) const ROTOR_FILE: &str = "rotor.csv";

/// Largest valid distance to the ground and baseline length, m.
const FURTHEST: f64 = 1e4;
/// Largest valid rotor speed, Hz.
const FASTEST_HZ: f64 = 5000.0;

pub(crate) fn read_ranges(
    dir: &Path,
    steps: &mut ClockSteps,
    warnings: &mut Vec<String>,
) -> Result<Vec<RangeReading>, LogError> {
    let columns = ["range_m", "sigma_m", "quality"];
    read(dir, RANGE_FILE, columns, steps, warnings, |time, range_m, [sigma_m, quality]| {
        let sound = (0.0..=FURTHEST).contains(&range_m)
            && sigma_m.is_none_or(|sigma_m| sigma_m > 0.0)
            && quality.is_none_or(|quality| (0.0..=1.0).contains(&quality));
        sound.then_some(RangeReading { time, range_m, sigma_m, quality })
    })
}

pub(crate) fn read_headings(
    dir: &Path,
    steps: &mut ClockSteps,
    warnings: &mut Vec<String>,
) -> Result<Vec<AntennaHeading>, LogError> {
    let columns = ["heading_deg", "sigma_deg", "length_m"];
    read(dir, HEADING_FILE, columns, steps, warnings, |time, heading_deg, [sigma_deg, length_m]| {
        let sound = heading_deg.abs() <= 720.0
            && sigma_deg.is_none_or(|sigma_deg| sigma_deg > 0.0)
            && length_m.is_none_or(|length_m| length_m > 0.0 && length_m <= FURTHEST);
        let sigma_rad = sigma_deg.map(f64::to_radians);
        let heading = AntennaHeading::new(time, heading_deg.to_radians(), sigma_rad);
        sound.then_some(AntennaHeading { length_m, ..heading })
    })
}

pub(crate) fn read_rotor(
    dir: &Path,
    steps: &mut ClockSteps,
    warnings: &mut Vec<String>,
) -> Result<Vec<(Time, f64)>, LogError> {
    read(dir, ROTOR_FILE, ["rotor_hz"], steps, warnings, |time, rotor_hz, []| {
        (0.0..=FASTEST_HZ).contains(&rotor_hz).then_some((time, rotor_hz))
    })
}

/// Reads the rows of `file`, in time order. `value` makes a value from the time, the first column and the other
/// columns. Rows without a time or a first column are skipped. The other columns may be absent or have empty fields.
fn read<T: Timed, const N: usize, const M: usize>(
    dir: &Path,
    file: &'static str,
    names: [&str; N],
    steps: &mut ClockSteps,
    warnings: &mut Vec<String>,
    value: impl Fn(Time, f64, [Option<f64>; M]) -> Option<T>,
) -> Result<Vec<T>, LogError> {
    let Some(mut table) = Table::open(dir, file)? else { return Ok(Vec::new()) };
    let mut remarks = Remarks::new(file);
    let [time] = table.require(["t_s"])?;
    let first = table.require([names[0]])?;
    let optional: [Option<[usize; 1]>; M] = std::array::from_fn(|k| table.find([names[k + 1]]));
    table.remark_unused(&[], &mut remarks);
    let mut rows = Rows::new();
    while let Some(row) = table.next(&mut remarks)? {
        let Some((time, [first])) = row.time(time)?.zip(row.finite(Some(first))?) else {
            remarks.count("skipped: a value is missing", row.line);
            continue;
        };
        let mut others = [None; M];
        for (other, column) in others.iter_mut().zip(optional) {
            *other = row.finite(column)?.map(|[value]| value);
        }
        match value(time, first, others) {
            Some(value) => rows.push(row.line, value),
            None => remarks.count("rejected: a value is out of range", row.line),
        }
    }
    let (rows, _) = rows.in_time_order(Timed::time, table.path(), steps, &mut remarks)?;
    warnings.extend(remarks.into_warnings());
    Ok(rows)
}

trait Timed {
    fn time(&mut self) -> &mut Time;
}

impl Timed for RangeReading {
    fn time(&mut self) -> &mut Time {
        &mut self.time
    }
}

impl Timed for AntennaHeading {
    fn time(&mut self) -> &mut Time {
        &mut self.time
    }
}

impl Timed for (Time, f64) {
    fn time(&mut self) -> &mut Time {
        &mut self.0
    }
}

impl Dataset {
    pub(crate) fn write_aids(&self, dir: &Path) -> Result<(), LogError> {
        let columns = ["t_s", "range_m", "sigma_m", "quality"];
        write_table(dir, RANGE_FILE, &columns, &self.ranges, |csv, reading| {
            csv.time(reading.time);
            csv.shortest_or_empty(Some([reading.range_m]))?;
            csv.shortest_or_empty(reading.sigma_m.map(|sigma_m| [sigma_m]))?;
            csv.shortest_or_empty(reading.quality.map(|quality| [quality]))
        })?;
        let columns = ["t_s", "heading_deg", "sigma_deg", "length_m"];
        write_table(dir, HEADING_FILE, &columns, &self.headings, |csv, heading| {
            csv.time(heading.time);
            csv.shortest_or_empty(Some([heading.heading_rad.to_degrees()]))?;
            csv.shortest_or_empty(heading.sigma_rad.map(|sigma_rad| [sigma_rad.to_degrees()]))?;
            csv.shortest_or_empty(heading.length_m.map(|length_m| [length_m]))
        })?;
        write_table(dir, ROTOR_FILE, &["t_s", "rotor_hz"], &self.rotor, |csv, (time, rotor_hz)| {
            csv.time(*time);
            csv.shortest_or_empty(Some([*rotor_hz]))
        })
    }
}
