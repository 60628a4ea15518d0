//! Tables `range.csv`, `heading.csv` and `rotor.csv`: readings of the rangefinder, the second antenna and the rotor
//! speed sensor.

use std::path::Path;

use crate::clock::steps::ClockSteps;
use crate::error::LogError;
use crate::sensors::auxiliary::{Columns, OUT_OF_RANGE, read_timed};
use crate::table::{TIME, Table};
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
    let rows = read(dir, RANGE_FILE, columns, steps, warnings, |range_m, [sigma_m, quality]| {
        let sound = (0.0..=FURTHEST).contains(&range_m)
            && sigma_m.is_none_or(|sigma_m| sigma_m > 0.0)
            && quality.is_none_or(|quality| (0.0..=1.0).contains(&quality));
        sound.then_some(RangeReading { time: Time::ZERO, range_m, sigma_m, quality })
    })?;
    Ok(rows.into_iter().map(|(time, reading)| RangeReading { time, ..reading }).collect())
}

pub(crate) fn read_headings(
    dir: &Path,
    steps: &mut ClockSteps,
    warnings: &mut Vec<String>,
) -> Result<Vec<AntennaHeading>, LogError> {
    let columns = ["heading_deg", "sigma_deg", "length_m"];
    let rows =
        read(dir, HEADING_FILE, columns, steps, warnings, |heading_deg, [sigma_deg, length_m]| {
            let sound = heading_deg.abs() <= 720.0
                && sigma_deg.is_none_or(|sigma_deg| sigma_deg > 0.0)
                && length_m.is_none_or(|length_m| length_m > 0.0 && length_m <= FURTHEST);
            let sigma_rad = sigma_deg.map(f64::to_radians);
            let heading = AntennaHeading::new(Time::ZERO, heading_deg.to_radians(), sigma_rad);
            sound.then_some(AntennaHeading { length_m, ..heading })
        })?;
    Ok(rows.into_iter().map(|(time, heading)| AntennaHeading { time, ..heading }).collect())
}

pub(crate) fn read_rotor(
    dir: &Path,
    steps: &mut ClockSteps,
    warnings: &mut Vec<String>,
) -> Result<Vec<(Time, f64)>, LogError> {
    read(dir, ROTOR_FILE, ["rotor_hz"], steps, warnings, |rotor_hz, []| {
        (0.0..=FASTEST_HZ).contains(&rotor_hz).then_some(rotor_hz)
    })
}

/// Reads the rows of `file`, in time order. `value` makes a value from the first column and the other columns. The
/// times of the values are shifted afterwards if the clock of the log steps. Rows without a time or a first column
/// are skipped. The other columns may be absent or have empty fields.
fn read<T: std::fmt::Debug, const N: usize, const M: usize>(
    dir: &Path,
    file: &'static str,
    names: [&str; N],
    steps: &mut ClockSteps,
    warnings: &mut Vec<String>,
    value: impl Fn(f64, [Option<f64>; M]) -> Option<T>,
) -> Result<Vec<(Time, T)>, LogError> {
    let Some(mut table) = Table::open(dir, file)? else { return Ok(Vec::new()) };
    table.require([TIME])?;
    let needed = table.require([names[0]])?;
    let optional = std::array::from_fn(|k| table.find([names[k + 1]]));
    let columns = Columns { needed, optional, without_use: &[] };
    read_timed(table, file, columns, steps, warnings, |[first], others| {
        value(first, others).ok_or(OUT_OF_RANGE)
    })
}
