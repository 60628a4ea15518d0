//! Reads the sensors of one file, row by row.

use super::columns::{Fields, Source};
use super::decimal::TimeUnit;
use super::gps::GpsPlaces;
use super::mapping::{AttitudeColumns, TableMapping, TimeColumn, Triad};
use super::units::{AttitudeRole, BaroUnit, ForceUnit, MagneticUnit, RateUnit, StickUnit, World};
use crate::axes;
use crate::utc::WEEK_S;
use hovernav::frames::{Body, EulerAngles, Ned, Rotation, Vector, wrap_angle};
use hovernav::imu::Motion;
use hovernav::time::Time;
use hovernav_dataset::{
    LogError, Remarks, StatedFix, field_fault, is_unknown, pressure_altitude_m,
};

/// Valid GPS weeks; an i64 of nanoseconds since 1970 cannot represent much later ones.
const MAX_WEEKS: std::ops::RangeInclusive<f64> = 0.0..=10_000.0;
/// Largest magnitude of a valid height, m.
const GREATEST_HEIGHT_M: f64 = 1e5;

/// The columns of one file.
pub(crate) struct TableColumns {
    mapping: TableMapping,
    time: Option<usize>,
    nanoseconds: Option<usize>,
    date: Option<usize>,
    week: Option<usize>,
    gyro: Option<[usize; 3]>,
    accel: Option<[usize; 3]>,
    gravity: Option<[usize; 3]>,
    mag: Option<[usize; 3]>,
    attitude: Option<Vec<usize>>,
    gps: Option<GpsPlaces>,
    velocity: Option<[usize; 3]>,
    baro: Option<usize>,
    controls: Option<[usize; 4]>,
    /// Last values of sensors whose value repeats on several rows.
    last_field: Option<[f64; 3]>,
    last_height: Option<f64>,
    last_motion: Option<[f64; 3]>,
}

/// The inertial values of a row.
pub(crate) enum Motions {
    Both(Motion),
    Rates([f64; 3]),
    Forces([f64; 3]),
    Neither,
}

/// The magnetic field of a row.
#[derive(Default)]
pub(crate) struct Magnetic {
    /// Field that becomes a part of the row's inertial sample, gauss.
    pub of_unit: Option<Vector<Body>>,
    /// Field that is a separate reading, not a part of an inertial sample, gauss.
    pub apart: Option<Vector<Body>>,
}

/// The attitudes of a row.
#[derive(Default)]
pub(crate) struct Attitudes {
    pub unit: Option<Rotation<Body, Ned>>,
    pub onboard: Option<Rotation<Body, Ned>>,
}

impl TableColumns {
    pub fn of(source: &Source, table: &TableMapping, latency_s: f64) -> Result<Self, LogError> {
        let attitude = table.attitude.as_ref().map(|columns| attitude_places(source, columns));
        let controls = table.controls.as_ref().map(|controls| -> Result<_, LogError> {
            let [a, b, c, d] = &controls.columns;
            Ok([source.find(a)?, source.find(b)?, source.find(c)?, source.find(d)?])
        });
        let columns = Self {
            time: source.find_optional(&table.time.column)?,
            nanoseconds: source.find_optional(&table.time.nanoseconds)?,
            date: source.find_optional(&table.time.date)?,
            week: source.find_optional(&table.time.week)?,
            gyro: table.gyro.as_ref().map(|t| source.find_triad(t)).transpose()?,
            accel: table.accel.as_ref().map(|t| source.find_triad(t)).transpose()?,
            gravity: table.gravity.as_ref().map(|t| source.find_triad(t)).transpose()?,
            mag: table.mag.as_ref().map(|t| source.find_triad(t)).transpose()?,
            attitude: attitude.transpose()?,
            gps: table.gps.as_ref().map(|g| GpsPlaces::of(source, g, latency_s)).transpose()?,
            velocity: table
                .velocity
                .as_ref()
                .map(|velocity| source.find_three(&velocity.columns))
                .transpose()?,
            baro: table.baro.as_ref().map(|b| source.find(&b.column)).transpose()?,
            controls: controls.transpose()?,
            mapping: table.clone(),
            last_field: None,
            last_height: None,
            last_motion: None,
        };
        match columns.contradiction() {
            Some(reason) => Err(LogError::Unusable { path: source.path().to_path_buf(), reason }),
            None => Ok(columns),
        }
    }

    /// Contradiction within the mapping of this file, if there is one.
    fn contradiction(&self) -> Option<String> {
        let rates = self.mapping.gyro.as_ref().map(|gyro| gyro.unit.is_increment());
        let forces = self.mapping.accel.as_ref().map(|accel| accel.unit.is_increment());
        let TimeColumn { unit, rate_hz, .. } = self.mapping.time;
        let is_counted = self.time.is_none() || unit == TimeUnit::Count;
        if is_counted && !rate_hz.is_some_and(|rate| rate > 0.0 && rate.is_finite()) {
            return Some(
                "found no time, expected `column` or a positive `rate_hz` under \
                         [table.time]; a `column` of counts needs both"
                    .into(),
            );
        }
        match (rates, forces) {
            (Some(rates), Some(forces)) if rates != forces => Some(
                "found increments for one of gyro and accel and rates for the other, expected \
                      the same for both"
                    .into(),
            ),
            (Some(true), None) | (None, Some(true)) => {
                Some("found increments, expected gyro and accel in one file".into())
            }
            _ => None,
        }
    }

    pub const fn has_motion(&self) -> bool {
        self.gyro.is_some() || self.accel.is_some()
    }

    pub fn time(&self, fields: &Fields<'_>) -> Result<Option<Time>, LogError> {
        let mapping = &self.mapping.time;
        let Some(mut time) = fields.time(self.time, mapping)? else { return Ok(None) };
        if let Some(column) = self.nanoseconds {
            let fraction = fields.known(Some(column))?.filter(|ns| (0.0..1e9).contains(ns));
            let Some(fraction) = fraction else { return Ok(None) };
            time = later(time, fraction as i64);
        }
        if let Some(column) = self.date {
            let Some(midnight) = fields.midnight(column)? else { return Ok(None) };
            time = later(time, midnight.nanoseconds());
        }
        if let Some(column) = self.week {
            const WEEK_NS: i64 = WEEK_S * 1_000_000_000;
            let week = fields.known(Some(column))?.filter(|week| MAX_WEEKS.contains(week));
            let Some(week) = week else { return Ok(None) };
            time = later(time, week as i64 * WEEK_NS);
        }
        let is_dated = self.date.is_some() || mapping.unit == TimeUnit::Clock;
        Ok(Some(mapping.scale.to_utc(time, is_dated).offset_by(mapping.offset_s)))
    }

    pub fn motion(&mut self, fields: &Fields<'_>) -> Result<Motions, LogError> {
        let gyro = triad(fields, self.gyro, self.mapping.gyro.as_ref(), RateUnit::factor)?;
        let mut accel = triad(fields, self.accel, self.mapping.accel.as_ref(), ForceUnit::factor)?;
        if self.gravity.is_some() && accel.is_some() {
            let gravity = self.gravity_of(fields)?;
            accel = accel.zip(gravity).map(|(a, g)| [0, 1, 2].map(|axis| a[axis] + g[axis]));
        }
        let held = self.mapping.gyro.as_ref().is_some_and(|gyro| gyro.held)
            || self.mapping.accel.as_ref().is_some_and(|accel| accel.held);
        let now = gyro.or(accel);
        if held && now.is_some() && now == self.last_motion {
            return Ok(Motions::Neither);
        }
        self.last_motion = now;
        let increments = self.mapping.gyro.as_ref().is_some_and(|gyro| gyro.unit.is_increment());
        Ok(match (gyro, accel) {
            (Some(gyro), Some(accel)) => {
                let (gyro, accel) = (Vector::from(gyro), Vector::from(accel));
                Motions::Both(match increments {
                    false => Motion::Rates { angular_rate_radps: gyro, specific_force_mps2: accel },
                    true => Motion::Increments { angle_rad: gyro, velocity_mps: accel },
                })
            }
            (Some(rates), None) if self.accel.is_none() => Motions::Rates(rates),
            (None, Some(forces)) if self.gyro.is_none() => Motions::Forces(forces),
            _ => Motions::Neither,
        })
    }

    /// Gravity in a row, m/s², for the linear acceleration of another file.
    pub fn gravity(&self, fields: &Fields<'_>) -> Result<Option<[f64; 3]>, LogError> {
        if self.accel.is_some() { Ok(None) } else { self.gravity_of(fields) }
    }

    fn gravity_of(&self, fields: &Fields<'_>) -> Result<Option<[f64; 3]>, LogError> {
        triad(fields, self.gravity, self.mapping.gravity.as_ref(), ForceUnit::factor)
    }

    pub fn magnetic(
        &mut self,
        fields: &Fields<'_>,
        remarks: &mut Remarks,
    ) -> Result<Magnetic, LogError> {
        let mapping = self.mapping.mag.as_ref();
        let Some(field) = triad(fields, self.mag, mapping, MagneticUnit::factor)? else {
            return Ok(Magnetic::default());
        };
        if let Some(why) = field_fault(field) {
            remarks.count(why, fields.line);
            return Ok(Magnetic::default());
        }
        let held = mapping.is_some_and(|mag| mag.held);
        if held && self.last_field == Some(field) {
            return Ok(Magnetic::default());
        }
        self.last_field = Some(field);
        let is_of_unit = self.gyro.is_some() && self.accel.is_some() && !held;
        let field = Some(Vector::from(field));
        Ok(match is_of_unit {
            true => Magnetic { of_unit: field, apart: None },
            false => Magnetic { of_unit: None, apart: field },
        })
    }

    pub fn attitude(&self, fields: &Fields<'_>) -> Result<Attitudes, LogError> {
        let Some((columns, places)) = self.mapping.attitude.as_ref().zip(self.attitude.as_ref())
        else {
            return Ok(Attitudes::default());
        };
        let attitude = match places[..] {
            [roll, pitch, yaw] => {
                let angles = fields.known_all([roll, pitch, yaw])?;
                angles.and_then(|angles| euler(columns, angles)).map(Rotation::from_euler)
            }
            [w, x, y, z] => {
                let quaternion = fields.known_all([w, x, y, z])?.map(normalised);
                quaternion.and_then(|quaternion| match columns.world {
                    World::Ned => axes::attitude_frd_ned(quaternion),
                    World::Enu => axes::attitude_flu_enu(quaternion),
                })
            }
            _ => None,
        };
        Ok(match columns.role {
            AttitudeRole::Unit => Attitudes { unit: attitude, onboard: None },
            AttitudeRole::Onboard => Attitudes { unit: None, onboard: attitude },
        })
    }

    /// The fix in a row at `time`, as the file states it.
    pub fn fix(&self, time: Time, fields: &Fields<'_>) -> Result<Option<StatedFix>, LogError> {
        match &self.gps {
            Some(gps) => gps.fix(time, fields),
            None => Ok(None),
        }
    }

    /// The velocity in a row north, east and down, m/s, for the fixes of another file.
    pub fn velocity(&self, fields: &Fields<'_>) -> Result<Option<[f64; 3]>, LogError> {
        let Some((mapping, columns)) = self.mapping.velocity.as_ref().zip(self.velocity) else {
            return Ok(None);
        };
        let Some(values) = fields.known_all(columns)? else { return Ok(None) };
        let [x, y, z] = values.map(|value| value * mapping.unit.factor());
        Ok(Some(match mapping.world {
            World::Ned => [x, y, z],
            World::Enu => [y, x, -z],
        }))
    }

    pub fn height(
        &mut self,
        fields: &Fields<'_>,
        remarks: &mut Remarks,
    ) -> Result<Option<f64>, LogError> {
        let (Some(baro), Some(value)) = (self.mapping.baro.as_ref(), fields.known(self.baro)?)
        else {
            return Ok(None);
        };
        if baro.held && self.last_height == Some(value) {
            return Ok(None);
        }
        self.last_height = Some(value);
        if is_unknown(value) {
            remarks.count(
                "skipped: the barometric value is one for unknown ones, such as -9999",
                fields.line,
            );
            return Ok(None);
        }
        let value = value * BaroUnit::factor(baro.unit);
        let height_m = match baro.unit.is_pressure() {
            true => pressure_altitude_m(value),
            false => Some(value).filter(|height_m| height_m.abs() <= GREATEST_HEIGHT_M),
        };
        if height_m.is_none() {
            remarks.count("rejected: the barometric value is out of range", fields.line);
        }
        Ok(height_m)
    }

    pub fn sticks(
        &self,
        fields: &Fields<'_>,
        remarks: &mut Remarks,
    ) -> Result<Option<[f64; 4]>, LogError> {
        let Some((mapping, columns)) = self.mapping.controls.as_ref().zip(self.controls) else {
            return Ok(None);
        };
        let Some(values) = fields.known_all(columns)? else { return Ok(None) };
        let factor = StickUnit::factor(mapping.unit);
        let sticks = std::array::from_fn(|stick| {
            let sign = if mapping.signs[stick] < 0.0 { -1.0 } else { 1.0 };
            values[stick] * factor * sign
        });
        if sticks.iter().any(|stick: &f64| stick.abs() > 2.0) {
            remarks.count("rejected: a stick is beyond ±2 of its full stroke", fields.line);
            return Ok(None);
        }
        Ok(Some(sticks))
    }
}

/// `time` plus `nanoseconds`.
fn later(time: Time, nanoseconds: i64) -> Time {
    Time::from_nanoseconds(time.nanoseconds().saturating_add(nanoseconds))
}

fn triad<U: Copy>(
    fields: &Fields<'_>,
    columns: Option<[usize; 3]>,
    mapping: Option<&Triad<U>>,
    factor: impl Fn(U) -> f64,
) -> Result<Option<[f64; 3]>, LogError> {
    match columns.zip(mapping) {
        Some((columns, mapping)) => {
            let factor = factor(mapping.unit) / mapping.counts_per_unit;
            fields.triad(columns, factor, mapping.axes)
        }
        None => Ok(None),
    }
}

fn attitude_places(source: &Source, columns: &AttitudeColumns) -> Result<Vec<usize>, LogError> {
    let names = match (columns.columns.len(), columns.quaternion.len()) {
        (3, 0) => &columns.columns,
        (0, 4) => &columns.quaternion,
        _ => {
            let reason =
                "[table.attitude]: expected three columns of angles or four of a quaternion";
            return Err(LogError::Unusable {
                path: source.path().to_path_buf(),
                reason: reason.into(),
            });
        }
    };
    names.iter().map(|name| source.find(name)).collect()
}

/// The quaternion scaled to length 1; NaN for one of length 0.
fn normalised(quaternion: [f64; 4]) -> [f64; 4] {
    let length = quaternion.iter().map(|part| part * part).sum::<f64>().sqrt();
    quaternion.map(|part| part / length)
}

/// Roll, pitch and yaw with hovernav's signs; `None` if the angles are impossible.
fn euler(columns: &AttitudeColumns, angles: [f64; 3]) -> Option<EulerAngles> {
    let [roll_rad, pitch_rad, yaw_rad] = std::array::from_fn(|axis| {
        let sign = if columns.signs[axis] < 0.0 { -1.0 } else { 1.0 };
        angles[axis] * sign * columns.unit.factor()
    });
    let within = roll_rad.abs() <= 6.3 && pitch_rad.abs() <= 1.571 && yaw_rad.abs() <= 6.3;
    let yaw_rad = wrap_angle(yaw_rad + columns.yaw_offset_deg.to_radians());
    within.then_some(EulerAngles { roll_rad: wrap_angle(roll_rad), pitch_rad, yaw_rad })
}
