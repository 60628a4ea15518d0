//! Check of a log against its set-up: units, signs, axes, clocks.
//!
//! The references need no estimator: gravity, the inertial unit's own attitude, the fixes' own velocity, the Earth's
//! magnetic field. Only certain or nearly certain errors are reported: false alarms would teach users to ignore the
//! messages.

mod alternatives;
mod attitude;
mod barometer;
mod clocks;
mod dead_axis;
mod field_turning;
mod fixes;
mod gravity;
mod interpolated;
mod magnetic;
mod pairs;
mod regression;
mod unmeasured;

use std::path::Path;

use crate::finding::{Sensor, SetupFinding};
use crate::rates::{Rates, with_rates};
use attitude::Turning;
use dead_axis::DeadAxis;
use field_turning::FieldTurning;
use gravity::Gravity;
use hovernav::event::Event;
use hovernav::imu::ImuSample;
use hovernav::setup::{SetupCheck, SetupFault};
use hovernav_dataset::{Dataset, LogError};
use magnetic::Field;

pub use alternatives::alternative;
pub(crate) use alternatives::denied_aid;
pub use barometer::barometer_scale;
pub(crate) use regression::Scale;
pub(crate) use unmeasured::Unmeasured;

/// Set-up errors of `dataset`, the certain ones first: see [`SetupFinding`]. Reads no reference and runs no filter.
#[must_use]
pub fn check_setup(dataset: &Dataset) -> Vec<SetupFinding> {
    let mut look = SetupLook::default();
    for (sample, rates) in with_rates(dataset.samples()) {
        look.push(&sample, rates.as_ref());
    }
    look.check(dataset)
}

/// Statistics of the inertial samples that the checks of the set-up need, gathered sample by sample.
#[derive(Default)]
pub(crate) struct SetupLook {
    gravity: Gravity,
    dead_axis: DeadAxis,
    turning: Turning,
    check: SetupCheck,
    in_degrees: Option<SetupFinding>,
    field: Field,
    field_turning: FieldTurning,
}

impl SetupLook {
    pub fn push(&mut self, sample: &ImuSample, rates: Option<&Rates>) {
        let fault = self.check.push(&Event::Imu(*sample));
        self.in_degrees = self.in_degrees.take().or_else(|| in_degrees(&fault?));
        if let Some(field_gauss) = sample.magnetic_field_gauss {
            self.field.push(field_gauss.to_array());
        }
        if let Some(rates) = rates {
            self.gravity.push(rates);
            self.dead_axis.push(rates);
            self.turning.push(rates, sample.attitude);
            self.field_turning.push(rates, sample.magnetic_field_gauss);
        }
    }

    /// Judges the set-up of `dataset`, whose samples have been pushed: see [`check_setup`].
    pub fn check(mut self, dataset: &Dataset) -> Vec<SetupFinding> {
        if !dataset.magnetometer.is_empty() {
            self.field = Field::default();
            let apart = dataset.magnetometer.iter();
            apart.for_each(|(_, field_gauss)| self.field.push(field_gauss.to_array()));
        }
        let up = self.gravity.up();
        let unmeasured = Unmeasured::of(&dataset.fixes);
        let fixes = Unmeasured::without(unmeasured.as_ref(), &dataset.fixes);
        let mut found = Vec::new();
        clocks::check(dataset, &mut found);
        self.gravity.check(&fixes, &mut found);
        self.dead_axis.check(&mut found);
        if !self.turning.check(&mut found) {
            found.extend(self.in_degrees);
        }
        if found.is_empty() {
            self.field_turning.check(&dataset.magnetometer, &mut found);
        }
        fixes::check(&fixes, &mut found);
        found.extend(unmeasured.map(|zeros| zeros.finding(&dataset.fixes)));
        interpolated::check(&dataset.fixes, &mut found);
        barometer::check(dataset, &mut found);
        self.field.check(dataset, up, &mut found);
        found.sort_by_key(|finding| !finding.is_certain);
        found
    }
}

/// Rejects a `dataset` whose set-up is certainly wrong; `path` names it in the message. Returns the certain errors of
/// sensors that [can be ignored](SetupFinding::can_be_ignored), for [`ignore`](crate::ignore).
///
/// # Errors
/// [`LogError::Setup`] with all certain errors, their likely causes and remedies.
pub fn ensure_possible(dataset: &Dataset, path: &Path) -> Result<Vec<SetupFinding>, LogError> {
    let certain = check_setup(dataset).into_iter().filter(|finding| finding.is_certain);
    let (aids, findings): (Vec<_>, Vec<_>) = certain.partition(SetupFinding::can_be_ignored);
    if findings.is_empty() {
        return Ok(aids);
    }
    let findings = findings.iter().map(ToString::to_string).collect();
    Err(LogError::Setup { path: path.to_path_buf(), findings })
}

/// Finding for gyro rates in degrees: the gyros report turns of which gravity shows only a small part.
fn in_degrees(fault: &SetupFault) -> Option<SetupFinding> {
    let SetupFault::RatesInDegrees { reported_rad, seen_rad } = fault else { return None };
    Some(SetupFinding {
        sensor: Sensor::InertialUnit,
        is_certain: true,
        found: format!(
            "the gyros report tilts of {reported_rad:.1} rad each 0.5 s, while gravity turns by {seen_rad:.2} rad"
        ),
        cause: "angular rates in °/s, expected rad/s".into(),
        mend: "write gyro_unit = \"degps\" under [imu] in dataset.toml".into(),
    })
}
