//! `reference.csv`: what a solution is scored against. Nothing else reads it.

use std::path::Path;

use crate::clock::{Rows, median_interval_s};
use crate::error::LogError;
use crate::gps::{POSITION, VELOCITY};
use crate::imu::ATTITUDE;
use crate::manifest::Manifest;
use crate::remarks::Remarks;
use crate::table::Table;
use crate::trajectory::Trajectory;
use hovernav::earth::Geodetic;
use hovernav::ekf::Solution;
use hovernav::frames::{Body, EulerAngles, Ned, Rotation, Vector, wrap_angle};
use hovernav::time::Time;

pub(crate) const FILE: &str = "reference.csv";
pub(crate) const COLUMNS: [&str; 16] = [
    "t_s",
    POSITION[0],
    POSITION[1],
    POSITION[2],
    VELOCITY[0],
    VELOCITY[1],
    VELOCITY[2],
    ATTITUDE[0],
    ATTITUDE[1],
    ATTITUDE[2],
    "u_mps",
    "v_mps",
    "w_mps",
    "p_radps",
    "q_radps",
    "r_radps",
];

/// Longer stretches between reference rows are not interpolated, s, unless three median intervals
/// are longer still.
const LONGEST_GAP_S: f64 = 0.5;

/// The motion a solution is scored against, in time order, each quantity with times of its own.
#[derive(Clone, Debug)]
pub struct Reference {
    position: Series,
    velocity: Series,
    attitude: Series,
    body_velocity: Series,
    /// The point whose motion this is, from the solution's point, m.
    pub from_solution_point_m: Vector<Body>,
    /// How long after the first inertial sample scoring begins, s.
    pub skip_s: f64,
    /// One-sigma of its own position, each axis, m; zero where it is taken for the truth.
    pub position_sigma_m: f64,
    /// One-sigma of its own velocity, each axis, m/s.
    pub velocity_sigma_mps: f64,
    /// One-sigma of its own roll, pitch and yaw, degrees.
    pub attitude_sigma_deg: f64,
    /// What was repaired or left out while reading, one plain sentence each.
    pub warnings: Vec<String>,
}

/// The reference at one moment; NaN where it has none.
#[derive(Clone, Copy, Debug)]
pub struct ReferenceMoment {
    /// Geodetic latitude, rad, longitude, rad, and height above the ellipsoid, m.
    pub position: [f64; 3],
    /// Velocity north, east and down, m/s.
    pub velocity_mps: [f64; 3],
    /// Roll, pitch and yaw, rad.
    pub attitude_rad: [f64; 3],
    /// Velocity u, v, w in body axes, m/s: as recorded, else from velocity and attitude.
    pub body_velocity_mps: [f64; 3],
}

impl Reference {
    /// Reads the reference of the dataset in `dir`, whose manifest says whose motion it is and whose
    /// the solution's; `None` where there is no reference.
    ///
    /// # Errors
    /// As [`Dataset::open`](crate::Dataset::open), for `reference.csv`.
    pub fn open(dir: &Path, manifest: &Manifest) -> Result<Option<Self>, LogError> {
        let Some(mut table) = Table::open(dir, FILE)? else { return Ok(None) };
        let mut remarks = Remarks::new(FILE);
        let [time] = table.require(["t_s"])?;
        let columns: Vec<Option<usize>> =
            COLUMNS[1..13].iter().map(|name| table.find([name]).map(|[column]| column)).collect();
        table.remark_unused(&COLUMNS, &mut remarks);
        let mut rows = Rows::new();
        while let Some(row) = table.next(&mut remarks)? {
            let Some(time) = row.time(time)? else {
                remarks.count("left out: no time", row.line);
                continue;
            };
            let mut values = [f64::NAN; 12];
            for (value, column) in values.iter_mut().zip(&columns) {
                if let Some(column) = *column {
                    *value = row.number(column)?;
                }
            }
            rows.push(row.line, (time, values));
        }
        let (rows, _) = rows.in_time_order(|row| row.0, table.path(), &mut remarks)?;
        if rows.is_empty() {
            remarks.say("holds no usable row".into());
        }
        let point = manifest.lever_arm_m(manifest.reference.point);
        Ok(Some(Self {
            position: Series::of(&rows, |[lat, lon, height, ..]| {
                [lat.to_radians(), lon.to_radians(), height]
            }),
            velocity: Series::of(&rows, |[_, _, _, vn, ve, vd, ..]| [vn, ve, vd]),
            attitude: Series::of(&rows, |[_, _, _, _, _, _, roll, pitch, yaw, ..]| {
                [roll, pitch, yaw].map(f64::to_radians)
            }),
            body_velocity: Series::of(&rows, |[.., u, v, w]| [u, v, w]),
            from_solution_point_m: point - manifest.lever_arm_m(manifest.solution.point),
            skip_s: manifest.reference.skip_s,
            position_sigma_m: manifest.reference.position_sigma_m,
            velocity_sigma_mps: manifest.reference.velocity_sigma_mps,
            attitude_sigma_deg: manifest.reference.attitude_sigma_deg,
            warnings: remarks.into_warnings().collect(),
        }))
    }

    /// A trajectory on Earth as reference, scored from its first moment on, its point the solution's.
    #[must_use]
    pub fn of_trajectory(trajectory: &Trajectory) -> Self {
        let of = |pick: &dyn Fn(&Solution) -> [f64; 3]| {
            let rows = trajectory.solutions.iter();
            Series::new(rows.map(|solution| (solution.time, pick(solution))))
        };
        Self {
            position: of(&|solution| {
                let Geodetic { latitude_rad, longitude_rad, height_m } = solution.position;
                [latitude_rad, longitude_rad, height_m]
            }),
            velocity: of(&|solution| solution.velocity_mps.to_array()),
            attitude: of(&|solution| {
                let angles = solution.body_to_ned.euler();
                [angles.roll_rad, angles.pitch_rad, angles.yaw_rad]
            }),
            body_velocity: of(&|_| [f64::NAN; 3]),
            from_solution_point_m: Vector::ZERO,
            skip_s: 0.0,
            position_sigma_m: 0.0,
            velocity_sigma_mps: 0.0,
            attitude_sigma_deg: 0.0,
            warnings: trajectory.warnings.clone(),
        }
    }

    /// The reference at `time`: position and velocities interpolated linearly, attitude along the
    /// shortest turn; NaN before its start, beyond its end, and across gaps longer than half a second
    /// and than three median intervals.
    #[must_use]
    pub fn at(&self, time: Time) -> ReferenceMoment {
        let velocity_mps = self.velocity.at(time, linear);
        let attitude_rad = self.attitude.at(time, along_shortest_turn);
        let mut body_velocity_mps = self.body_velocity.at(time, linear);
        if !is_finite(body_velocity_mps) && is_finite(velocity_mps) && is_finite(attitude_rad) {
            let ned_to_body = attitude(attitude_rad).inverse();
            body_velocity_mps = (ned_to_body * Vector::from(velocity_mps)).to_array();
        }
        let position = self.position.at(time, |from, to, fraction| {
            let [lat, _, height] = linear(from, to, fraction);
            [lat, wrapped_linear(from[1], to[1], fraction), height]
        });
        ReferenceMoment { position, velocity_mps, attitude_rad, body_velocity_mps }
    }
}

/// Three components over time; NaN where one is unknown.
#[derive(Clone, Debug)]
struct Series {
    times: Vec<Time>,
    values: Vec<[f64; 3]>,
    longest_gap_s: f64,
}

impl Series {
    fn of(rows: &[(Time, [f64; 12])], pick: impl Fn([f64; 12]) -> [f64; 3]) -> Self {
        Self::new(rows.iter().map(|(time, row)| (*time, pick(*row))))
    }

    fn new(rows: impl Iterator<Item = (Time, [f64; 3])>) -> Self {
        let (times, values): (Vec<Time>, Vec<[f64; 3]>) =
            rows.filter(|(_, values)| values.iter().any(|value| value.is_finite())).unzip();
        let longest_gap_s = LONGEST_GAP_S.max(3.0 * median_interval_s(&times).unwrap_or(0.0));
        Self { times, values, longest_gap_s }
    }

    fn at(
        &self,
        time: Time,
        interpolate: impl Fn([f64; 3], [f64; 3], f64) -> [f64; 3],
    ) -> [f64; 3] {
        const UNKNOWN: [f64; 3] = [f64::NAN; 3];
        let next = self.times.partition_point(|known| *known <= time);
        let Some(last) = next.checked_sub(1) else { return UNKNOWN };
        if self.times[last] == time {
            return self.values[last];
        }
        let Some(&end) = self.times.get(next) else { return UNKNOWN };
        let interval_s = end - self.times[last];
        if interval_s > self.longest_gap_s {
            return UNKNOWN;
        }
        interpolate(self.values[last], self.values[next], (time - self.times[last]) / interval_s)
    }
}

fn linear(from: [f64; 3], to: [f64; 3], fraction: f64) -> [f64; 3] {
    std::array::from_fn(|axis| from[axis] + (to[axis] - from[axis]) * fraction)
}

fn wrapped_linear(from_rad: f64, to_rad: f64, fraction: f64) -> f64 {
    wrap_angle(from_rad + wrap_angle(to_rad - from_rad) * fraction)
}

/// Spherical linear interpolation, or angle by angle where not all three are known.
fn along_shortest_turn(from: [f64; 3], to: [f64; 3], fraction: f64) -> [f64; 3] {
    if !is_finite(from) || !is_finite(to) {
        return std::array::from_fn(|axis| wrapped_linear(from[axis], to[axis], fraction));
    }
    let [from, to] = [from, to].map(|angles| attitude(angles).quaternion());
    let angles = Rotation::<Body, Ned>::claim(from.slerp(to, fraction)).euler();
    [angles.roll_rad, angles.pitch_rad, angles.yaw_rad]
}

fn attitude([roll_rad, pitch_rad, yaw_rad]: [f64; 3]) -> Rotation<Body, Ned> {
    Rotation::from_euler(EulerAngles { roll_rad, pitch_rad, yaw_rad })
}

fn is_finite(values: [f64; 3]) -> bool {
    values.iter().all(|value| value.is_finite())
}
