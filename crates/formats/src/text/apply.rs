//! Reads foreign text files into a dataset with a mapping.

use std::path::Path;

use super::columns::{Fields, Source};
use super::mapping::{Mapping, TableMapping};
use super::table::TableColumns;
use super::together::{self, Gathered};
use crate::onboard::{Onboard, OnboardMoment};
#[cfg(feature = "raw")]
use crate::window::Input;
use hovernav::frames::Rotation;
use hovernav::imu::ImuSample;
use hovernav_dataset::{Dataset, LogError, Manifest, Remarks, Trajectory};

/// Largest number of rows in a file: 2.8 h at 1 kHz.
const MAX_ROWS: u64 = 10_000_000;

/// Reads the files of `mapping`, which is in `directory`, into a dataset with `manifest`.
///
/// # Errors
/// [`LogError`] if a file cannot be read, lacks a column, or has the wrong content in a column.
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
/// As [`dataset`]; [`LogError::Unusable`] if the files contain neither position nor attitude.
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
    let (path, steps) = (directory, &mut mapping.clock());
    let fixes = gathered.fixes.finish(path, steps, &mut remarks)?;
    let (attitudes, _) =
        gathered.attitudes.in_time_order(|row| &mut row.0, path, steps, &mut remarks)?;
    let (onboard, _) =
        gathered.onboard.in_time_order(|row| &mut row.time, path, steps, &mut remarks)?;
    let (imu, _) = gathered.imu.in_time_order(|row| &mut row.time, path, steps, &mut remarks)?;
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
    if table.capture {
        return read_capture(&directory.join(&table.file), table, manifest, gathered, warnings);
    }
    if table.gps.as_ref().is_some_and(|gps| gps.held) {
        gathered.fixes.hold();
    }
    let mut source = Source::open(directory, table)?;
    let path = source.path().to_path_buf();
    let mut columns = TableColumns::of(&source, table, manifest.gps.latency_s)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut remarks = Remarks::new(name);
    let (mut rows, mut unreadable, mut worded) = (0u64, 0u64, 0u64);
    let (mut first_fault, mut first_word) = (None, None);
    while let Some(fields) = source.next()? {
        rows += 1;
        if rows > MAX_ROWS {
            let reason =
                format!("found more than {MAX_ROWS} rows, expected one flight: split the file");
            return Err(LogError::Unusable { path, reason });
        }
        if let Err(fault) = read_row(&fields, &mut columns, gathered, &mut remarks) {
            remarks.count("skipped: a field does not fit its column", fields.line);
            unreadable += 1;
            first_fault.get_or_insert(fault);
        } else if let Some(word) = fields.word() {
            remarks.count("with text in place of a number: read as missing", fields.line);
            worded += 1;
            first_word.get_or_insert(word);
        }
    }
    // If a column contains no number at all, it is the wrong column.
    if let Some(fault) = first_word.filter(|_| worded + unreadable == rows) {
        return Err(fault);
    }
    // A few damaged rows, or a row of units, are accepted; more of them mean a wrong format.
    if let Some(fault) = first_fault.filter(|_| unreadable > 10 && 100 * unreadable > rows) {
        return Err(fault);
    }
    if rows == 0 {
        let reason = "found no rows, expected rows below the names".into();
        return Err(LogError::Unusable { path, reason });
    }
    if let (others @ 1.., Some(instance)) = (source.others(), table.instance) {
        let column = &table.instance_column;
        remarks.say(format!("{others} rows of other sensors than {column} = {instance}: ignored"));
    }
    if let Some((line, bytes)) = source.unwritten() {
        remarks.say(format!(
            "line {line}: {bytes} zero bytes, from storage that was not written: the lines with them are skipped"
        ));
    }
    warnings.extend(remarks.into_warnings());
    Ok(())
}

/// Reads the fixes of a receiver's capture, at their UTC since 1970.
#[cfg(feature = "raw")]
fn read_capture(
    path: &Path,
    table: &TableMapping,
    manifest: &Manifest,
    gathered: &mut Gathered,
    warnings: &mut Vec<String>,
) -> Result<(), LogError> {
    let (assembly, of_capture) = crate::raw::assembled(Input::of(path))?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let zero_s = of_capture.utc_at_zero_ns().unwrap_or_default() as f64 * 1e-9;
    let later_s = zero_s + table.time.offset_s - manifest.gps.latency_s;
    let (fixes, of_fixes, notes) = assembly.into_fixes();
    // Clock steps are those of all sensors together.
    gathered.fixes.append(fixes, later_s);
    let named = |sentence: String| format!("{name}: {sentence}");
    warnings.extend(of_fixes.into_iter().map(named));
    gathered.notes.extend(notes.into_iter().map(named));
    Ok(())
}

#[cfg(not(feature = "raw"))]
fn read_capture(
    path: &Path,
    _: &TableMapping,
    _: &Manifest,
    _: &mut Gathered,
    _: &mut Vec<String>,
) -> Result<(), LogError> {
    let format = "capture of raw bytes".to_owned();
    Err(LogError::MissingFeature { path: path.to_path_buf(), format, feature: "raw" })
}

fn read_row(
    fields: &Fields<'_>,
    columns: &mut TableColumns,
    gathered: &mut Gathered,
    remarks: &mut Remarks,
) -> Result<(), LogError> {
    let line = fields.line;
    let Some(time) = columns.time(fields)? else {
        remarks.count("skipped: no time", line);
        return Ok(());
    };
    let attitude = columns.attitude(fields)?;
    let magnetic = columns.magnetic(fields, remarks)?;
    match columns.motion(fields)? {
        super::table::Motions::Both(motion) => match hovernav_dataset::motion_fault(&motion) {
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
    if let Some(gravity) = columns.gravity(fields)? {
        gathered.gravity.push(line, (time, gravity));
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
    if let Some(fix) = columns.fix(time, fields)? {
        gathered.fixes.push(line, fix, remarks);
    }
    if let Some(velocity_mps) = columns.velocity(fields)? {
        gathered.velocities.push(line, (time, velocity_mps));
    }
    if let Some(height_m) = columns.height(fields, remarks)? {
        gathered.baro.push(line, (time, height_m));
    }
    if let Some(sticks) = columns.sticks(fields, remarks)? {
        gathered.controls.push(line, (time, sticks));
    }
    Ok(())
}
