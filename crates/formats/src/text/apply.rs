//! Reads foreign text files into a dataset with a mapping.

use std::path::Path;

use super::columns::{Fields, Source};
use super::mapping::{Mapping, TableMapping};
use super::table::TableColumns;
use super::together::{self, Gathered};
use crate::onboard::{Onboard, OnboardMoment};
use hovernav::frames::Rotation;
use hovernav::imu::ImuSample;
use hovernav_log::{Dataset, LogError, Manifest, Remarks, Trajectory};

/// Largest number of rows in a file: 2.8 h at 1 kHz.
const MOST_ROWS: u64 = 10_000_000;

/// Reads the files of `mapping`, which is in `directory`, into a dataset with `manifest`.
///
/// # Errors
/// [`LogError`] where a file cannot be read, lacks a column, or has the wrong content in a column.
pub(crate) fn dataset(
    directory: &Path,
    mapping: &Mapping,
    manifest: Manifest,
    mut warnings: Vec<String>,
) -> Result<(Dataset, Option<Onboard>), LogError> {
    let mut gathered = Gathered::default();
    for table in &mapping.table {
        read_table(directory, table, &manifest, &mut gathered, &mut warnings)?;
    }
    together::dataset(directory, mapping, gathered, manifest, warnings)
}

/// Reads the files of `mapping` as a trajectory: positions, velocities, and attitudes of either role.
///
/// # Errors
/// As [`dataset`]; [`LogError::Unusable`] where the files contain neither position nor attitude.
pub(crate) fn trajectory(
    directory: &Path,
    mapping: &Mapping,
    manifest: &Manifest,
    mut warnings: Vec<String>,
) -> Result<Trajectory, LogError> {
    let mut gathered = Gathered::default();
    for table in &mapping.table {
        read_table(directory, table, manifest, &mut gathered, &mut warnings)?;
    }
    let mut remarks = Remarks::new("trajectory");
    let path = directory;
    let (fixes, _) = gathered.fixes.in_time_order(|fix| fix.time, path, &mut remarks)?;
    let (attitudes, _) = gathered.attitudes.in_time_order(|row| row.0, path, &mut remarks)?;
    let (onboard, _) = gathered.onboard.in_time_order(|moment| moment.time, path, &mut remarks)?;
    let (imu, _) = gathered.imu.in_time_order(|sample| sample.time, path, &mut remarks)?;
    let of_unit = imu.iter().filter_map(|sample| Some((sample.time, sample.attitude?)));
    let attitudes = attitudes.into_iter().chain(of_unit);
    let attitudes = attitudes.map(|(time, angles)| (time, Rotation::from_euler(angles)));
    let onboard = onboard.into_iter().filter_map(|one| Some((one.time, one.body_to_ned?)));
    let found = Trajectory::of_parts(&fixes, attitudes.chain(onboard));
    warnings.extend(remarks.into_warnings());
    if found.solutions.is_empty() {
        let reason = "found no position and no attitude, expected at least one of them".to_owned();
        return Err(LogError::Unusable { path: path.to_path_buf(), reason });
    }
    Ok(Trajectory { warnings, ..found })
}

fn read_table(
    directory: &Path,
    table: &TableMapping,
    manifest: &Manifest,
    gathered: &mut Gathered,
    warnings: &mut Vec<String>,
) -> Result<(), LogError> {
    let mut source = Source::open(directory, table)?;
    let path = source.path().to_path_buf();
    let mut columns = TableColumns::of(&source, table, manifest.gps.latency_s)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut remarks = Remarks::new(name);
    let (mut rows, mut unreadable) = (0u64, 0u64);
    let mut first_fault = None;
    while let Some(fields) = source.next()? {
        rows += 1;
        if rows > MOST_ROWS {
            let reason =
                format!("found more than {MOST_ROWS} rows, expected one flight: split the file");
            return Err(LogError::Unusable { path, reason });
        }
        if let Err(fault) = read_row(&fields, &mut columns, gathered, &mut remarks) {
            remarks.count("left out: a field does not fit its column", fields.line);
            unreadable += 1;
            first_fault.get_or_insert(fault);
        }
    }
    // A few damaged rows, or a row of units, are tolerated; more mean a wrong format.
    if let Some(fault) = first_fault.filter(|_| unreadable > 10 && 100 * unreadable > rows) {
        return Err(fault);
    }
    if rows == 0 {
        let reason = "found no rows, expected rows below the names".into();
        return Err(LogError::Unusable { path, reason });
    }
    warnings.extend(remarks.into_warnings());
    Ok(())
}

fn read_row(
    fields: &Fields<'_>,
    columns: &mut TableColumns,
    gathered: &mut Gathered,
    remarks: &mut Remarks,
) -> Result<(), LogError> {
    let line = fields.line;
    let Some(time) = columns.time(fields)? else {
        remarks.count("left out: no time", line);
        return Ok(());
    };
    let attitude = columns.attitude(fields)?;
    let magnetic = columns.magnetic(fields, remarks)?;
    match columns.motion(fields)? {
        super::table::Motions::Both(motion) => match hovernav_log::motion_fault(&motion) {
            Some(why) => remarks.count(why, line),
            None => gathered.imu.push(
                line,
                ImuSample {
                    attitude: attitude.unit.map(|rotation| rotation.euler()),
                    magnetic_field_gauss: magnetic.of_unit,
                    ..ImuSample::new(time, motion)
                },
            ),
        },
        super::table::Motions::Rates(rates) => gathered.rates.push(line, (time, rates)),
        super::table::Motions::Forces(forces) => gathered.forces.push(line, (time, forces)),
        super::table::Motions::Neither => {
            if let Some(attitude) = attitude.unit.filter(|_| !columns.has_motion()) {
                gathered.attitudes.push(line, (time, attitude.euler()));
            }
        }
    }
    if let Some(field) = magnetic.apart {
        gathered.magnetometer.push(line, (time, field));
    }
    if let Some(body_to_ned) = attitude.onboard {
        let moment = OnboardMoment {
            time,
            body_to_ned: Some(body_to_ned),
            velocity_mps: None,
            position: None,
        };
        gathered.onboard.push(line, moment);
    }
    if let Some(fix) = columns.fix(time, fields, remarks)? {
        gathered.fixes.push(line, fix);
    }
    if let Some(height_m) = columns.height(fields, remarks)? {
        gathered.baro.push(line, (time, height_m));
    }
    if let Some(sticks) = columns.sticks(fields, remarks)? {
        gathered.controls.push(line, (time, sticks));
    }
    Ok(())
}
