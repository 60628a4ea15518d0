//! A dataset from arrays, with the same checks as for a log.

use hovernav::frames::EulerAngles;
use hovernav::imu::{ImuSample, Motion};
use hovernav_dataset::columns::{ALTITUDE, ATTITUDE, GPS, INCREMENTS, MAGNETIC, RATES, STICKS};
use hovernav_dataset::{
    ClockSteps, Dataset, FixGate, Remarks, StatedFix, field_fault, motion_fault,
};
use pyo3::prelude::*;

use crate::columns::Columns;
use crate::error::{Error, Result};
use crate::settings::Settings;

/// The tables of `Log.from_arrays`.
pub struct Tables<'a, 'py> {
    pub imu: &'a Bound<'py, PyAny>,
    pub gps: &'a Bound<'py, PyAny>,
    pub baro: Option<&'a Bound<'py, PyAny>>,
    pub magnetometer: Option<&'a Bound<'py, PyAny>>,
    pub controls: Option<&'a Bound<'py, PyAny>>,
}

/// The dataset from `tables`; the inertial samples have the axes `axes`.
pub fn dataset(
    tables: &Tables<'_, '_>,
    axes: &str,
    config: Option<&Bound<'_, PyAny>>,
) -> Result<Dataset> {
    let mut dataset = Dataset::default();
    dataset.manifest.name = "arrays".into();
    let axes = axes.parse().map_err(|why| Error::Config(format!("axes: {why}")))?;
    dataset.imu = samples(tables.imu)?;
    dataset.manifest.imu.axes = axes;
    dataset.normalise_imu();
    fixes(tables.gps, &mut dataset)?;
    if let Some(baro) = tables.baro {
        let columns = Columns::of("baro", baro, &[ALTITUDE])?;
        let heights = columns.one(ALTITUDE)?.ok_or_else(|| columns.missing(ALTITUDE))?;
        for (row, height_m) in heights.iter().enumerate() {
            ensure_finite("baro", row, &[*height_m])?;
        }
        dataset.baro = columns.times.into_iter().zip(heights).collect();
    }
    if let Some(magnetometer) = tables.magnetometer {
        let columns = Columns::of("magnetometer", magnetometer, &with("mag_gauss", &MAGNETIC))?;
        let fields = columns.three("mag_gauss", MAGNETIC)?;
        let fields = fields.ok_or_else(|| columns.missing("mag_gauss"))?;
        for (row, field) in fields.iter().enumerate() {
            reject("magnetometer", row, field_fault(*field))?;
        }
        let fields = fields.into_iter().map(Into::into);
        dataset.magnetometer = columns.times.into_iter().zip(fields).collect();
    }
    if let Some(controls) = tables.controls {
        dataset.controls = sticks(controls)?;
    }
    if let Some(config) = config {
        let settings = Settings::of(config)?;
        dataset.configure_with(&settings.text, settings.name())?;
    }
    Ok(dataset)
}

/// The names of a group and of its columns.
fn with<'a>(group: &'a str, columns: &[&'a str]) -> Vec<&'a str> {
    std::iter::once(group).chain(columns.iter().copied()).collect()
}

/// Returns the error for a `fault` in a row, with the same message as for a log.
fn reject(table: &str, row: usize, fault: Option<&'static str>) -> Result<()> {
    let Some(fault) = fault else { return Ok(()) };
    let fault = ["skipped: ", "rejected: "]
        .iter()
        .find_map(|verb| fault.strip_prefix(verb))
        .unwrap_or(fault);
    Err(Error::Array(format!("{table}: row {row}: {fault}")))
}

fn ensure_finite(table: &str, row: usize, values: &[f64]) -> Result<()> {
    let is_finite = values.iter().all(|value| value.is_finite());
    reject(table, row, (!is_finite).then_some("a value is missing or not finite"))
}

fn samples(table: &Bound<'_, PyAny>) -> Result<Vec<ImuSample>> {
    let groups =
        ["gyro_radps", "accel_mps2", "dtheta_rad", "dvel_mps", "attitude_deg", "mag_gauss"];
    let known = [&groups[..], &RATES, &INCREMENTS, &ATTITUDE, &MAGNETIC].concat();
    let columns = Columns::of("imu", table, &known)?;
    let [gx, gy, gz, ax, ay, az] = RATES;
    let [dx, dy, dz, vx, vy, vz] = INCREMENTS;
    let rates = columns.three("gyro_radps", [gx, gy, gz])?;
    let are_rates = rates.is_some();
    if are_rates && columns.three("dtheta_rad", [dx, dy, dz])?.is_some() {
        return Err(Error::Array("imu: found rates and increments, expected one of both".into()));
    }
    let (turns, pushes, missing) = match rates {
        Some(rates) => (Some(rates), columns.three("accel_mps2", [ax, ay, az])?, "accel_mps2"),
        None => {
            let turns = columns.three("dtheta_rad", [dx, dy, dz])?;
            let missing = if turns.is_some() { "dvel_mps" } else { "gyro_radps" };
            (turns, columns.three("dvel_mps", [vx, vy, vz])?, missing)
        }
    };
    let (Some(turns), Some(pushes)) = (turns, pushes) else {
        return Err(columns.missing(missing));
    };
    let attitudes = columns.three("attitude_deg", ATTITUDE)?;
    let fields = columns.three("mag_gauss", MAGNETIC)?;
    let mut samples = Vec::with_capacity(columns.times.len());
    for (row, time) in columns.times.iter().enumerate() {
        let (turn, push) = (turns[row].into(), pushes[row].into());
        let motion = match are_rates {
            true => Motion::Rates { angular_rate_radps: turn, specific_force_mps2: push },
            false => Motion::Increments { angle_rad: turn, velocity_mps: push },
        };
        reject("imu", row, motion_fault(&motion))?;
        let mut sample = ImuSample::new(*time, motion);
        let is_known = |values: &[f64; 3]| values.iter().all(|value| !value.is_nan());
        sample.attitude = attitudes.as_ref().map(|all| all[row]).filter(is_known).map(
            |[roll_deg, pitch_deg, yaw_deg]| {
                EulerAngles::from_degrees(roll_deg, pitch_deg, yaw_deg)
            },
        );
        let field = fields.as_ref().map(|all| all[row]).filter(is_known);
        reject("imu", row, field.and_then(field_fault))?;
        sample.magnetic_field_gauss = field.map(Into::into);
        samples.push(sample);
    }
    Ok(samples)
}

/// Adds the fixes of `table` to the dataset. A [`FixGate`] decides which rows are fixes.
fn fixes(table: &Bound<'_, PyAny>, dataset: &mut Dataset) -> Result<()> {
    let groups = ["velocity_mps", "position_sigma_m", "velocity_sigma_mps"];
    let columns = Columns::of("gps", table, &[&groups[..], &GPS[1..]].concat())?;
    let [_, lat, lon, height, vn, ve, vd, n, e, d, svn, sve, svd, satellites] = GPS;
    let one = |name| columns.one(name)?.ok_or_else(|| columns.missing(name));
    let (lat, lon, height) = (one(lat)?, one(lon)?, one(height)?);
    let velocity = columns.three(groups[0], [vn, ve, vd])?;
    let position_sigma = columns.three(groups[1], [n, e, d])?;
    let velocity_sigma = columns.three(groups[2], [svn, sve, svd])?;
    let satellites = columns.one(satellites)?;
    let (mut gate, mut remarks) = (FixGate::default(), Remarks::new("gps"));
    for (row, time) in columns.times.iter().enumerate() {
        let of = |all: &Option<Vec<[f64; 3]>>| all.as_ref().map_or([f64::NAN; 3], |all| all[row]);
        let stated = StatedFix {
            velocity_mps: of(&velocity),
            position_sigma_m: of(&position_sigma),
            velocity_sigma_mps: of(&velocity_sigma),
            satellites: satellites.as_ref().map_or(f64::NAN, |all| all[row]),
            ..StatedFix::at(Some(*time), [lat[row], lon[row], height[row]])
        };
        gate.push(row as u64, stated, &mut remarks);
    }
    dataset.fixes = gate.finish("gps".as_ref(), &mut ClockSteps::default(), &mut remarks)?;
    dataset.warnings.extend(remarks.into_warnings());
    Ok(())
}

fn sticks(table: &Bound<'_, PyAny>) -> Result<Vec<(hovernav::time::Time, [f64; 4])>> {
    let columns = Columns::of("controls", table, &STICKS)?;
    let mut rows: Vec<_> = columns.times.iter().map(|time| (*time, [0.0; 4])).collect();
    for (stick, name) in STICKS.iter().enumerate() {
        let values = columns.one(name)?.ok_or_else(|| columns.missing(name))?;
        for (row, value) in values.into_iter().enumerate() {
            ensure_finite("controls", row, &[value])?;
            rows[row].1[stick] = value;
        }
    }
    Ok(rows)
}
