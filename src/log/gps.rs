//! `gps.csv`: the fixes.

use std::path::Path;

use super::clock::Rows;
use super::error::LogError;
use super::remarks::Remarks;
use super::table::Table;
use crate::earth::Geodetic;
use crate::frames::{Ned, Vector};
use crate::gps::Fix;

pub(super) const FILE: &str = "gps.csv";
pub(super) const POSITION: [&str; 3] = ["lat_deg", "lon_deg", "height_m"];
pub(super) const VELOCITY: [&str; 3] = ["vn_mps", "ve_mps", "vd_mps"];
pub(super) const POSITION_SIGMA: [&str; 3] = ["sigma_n_m", "sigma_e_m", "sigma_d_m"];
pub(super) const VELOCITY_SIGMA: [&str; 3] = ["sigma_vn_mps", "sigma_ve_mps", "sigma_vd_mps"];
pub(super) const SATELLITES: &str = "satellites";

/// Nothing that flies by this filter is faster, m/s.
const FASTEST_MPS: f64 = 1000.0;
/// Larger sigmas are a receiver's way of saying it does not know: m, m/s.
const LARGEST_POSITION_SIGMA_M: f64 = 1e4;
const LARGEST_VELOCITY_SIGMA_MPS: f64 = 1e3;

pub(super) fn read(
    dir: &Path,
    latency_s: f64,
    warnings: &mut Vec<String>,
) -> Result<Vec<Fix>, LogError> {
    let Some(mut table) = Table::open(dir, FILE)? else {
        warnings.push(format!("{FILE}: no such file, so no GPS"));
        return Ok(Vec::new());
    };
    let mut remarks = Remarks::new(FILE);
    let [time, lat, lon, height] = table.require(["t_s", POSITION[0], POSITION[1], POSITION[2]])?;
    let horizontal_velocity = table.find([VELOCITY[0], VELOCITY[1]]);
    let down_velocity = table.find([VELOCITY[2]]);
    let position_sigma = [
        table.find(POSITION_SIGMA),
        horizontal_and_vertical(&mut table, ["sigma_h_m", "sigma_v_m"]),
    ];
    let velocity_sigma = [
        table.find(VELOCITY_SIGMA),
        horizontal_and_vertical(&mut table, ["sigma_vh_mps", "sigma_vv_mps"]),
    ];
    let fix_type = table.find(["fix_type"]);
    let satellites = table.find([SATELLITES]);
    table.remark_unused(&["hdop"], &mut remarks);

    let mut rows = Rows::new();
    while let Some(row) = table.next(&mut remarks)? {
        let arrival = row.time(time)?;
        let place @ [lat, lon, height] = row.numbers([lat, lon, height])?;
        let mut sigma = |forms: [Option<[usize; 3]>; 2], largest: f64| {
            let [per_axis, grouped] = [row.finite(forms[0])?, row.finite(forms[1])?];
            let found = per_axis.or(grouped);
            let usable = found.filter(|sigma| sigma.iter().all(|s| *s > 0.0 && *s <= largest));
            if found.is_some() && usable.is_none() {
                remarks.count("with a sigma that is none: taken as unknown", row.line);
            }
            Ok::<_, LogError>(usable.map(Vector::<Ned>::from))
        };
        let position_sigma_m = sigma(position_sigma, LARGEST_POSITION_SIGMA_M)?;
        let velocity_sigma_mps = sigma(velocity_sigma, LARGEST_VELOCITY_SIGMA_MPS)?;
        let horizontal = row.finite(horizontal_velocity)?;
        let down = row.finite(down_velocity)?.map(|[down]| down);
        let fix_type = row.finite(fix_type)?;
        let satellites = row.finite(satellites)?;

        let Some(arrival) = arrival else {
            remarks.count("left out: no time", row.line);
            continue;
        };
        if fix_type == Some([0.0]) || [lat, lon] == [0.0; 2] {
            remarks.count("left out: no fix", row.line);
            continue;
        }
        if place.iter().any(|value| value.is_nan()) {
            remarks.count("left out: a coordinate is missing", row.line);
            continue;
        }
        let Some(position) = Geodetic::from_degrees(lat, lon, height) else {
            remarks.count("left out: no place on Earth", row.line);
            continue;
        };
        let is_motion = |v: f64| v.abs() <= FASTEST_MPS;
        let is_velocity =
            horizontal.is_none_or(|v| v.into_iter().all(is_motion)) && down.is_none_or(is_motion);
        if !is_velocity {
            remarks.count("with a velocity beyond any vehicle's: taken as unknown", row.line);
        }
        rows.push(
            row.line,
            Fix {
                time: arrival.offset_by(-latency_s),
                position,
                position_sigma_m,
                horizontal_velocity_mps: horizontal.filter(|_| is_velocity),
                down_velocity_mps: down.filter(|_| is_velocity),
                velocity_sigma_mps,
                satellites: satellites
                    .map(|[count]| count)
                    .filter(|count| (0.0..=255.0).contains(count))
                    .map(|count| count as u8),
            },
        );
    }
    let (fixes, _) = rows.in_time_order(|fix| fix.time, table.path(), &mut remarks)?;
    if fixes.is_empty() {
        remarks.say("holds no usable fix".into());
    }
    warnings.extend(remarks.into_warnings());
    Ok(fixes)
}

fn horizontal_and_vertical(table: &mut Table, names: [&str; 2]) -> Option<[usize; 3]> {
    table.find(names).map(|[horizontal, vertical]| [horizontal, horizontal, vertical])
}
