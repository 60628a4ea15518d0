//! `reference.csv`: the reference for scores. Nothing else reads it.

pub(crate) mod align;
pub(crate) mod series;
pub(crate) mod truth;

use std::path::Path;

use crate::clock::ordered::{self, Gathered, TimedRows};
use crate::clock::steps::ClockSteps;
use crate::error::LogError;
use crate::manifest::Manifest;
use crate::reference::series::{Series, SeriesAt};
use crate::sensors::fix_gate::FASTEST_MPS;
use crate::solution;
use crate::table::Table;
use crate::table::remarks::Remarks;
use crate::trajectory::Trajectory;
use crate::trajectory::possible_motion::MotionColumns;
use hovernav::earth::Geodetic;
use hovernav::ekf::Solution;
use hovernav::frames::{Body, EulerAngles, Ned, Rotation, Vector, wrap_angle};
use hovernav::time::Time;

pub(crate) const FILE: &str = "reference.csv";
/// The first columns of `solution.csv`.
pub(crate) const COLUMNS: &[&str] = solution::COLUMNS.split_at(16).0;

/// The motion that a solution is scored against, in time order, each quantity with its own times.
#[derive(Clone, Debug)]
pub struct Reference {
    position: Series,
    velocity: Series,
    attitude: Series,
    body_velocity: Series,
    /// Vector from the solution's point to the reference's point, m.
    pub from_solution_point_m: Vector<Body>,
    /// Time from the first inertial sample to the start of scoring, s.
    pub skip_s: f64,
    /// One-sigma of the reference's own position, each axis, m; zero if it counts as exact.
    pub position_sigma_m: f64,
    /// One-sigma of the reference's own velocity, each axis, m/s.
    pub velocity_sigma_mps: f64,
    /// One-sigma of the reference's own roll, pitch and yaw, degrees.
    pub attitude_sigma_deg: f64,
    /// Repairs and skipped rows while reading, one plain sentence each.
    pub warnings: Vec<String>,
}

/// The reference at one time; NaN for unknown values.
#[derive(Clone, Copy, Debug)]
pub struct ReferenceMoment {
    /// Geodetic latitude, rad, longitude, rad, and height above the ellipsoid, m.
    pub position: [f64; 3],
    /// Velocity north, east and down, m/s.
    pub velocity_mps: [f64; 3],
    /// Roll, pitch and yaw, rad.
    pub attitude_rad: [f64; 3],
    /// Velocity u, v, w in body axes, m/s: as recorded, otherwise from velocity and attitude.
    pub body_velocity_mps: [f64; 3],
}

impl Reference {
    /// Reads the reference of the dataset in `dir`; `None` if the dataset has none. `manifest` states the point of the
    /// vehicle to which the reference refers, and that to which the solution refers.
    ///
    /// # Errors
    /// As [`Dataset::open`](crate::Dataset::open), for `reference.csv`.
    pub fn open(dir: &Path, manifest: &Manifest) -> Result<Option<Self>, LogError> {
        Self::read(dir, manifest, None)
    }

    /// [`open`](Self::open) that stores only what interpolation at the `moments`, in order of time, needs. At other
    /// times its values are unknown or less accurate.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_at(
        dir: &Path,
        manifest: &Manifest,
        moments: &[Time],
    ) -> Result<Option<Self>, LogError> {
        Self::read(dir, manifest, Some(moments))
    }

    fn read(
        dir: &Path,
        manifest: &Manifest,
        moments: Option<&[Time]>,
    ) -> Result<Option<Self>, LogError> {
        if ReferenceRows::open(dir)?.is_none() {
            return Ok(None);
        }
        let path = dir.join(FILE);
        let Gathered { made, mut rows, .. } = ordered::gather(
            || ReferenceRows::open(dir)?.ok_or_else(|| LogError::changed(path.clone())),
            |_| Quantities::at(moments),
            |quantities, _, (time, values)| quantities.push(time, values),
            &mut ClockSteps::default(),
        )?;
        let Quantities { position, velocity, attitude, body_velocity, count } = made;
        if count == 0 {
            rows.remarks().say("found no usable row".into());
        }
        let point = manifest.lever_arm_m(manifest.reference.point);
        Ok(Some(Self {
            position: position.finish(),
            velocity: velocity.finish(),
            attitude: attitude.finish(),
            body_velocity: body_velocity.finish(),
            from_solution_point_m: point - manifest.lever_arm_m(manifest.solution.point),
            skip_s: manifest.reference.skip_s,
            position_sigma_m: manifest.reference.position_sigma_m,
            velocity_sigma_mps: manifest.reference.velocity_sigma_mps,
            attitude_sigma_deg: manifest.reference.attitude_sigma_deg,
            warnings: rows.remarks.into_warnings().collect(),
        }))
    }

    /// A trajectory on Earth as reference, scored from its start, for the solution's point.
    #[must_use]
    pub fn of_trajectory(trajectory: &Trajectory) -> Self {
        let of = |pick: &dyn Fn(&Solution) -> [f64; 3]| {
            let rows = trajectory.solutions.iter();
            let mut series = SeriesAt::new(None);
            rows.for_each(|solution| series.push(solution.time, pick(solution)));
            series.finish()
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

    /// The reference at `time`: position and velocities interpolated linearly, attitude along the shortest turn; NaN
    /// before its start, beyond its end, and across gaps longer than both half a second and three median intervals.
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

/// Reader of the rows of `reference.csv`: each has the twelve quantities after its time, NaN for unknown ones.
struct ReferenceRows {
    table: Table,
    columns: MotionColumns<12>,
    remarks: Remarks,
}

impl ReferenceRows {
    /// Opens `reference.csv` of `dir`; `None` without such a file.
    fn open(dir: &Path) -> Result<Option<Self>, LogError> {
        let Some(mut table) = Table::open(dir, FILE)? else { return Ok(None) };
        let columns = MotionColumns::find(&mut table)?;
        let mut remarks = Remarks::new(FILE);
        table.remark_unused(COLUMNS, &mut remarks);
        Ok(Some(Self { table, columns, remarks }))
    }
}

impl TimedRows for ReferenceRows {
    type Row = (Time, [f64; 12]);

    fn next(&mut self) -> Result<Option<(u64, Self::Row)>, LogError> {
        while let Some(row) = self.table.next(&mut self.remarks)? {
            if let Some(moment) = self.columns.read(&row, FASTEST_MPS, &mut self.remarks)? {
                return Ok(Some((row.line, moment)));
            }
        }
        Ok(None)
    }

    fn time((time, _): &mut Self::Row) -> &mut Time {
        time
    }

    fn path(&self) -> &Path {
        self.table.path()
    }

    fn remarks(&mut self) -> &mut Remarks {
        &mut self.remarks
    }
}

/// The quantities gathered from the rows.
struct Quantities<'a> {
    position: SeriesAt<'a>,
    velocity: SeriesAt<'a>,
    attitude: SeriesAt<'a>,
    body_velocity: SeriesAt<'a>,
    /// Number of rows read.
    count: usize,
}

impl<'a> Quantities<'a> {
    fn at(moments: Option<&'a [Time]>) -> Self {
        let [position, velocity, attitude, body_velocity] =
            std::array::from_fn(|_| SeriesAt::new(moments));
        Self { position, velocity, attitude, body_velocity, count: 0 }
    }

    fn push(&mut self, time: Time, values: [f64; 12]) {
        let [lat, lon, height, vn, ve, vd, roll, pitch, yaw, u, v, w] = values;
        self.position.push(time, [lat.to_radians(), lon.to_radians(), height]);
        self.velocity.push(time, [vn, ve, vd]);
        self.attitude.push(time, [roll, pitch, yaw].map(f64::to_radians));
        self.body_velocity.push(time, [u, v, w]);
        self.count += 1;
    }
}

fn linear(from: [f64; 3], to: [f64; 3], fraction: f64) -> [f64; 3] {
    std::array::from_fn(|axis| from[axis] + (to[axis] - from[axis]) * fraction)
}

fn wrapped_linear(from_rad: f64, to_rad: f64, fraction: f64) -> f64 {
    wrap_angle(from_rad + wrap_angle(to_rad - from_rad) * fraction)
}

/// Spherical linear interpolation, or linear interpolation of each angle if an angle is unknown.
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
