//! Meanings of columns without names, from their values.

use super::look::Look;
use super::names::Meaning;
use super::quantity::Quantity;

/// The meanings of the columns of `look`, as far as their values determine them.
///
/// Time is the first column that rises. Three adjacent columns are an accelerometer if their norm is gravity, or
/// gravity times the time step. The three columns before them, otherwise those after them, are a gyro. This reads the
/// inertial files of KF-GINS (angle increments, then velocity increments) and of NaveGo (specific force, then rates).
/// Latitude, longitude and height are adjacent columns. In a file with an accelerometer, the first two of them must
/// change as slowly as a position does. In a file without, the three columns after the height are one-sigmas if all
/// values are positive, otherwise velocities.
pub(crate) fn meanings(look: &Look) -> Vec<Option<Meaning>> {
    let count = look.columns.len();
    let mut meanings = vec![None; count];
    if let Some(first) = kitti(look) {
        if first > 0 {
            meanings[0] = Some(Meaning { quantity: Quantity::Time, unit: None, estimated: false });
        }
        for (column, quantity, unit) in KITTI {
            // Attitude, position and velocity are those of the inertial unit's own filter.
            let estimated = matches!(quantity, Quantity::Attitude(_));
            meanings[first + column] = Some(Meaning { quantity, unit: Some(unit), estimated });
        }
        return meanings;
    }
    let mut give = |column: usize, quantity: Quantity| {
        meanings[column] = Some(Meaning { quantity, unit: None, estimated: false });
    };
    let rising = (0..count).find(|&column| look.rises(column));
    let Some(time) = rising.or_else(|| (count > 0 && look.climbs(0)).then_some(0)) else {
        return meanings;
    };
    give(time, Quantity::Time);
    let first = time + 1;
    let step = look.step(time);
    // Triples with the norm of gravity at a multiple of three columns after the time are preferred. Among these,
    // the one whose norm varies least is chosen.
    let variation = |at: usize| {
        let columns = [at, at + 1, at + 2];
        let (norm, high) = (look.median_norm(columns), look.high_norm(columns));
        let near = |gravity: &f64| (0.85..1.15).contains(&(norm / gravity));
        let is_increment = norm < 0.5 && near(&(9.81 * step));
        let is_gravity = is_increment || [1.0, 9.81, 1000.0].iter().any(near);
        is_gravity.then_some((at, is_increment, high / norm))
    };
    let accel = (first..count.saturating_sub(2)).filter_map(variation);
    let split = |at: usize| !(at - first).is_multiple_of(3);
    let accel = accel.min_by(|a, b| split(a.0).cmp(&split(b.0)).then(a.2.total_cmp(&b.2)));
    if let Some((accel, is_increment, _)) = accel {
        let before = accel.checked_sub(3).filter(|gyro| *gyro >= first);
        let gyro = before.or_else(|| (accel + 6 <= count).then_some(accel + 3));
        let taken = gyro.map_or(accel..accel + 3, |gyro| accel.min(gyro)..accel.max(gyro) + 3);
        let is_free =
            |at: &usize| !(taken.start..taken.end).any(|own| (*at..at + 3).contains(&own));
        let place = (first..count.saturating_sub(2))
            .filter(is_free)
            .find(|&at| is_place(look, at) && is_smooth(look, at) && is_smooth(look, at + 1));
        if let Some(place) = place {
            give(place, Quantity::Latitude);
            give(place + 1, Quantity::Longitude);
            give(place + 2, Quantity::Height(None));
        }
        for axis in 0..3 {
            let (force, rate) = match is_increment {
                true => (Quantity::VelocityIncrement(axis), Quantity::AngleIncrement(axis)),
                false => (Quantity::Accel(axis), Quantity::Gyro(axis)),
            };
            give(accel + axis, force);
            if let Some(gyro) = gyro {
                give(gyro + axis, rate);
            }
        }
    } else if first + 3 <= count && is_place(look, first) {
        give(first, Quantity::Latitude);
        give(first + 1, Quantity::Longitude);
        give(first + 2, Quantity::Height(None));
        let mut next = first + 3;
        let is_positive = |column: usize| look.known(column).all(|value| value > 0.0);
        if next + 3 <= count && (next..next + 3).all(is_positive) {
            give(next, Quantity::SigmaHorizontal);
            give(next + 2, Quantity::SigmaVertical);
            next += 3;
        }
        if next + 3 <= count {
            (0..3).for_each(|axis| give(next + axis, Quantity::Velocity(axis)));
        }
    }
    meanings
}

/// Columns of the KITTI data set that are used, with their units. The vehicle axes are forward, left and up; the
/// columns after each triple are the same quantity along other axes.
///
/// # Source
/// A. Geiger, P. Lenz, C. Stiller, R. Urtasun (2013), Vision meets robotics: the KITTI dataset, *International Journal
/// of Robotics Research* 32 (11), and its file `dataformat.txt`.
const KITTI: [(usize, Quantity, &str); 15] = [
    (0, Quantity::Latitude, "deg"),
    (1, Quantity::Longitude, "deg"),
    (2, Quantity::Height(None), "m"),
    (3, Quantity::Attitude(0), "rad"),
    (4, Quantity::Attitude(1), "rad"),
    (5, Quantity::Attitude(2), "rad"),
    (6, Quantity::Velocity(0), "m/s"),
    (7, Quantity::Velocity(1), "m/s"),
    (10, Quantity::Up, "m/s"),
    (11, Quantity::Accel(0), "m/s2"),
    (12, Quantity::Accel(1), "m/s2"),
    (13, Quantity::Accel(2), "m/s2"),
    (17, Quantity::Gyro(0), "rad/s"),
    (18, Quantity::Gyro(1), "rad/s"),
    (19, Quantity::Gyro(2), "rad/s"),
];

/// The first column of a row of the KITTI data set, which may be preceded by a time. The row has 30 values: the last
/// five are whole numbers, and two triples have the size of gravity.
fn kitti(look: &Look) -> Option<usize> {
    const COLUMNS: usize = 30;
    let first = look.columns.len().checked_sub(COLUMNS).filter(|first| *first <= 1)?;
    let is_gravity = |at: usize| {
        let at = first + at;
        (8.5..11.0).contains(&look.median_norm([at, at + 1, at + 2]))
    };
    let are_states = (first + 25..first + COLUMNS).all(|column| look.is_whole(column));
    (are_states && is_place(look, first) && is_gravity(11) && is_gravity(14)).then_some(first)
}

/// Whether a column changes, and as slowly as a latitude does. In a file with an IMU, other columns may contain
/// anything.
fn is_smooth(look: &Look, column: usize) -> bool {
    /// Largest change from one fix to the next, °.
    const FASTEST_DEG: f64 = 0.002;
    let values = || look.known(column);
    let steps = || values().zip(values().skip(1)).map(|(a, b)| (b - a).abs());
    look.largest(column) > 0.5
        && steps().all(|step| step < FASTEST_DEG)
        && steps().filter(|step| *step > 0.0).count() >= 10
}

/// Whether two columns can be a latitude and a longitude, in degrees, each with a range below 1°.
fn is_place(look: &Look, at: usize) -> bool {
    let spread = |column: usize| {
        let [least, most] = look.range(column);
        most - least
    };
    look.largest(at) <= 90.0
        && look.largest(at + 1) <= 360.0
        && look.largest(at) > 0.0
        && spread(at) < 1.0
        && spread(at + 1) < 1.0
}
