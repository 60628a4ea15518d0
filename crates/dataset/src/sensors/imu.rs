//! `imu.csv`: the inertial unit.

use std::path::Path;

use crate::clock::Gaps;
use crate::clock::batch::Batch;
use crate::clock::ordered::TimedRows;
use crate::error::LogError;
use crate::manifest::axes::Reading;
use crate::table::records::Place;
use crate::table::remarks::Remarks;
use crate::table::{Row, TIME, Table};
use hovernav::frames::{EulerAngles, Vector, wrap_angle};
use hovernav::imu::{ImuAxes, ImuSample, Motion};
use hovernav::time::Time;

pub(crate) const FILE: &str = "imu.csv";
/// Columns of `imu.csv` with angular rates, rad/s, and specific forces, m/s².
pub const RATES: [&str; 6] = [
    "gyro_x_radps",
    "gyro_y_radps",
    "gyro_z_radps",
    "accel_x_mps2",
    "accel_y_mps2",
    "accel_z_mps2",
];
/// Columns of `imu.csv` with rotation, rad, and change of velocity, m/s, since the previous sample.
pub const INCREMENTS: [&str; 6] =
    ["dtheta_x_rad", "dtheta_y_rad", "dtheta_z_rad", "dvel_x_mps", "dvel_y_mps", "dvel_z_mps"];
/// Columns of the inertial unit's own attitude, °.
pub const ATTITUDE: [&str; 3] = ["roll_deg", "pitch_deg", "yaw_deg"];
/// Columns with the number of raw readings at full scale since the previous sample, for each gyro and accelerometer.
pub(crate) const CLIPPED: [[&str; 3]; 2] = [
    ["gyro_x_clipped", "gyro_y_clipped", "gyro_z_clipped"],
    ["accel_x_clipped", "accel_y_clipped", "accel_z_clipped"],
];
/// Columns of the magnetic field, gauss.
pub const MAGNETIC: [&str; 3] = ["mag_x_gauss", "mag_y_gauss", "mag_z_gauss"];

/// Largest plausible turn rate, rad/s.
const FASTEST_TURN_RADPS: f64 = 100.0;
/// Largest plausible specific force, m/s².
const HARDEST_PUSH_MPS2: f64 = 1000.0;
/// Longest interval of increments, s, that scales [`FASTEST_TURN_RADPS`] and [`HARDEST_PUSH_MPS2`].
const LONGEST_INTERVAL_S: f64 = 1.0;
/// Largest plausible field, gauss (the Earth's is below 0.7).
const STRONGEST_FIELD_GAUSS: f64 = 100.0;
/// The Earth's field in milligauss, with room for iron nearby.
const FIELD_MILLIGAUSS: std::ops::Range<f64> = 150.0..1500.0;
/// The Earth's field in nanotesla, with room for iron nearby.
const FIELD_NANOTESLA: std::ops::Range<f64> = 15_000.0..150_000.0;

/// Smallest number of rows, equal to the last bit, at which the inertial unit is stuck.
const STUCK_ROWS: usize = 10;
/// Shortest duration of such rows, s.
const STUCK_S: f64 = 0.2;

/// Number of gaps that are listed; further ones are only counted.
const GAPS_NAMED: usize = 8;

/// Reader of the rows of `imu.csv`; rows of one time are merged.
pub(crate) struct ImuRows {
    table: Table,
    columns: Columns,
    /// Offset and line at which the sample that was returned last begins.
    place: Place,
    /// First row of the next sample, with its offset and line, if already read.
    ahead: Option<(Place, u64, ImuSample)>,
    /// Defects of the rows read.
    pub remarks: Remarks,
}

impl ImuRows {
    /// Opens `imu.csv` of `dir`, whose samples are converted by `reading`.
    pub fn open(dir: &Path, reading: Reading) -> Result<Self, LogError> {
        let mut table = Table::open(dir, FILE)?.ok_or_else(|| LogError::Unusable {
            path: dir.join(FILE),
            reason: "no such file, and a dataset needs it".into(),
        })?;
        let mut remarks = Remarks::new(FILE);
        let columns = Columns::of(&mut table, reading, &mut remarks)?;
        let place = table.place();
        Ok(Self { table, columns, place, ahead: None, remarks })
    }

    /// Offset and line at which the sample that was returned last begins.
    pub fn place(&self) -> Place {
        self.place
    }

    /// Continues after the sample that begins at `place`.
    pub fn resume(&mut self, place: Place) -> Result<(), LogError> {
        self.table.resume(place)?;
        self.ahead = None;
        self.next().map(drop)
    }

    /// The next row with a sample, with its offset and line.
    fn row(&mut self) -> Result<Option<(Place, u64, ImuSample)>, LogError> {
        while let Some(row) = self.table.next(&mut self.remarks)? {
            let line = row.line;
            match self.columns.sample(&row)? {
                Ok((sample, field)) => {
                    if let Err(why) = field {
                        self.remarks.count(why, line);
                    }
                    return Ok(Some((self.table.place(), line, sample)));
                }
                Err(why) => self.remarks.count(why, line),
            }
        }
        Ok(None)
    }
}

impl TimedRows for ImuRows {
    type Row = ImuSample;

    fn next(&mut self) -> Result<Option<(u64, ImuSample)>, LogError> {
        let first = match self.ahead.take() {
            Some(ahead) => Some(ahead),
            None => self.row()?,
        };
        let Some((place, line, sample)) = first else { return Ok(None) };
        self.place = place;
        let mut batch = Batch::new(line, sample);
        while let Some((place, line, sample)) = self.row()? {
            if let Some((line, sample)) = batch.push(line, sample, &mut self.remarks) {
                self.ahead = Some((place, line, sample));
                break;
            }
        }
        Ok(Some(batch.row()))
    }

    fn time(sample: &mut ImuSample) -> &mut Time {
        &mut sample.time
    }

    fn path(&self) -> &Path {
        self.table.path()
    }

    fn remarks(&mut self) -> &mut Remarks {
        &mut self.remarks
    }
}

/// A sample, and the reason to reject its magnetic field, if there is one.
type WithField = (ImuSample, Result<(), &'static str>);

/// Columns of the quantities in the table.
struct Columns {
    time: usize,
    motion: [usize; 6],
    are_rates: bool,
    attitude: Option<[usize; 3]>,
    magnetic: Option<[usize; 3]>,
    clipped: [Option<[usize; 3]>; 2],
    reading: Reading,
}

impl Columns {
    fn of(table: &mut Table, reading: Reading, remarks: &mut Remarks) -> Result<Self, LogError> {
        let [time] = table.require([TIME])?;
        let (motion, are_rates) = match (table.find(RATES), table.find(INCREMENTS)) {
            (Some(rates), increments) => {
                if increments.is_some() {
                    remarks.say("found rates and increments: the rates are used".into());
                }
                (rates, true)
            }
            (None, Some(increments)) => (increments, false),
            (None, None) => {
                let expected = format!("{}, or {}", RATES.join(","), INCREMENTS.join(","));
                return Err(table.columns_missing(&expected));
            }
        };
        let (attitude, magnetic) = (table.find(ATTITUDE), table.find(MAGNETIC));
        let clipped = CLIPPED.map(|columns| table.find(columns));
        table.remark_unused(&["temp_degc"], remarks);
        Ok(Self { time, motion, are_rates, attitude, magnetic, clipped, reading })
    }

    /// The sample in `row`, or the reason to skip it.
    fn sample(&self, row: &Row<'_>) -> Result<Result<WithField, &'static str>, LogError> {
        let time = row.time(self.time)?;
        let [p, q, r, x, y, z] = row.numbers(self.motion)?;
        let attitude = row.finite(self.attitude)?;
        let magnetic = row.finite(self.magnetic)?;
        let [gyro, accel] = self.clipped;
        let marks = |columns| row.finite(columns).map(|counts| counts.unwrap_or_default());
        let clipped = ImuAxes {
            gyro: marks(gyro)?.map(|count| count > 0.0),
            accel: marks(accel)?.map(|count| count > 0.0),
        };
        let clipped = self.reading.marks(clipped);
        let Some(time) = time else { return Ok(Err("skipped: no time")) };
        let (gyro, accel) = (Vector::new(p, q, r), Vector::new(x, y, z));
        let motion = match self.are_rates {
            true => Motion::Rates { angular_rate_radps: gyro, specific_force_mps2: accel },
            false => Motion::Increments { angle_rad: gyro, velocity_mps: accel },
        };
        let motion = self.reading.motion(motion);
        if let Some(why) = motion_fault(&motion) {
            return Ok(Err(why));
        }
        let attitude =
            attitude.filter(|angles| is_within(*angles, 360.0) && angles[1].abs() <= 90.0);
        let attitude = attitude.map(|[roll, pitch, yaw]| EulerAngles {
            roll_rad: wrap_angle(roll.to_radians()),
            pitch_rad: pitch.to_radians(),
            yaw_rad: wrap_angle(yaw.to_radians()),
        });
        let attitude = attitude.map(|attitude| self.reading.attitude(attitude));
        let fault = magnetic.and_then(field_fault);
        let magnetic = magnetic.filter(|_| fault.is_none());
        let magnetic_field_gauss = magnetic.map(|field| self.reading.field(field.into()));
        let sample = ImuSample { time, motion, attitude, magnetic_field_gauss, clipped };
        Ok(Ok((sample, fault.map_or(Ok(()), Err))))
    }
}

/// Reason to reject a magnetic field given in gauss, with its likely unit; `None` if the field is plausible.
#[must_use]
pub fn field_fault(field_gauss: [f64; 3]) -> Option<&'static str> {
    if is_within(field_gauss, STRONGEST_FIELD_GAUSS) {
        return None;
    }
    if !field_gauss.iter().all(|component| component.is_finite()) {
        return Some("magnetic field rejected: it is not a number");
    }
    let [x, y, z] = field_gauss;
    let strength = x.hypot(y).hypot(z);
    Some(if FIELD_MILLIGAUSS.contains(&strength) {
        "magnetic field rejected: over 100 gauss, as the Earth's field in milligauss is; divide by 1000"
    } else if FIELD_NANOTESLA.contains(&strength) {
        "magnetic field rejected: over 100 gauss, as the Earth's field in nT is; divide by 100 000"
    } else {
        "magnetic field rejected: over 100 gauss, stronger than any field of the Earth"
    })
}

/// Reason to skip or reject an inertial sample with this motion, in any log; `None` if it is plausible.
#[must_use]
pub fn motion_fault(motion: &Motion) -> Option<&'static str> {
    let (gyro, accel, scale) = match *motion {
        Motion::Rates { angular_rate_radps, specific_force_mps2 } => {
            (angular_rate_radps.to_array(), specific_force_mps2.to_array(), 1.0)
        }
        Motion::Increments { angle_rad, velocity_mps } => {
            (angle_rad.to_array(), velocity_mps.to_array(), LONGEST_INTERVAL_S)
        }
    };
    if gyro.iter().chain(&accel).any(|value| value.is_nan()) {
        return Some("skipped: a value is missing");
    }
    if !is_within(gyro, scale * FASTEST_TURN_RADPS) || !is_within(accel, scale * HARDEST_PUSH_MPS2)
    {
        return Some("rejected: a value is beyond any vehicle's motion");
    }
    (gyro == [0.0; 3] && accel == [0.0; 3])
        .then_some("rejected: all zeros, the inertial unit was not measuring")
}

fn is_within(values: [f64; 3], largest: f64) -> bool {
    values.iter().all(|value| value.abs() <= largest)
}

/// Adds remarks on gaps in `samples`, found at `lines`, and on times at which the inertial unit was stuck.
pub fn remark_faults(samples: &[ImuSample], lines: &[u64], remarks: &mut Remarks) {
    let (mut faults, mut gaps) = (Faults::default(), Gaps::default());
    for (sample, line) in samples.iter().zip(lines) {
        faults.push(*line, sample, remarks.place());
        gaps.push(sample.time);
    }
    faults.remark(&gaps, remarks);
}

/// Detector of a stuck inertial unit, sample by sample.
#[derive(Debug, Default)]
pub(crate) struct Faults {
    run: Option<Repeated>,
    stuck: Vec<String>,
}

/// Samples that repeat the first of them to the last bit, as no working sensor does.
#[derive(Debug)]
struct Repeated {
    first: ImuSample,
    line: u64,
    last: Time,
    rows: usize,
}

impl Faults {
    /// Adds the sample found at `line`; `place` names the unit of that number, `line` or `byte`.
    pub fn push(&mut self, line: u64, sample: &ImuSample, place: &str) {
        match &mut self.run {
            // Every sample of a run equals its neighbour, so the last equals the first.
            Some(run) if run.first.motion == sample.motion => {
                run.last = sample.time;
                run.rows += 1;
            }
            _ => {
                self.end_run(place);
                self.run = Some(Repeated { first: *sample, line, last: sample.time, rows: 1 });
            }
        }
    }

    fn end_run(&mut self, place: &str) {
        let Some(Repeated { first, line, last, rows }) = self.run.take() else { return };
        if rows >= STUCK_ROWS && last - first.time >= STUCK_S {
            self.stuck.push(format!(
                "stuck: {rows} rows from {place} {line} on repeat to the last bit, {:.2} s from {} on",
                last - first.time,
                first.time
            ));
        }
    }

    /// Adds remarks on stuck samples and on gaps. The samples stay, and the filter bridges the gaps.
    pub fn remark(mut self, gaps: &Gaps, remarks: &mut Remarks) {
        self.end_run(remarks.place());
        let gaps = gaps.found();
        for gap in gaps.iter().take(GAPS_NAMED) {
            remarks.say(format!("gap of {:.3} s after {}", gap.length_s, gap.after));
        }
        if let Some(more @ 1..) = gaps.len().checked_sub(GAPS_NAMED) {
            remarks.say(format!("and {more} more gaps"));
        }
        self.stuck.into_iter().for_each(|stuck| remarks.say(stuck));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_in_another_unit_is_named() {
        assert_eq!(field_fault([21.0, 1.0, 43.0]), None);
        assert!(field_fault([0.2, f64::NAN, 0.4]).is_some_and(|why| why.contains("not a number")));
        for (field, unit) in [([210.0, 10.0, 430.0], "milligauss"), ([21e3, 1e3, 43e3], "nT")] {
            assert!(field_fault(field).is_some_and(|why| why.contains(unit)), "{field:?}");
        }
        assert!(field_fault([5000.0, 0.0, 0.0]).is_some_and(|why| why.contains("any field")));
    }
}
