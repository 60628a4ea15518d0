//! Tables `baro.csv` and `mag.csv`: readings of the barometer and the magnetometer.

use std::path::Path;

use crate::clock::Rows;
use crate::clock::steps::ClockSteps;
use crate::error::LogError;
use crate::sensors::imu::{MAGNETIC, field_fault};
use crate::table::remarks::Remarks;
use crate::table::{TIME, Table};
use hovernav::earth::STANDARD_GRAVITY_MPS2;
use hovernav::frames::{Body, Vector};
use hovernav::time::Time;

pub(crate) const BARO_FILE: &str = "baro.csv";
pub(crate) const MAG_FILE: &str = "mag.csv";
/// Barometric height above any fixed level, m.
pub const ALTITUDE: &str = "altitude_m";

/// Altitude in the International Standard Atmosphere at `pressure_pa`, m above the 1013.25 hPa level; `None` above the
/// troposphere (22 632 Pa, 11 km) and below −2 km (127 774 Pa).
///
/// Not a height above the ellipsoid: it differs from one by weather and geoid. Both change slowly, so differences
/// within a flight are accurate.
///
/// # Source
/// ICAO Doc 7488/3, *Manual of the ICAO Standard Atmosphere*, table A (p0 = 101 325 Pa, T0 = 288.15 K,
/// β = −6.5 K/km, R = 287.052 87 J/(kg K), g0 = 9.806 65 m/s²) and the pressure equation of a layer of
/// constant gradient, solved for the geopotential altitude.
#[must_use]
pub fn pressure_altitude_m(pressure_pa: f64) -> Option<f64> {
    const SEA_LEVEL_PRESSURE_PA: f64 = 101_325.0;
    const SEA_LEVEL_TEMPERATURE_K: f64 = 288.15;
    const LAPSE_RATE_KPM: f64 = 0.0065;
    const EXPONENT: f64 = 287.052_87 * LAPSE_RATE_KPM / STANDARD_GRAVITY_MPS2;
    (22_632.0..=127_774.0).contains(&pressure_pa).then(|| {
        let ratio = libm::pow(pressure_pa / SEA_LEVEL_PRESSURE_PA, EXPONENT);
        SEA_LEVEL_TEMPERATURE_K / LAPSE_RATE_KPM * (1.0 - ratio)
    })
}

pub(crate) fn read_baro(
    dir: &Path,
    steps: &mut ClockSteps,
    warnings: &mut Vec<String>,
) -> Result<Vec<(Time, f64)>, LogError> {
    let Some(mut table) = Table::open(dir, BARO_FILE)? else { return Ok(Vec::new()) };
    let (column, is_pressure) = match (table.find([ALTITUDE]), table.find(["pressure_pa"])) {
        (Some(altitude), _) => (altitude, false),
        (None, Some(pressure)) => (pressure, true),
        (None, None) => return Err(table.columns_missing("altitude_m or pressure_pa")),
    };
    let columns = Columns { needed: column, optional: [], without_use: &["temp_degc"] };
    read_timed(table, BARO_FILE, columns, steps, warnings, |[value], []| match is_pressure {
        true => pressure_altitude_m(value).ok_or_else(|| pressure_fault(value)),
        false if value.abs() <= 1e5 => Ok(value),
        false if pressure_altitude_m(value).is_some() => Err(
            "rejected: a height of over 100 km; for a pressure in Pa name the column pressure_pa",
        ),
        false => Err(OUT_OF_RANGE),
    })
}

pub(crate) fn read_magnetometer(
    dir: &Path,
    steps: &mut ClockSteps,
    warnings: &mut Vec<String>,
) -> Result<Vec<(Time, Vector<Body>)>, LogError> {
    let Some(mut table) = Table::open(dir, MAG_FILE)? else { return Ok(Vec::new()) };
    let needed = table.require(MAGNETIC)?;
    let columns = Columns { needed, optional: [], without_use: &["temp_degc"] };
    read_timed(table, MAG_FILE, columns, steps, warnings, |field, []| {
        field_fault(field).map_or_else(|| Ok(field.into()), Err)
    })
}

pub(crate) const OUT_OF_RANGE: &str = "rejected: a value is out of range";

/// Reason to reject a pressure given in Pa, with its likely unit.
fn pressure_fault(pressure_pa: f64) -> &'static str {
    let is_pressure = |scale: f64| pressure_altitude_m(scale * pressure_pa).is_some();
    if is_pressure(100.0) {
        "rejected: a pressure of the air in hPa, expected Pa; multiply by 100; for a height name the column altitude_m"
    } else if is_pressure(1000.0) {
        "rejected: a pressure of the air in kPa, expected Pa; multiply by 1000; for a height name the column altitude_m"
    } else {
        OUT_OF_RANGE
    }
}

/// Columns of an aid's table.
pub(crate) struct Columns<const N: usize, const M: usize> {
    /// Columns without which a row is skipped.
    pub needed: [usize; N],
    /// Columns that may be absent or have empty fields.
    pub optional: [Option<[usize; 1]>; M],
    /// Names of columns that the reader does not use and that cause no warning.
    pub without_use: &'static [&'static str],
}

/// Reads the rows of `table`, in time order. `value` makes a value from the needed and the optional numbers of a row, or
/// states the reason to reject the row. Rejected rows are counted by reason.
pub(crate) fn read_timed<T: std::fmt::Debug, const N: usize, const M: usize>(
    mut table: Table,
    file: &'static str,
    columns: Columns<N, M>,
    steps: &mut ClockSteps,
    warnings: &mut Vec<String>,
    value: impl Fn([f64; N], [Option<f64>; M]) -> Result<T, &'static str>,
) -> Result<Vec<(Time, T)>, LogError> {
    let mut remarks = Remarks::new(file);
    let [time] = table.require([TIME])?;
    table.remark_unused(columns.without_use, &mut remarks);
    let mut rows = Rows::new();
    while let Some(row) = table.next(&mut remarks)? {
        let Some((time, numbers)) = row.time(time)?.zip(row.finite(Some(columns.needed))?) else {
            remarks.count("skipped: a value is missing", row.line);
            continue;
        };
        let mut others = [None; M];
        for (other, column) in others.iter_mut().zip(columns.optional) {
            *other = row.finite(column)?.map(|[value]| value);
        }
        match value(numbers, others) {
            Ok(value) => rows.push(row.line, (time, value)),
            Err(why) => remarks.count(why, row.line),
        }
    }
    let (rows, _) = rows.in_time_order(|row| &mut row.0, table.path(), steps, &mut remarks)?;
    warnings.extend(remarks.into_warnings());
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn a_pressure_in_another_unit_is_named() {
        assert!(pressure_fault(1013.25).contains("hPa, expected Pa"));
        assert!(pressure_fault(95.1).contains("kPa, expected Pa"));
        for pressure_pa in [-1013.25, 0.0, 5000.0, 1e6] {
            assert_eq!(pressure_fault(pressure_pa), OUT_OF_RANGE, "{pressure_pa} Pa");
        }
    }

    // ICAO Doc 7488/3, table 1.
    #[test]
    fn altitudes_are_those_of_the_standard_atmosphere() {
        for (pressure_pa, altitude_m) in [(101_325.0, 0.0), (89_874.6, 1000.0), (54_019.9, 5000.0)]
        {
            assert_abs_diff_eq!(
                pressure_altitude_m(pressure_pa).unwrap(),
                altitude_m,
                epsilon = 0.1
            );
        }
        assert_eq!(pressure_altitude_m(22_000.0), None);
    }
}
