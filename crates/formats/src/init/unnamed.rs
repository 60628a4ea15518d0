//! Meanings of columns without names, from their values.

use super::look::Look;
use super::names::Meaning;
use super::quantity::Quantity;
use crate::text::HeightAbove;

/// The meanings of the columns of `look`, as far as their values determine them, and the other columns that may be the
/// gyro.
///
/// Time is the first column that rises, if possible one that does not count rows. Three adjacent columns are an
/// accelerometer if their norm is gravity, or gravity times the time step. The gyro is [next](gyros) to them. This reads
/// the inertial files of KF-GINS (angle increments, then velocity increments) and of NaveGo (specific force, then rates).
/// Latitude, longitude and height are adjacent columns. In a file with an accelerometer, the first two of them must
/// change as slowly as a position does. In a file without, the three columns after the height are one-sigmas if all
/// values are positive, otherwise velocities.
pub(crate) fn meanings(look: &Look) -> (Vec<Option<Meaning>>, Vec<[usize; 3]>) {
    let count = look.columns.len();
    let mut meanings = vec![None; count];
    let is_time_of_day = |column: usize| {
        look.are_clock[column] && column.checked_sub(1).is_some_and(|date| look.are_dates[date])
    };
    let of_time = |column: usize| match look.are_dates[column] {
        true => Quantity::Date,
        false => Quantity::Time,
    };
    let known = kitti(look).map(|first| (first, KITTI)).or_else(|| ros(look));
    if let Some((first, known)) = known {
        for (column, meaning) in meanings.iter_mut().enumerate().take(first) {
            *meaning = Some(Meaning { quantity: of_time(column), unit: None, estimated: false });
        }
        for &(column, quantity, unit) in known {
            // Attitude, position and velocity are those of the inertial unit's own filter.
            let estimated = matches!(quantity, Quantity::Attitude(_));
            meanings[first + column] = Some(Meaning { quantity, unit: Some(unit), estimated });
        }
        return (meanings, Vec::new());
    }
    let mut give = |column: usize, quantity: Quantity| {
        meanings[column] = Some(Meaning { quantity, unit: None, estimated: false });
    };
    let is_time = |&column: &usize| {
        let [least, most] = look.range(column);
        !look.counts(column) && look.is_even(column) && most - least > 1.0
    };
    let rising = || (0..count).filter(|&column| look.rises(column));
    let rising = rising()
        .find(is_time)
        .filter(|_| rising().next().is_some_and(|first| look.counts(first)))
        .or_else(|| rising().next());
    let Some(time) = rising.or_else(|| (count > 0 && look.climbs(0)).then_some(0)) else {
        return (meanings, Vec::new());
    };
    let mut other_gyros = Vec::new();
    give(time, Quantity::Time);
    if is_time_of_day(time) {
        give(time - 1, Quantity::Date);
    }
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
    let is_position =
        |at: &usize| is_place(look, *at) && is_smooth(look, *at) && is_smooth(look, at + 1);
    let positions: Vec<usize> = (first..count.saturating_sub(2)).filter(is_position).collect();
    // Other columns of one value, such as a number of satellites, do not belong to a triple.
    let is_single = |column: &usize| {
        let [least, most] = look.range(*column);
        least == most && most != 0.0 && !positions.iter().any(|at| at + 2 == *column)
    };
    let split =
        |at: usize| !(first..at).filter(|column| !is_single(column)).count().is_multiple_of(3);
    let accel = accel.min_by(|a, b| split(a.0).cmp(&split(b.0)).then(a.2.total_cmp(&b.2)));
    if let Some((accel, is_increment, _)) = accel {
        let found = gyros(look, first, accel);
        let gyro = found.first().copied();
        // Increments of angle and velocity have one unit each.
        let others = found.iter().skip(1).filter(|_| !is_increment);
        other_gyros = others.map(|&at| [at, at + 1, at + 2]).collect();
        let is_free = |at: &usize| {
            [Some(accel), gyro].into_iter().flatten().all(|own| own.abs_diff(*at) >= 3)
        };
        if let Some(place) = positions.iter().copied().find(is_free) {
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
    (meanings, other_gyros)
}

/// First columns of the triples that may be a gyro, at a multiple of three columns from the accelerometer at `accel`:
/// the triples next to it, those before it first, otherwise the nearest one.
///
/// A triple is no gyro if it is 0 throughout, or if another one is the rate of its change, or repeats it. A triple of
/// constant norm, as of a position or a magnetic field, is one only without another.
fn gyros(look: &Look, first: usize, accel: usize) -> Vec<usize> {
    /// Smallest ratio of the median norm to the 99th percentile that counts as constant.
    const CONSTANT: f64 = 0.9;
    /// Smallest magnitude of the correlation of an angle's change with the rate.
    const ALIKE: f64 = 0.8;
    let count = look.columns.len();
    let triple = |at: usize| [at, at + 1, at + 2];
    let is_moving = |at: &usize| look.high_norm(triple(*at)) > 0.0;
    let mut all: Vec<usize> = (first..count.saturating_sub(2))
        .filter(|at| *at != accel && at.abs_diff(accel).is_multiple_of(3))
        .filter(is_moving)
        .collect();
    all.sort_by_key(|at| (at.abs_diff(accel), *at));
    let varies =
        |at: &usize| look.median_norm(triple(*at)) < CONSTANT * look.high_norm(triple(*at));
    if all.iter().any(varies) {
        all.retain(varies);
    }
    let likeness = |a: usize, b: usize, of: fn(&Look, usize, usize) -> f64| {
        (0..3).map(|axis| of(look, a + axis, b + axis).abs()).fold(0.0, f64::max)
    };
    // The change of an oscillating rate is also correlated with the angle, but less than the change of the angle with
    // the rate.
    let is_angle = |angle: usize, rate: usize| {
        let change = likeness(angle, rate, Look::likeness_of_change);
        change > ALIKE && change > likeness(rate, angle, Look::likeness_of_change)
    };
    let candidates = all.clone();
    all.retain(|&at| !candidates.iter().any(|&rate| rate != at && is_angle(at, rate)));
    let mut different: Vec<usize> = Vec::new();
    for at in all {
        if !different.iter().any(|&before| likeness(before, at, Look::likeness) > ALIKE) {
            different.push(at);
        }
    }
    let nearest = different.iter().take_while(|at| at.abs_diff(accel) == 3).count().max(1);
    different.truncate(nearest);
    different
}

/// Columns of the KITTI data set that are used, with their units. The vehicle axes are forward, left and up; the
/// columns after each triple are the same quantity along other axes.
///
/// # Source
/// A. Geiger, P. Lenz, C. Stiller, R. Urtasun (2013), Vision meets robotics: the KITTI dataset, *International Journal
/// of Robotics Research* 32 (11), and its file `dataformat.txt`.
const KITTI: Columns = &[
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

/// Columns of a known layout, each with its unit.
type Columns = &'static [(usize, Quantity, &'static str)];

/// Columns of the messages that `ros2 topic echo --csv` writes, counted behind the seconds of the stamp, by the number of
/// all columns: `Imu`, `NavSatFix`, `TwistStamped`, `MagneticField` and `FluidPressure`.
///
/// # Source
/// The definitions of `sensor_msgs` and `geometry_msgs` of ROS 2.
const ROS: [(usize, Columns); 5] = [
    (
        40,
        &[
            (15, Quantity::Gyro(0), "rad/s"),
            (16, Quantity::Gyro(1), "rad/s"),
            (17, Quantity::Gyro(2), "rad/s"),
            (27, Quantity::Accel(0), "m/s2"),
            (28, Quantity::Accel(1), "m/s2"),
            (29, Quantity::Accel(2), "m/s2"),
        ],
    ),
    (
        18,
        &[
            (4, Quantity::Latitude, "deg"),
            (5, Quantity::Longitude, "deg"),
            (6, Quantity::Height(Some(HeightAbove::Ellipsoid)), "m"),
        ],
    ),
    (
        9,
        &[
            (2, Quantity::Twist(0), "m/s"),
            (3, Quantity::Twist(1), "m/s"),
            (4, Quantity::Twist(2), "m/s"),
        ],
    ),
    (15, &[(2, Quantity::Mag(0), "t"), (3, Quantity::Mag(1), "t"), (4, Quantity::Mag(2), "t")]),
    (5, &[(2, Quantity::Pressure, "pa")]),
];

/// The columns of a message of ROS 2, in a file that begins with a stamp and the name of a frame, behind the first one.
fn ros(look: &Look) -> Option<(usize, Columns)> {
    let is_frame =
        look.stamp == Some(0) && look.columns.len() > 2 && look.known(2).next().is_none();
    let (_, columns) = ROS.iter().find(|(count, _)| is_frame && *count == look.columns.len())?;
    Some((1, columns))
}

/// The first column of a row of the KITTI data set, which may be preceded by a time and its date. The row has 30
/// values: the last five are whole numbers, and two triples have the size of gravity.
fn kitti(look: &Look) -> Option<usize> {
    const COLUMNS: usize = 30;
    let first = look.columns.len().checked_sub(COLUMNS).filter(|first| *first <= 2)?;
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
