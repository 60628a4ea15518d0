//! Readers of trajectory files.

use std::path::Path;

use super::poses::{LocalAxes, Trajectory, unknown};
use crate::clock::Rows;
use crate::clock::steps::ClockSteps;
use crate::error::{LogError, excerpt};
use crate::solution::COLUMNS;
use crate::table::number::{parse_number, parse_time};
use crate::table::remarks::Remarks;
use crate::table::{LARGEST_BYTES, Table};
use crate::trajectory::possible_motion::{MotionColumns, TOO_FAST};
use hovernav::earth::Geodetic;
use hovernav::ekf::Solution;
use hovernav::frames::{EulerAngles, Ned, Rotation, Vector};
use hovernav::time::Time;
use hovernav_toml::read_bytes;

/// Escape velocity of the Earth, m/s. A diverged solution is scored as it is, except for impossible values.
const FASTEST_MPS: f64 = 11_200.0;
/// The diameter of the Earth, m.
const FURTHEST_M: f64 = 1.2756e7;

impl Trajectory {
    /// Reads a trajectory from `path`. It is a `solution.csv` or `reference.csv`, recognised by its header, or a TUM or
    /// EuRoC file in `axes`. TUM files have `t x y z qx qy qz qw`, separated by blanks. EuRoC files have nanoseconds,
    /// position, quaternion w x y z, and optionally velocity, separated by commas.
    ///
    /// # Errors
    /// [`LogError`] if the file cannot be read or has none of these forms, with line and column.
    pub fn open(path: &Path, axes: LocalAxes) -> Result<Self, LogError> {
        let bytes = read_bytes(path, LARGEST_BYTES).map_err(LogError::io(path))?;
        let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut remarks = Remarks::new(file);
        let head =
            bytes.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii).find(|l| !l.is_empty());
        let is_table = head.is_some_and(|head| {
            let mut names = head.split(|&byte| byte == b',').map(<[u8]>::trim_ascii);
            names.any(|name| name.trim_ascii_start().ends_with(b"t_s"))
        });
        let mut origin = None;
        let (solutions, local_m) = if is_table {
            let table = Table::parse(path.to_path_buf(), bytes)?;
            (of_table(table, &mut remarks)?, Vec::new())
        } else {
            let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
            origin = head.and_then(origin_of);
            of_lines(path, text, axes, &mut remarks)?.into_iter().unzip()
        };
        if solutions.is_empty() {
            let reason =
                "found no usable row, expected a trajectory: solution.csv, TUM or EuRoC".into();
            return Err(LogError::Unusable { path: path.to_path_buf(), reason });
        }
        Ok(Self { solutions, local_m, origin, warnings: remarks.into_warnings().collect() })
    }
}

/// The origin in the first line of our own TUM export, `# east, north, up from LAT LON HEIGHT (…`.
fn origin_of(head: &[u8]) -> Option<Geodetic> {
    let text = std::str::from_utf8(head).ok()?.strip_prefix('#')?;
    let numbers = text.trim_start().strip_prefix("east, north, up from ")?;
    let numbers: Vec<f64> =
        numbers.split_whitespace().take(3).map_while(|number| number.parse().ok()).collect();
    let &[latitude_deg, longitude_deg, height_m] = &numbers[..] else { return None };
    Geodetic::from_degrees(latitude_deg, longitude_deg, height_m)
}

fn of_table(mut table: Table, remarks: &mut Remarks) -> Result<Vec<Solution>, LogError> {
    let columns = MotionColumns::<30>::find(&mut table)?;
    if !columns.any_motion() {
        return Err(table.columns_missing(&COLUMNS[1..10].join(" or ")));
    }
    let mut rows = Rows::new();
    while let Some(row) = table.next(remarks)? {
        if let Some((time, values)) = columns.read(&row, FASTEST_MPS, remarks)? {
            rows.push(row.line, of_values(time, &values));
        }
    }
    let steps = &mut ClockSteps::default();
    Ok(rows.in_time_order(|solution| &mut solution.time, table.path(), steps, remarks)?.0)
}

/// Solution at `time` from the other values of a row of `solution.csv`.
fn of_values(time: Time, values: &[f64; 30]) -> Solution {
    let three = |first: usize| [values[first], values[first + 1], values[first + 2]];
    let [latitude_deg, longitude_deg, height_m] = three(0);
    let [roll_deg, pitch_deg, yaw_deg] = three(6);
    Solution {
        position: Geodetic {
            latitude_rad: latitude_deg.to_radians(),
            longitude_rad: longitude_deg.to_radians(),
            height_m,
        },
        velocity_mps: three(3).into(),
        body_to_ned: Rotation::from_euler(EulerAngles::from_degrees(roll_deg, pitch_deg, yaw_deg)),
        angular_rate_radps: three(12).into(),
        position_sigma_m: three(15).into(),
        velocity_sigma_mps: three(18).into(),
        attitude_sigma_rad: three(21).map(f64::to_radians),
        gyro_bias_radps: three(24).into(),
        accel_bias_mps2: three(27).into(),
        ..unknown(time)
    }
}

/// Reads lines of TUM, separated by blanks, or of EuRoC, separated by commas.
fn of_lines(
    path: &Path,
    bytes: &[u8],
    axes: LocalAxes,
    remarks: &mut Remarks,
) -> Result<Vec<(Solution, Vector<Ned>)>, LogError> {
    let (mut rows, mut is_first) = (Rows::new(), true);
    for (index, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let line_number = index as u64 + 1;
        let line = line.trim_ascii();
        if line.is_empty() || line.starts_with(b"#") || line.starts_with(b"%") {
            continue;
        }
        let is_euroc = line.contains(&b',');
        let fields: Vec<&[u8]> = if is_euroc {
            line.split(|&byte| byte == b',').map(<[u8]>::trim_ascii).collect()
        } else {
            line.split(u8::is_ascii_whitespace).filter(|field| !field.is_empty()).collect()
        };
        let unexpected = |column: String, field: &[u8], expected: &'static str| LogError::Field {
            path: path.to_path_buf(),
            line: line_number,
            column,
            found: excerpt(field, 40),
            expected,
        };
        if is_first && parse_time(fields[0]).is_none() {
            return Err(LogError::Columns {
                path: path.to_path_buf(),
                line: line_number,
                expected:
                    "a header with t_s and the columns of solution.csv, or numbers alone as in TUM and EuRoC; \
                     for other files the mapping that `hovernav init` writes"
                        .into(),
                found: excerpt(line, 200),
            });
        }
        is_first = false;
        if fields.len() < 8 {
            const EXPECTED: &str = "eight numbers: t x y z qx qy qz qw (TUM), or with commas t x y z qw qx qy qz (EuRoC)";
            return Err(unexpected(format!("1 to {}", fields.len()), line, EXPECTED));
        }
        let mut numbers = [f64::NAN; 10];
        for (place, number) in numbers.iter_mut().enumerate() {
            let Some(field) = fields.get(place + 1) else { break };
            let found = parse_number(field);
            *number =
                found.ok_or_else(|| unexpected((place + 2).to_string(), field, "a number"))?;
        }
        // EuRoC has whole nanoseconds; a number with a decimal point is in seconds.
        let whole_ns = std::str::from_utf8(fields[0]).ok().and_then(|text| text.parse().ok());
        let time = match whole_ns.filter(|_: &i64| is_euroc) {
            Some(ns) => Some(Time::from_nanoseconds(ns)),
            None => {
                parse_time(fields[0]).ok_or_else(|| unexpected("1".into(), fields[0], "a time"))?
            }
        };
        let [x, y, z, a, b, c, d, velocity @ ..] = numbers;
        let quaternion = if is_euroc { [b, c, d, a] } else { [a, b, c, d] };
        let length = quaternion.iter().map(|part| part * part).sum::<f64>().sqrt();
        let Some(time) = time.filter(|_| (0.5..2.0).contains(&length)) else {
            remarks.count("skipped: no time or no quaternion of length one", line_number);
            continue;
        };
        if [x, y, z].iter().any(|metres| metres.abs() > FURTHEST_M) {
            remarks.count("rejected: further from its zero than the Earth is wide", line_number);
            continue;
        }
        let mut solution = unknown(time);
        solution.body_to_ned = axes.attitude(quaternion);
        if is_euroc {
            let is_too_fast = velocity.iter().any(|speed| speed.abs() > FASTEST_MPS);
            if is_too_fast {
                remarks.count(TOO_FAST, line_number);
            }
            let velocity = if is_too_fast { [f64::NAN; 3] } else { velocity };
            solution.velocity_mps = axes.vector(velocity);
        }
        rows.push(line_number, (solution, axes.vector([x, y, z])));
    }
    let steps = &mut ClockSteps::default();
    Ok(rows.in_time_order(|(solution, _)| &mut solution.time, path, steps, remarks)?.0)
}
