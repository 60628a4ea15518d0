//! Rows of a trajectory, and the check whether their motion is possible for a vehicle.

use crate::error::LogError;
use crate::sensors::fix_gate::no_place;
use crate::solution::COLUMNS;
use crate::table::remarks::Remarks;
use crate::table::{Row, TIME, Table};
use hovernav::earth::Geodetic;
use hovernav::time::Time;

/// Remark on a row whose velocity is too large.
pub(crate) const TOO_FAST: &str = "with a velocity beyond any vehicle's: velocity ignored";

/// The columns of the first `N` quantities of `solution.csv` in a table, each of which may be absent.
pub(crate) struct MotionColumns<const N: usize> {
    time: usize,
    columns: [Option<usize>; N],
}

impl<const N: usize> MotionColumns<N> {
    /// Finds the columns.
    ///
    /// # Errors
    /// The table has no times.
    pub fn find(table: &mut Table) -> Result<Self, LogError> {
        let [time] = table.require([TIME])?;
        let find = |index: usize| table.find([COLUMNS[1 + index]]).map(|[column]| column);
        Ok(Self { time, columns: std::array::from_fn(find) })
    }

    /// Whether the table has any of the quantities that describe a motion.
    pub fn any_motion(&self) -> bool {
        self.columns.iter().take(9).any(Option::is_some)
    }

    /// Time and quantities of `row`, NaN for unknown ones; `None` for a row to be skipped, counted in `remarks`.
    pub fn read(
        &self,
        row: &Row<'_>,
        fastest_mps: f64,
        remarks: &mut Remarks,
    ) -> Result<Option<(Time, [f64; N])>, LogError> {
        let Some(time) = row.time(self.time)? else {
            remarks.count("skipped: no time", row.line);
            return Ok(None);
        };
        let mut values = [f64::NAN; N];
        for (value, column) in values.iter_mut().zip(self.columns) {
            if let Some(column) = column {
                *value = row.number(column)?;
            }
        }
        Ok(match ensure_motion(&mut values, fastest_mps, row.line, remarks) {
            Ok(()) => Some((time, values)),
            Err(why) => {
                remarks.count(why, row.line);
                None
            }
        })
    }
}

/// Replaces impossible values among the twelve quantities of a row by NaN, and counts the row in `remarks` at `line`.
/// The quantities are in the order of [`COLUMNS`] after the time.
///
/// # Errors
/// Reason to reject the row: its position is not on Earth.
fn ensure_motion(
    values: &mut [f64],
    fastest_mps: f64,
    line: u64,
    remarks: &mut Remarks,
) -> Result<(), &'static str> {
    let [lat, lon, height, vn, ve, vd, roll, pitch, yaw, u, v, w, ..] = values else {
        return Ok(());
    };
    // An unknown coordinate passes this check.
    let known = |value: f64| if value.is_nan() { 0.0 } else { value };
    if Geodetic::from_degrees(known(*lat), known(*lon), known(*height)).is_none() {
        return Err(no_place([known(*lat), known(*lon), known(*height)]));
    }
    let mut within = |quantity: [&mut f64; 3], most: f64, what| {
        if quantity.iter().any(|value| value.abs() > most) {
            remarks.count(what, line);
            quantity.into_iter().for_each(|value| *value = f64::NAN);
        }
    };
    within([vn, ve, vd], fastest_mps, TOO_FAST);
    within([u, v, w], fastest_mps, TOO_FAST);
    within([roll, pitch, yaw], 360.0, "with an angle beyond 360°: attitude ignored");
    Ok(())
}
