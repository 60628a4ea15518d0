//! Writing of a dataset to a directory, for the simulator and for conversion.

use std::path::Path;

use crate::dataset::Dataset;
use crate::error::LogError;
use crate::manifest::MANIFEST_FILE;
use crate::reference;
use crate::reference::truth::Truth;
use crate::sensors::controls::{self, ControlFile};
use crate::sensors::{aids, auxiliary, gps, imu};
use crate::table::TIME;
use crate::table::csv_writer::CsvWriter;
use hovernav::earth::Geodetic;
use hovernav::frames::{EulerAngles, Vector};
use hovernav::imu::Motion;
use hovernav_toml::write_whole;

impl Dataset {
    /// Writes this dataset to the directory `dir`, which is created if necessary. Also writes the true motion if
    /// `reference` is not empty.
    ///
    /// Numbers have the fewest digits that read back as the same number, and times have nanoseconds. Values that were
    /// in degrees read back to within rounding. Tables of an earlier dataset in `dir` that this one does not have are
    /// emptied.
    ///
    /// # Errors
    /// [`LogError::Io`]; [`LogError::Unwritable`] for a number that is not finite; [`LogError::Unusable`] for inertial
    /// samples of both kinds, or a manifest that TOML cannot hold.
    pub fn write(&self, dir: &Path, reference: &[Truth]) -> Result<(), LogError> {
        std::fs::create_dir_all(dir).map_err(LogError::io(dir))?;
        let path = dir.join(MANIFEST_FILE);
        let manifest = hovernav_toml::to_string(&self.manifest).map_err(|error| {
            LogError::Unusable { path: path.clone(), reason: error.to_string() }
        })?;
        write_whole(&path, manifest).map_err(LogError::io(&path))?;
        self.write_imu(dir)?;
        self.write_fixes(dir)?;
        self.write_baro(dir)?;
        self.write_magnetometer(dir)?;
        self.write_aids(dir)?;
        self.write_controls(dir)?;
        write_reference(dir, reference)
    }

    fn write_imu(&self, dir: &Path) -> Result<(), LogError> {
        let are_rates =
            self.samples().next().is_none_or(|first| matches!(first.motion, Motion::Rates { .. }));
        let has_attitude = self.samples().any(|sample| sample.attitude.is_some());
        let has_magnetic = self.has_magnetic_samples();
        let has_marks = self.samples().any(|sample| sample.clipped.any());
        let mut columns = vec![TIME];
        columns.extend(if are_rates { imu::RATES } else { imu::INCREMENTS });
        columns.extend(imu::ATTITUDE.iter().filter(|_| has_attitude));
        columns.extend(imu::MAGNETIC.iter().filter(|_| has_magnetic));
        columns.extend(imu::CLIPPED.iter().flatten().filter(|_| has_marks));
        let path = dir.join(imu::FILE);
        // A dataset of a receiver alone has no imu.csv.
        if self.sample_count() == 0 && !self.fixes.is_empty() && !path.exists() {
            return Ok(());
        }
        let mut csv = CsvWriter::new(path.clone(), &columns);
        for sample in self.samples() {
            csv.time(sample.time);
            let (gyro, accel) = match sample.motion {
                Motion::Rates { angular_rate_radps, specific_force_mps2 } if are_rates => {
                    (angular_rate_radps, specific_force_mps2)
                }
                Motion::Increments { angle_rad, velocity_mps } if !are_rates => {
                    (angle_rad, velocity_mps)
                }
                _ => {
                    let reason = "found samples of rates and of increments, expected one kind";
                    return Err(LogError::Unusable { path, reason: reason.into() });
                }
            };
            csv.shortest_or_empty(Some(gyro.to_array()))?;
            csv.shortest_or_empty(Some(accel.to_array()))?;
            if has_attitude {
                csv.shortest_or_empty(sample.attitude.map(EulerAngles::to_degrees))?;
            }
            if has_magnetic {
                csv.shortest_or_empty(sample.magnetic_field_gauss.map(Vector::to_array))?;
            }
            if has_marks {
                let marks = [sample.clipped.gyro, sample.clipped.accel];
                for mark in marks.into_iter().flatten() {
                    csv.fixed(f64::from(u8::from(mark)), 0)?;
                }
            }
            csv.end_row();
        }
        csv.finish()?;
        self.ensure_read()
    }

    fn write_fixes(&self, dir: &Path) -> Result<(), LogError> {
        let mut columns = vec![TIME];
        columns.extend(gps::POSITION);
        columns.extend(gps::VELOCITY);
        columns.extend(gps::POSITION_SIGMA);
        columns.extend(gps::VELOCITY_SIGMA);
        columns.push(gps::SATELLITES);
        write_table(dir, gps::FILE, &columns, &self.fixes, |csv, fix| {
            csv.time(fix.time.offset_by(self.manifest.gps.latency_s));
            let [latitude, longitude, height] = position_fields(&fix.position);
            csv.shortest_or_empty(Some([latitude, longitude]))?;
            csv.shortest_or_empty((!fix.two_dimensional).then_some([height]))?;
            csv.shortest_or_empty(fix.horizontal_velocity_mps)?;
            csv.shortest_or_empty(fix.down_velocity_mps.map(|down| [down]))?;
            csv.shortest_or_empty(fix.position_sigma_m.map(Vector::to_array))?;
            csv.shortest_or_empty(fix.velocity_sigma_mps.map(Vector::to_array))?;
            match fix.satellites {
                Some(count) => csv.fixed(f64::from(count), 0),
                None => csv.shortest_or_empty::<1>(None),
            }
        })
    }

    fn write_baro(&self, dir: &Path) -> Result<(), LogError> {
        let columns = [TIME, auxiliary::ALTITUDE];
        write_table(dir, auxiliary::BARO_FILE, &columns, &self.baro, |csv, (time, altitude_m)| {
            csv.time(*time);
            csv.shortest_or_empty(Some([*altitude_m]))
        })
    }

    fn write_magnetometer(&self, dir: &Path) -> Result<(), LogError> {
        let mut columns = vec![TIME];
        columns.extend(imu::MAGNETIC);
        write_table(dir, auxiliary::MAG_FILE, &columns, &self.magnetometer, |csv, (time, field)| {
            csv.time(*time);
            csv.shortest_or_empty(Some(field.to_array()))
        })
    }

    fn write_aids(&self, dir: &Path) -> Result<(), LogError> {
        let columns = [TIME, "range_m", "sigma_m", "quality"];
        write_table(dir, aids::RANGE_FILE, &columns, &self.ranges, |csv, reading| {
            csv.time(reading.time);
            csv.shortest_or_empty(Some([reading.range_m]))?;
            csv.shortest_or_empty(reading.sigma_m.map(|sigma_m| [sigma_m]))?;
            csv.shortest_or_empty(reading.quality.map(|quality| [quality]))
        })?;
        let columns = [TIME, "heading_deg", "sigma_deg", "length_m"];
        write_table(dir, aids::HEADING_FILE, &columns, &self.headings, |csv, heading| {
            csv.time(heading.time);
            csv.shortest_or_empty(Some([heading.heading_rad.to_degrees()]))?;
            csv.shortest_or_empty(heading.sigma_rad.map(|sigma_rad| [sigma_rad.to_degrees()]))?;
            csv.shortest_or_empty(heading.length_m.map(|length_m| [length_m]))
        })?;
        write_table(
            dir,
            aids::ROTOR_FILE,
            &[TIME, "rotor_hz"],
            &self.rotor,
            |csv, (time, rotor_hz)| {
                csv.time(*time);
                csv.shortest_or_empty(Some([*rotor_hz]))
            },
        )
    }

    fn write_controls(&self, dir: &Path) -> Result<(), LogError> {
        let whole = self.controls_file.as_ref().map(ControlFile::whole).transpose()?;
        let (sticks, injected) = match &whole {
            Some(whole) => (&whole.sticks, &whole.injected),
            None => (&self.controls, &self.injected),
        };
        let mut columns = vec![TIME];
        columns.extend(controls::STICKS);
        if injected.len() != sticks.len() || sticks.is_empty() {
            return write_table(dir, controls::FILE, &columns, sticks, |csv, (time, sticks)| {
                csv.time(*time);
                csv.shortest_or_empty(Some(*sticks))
            });
        }
        columns.extend(controls::INJECTED);
        let rows: Vec<_> = sticks.iter().zip(injected).collect();
        write_table(dir, controls::FILE, &columns, &rows, |csv, ((time, sticks), injected)| {
            csv.time(*time);
            csv.shortest_or_empty(Some(*sticks))?;
            csv.shortest_or_empty(Some(**injected))
        })
    }
}

fn write_reference(dir: &Path, samples: &[Truth]) -> Result<(), LogError> {
    write_table(dir, reference::FILE, reference::COLUMNS, samples, |csv, sample| {
        let Truth { time, position, velocity_mps, body_to_ned, angular_rate_radps } = *sample;
        csv.time(time);
        csv.shortest_or_empty(Some(position_fields(&position)))?;
        csv.shortest_or_empty(Some(velocity_mps.to_array()))?;
        csv.shortest_or_empty(Some(body_to_ned.euler().to_degrees()))?;
        csv.shortest_or_empty(Some((body_to_ned.inverse() * velocity_mps).to_array()))?;
        csv.shortest_or_empty(Some(angular_rate_radps.to_array()))
    })
}

fn position_fields(position: &Geodetic) -> [f64; 3] {
    [position.latitude_deg(), position.longitude_deg(), position.height_m]
}

/// Writes `rows` to `file` if there are any, or if an earlier file must be replaced.
fn write_table<T>(
    dir: &Path,
    file: &str,
    columns: &[&'static str],
    rows: &[T],
    write_row: impl Fn(&mut CsvWriter, &T) -> Result<(), LogError>,
) -> Result<(), LogError> {
    let path = dir.join(file);
    if rows.is_empty() && !path.exists() {
        return Ok(());
    }
    let mut csv = CsvWriter::new(path, columns);
    for row in rows {
        write_row(&mut csv, row)?;
        csv.end_row();
    }
    csv.finish()
}
