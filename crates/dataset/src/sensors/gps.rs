//! `gps.csv`: the fixes.

use std::path::Path;

use crate::clock::steps::ClockSteps;
use crate::error::LogError;
use crate::sensors::fix_gate::{Dimensions, FixGate, StatedFix};
use crate::table::remarks::Remarks;
use crate::table::{Row, TIME, Table};
use hovernav::gps::Fix;

pub(crate) const FILE: &str = "gps.csv";
pub(crate) const POSITION: [&str; 3] = ["lat_deg", "lon_deg", "height_m"];
pub(crate) const VELOCITY: [&str; 3] = ["vn_mps", "ve_mps", "vd_mps"];
pub(crate) const POSITION_SIGMA: [&str; 3] = ["sigma_n_m", "sigma_e_m", "sigma_d_m"];
pub(crate) const VELOCITY_SIGMA: [&str; 3] = ["sigma_vn_mps", "sigma_ve_mps", "sigma_vd_mps"];
pub(crate) const SATELLITES: &str = "satellites";

pub(crate) fn read(
    dir: &Path,
    latency_s: f64,
    steps: &mut ClockSteps,
    warnings: &mut Vec<String>,
) -> Result<Vec<Fix>, LogError> {
    let Some(mut table) = Table::open(dir, FILE)? else {
        warnings.push(format!("{FILE}: no such file, so no GPS"));
        return Ok(Vec::new());
    };
    let mut remarks = Remarks::new(FILE);
    let columns = Columns::of(&mut table)?;
    table.remark_unused(&["hdop"], &mut remarks);
    let mut gate = FixGate::default();
    while let Some(row) = table.next(&mut remarks)? {
        gate.push(row.line, columns.fix(&row, latency_s)?, &mut remarks);
    }
    let fixes = gate.finish(table.path(), steps, &mut remarks)?;
    if fixes.is_empty() {
        remarks.say("found no usable fix".into());
    }
    warnings.extend(remarks.into_warnings());
    Ok(fixes)
}

/// Columns of the quantities in the table.
struct Columns {
    time: usize,
    position: [usize; 3],
    horizontal_velocity: Option<[usize; 2]>,
    down_velocity: Option<[usize; 1]>,
    /// Columns of the one-sigma of position: by axis, and as horizontal and vertical.
    position_sigma: [Option<[usize; 3]>; 2],
    velocity_sigma: [Option<[usize; 3]>; 2],
    fix_type: Option<[usize; 1]>,
    satellites: Option<[usize; 1]>,
}

impl Columns {
    fn of(table: &mut Table) -> Result<Self, LogError> {
        let [time, lat, lon, height] =
            table.require([TIME, POSITION[0], POSITION[1], POSITION[2]])?;
        let mut sigma = |per_axis: [&str; 3], grouped: [&str; 2]| {
            let grouped = table.find(grouped).map(|[h, v]| [h, h, v]);
            [table.find(per_axis), grouped]
        };
        Ok(Self {
            time,
            position: [lat, lon, height],
            position_sigma: sigma(POSITION_SIGMA, ["sigma_h_m", "sigma_v_m"]),
            velocity_sigma: sigma(VELOCITY_SIGMA, ["sigma_vh_mps", "sigma_vv_mps"]),
            horizontal_velocity: table.find([VELOCITY[0], VELOCITY[1]]),
            down_velocity: table.find([VELOCITY[2]]),
            fix_type: table.find(["fix_type"]),
            satellites: table.find([SATELLITES]),
        })
    }

    /// The fix in `row`. The row has the time of arrival, `latency_s` after the time of validity.
    fn fix(&self, row: &Row<'_>, latency_s: f64) -> Result<StatedFix, LogError> {
        let arrival = row.time(self.time)?;
        let fix_type = row.finite(self.fix_type)?;
        let horizontal_mps = row.finite(self.horizontal_velocity)?.unwrap_or([f64::NAN; 2]);
        let down_mps = row.finite(self.down_velocity)?.map_or(f64::NAN, |[down]| down);
        let time = arrival.map(|arrival| arrival.offset_by(-latency_s));
        Ok(StatedFix {
            dimensions: fix_type.map_or(Dimensions::Three, |[number]| Dimensions::Type(number)),
            position_sigma_m: sigma(row, self.position_sigma)?,
            velocity_mps: [horizontal_mps[0], horizontal_mps[1], down_mps],
            velocity_sigma_mps: sigma(row, self.velocity_sigma)?,
            satellites: row.finite(self.satellites)?.map_or(f64::NAN, |[count]| count),
            ..StatedFix::at(time, row.numbers(self.position)?)
        })
    }
}

/// One-sigmas from the first of `columns` that has finite values in this row; NaN if neither has.
fn sigma(row: &Row<'_>, columns: [Option<[usize; 3]>; 2]) -> Result<[f64; 3], LogError> {
    let [per_axis, grouped] = [row.finite(columns[0])?, row.finite(columns[1])?];
    Ok(per_axis.or(grouped).unwrap_or([f64::NAN; 3]))
}
