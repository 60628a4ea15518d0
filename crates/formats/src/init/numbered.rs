//! Names of axes as loggers write them: numbers, or one file per sensor.

use std::collections::BTreeMap;

use super::axis_names::quaternion;
use super::words::words;

/// Sensors of phone loggers, whose columns are called x, y and z: parts of the file's name, and the sensor.
const OF_FILES: [(&str, &str); 8] = [
    ("linear", "linear accel"),
    ("withoutg", "linear accel"),
    ("gravity", "gravity"),
    ("gyro", "gyro"),
    ("magnet", "mag"),
    ("accel", "accel"),
    ("rotationrate", "gyro"),
    ("compass", "mag"),
];

/// The `names` of a file called `file`, with letters instead of numbers. `gyroADC[0]` and `gyro_1` become axis x, `x`
/// in `Gyroscope.csv` becomes `gyro x`.
pub(super) fn lettered(names: &[String], file: &str) -> Vec<String> {
    let mut by_stem: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    let split: Vec<Option<Indexed<'_>>> = names.iter().map(|name| indexed(name)).collect();
    for Indexed { stem, index, .. } in split.iter().flatten() {
        by_stem.entry((*stem).to_owned()).or_default().push(*index);
    }
    let letters = |stem: &str, index: usize| {
        let found = by_stem.get(stem)?;
        let count = found.len();
        let first = *found.iter().min()?;
        let all: &[&str] = match count {
            2 if stem.to_lowercase().ends_with("coord") => &["lat", "lon"],
            3 => &["x", "y", "z"],
            4 => &["w", "x", "y", "z"],
            _ => return None,
        };
        let is_whole = first <= 1 && (first..first + count).all(|index| found.contains(&index));
        all.get(index - first).filter(|_| is_whole)
    };
    let sensor = sensor_of(file);
    let lettered = names.iter().zip(&split).map(|(name, split)| {
        let bare = name.split(['[', '(']).next().unwrap_or_default().trim().to_lowercase();
        match (split, sensor) {
            (Some(Indexed { stem, index, unit }), _) => match letters(stem, *index) {
                Some(letter) => format!("{stem} {letter}{unit}"),
                None => name.clone(),
            },
            (None, Some(sensor)) if matches!(&*bare, "x" | "y" | "z") => format!("{sensor} {name}"),
            _ => without_numbers(name),
        }
    });
    lettered.collect()
}

/// Whether a file is of a phone's logger: called by its sensor, with columns called x, y and z.
pub(super) fn is_of_phone(names: &[String], file: &str) -> bool {
    let bare =
        |name: &String| name.split(['[', '(']).next().unwrap_or_default().trim().to_lowercase();
    sensor_of(file).is_some()
        && ["x", "y", "z"].iter().all(|axis| names.iter().any(|name| bare(name) == *axis))
}

/// The sensor of a phone that the name of the file denotes, if any.
fn sensor_of(file: &str) -> Option<&'static str> {
    let name = words(file).concat();
    OF_FILES.iter().find(|(part, _)| name.contains(part)).map(|(_, sensor)| *sensor)
}

/// A name that ends in a number.
struct Indexed<'a> {
    stem: &'a str,
    index: usize,
    /// The unit behind the number, with its brackets.
    unit: &'a str,
}

/// The parts of a name that ends in a number: `gyroADC[0]`, `gyroADC[0] (deg/s)`, `gyro_1`. Names of quaternions may lack
/// a separator: `q1`, `Quat4`.
fn indexed(name: &str) -> Option<Indexed<'_>> {
    let unit = name.rfind([' ', ']']).map_or("", |at| &name[at..]);
    let unit = unit.strip_prefix(']').unwrap_or(unit);
    let unit = if unit.trim_start().starts_with(['(', '[']) { unit } else { "" };
    let name = name[..name.len() - unit.len()].trim();
    let (stem, index) = match name.strip_suffix([']', ')']) {
        Some(inside) => inside.rsplit_once(['[', '('])?,
        None => name.rsplit_once('_').filter(|(_, index)| index.len() == 1).or_else(|| {
            let (stem, index) = name.split_at_checked(name.len().checked_sub(1)?)?;
            let scalar = words(stem).concat() + "w";
            quaternion(&scalar).map(|_| (stem, index))
        })?,
    };
    let index = index.trim().parse().ok().filter(|index| *index < 10)?;
    (!stem.is_empty()).then_some(Indexed { stem, index, unit })
}

/// `name` without the sensor's number in brackets, which every column of a sensor has: `IMU_ATTI(0):accel:X`,
/// `GPS[0].Lat`.
fn without_numbers(name: &str) -> String {
    let Some((before, rest)) = name.split_once(['(', '[']) else { return name.to_owned() };
    match rest.split_once([')', ']']) {
        Some((inside, after)) if !after.is_empty() && inside.parse::<u8>().is_ok() => {
            format!("{before}{after}")
        }
        _ => name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_axes_become_letters() {
        for (names, file, expected) in [
            (
                ["gyroADC[0]", "gyroADC[1]", "gyroADC[2]"],
                "log.csv",
                ["gyroADC x", "gyroADC y", "gyroADC z"],
            ),
            (["acc_1", "acc_2", "acc_3"], "log.csv", ["acc x", "acc y", "acc z"]),
            (
                ["gyro[0] (deg/s)", "gyro[1] (deg/s)", "gyro[2] (deg/s)"],
                "log.csv",
                ["gyro x (deg/s)", "gyro y (deg/s)", "gyro z (deg/s)"],
            ),
            (
                ["GPS_coord[0]", "GPS_coord[1]", "t"],
                "log.csv",
                ["GPS_coord lat", "GPS_coord lon", "t"],
            ),
            (["acc_1", "acc_2", "t_3"], "log.csv", ["acc_1", "acc_2", "t_3"]),
            (["ch1", "ch2", "ch3"], "log.csv", ["ch1", "ch2", "ch3"]),
            (["z", "y (m/s^2)", "t"], "Accelerometer.csv", ["accel z", "accel y (m/s^2)", "t"]),
            (
                ["x", "y", "z"],
                "Linear Accelerometer.csv",
                ["linear accel x", "linear accel y", "linear accel z"],
            ),
            (["X (rad/s)", "y", "t"], "Gyroskop.csv", ["gyro X (rad/s)", "gyro y", "t"]),
            (["x", "y", "t"], "Beschleunigung mit g.csv", ["accel x", "accel y", "t"]),
            (
                ["x", "y", "t"],
                "Accélération (sans g).csv",
                ["linear accel x", "linear accel y", "t"],
            ),
            (
                ["IMU_ATTI(0):accel:X", "time(s)", "GPS[0].Lat"],
                "log.csv",
                ["IMU_ATTI:accel:X", "time(s)", "GPS.Lat"],
            ),
        ] {
            let names = names.map(str::to_owned);
            assert_eq!(lettered(&names, file), expected, "{names:?}");
        }
        for stem in ["q", "Quat", "Quaternion ", "att_q"] {
            let names = [1, 2, 3, 4].map(|number| format!("{stem}{number}"));
            let expected = ["w", "x", "y", "z"].map(|letter| format!("{stem} {letter}"));
            assert_eq!(lettered(&names, "log.csv"), expected, "{names:?}");
        }
    }
}
