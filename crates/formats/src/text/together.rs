//! Combines the values of several files into one dataset.

use std::fmt::Debug;
use std::path::{Path, PathBuf};

use super::mapping::{MAPPING_FILE, Mapping, TableMapping};
use crate::onboard::{Onboard, OnboardMoment};
use hovernav::frames::{Body, EulerAngles, Vector};
use hovernav::gps::Fix;
use hovernav::imu::{ImuSample, Motion};
use hovernav::time::Time;
use hovernav_dataset::{
    ClockSteps, Dataset, FixGate, Join, LogError, Manifest, Remarks, Rows, motion_fault,
};

/// The values that have been read, by sensor and in file order.
#[derive(Default)]
pub(crate) struct Gathered {
    pub imu: Rows<ImuSample>,
    /// Angular rate, rad/s, from a file without specific force.
    pub rates: Rows<(Time, [f64; 3])>,
    /// Specific force, m/s², from a file without angular rates.
    pub forces: Rows<(Time, [f64; 3])>,
    /// Gravity, m/s², which is added to an acceleration without it.
    pub gravity: Rows<(Time, [f64; 3])>,
    /// The IMU's attitude from a file without angular rates.
    pub attitudes: Rows<(Time, EulerAngles)>,
    pub fixes: FixGate,
    /// Velocity north, east and down, m/s, from a file without positions.
    pub velocities: Rows<(Time, [f64; 3])>,
    pub baro: Rows<(Time, f64)>,
    pub magnetometer: Rows<(Time, Vector<Body>)>,
    pub controls: Rows<(Time, [f64; 4])>,
    pub onboard: Rows<OnboardMoment>,
    /// Choices and assumptions during reading.
    pub notes: Vec<String>,
}

/// The dataset of the values `gathered` from the files of `mapping`, which is in `directory`.
pub(crate) fn dataset(
    directory: &Path,
    mapping: &Mapping,
    gathered: Gathered,
    manifest: Manifest,
    mut warnings: Vec<String>,
) -> Result<(Dataset, Option<Onboard>), LogError> {
    let of = |sensor: &str, has: fn(&TableMapping) -> bool| {
        let table = mapping.table.iter().find(|table| has(table));
        let file = table.map_or(Path::new(MAPPING_FILE), |table| &table.file);
        Ordering { path: directory.join(file), remarks: Remarks::new(sensor) }
    };
    let steps = &mut mapping.clock();
    let gyro = |table: &TableMapping| table.gyro.is_some();
    let imu = of("imu", gyro);
    let mut imu = imu.joined(gathered.imu, steps, &mut warnings)?;
    let rates = of("gyro", gyro).joined(gathered.rates, steps, &mut warnings)?;
    let accel = of("accel", |table| table.accel.is_some());
    let mut forces = accel.joined(gathered.forces, steps, &mut warnings)?;
    let gravity = of("gravity", |table| table.gravity.is_some());
    let gravity = gravity.joined(gathered.gravity, steps, &mut warnings)?;
    if !gravity.is_empty() {
        forces.retain_mut(|(time, force)| {
            let gravity = interpolated(&gravity, *time);
            *force = std::array::from_fn(|axis| force[axis] + gravity.map_or(0.0, |g| g[axis]));
            gravity.is_some()
        });
    }
    let attitude = |table: &TableMapping| table.attitude.is_some();
    let attitudes = of("attitude", attitude);
    let attitudes =
        attitudes.ordered(gathered.attitudes, |row| &mut row.0, steps, &mut warnings)?;
    if imu.is_empty() {
        imu = joined(&rates, &forces, &mut warnings);
    }
    attach(&mut imu, &attitudes);
    let moments = of("onboard", attitude);
    let moments = moments.ordered(gathered.onboard, |row| &mut row.time, steps, &mut warnings)?;
    let onboard = (!moments.is_empty()).then(|| Onboard {
        name: "attitude on board".into(),
        moments,
        innovations: Vec::new(),
    });
    let mut receiver = of("gps", |table| table.gps.is_some());
    let mut fixes = gathered.fixes.finish(&receiver.path, steps, &mut receiver.remarks)?;
    let velocity = of("velocity", |table| table.velocity.is_some());
    let velocities = velocity.joined(gathered.velocities, steps, &mut warnings)?;
    let latency_s = manifest.gps.latency_s;
    attach_velocities(&mut fixes, &velocities, latency_s);
    warnings.extend(receiver.remarks.into_warnings());
    let baro = of("baro", |table| table.baro.is_some());
    let magnetometer = of("mag", |table| table.mag.is_some());
    let controls = of("controls", |table| table.controls.is_some());
    let dataset = Dataset {
        imu,
        fixes,
        baro: baro.ordered(gathered.baro, |row| &mut row.0, steps, &mut warnings)?,
        magnetometer: magnetometer.ordered(
            gathered.magnetometer,
            |row| &mut row.0,
            steps,
            &mut warnings,
        )?,
        controls: controls.ordered(gathered.controls, |row| &mut row.0, steps, &mut warnings)?,
        manifest,
        warnings,
        notes: gathered.notes,
        ..Dataset::default()
    };
    Ok((dataset, onboard))
}

/// Sorter of the rows of one sensor, with its file and remarks.
struct Ordering {
    path: PathBuf,
    remarks: Remarks,
}

impl Ordering {
    /// Combines rows of equal time, then sorts.
    fn joined<T: Join + Debug>(
        mut self,
        rows: Rows<T>,
        steps: &mut ClockSteps,
        warnings: &mut Vec<String>,
    ) -> Result<Vec<T>, LogError> {
        let rows = rows.together(&mut self.remarks);
        self.ordered(rows, Join::time_mut, steps, warnings)
    }

    fn ordered<T: Debug>(
        mut self,
        rows: Rows<T>,
        time: impl Fn(&mut T) -> &mut Time,
        steps: &mut ClockSteps,
        warnings: &mut Vec<String>,
    ) -> Result<Vec<T>, LogError> {
        let (rows, _) = rows.in_time_order(time, &self.path, steps, &mut self.remarks)?;
        warnings.extend(self.remarks.into_warnings());
        Ok(rows)
    }
}

/// The vector of `rows` at `time`, interpolated between its neighbours; `None` in a gap.
fn interpolated(rows: &[(Time, [f64; 3])], time: Time) -> Option<[f64; 3]> {
    /// Longest interval over which a vector is interpolated, s.
    const LONGEST_S: f64 = 0.2;
    let after = rows.partition_point(|row| row.0 < time);
    match (after.checked_sub(1).and_then(|before| rows.get(before)), rows.get(after)) {
        (_, Some((at, vector))) if *at == time => Some(*vector),
        (Some((t0, v0)), Some((t1, v1))) if *t1 - *t0 <= LONGEST_S => {
            let share = (time - *t0) / (*t1 - *t0);
            Some(std::array::from_fn(|axis| v0[axis] + share * (v1[axis] - v0[axis])))
        }
        _ => None,
    }
}

/// Inertial samples at the times of `rates`; the specific force is interpolated between its neighbours.
fn joined(
    rates: &[(Time, [f64; 3])],
    forces: &[(Time, [f64; 3])],
    warnings: &mut Vec<String>,
) -> Vec<ImuSample> {
    let mut samples = Vec::with_capacity(rates.len());
    let mut without = 0usize;
    for &(time, rate) in rates {
        let force = interpolated(forces, time);
        let sample = force.map(|force| {
            let motion = Motion::Rates {
                angular_rate_radps: Vector::from(rate),
                specific_force_mps2: Vector::from(force),
            };
            ImuSample::new(time, motion)
        });
        match sample.filter(|sample| motion_fault(&sample.motion).is_none()) {
            Some(sample) => samples.push(sample),
            None => without += 1,
        }
    }
    if !samples.is_empty() {
        warnings.push(
            "accel: interpolated to the times of the gyro, because they are in two files".into(),
        );
    }
    if without > 0 && !forces.is_empty() {
        warnings.push(format!(
            "gyro: {without} rows skipped: no valid specific force at their \
                               time"
        ));
    }
    samples
}

/// Assigns to each fix without a velocity the nearest one. The fixes are `latency_s` earlier than their rows.
fn attach_velocities(fixes: &mut [Fix], velocities: &[(Time, [f64; 3])], latency_s: f64) {
    /// Largest time from a velocity to its fix, s.
    const FARTHEST_S: f64 = 0.06;
    for fix in fixes.iter_mut().filter(|fix| fix.horizontal_velocity_mps.is_none()) {
        let time = fix.time.offset_by(latency_s);
        let after = velocities.partition_point(|row| row.0 < time);
        let near = [after.checked_sub(1), Some(after)].into_iter().flatten();
        let near = near.filter_map(|at| velocities.get(at));
        let away_s = |row: &&(Time, [f64; 3])| (row.0 - time).abs();
        let nearest = near.min_by(|a, b| away_s(a).total_cmp(&away_s(b)));
        if let Some((_, [north, east, down])) = nearest.filter(|row| away_s(row) <= FARTHEST_S) {
            fix.horizontal_velocity_mps = Some([*north, *east]);
            fix.down_velocity_mps = Some(*down);
        }
    }
}

/// Assigns each attitude to the nearest inertial sample.
fn attach(imu: &mut [ImuSample], attitudes: &[(Time, EulerAngles)]) {
    /// Largest time from an attitude to its sample, s.
    const FARTHEST_S: f64 = 0.02;
    for &(time, attitude) in attitudes {
        let after = imu.partition_point(|sample| sample.time < time);
        let distance = |index: usize| imu.get(index).map(|s| ((s.time - time).abs(), index));
        let nearest = [after.checked_sub(1).and_then(distance), distance(after)];
        let nearest = nearest.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, index)) = nearest.filter(|(away_s, _)| *away_s <= FARTHEST_S) {
            imu[index].attitude = Some(attitude);
        }
    }
}
