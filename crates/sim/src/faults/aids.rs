//! Faults of the rangefinder and of the second antenna.

use super::catalogue::Kind;
use super::fault::Fault;
use super::table::Table;
use super::window::Window;
use crate::noise::Noise;

/// Makes `fault` in `table`, which is `range.csv`; false where it is of another sensor.
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

/// Makes `fault` in `table`, which is `heading.csv`; false where it is of another sensor.
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
