//! `gps.csv`: the fixes.

use std::path::Path;

use crate::clock::Rows;
use crate::error::LogError;
use crate::remarks::Remarks;
use crate::table::{Row, Table};
use hovernav::earth::Geodetic;
use hovernav::frames::{Ned, Vector};
use hovernav::gps::Fix;

pub(crate) const FILE: &str = "gps.csv";
pub(crate) const POSITION: [&str; 3] = ["lat_deg", "lon_deg", "height_m"];
pub(crate) const VELOCITY: [&str; 3] = ["vn_mps", "ve_mps", "vd_mps"];
pub(crate) const POSITION_SIGMA: [&str; 3] = ["sigma_n_m", "sigma_e_m", "sigma_d_m"];
pub(crate) const VELOCITY_SIGMA: [&str; 3] = ["sigma_vn_mps", "sigma_ve_mps", "sigma_vd_mps"];
pub(crate) const SATELLITES: &str = "satellites";

/// Nothing that flies by this filter is faster, m/s.
const FASTEST_MPS: f64 = 1000.0;
/// Larger sigmas are a receiver's way of saying it does not know: m, m/s.
const LARGEST_POSITION_SIGMA_M: f64 = 1e4;
const LARGEST_VELOCITY_SIGMA_MPS: f64 = 1e3;

pub(crate) fn read(
    dir: &Path,
    latency_s: f64,
    warnings: &mut Vec<String>,
) -> Result<Vec<Fix>, LogError> {
    let Some(mut table) = Table::open(dir, FILE)? else {
        warnings.push(format!("{FILE}: no such file, so no GPS"));
        return Ok(Vec::new());
    };
    let mut remarks = Remarks::new(FILE);
    let columns = Columns::of(&mut table)?;
    table.remark_unused(&["hdop"], &mut remarks);
    let mut rows = Rows::new();
    while let Some(row) = table.next(&mut remarks)? {
        match columns.fix(&row, &mut remarks)? {
            Ok(fix) => rows.push(row.line, Fix { time: fix.time.offset_by(-latency_s), ..fix }),
            Err(why) => remarks.count(why, row.line),
        }
    }
    let (fixes, _) = rows.in_time_order(|fix| fix.time, table.path(), &mut remarks)?;
    if fixes.is_empty() {
        remarks.say("holds no usable fix".into());
    }
    warnings.extend(remarks.into_warnings());
    Ok(fixes)
}

/// Where in the table each quantity stands.
struct Columns {
    time: usize,
    position: [usize; 3],
    horizontal_velocity: Option<[usize; 2]>,
    down_velocity: Option<[usize; 1]>,
    /// Per axis, and as horizontal and vertical.
    position_sigma: [Option<[usize; 3]>; 2],
    velocity_sigma: [Option<[usize; 3]>; 2],
    fix_type: Option<[usize; 1]>,
    satellites: Option<[usize; 1]>,
}

impl Columns {
    fn of(table: &mut Table) -> Result<Self, LogError> {
        let [time, lat, lon, height] =
            table.require(["t_s", POSITION[0], POSITION[1], POSITION[2]])?;
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

    /// The fix in `row` at its time of arrival, or why it is left out.
    fn fix(
        &self,
        row: &Row<'_>,
        remarks: &mut Remarks,
    ) -> Result<Result<Fix, &'static str>, LogError> {
        let arrival = row.time(self.time)?;
        let place @ [lat, lon, height] = row.numbers(self.position)?;
        let horizontal_mps = row.finite(self.horizontal_velocity)?;
        let down_mps = row.finite(self.down_velocity)?.map(|[down]| down);
        let position_sigma_m = sigma(row, self.position_sigma)?;
        let velocity_sigma_mps = sigma(row, self.velocity_sigma)?;
        let fix_type = row.finite(self.fix_type)?;
        let satellites = row.finite(self.satellites)?;

        let Some(arrival) = arrival else { return Ok(Err("left out: no time")) };
        // What else the type says differs from receiver to receiver.
        if fix_type == Some([0.0]) || [lat, lon] == [0.0; 2] {
            return Ok(Err("left out: no fix"));
        }
        if place.iter().any(|value| value.is_nan()) {
            return Ok(Err("left out: a coordinate is missing"));
        }
        let Some(position) = Geodetic::from_degrees(lat, lon, height) else {
            return Ok(Err("left out: no place on Earth"));
        };
        let satellites = satellites.filter(|[count]| (0.0..=255.0).contains(count));
        let fix = Fix {
            time: arrival,
            position,
            position_sigma_m,
            horizontal_velocity_mps: horizontal_mps,
            down_velocity_mps: down_mps,
            velocity_sigma_mps,
            satellites: satellites.map(|[count]| count as u8),
        };
        Ok(Ok(plausible_fix(fix, row.line, remarks)))
    }
}

/// `fix` without a velocity beyond any vehicle's and without a sigma that is none, each of which counts
/// in `remarks` against `line`.
#[must_use]
pub fn plausible_fix(mut fix: Fix, line: u64, remarks: &mut Remarks) -> Fix {
    let is_motion = |speed: f64| speed.abs() <= FASTEST_MPS;
    let is_velocity = fix.horizontal_velocity_mps.is_none_or(|v| v.into_iter().all(is_motion))
        && fix.down_velocity_mps.is_none_or(is_motion);
    if !is_velocity {
        remarks.count("with a velocity beyond any vehicle's: taken as unknown", line);
        (fix.horizontal_velocity_mps, fix.down_velocity_mps) = (None, None);
    }
    let mut known = |sigma: Option<Vector<Ned>>, largest: f64| {
        let is_one =
            |sigma: &Vector<Ned>| sigma.to_array().iter().all(|s| *s > 0.0 && *s <= largest);
        if sigma.is_some_and(|sigma| !is_one(&sigma)) {
            remarks.count("with a sigma that is none: taken as unknown", line);
        }
        sigma.filter(is_one)
    };
    fix.position_sigma_m = known(fix.position_sigma_m, LARGEST_POSITION_SIGMA_M);
    fix.velocity_sigma_mps = known(fix.velocity_sigma_mps, LARGEST_VELOCITY_SIGMA_MPS);
    fix
}

/// The sigma in whichever of `columns` has one.
fn sigma(row: &Row<'_>, columns: [Option<[usize; 3]>; 2]) -> Result<Option<Vector<Ned>>, LogError> {
    let [per_axis, grouped] = [row.finite(columns[0])?, row.finite(columns[1])?];
    Ok(per_axis.or(grouped).map(Vector::from))
}
