//! What was read from several files, put together on one clock.

use std::path::Path;

use super::apply::Gathered;
use crate::onboard::Onboard;
use hovernav::frames::{EulerAngles, Vector};
use hovernav::imu::{ImuSample, Motion};
use hovernav::time::Time;
use hovernav_log::{Dataset, LogError, Manifest, Remarks, Rows, motion_fault};

/// The dataset of what was `gathered` from files in `directory`.
pub(crate) fn dataset(
    directory: &Path,
    gathered: Gathered,
    manifest: Manifest,
    mut warnings: Vec<String>,
) -> Result<(Dataset, Option<Onboard>), LogError> {
    let remarks = |sensor: &str| Ordering { directory, remarks: Remarks::new(sensor) };
    let mut imu = remarks("imu").ordered(gathered.imu, |sample| sample.time, &mut warnings)?;
    let rates = remarks("gyro").ordered(gathered.rates, |row| row.0, &mut warnings)?;
    let forces = remarks("accel").ordered(gathered.forces, |row| row.0, &mut warnings)?;
    let attitudes = remarks("attitude").ordered(gathered.attitudes, |row| row.0, &mut warnings)?;
    if imu.is_empty() {
        imu = joined(&rates, &forces, &mut warnings);
    }
    attach(&mut imu, &attitudes);
    let moments = remarks("onboard").ordered(gathered.onboard, |row| row.time, &mut warnings)?;
    let onboard = (!moments.is_empty()).then(|| Onboard {
        name: "attitude on board".into(),
        moments,
        innovations: Vec::new(),
    });
    let dataset = Dataset {
        imu,
        fixes: remarks("gps").ordered(gathered.fixes, |fix| fix.time, &mut warnings)?,
        baro: remarks("baro").ordered(gathered.baro, |row| row.0, &mut warnings)?,
        magnetometer: remarks("mag").ordered(gathered.magnetometer, |row| row.0, &mut warnings)?,
        controls: remarks("controls").ordered(gathered.controls, |row| row.0, &mut warnings)?,
        manifest,
        headings: Vec::new(),
        ranges: Vec::new(),
        rotor: Vec::new(),
        injected: Vec::new(),
        order: Vec::new(),
        warnings,
        notes: Vec::new(),
    };
    Ok((dataset, onboard))
}

struct Ordering<'a> {
    directory: &'a Path,
    remarks: Remarks,
}

impl Ordering<'_> {
    fn ordered<T>(
        mut self,
        rows: Rows<T>,
        time: impl Fn(&T) -> Time,
        warnings: &mut Vec<String>,
    ) -> Result<Vec<T>, LogError> {
        let (rows, _) = rows.in_time_order(time, self.directory, &mut self.remarks)?;
        warnings.extend(self.remarks.into_warnings());
        Ok(rows)
    }
}

/// Inertial samples at the times of `rates`, with the specific force between the two samples around.
fn joined(
    rates: &[(Time, [f64; 3])],
    forces: &[(Time, [f64; 3])],
    warnings: &mut Vec<String>,
) -> Vec<ImuSample> {
    /// Forces further apart than this are not interpolated, s.
    const LONGEST_S: f64 = 0.2;
    let mut samples = Vec::with_capacity(rates.len());
    let mut without = 0usize;
    for &(time, rate) in rates {
        let after = forces.partition_point(|force| force.0 < time);
        let force = match (after.checked_sub(1).and_then(|i| forces.get(i)), forces.get(after)) {
            (_, Some((at, force))) if *at == time => Some(*force),
            (Some((t0, f0)), Some((t1, f1))) if *t1 - *t0 <= LONGEST_S => {
                let share = (time - *t0) / (*t1 - *t0);
                Some(std::array::from_fn(|axis| f0[axis] + share * (f1[axis] - f0[axis])))
            }
            _ => None,
        };
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
        warnings.push("accel: interpolated to the times of gyro, as they come in two files".into());
    }
    if without > 0 && !forces.is_empty() {
        warnings.push(format!("gyro: {without} rows left out: no specific force around them"));
    }
    samples
}

/// Gives each attitude to the inertial sample next to it.
fn attach(imu: &mut [ImuSample], attitudes: &[(Time, EulerAngles)]) {
    /// No attitude is given to a sample further away than this, s.
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
