//! Faults of the inertial unit's own attitude, the rangefinder and the second antenna.

use super::catalogue::Kind;
use super::fault::Fault;
use super::table::Table;
use super::window::Window;
use crate::noise::Noise;

/// Applies `fault` to `table`, which is `range.csv`; false where it is a fault of another sensor.
pub(super) fn make_range(
    table: &mut Table,
    fault: &Fault,
    window: Window,
    noise: &mut Noise,
) -> bool {
    let Some(range) = table.column("range_m") else { return false };
    let rows = table.rows_in(window);
    match fault.kind {
        Kind::RangeStuck => {
            if let Some(last) = rows.first().map(|&row| table.get(row, range)) {
                rows.into_iter().for_each(|row| table.change(row, range, |_| last));
            }
        }
        Kind::RangeOutliers => {
            for row in rows {
                let (hit, size) = (100.0 * noise.uniform() < fault.number, noise.uniform());
                if hit {
                    table.change(row, range, |range_m| 2.0 * size * range_m);
                }
            }
        }
        Kind::RangeStep => {
            for row in rows {
                table.change(row, range, |range_m| (range_m + fault.number).max(0.0));
            }
        }
        Kind::RangeGone => rows.into_iter().for_each(|row| table.drop_row(row)),
        _ => return false,
    }
    true
}

/// Applies `fault` to `table`, which is `imu.csv`; false where it is a fault of another sensor, or the attitude is
/// missing.
pub(super) fn make_attitude(table: &mut Table, fault: &Fault, window: Window) -> bool {
    let (Some(time), Some(attitude)) =
        (table.column("t_s"), table.columns(["roll_deg", "pitch_deg", "yaw_deg"]))
    else {
        return false;
    };
    let rows = table.rows_in(window);
    let told: Vec<(f64, [f64; 3])> =
        rows.iter().map(|&row| (table.get(row, time), table.triple(row, attitude))).collect();
    let Some(&(_, first)) = told.first() else { return false };
    let told_at = |time_s: f64| {
        let later = told.partition_point(|&(told_s, _)| told_s <= time_s);
        later.checked_sub(1).map_or(first, |last| told[last].1)
    };
    for (row, &(time_s, _)) in rows.into_iter().zip(&told) {
        let angles = match fault.kind {
            Kind::AttitudeFrozen => first,
            Kind::AttitudeLate => told_at(time_s - fault.number),
            _ => return false,
        };
        for (column, angle_deg) in attitude.into_iter().zip(angles) {
            table.change(row, column, |_| angle_deg);
        }
    }
    true
}

/// Applies `fault` to `table`, which is `heading.csv`; false where it is a fault of another sensor.
pub(super) fn make_heading(table: &mut Table, fault: &Fault, window: Window) -> bool {
    let Some(heading) = table.column("heading_deg") else { return false };
    let rows = table.rows_in(window);
    match fault.kind {
        Kind::HeadingTurn => {
            for row in rows {
                table.change(row, heading, |heading_deg| (heading_deg + fault.number) % 360.0);
            }
        }
        Kind::HeadingGone => rows.into_iter().for_each(|row| table.drop_row(row)),
        _ => return false,
    }
    true
}
