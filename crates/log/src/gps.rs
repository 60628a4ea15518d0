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

/// Largest plausible velocity, m/s.
pub(crate) const FASTEST_MPS: f64 = 1000.0;
/// Larger sigmas mean that the receiver does not know its accuracy: m, m/s.
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
    let (mut last_height_m, mut types) = (None, TypesSeen::default());
    while let Some(row) = table.next(&mut remarks)? {
        let fix_type = row.finite(columns.fix_type)?.map(|[fix_type]| fix_type);
        match columns.fix(&row, fix_type, last_height_m, &mut remarks)? {
            Ok(fix) => {
                last_height_m = Some(fix.position.height_m);
                types.see(fix_type);
                let time = fix.time.offset_by(-latency_s);
                rows.push(row.line, (Fix { time, ..fix }, fix_type == Some(TWO_DIMENSIONAL)));
            }
            Err(why) => remarks.count(why, row.line),
        }
    }
    let (rows, _) = rows.in_time_order(|(fix, _)| fix.time, table.path(), &mut remarks)?;
    let held = rows.iter().filter(|(_, flat)| *flat && types.are_dimensions()).count();
    if held > 0 {
        remarks.say(format!(
            "fixes of type 2, {held} of them: two-dimensional, used for the horizontal alone"
        ));
    }
    // Fixes before the first height get that height.
    let first_m =
        rows.iter().find(|(fix, _)| !fix.two_dimensional).map(|(fix, _)| fix.position.height_m);
    if first_m.is_none() && !rows.is_empty() {
        remarks.say("no fix has a height: 0 m is assumed, and the height is unknown".into());
    }
    let mut until_height = true;
    let fixes: Vec<Fix> = rows
        .into_iter()
        .map(|(mut fix, flat)| {
            until_height &= fix.two_dimensional;
            if let Some(height_m) = first_m.filter(|_| until_height) {
                fix.position.height_m = height_m;
            }
            fix.two_dimensional |= flat && types.are_dimensions();
            fix
        })
        .collect();
    if fixes.is_empty() {
        remarks.say("found no usable fix".into());
    }
    warnings.extend(remarks.into_warnings());
    Ok(fixes)
}

/// Type of a fix without its own height, in a log whose types are dimensions.
const TWO_DIMENSIONAL: f64 = 2.0;

/// Types of fixes in a log, whose meaning differs between receivers.
#[derive(Clone, Copy, Debug, Default)]
struct TypesSeen {
    three: bool,
    one: bool,
}

impl TypesSeen {
    fn see(&mut self, fix_type: Option<f64>) {
        self.three |= fix_type == Some(3.0);
        self.one |= fix_type == Some(1.0);
    }

    /// Whether types 2 and 3 are dimensions: some fixes are of type 3, and none of type 1.
    const fn are_dimensions(self) -> bool {
        self.three && !self.one
    }
}

/// Columns of the quantities in the table.
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

    /// The fix in `row` at its time of arrival, or the reason to leave it out.
    fn fix(
        &self,
        row: &Row<'_>,
        fix_type: Option<f64>,
        last_height_m: Option<f64>,
        remarks: &mut Remarks,
    ) -> Result<Result<Fix, &'static str>, LogError> {
        let arrival = row.time(self.time)?;
        let [lat, lon, height] = row.numbers(self.position)?;
        let horizontal_mps = row.finite(self.horizontal_velocity)?;
        let down_mps = row.finite(self.down_velocity)?.map(|[down]| down);
        let position_sigma_m = sigma(row, self.position_sigma)?;
        let velocity_sigma_mps = sigma(row, self.velocity_sigma)?;
        let satellites = row.finite(self.satellites)?;

        let Some(arrival) = arrival else { return Ok(Err("left out: no time")) };
        // The meaning of other types differs between receivers.
        if fix_type == Some(0.0) || [lat, lon] == [0.0; 2] {
            return Ok(Err("left out: no fix"));
        }
        let two_dimensional = height.is_nan();
        let height_m = if two_dimensional { last_height_m.unwrap_or(0.0) } else { height };
        if [lat, lon, height_m].iter().any(|value| value.is_nan()) {
            return Ok(Err("left out: a coordinate is missing"));
        }
        let Some(position) = Geodetic::from_degrees(lat, lon, height_m) else {
            return Ok(Err(no_place([lat, lon])));
        };
        if two_dimensional {
            remarks.count("without a height: used for the horizontal alone", row.line);
        }
        let satellites = satellites.filter(|[count]| (0.0..=255.0).contains(count));
        let fix = Fix {
            time: arrival,
            position,
            two_dimensional,
            position_sigma_m,
            horizontal_velocity_mps: horizontal_mps,
            down_velocity_mps: down_mps,
            velocity_sigma_mps,
            satellites: satellites.map(|[count]| count as u8),
        };
        Ok(Ok(plausible_fix(fix, row.line, remarks)))
    }
}

/// Reason why a latitude and a longitude, °, and a height are not a position on Earth.
#[must_use]
pub fn no_place([lat, lon]: [f64; 2]) -> &'static str {
    let latitude = |degrees: f64| degrees.abs() <= 90.0;
    match (latitude(lat), latitude(lon)) {
        (false, true) => {
            "left out: not a position on Earth, the latitude is beyond 90° (latitude and longitude swapped?)"
        }
        (false, false) => {
            "left out: not a position on Earth, the latitude is beyond 90° (expected degrees, not 1e-7 degrees)"
        }
        _ if lon.abs() > 360.0 => {
            "left out: not a position on Earth, the longitude is beyond 360° (expected degrees)"
        }
        _ => "left out: not a position on Earth, the height is too large (expected metres)",
    }
}

/// `fix` without an implausible velocity and without invalid sigmas; each is counted in `remarks` against `line`.
#[must_use]
pub fn plausible_fix(mut fix: Fix, line: u64, remarks: &mut Remarks) -> Fix {
    let is_motion = |speed: f64| speed.abs() <= FASTEST_MPS;
    let is_velocity = fix.horizontal_velocity_mps.is_none_or(|v| v.into_iter().all(is_motion))
        && fix.down_velocity_mps.is_none_or(is_motion);
    if !is_velocity {
        remarks.count("with a velocity beyond any vehicle's: velocity ignored", line);
        (fix.horizontal_velocity_mps, fix.down_velocity_mps) = (None, None);
    }
    let mut known = |sigma: Option<Vector<Ned>>, largest: f64| {
        let is_one =
            |sigma: &Vector<Ned>| sigma.to_array().iter().all(|s| *s > 0.0 && *s <= largest);
        if sigma.is_some_and(|sigma| !is_one(&sigma)) {
            remarks.count("with an invalid sigma: sigma ignored", line);
        }
        sigma.filter(is_one)
    };
    fix.position_sigma_m = known(fix.position_sigma_m, LARGEST_POSITION_SIGMA_M);
    fix.velocity_sigma_mps = known(fix.velocity_sigma_mps, LARGEST_VELOCITY_SIGMA_MPS);
    fix
}

/// The sigma in the first of `columns` that the table has.
fn sigma(row: &Row<'_>, columns: [Option<[usize; 3]>; 2]) -> Result<Option<Vector<Ned>>, LogError> {
    let [per_axis, grouped] = [row.finite(columns[0])?, row.finite(columns[1])?];
    Ok(per_axis.or(grouped).map(Vector::from))
}
