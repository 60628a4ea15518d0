//! Magnetic disturbances of the magnetometer and of the inertial unit's own yaw.

use hovernav::frames::wrap_angle;
use hovernav::glam::{DQuat, DVec3};

use super::catalogue::Kind;
use super::fault::Fault;
use super::table::Table;
use super::window::Window;
use crate::noise::Noise;

pub(super) const FIELD: [&str; 3] = ["mag_x_gauss", "mag_y_gauss", "mag_z_gauss"];

/// Applies `fault` to `table`, which is `imu.csv` or `mag.csv`. Returns `false` for a fault that is not magnetic, and
/// for a table without a magnetic field. For `MagHeading` a yaw without a field is sufficient.
///
/// The tilt is the roll and pitch in the same row. Without them the body is assumed level, an error of a degree or two
/// in hover.
pub(super) fn make(table: &mut Table, fault: &Fault, window: Window, noise: &mut Noise) -> bool {
    let added = DVec3::from_array(noise.direction()) * fault.number;
    let turn_rad = fault.number.to_radians();
    let turns = match fault.kind {
        Kind::MagHeading | Kind::MagHeadingOnly => true,
        Kind::MagVector | Kind::MagVectorOnly => false,
        _ => return false,
    };
    let field = table.columns(FIELD);
    let tilt = table.columns(["roll_deg", "pitch_deg"]);
    let yaw = table
        .column("yaw_deg")
        .filter(|_| matches!(fault.kind, Kind::MagHeading | Kind::MagVector));
    if field.is_none() && (yaw.is_none() || !turns) {
        return false;
    }
    for row in table.rows_in(window) {
        let tilt_rad = tilt.map_or([0.0; 2], |tilt| tilt.map(|c| table.get(row, c).to_radians()));
        let before = field.map(|columns| DVec3::from_array(table.triple(row, columns)));
        let after = before.map(|field| match turns {
            // Turning the field in one direction turns the measured heading in the other.
            true => DQuat::from_axis_angle(down(tilt_rad), -turn_rad) * field,
            false => field + added,
        });
        if let (Some(columns), Some(after)) = (field, after) {
            for (column, component) in columns.into_iter().zip(after.to_array()) {
                table.change(row, column, |_| component);
            }
        }
        let turned_rad = match (turns, before, after) {
            (true, ..) => turn_rad,
            (false, Some(before), Some(after)) => {
                heading_rad(after, tilt_rad) - heading_rad(before, tilt_rad)
            }
            _ => 0.0,
        };
        if let Some(yaw) = yaw {
            table.change(row, yaw, |yaw| wrap_angle(yaw.to_radians() + turned_rad).to_degrees());
        }
    }
    true
}

/// The down axis in body axes.
fn down([roll, pitch]: [f64; 2]) -> DVec3 {
    if !(roll.is_finite() && pitch.is_finite()) {
        return DVec3::Z;
    }
    DVec3::new(-pitch.sin(), roll.sin() * pitch.cos(), roll.cos() * pitch.cos())
}

/// Magnetic heading of a measured field.
fn heading_rad(field: DVec3, tilt_rad: [f64; 2]) -> f64 {
    let down = down(tilt_rad);
    let right = down.cross(DVec3::X).normalize_or_zero();
    let forward = right.cross(down);
    (-field.dot(right)).atan2(field.dot(forward))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn a_turned_field_shows_a_heading_off_by_as_much() {
        for tilt in [[0.0, 0.0], [0.2, -0.3]] {
            let field = DVec3::new(0.2, -0.1, 0.4);
            let turned = DQuat::from_axis_angle(down(tilt), -0.5) * field;
            let off = wrap_angle(heading_rad(turned, tilt) - heading_rad(field, tilt));
            assert_abs_diff_eq!(off, 0.5, epsilon = 1e-12);
        }
    }
}
