//! Columns without names, by what they hold.

use super::look::Look;
use super::names::{Meaning, Quantity};

/// What the columns of `look` hold, as far as their values tell.
///
/// Time is the first column that rises. Three columns side by side whose norm is gravity's are an
/// accelerometer, the three beside them that are left a gyro; latitude, longitude and height follow
/// each other where there is no accelerometer.
pub(crate) fn meanings(look: &Look) -> Vec<Option<Meaning>> {
    let count = look.columns.len();
    let mut meanings = vec![None; count];
    let mut give = |column: usize, quantity: Quantity| {
        meanings[column] = Some(Meaning { quantity, unit: None, estimated: false });
    };
    let Some(time) = (0..count).find(|&column| look.rises(column)) else { return meanings };
    give(time, Quantity::Time);
    let first = time + 1;
    // Of those with gravity's norm, the three whose norm varies least.
    let variation = |at: usize| {
        let (norm, high) =
            (look.median_norm([at, at + 1, at + 2]), look.high_norm([at, at + 1, at + 2]));
        let is_gravity =
            [1.0, 9.81, 1000.0].iter().any(|gravity| (0.85..1.15).contains(&(norm / gravity)));
        is_gravity.then_some((at, high / norm))
    };
    let accel = (first..count.saturating_sub(2)).filter_map(variation);
    if let Some((accel, _)) = accel.min_by(|a, b| a.1.total_cmp(&b.1)) {
        (0..3).for_each(|axis| give(accel + axis, Quantity::Accel(axis)));
        let before = accel.checked_sub(3).filter(|gyro| *gyro >= first);
        let gyro = before.or_else(|| (accel + 6 <= count).then_some(accel + 3));
        if let Some(gyro) = gyro {
            (0..3).for_each(|axis| give(gyro + axis, Quantity::Gyro(axis)));
        }
    } else if first + 3 <= count && is_place(look, first) {
        give(first, Quantity::Latitude);
        give(first + 1, Quantity::Longitude);
        give(first + 2, Quantity::Height(None));
        if first + 6 <= count {
            (0..3).for_each(|axis| give(first + 3 + axis, Quantity::Velocity(axis)));
        }
    }
    meanings
}

/// Whether two columns can be a latitude and a longitude that hardly change.
fn is_place(look: &Look, at: usize) -> bool {
    let spread = |column: usize| {
        let (least, most) = look
            .known(column)
            .fold((f64::MAX, f64::MIN), |(least, most), value| (least.min(value), most.max(value)));
        most - least
    };
    look.largest(at) <= 90.0
        && look.largest(at + 1) <= 360.0
        && look.largest(at) > 0.0
        && spread(at) < 1.0
        && spread(at + 1) < 1.0
}
