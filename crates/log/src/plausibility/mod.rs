//! Whether a log matches its set-up: units, signs, axes, clocks.
//!
//! References that need no estimator: gravity, the unit's own attitude, the fixes' own velocity, the Earth's magnetic
//! field. Only certain or nearly certain errors are reported: false alarms would teach users to ignore the messages.

mod alternatives;
mod attitude;
mod barometer;
mod clocks;
mod field_turning;
mod fixes;
mod gravity;
mod magnetic;
mod pairs;
mod regression;
mod unmeasured;

use std::path::Path;

use hovernav::earth::STANDARD_GRAVITY_MPS2;

use crate::dataset::Dataset;
use crate::error::LogError;
use crate::finding::SetupFinding;
use crate::rates::{Rates, with_rates};
use attitude::{Tilting, Turning};
use field_turning::FieldTurning;
use gravity::Gravity;
use hovernav::imu::ImuSample;
use hovernav::time::Time;
use magnetic::Field;

pub use alternatives::{alternative, denied_aid};
pub(crate) use regression::Scale;
pub(crate) use unmeasured::Unmeasured;

impl Dataset {
    /// Set-up errors of this log, the certain ones first: see [`SetupFinding`]. Reads no reference and runs no filter.
    #[must_use]
    pub fn check_setup(&self) -> Vec<SetupFinding> {
        let mut look = SetupLook::default();
        for (sample, rates) in with_rates(self.samples()) {
            look.push(&sample, rates.as_ref());
        }
        look.check(self)
    }
}

/// Statistics of the inertial samples that the checks of the set-up need, gathered sample by sample.
#[derive(Default)]
pub(crate) struct SetupLook {
    gravity: Gravity,
    turning: Turning,
    tilting: Tilting,
    field: Field,
    field_turning: FieldTurning,
}

impl SetupLook {
    pub fn push(&mut self, sample: &ImuSample, rates: Option<&Rates>) {
        if let Some(field_gauss) = sample.magnetic_field_gauss {
            self.field.push(field_gauss.to_array());
        }
        if let Some(rates) = rates {
            self.gravity.push(rates);
            self.turning.push(rates, sample.attitude);
            self.tilting.push(rates);
            self.field_turning.push(rates, sample.magnetic_field_gauss);
        }
    }

    /// Judges the set-up of `dataset`, whose samples have been pushed: see [`Dataset::check_setup`].
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
        if !self.turning.check(&mut found) {
            self.tilting.check(&mut found);
        }
        if found.is_empty() {
            self.field_turning.check(&dataset.magnetometer, &mut found);
        }
        fixes::check(&fixes, &mut found);
        found.extend(unmeasured.map(|zeros| zeros.finding(&dataset.fixes)));
        barometer::check(dataset, &mut found);
        self.field.check(dataset, up, &mut found);
        found.sort_by_key(|finding| !finding.is_certain);
        found
    }
}

impl Dataset {
    /// Rejects a log whose set-up is certainly wrong; `path` names it in the message. Returns the certain errors of
    /// sensors that [can be left out](SetupFinding::can_be_left_out), for [`leave_out`](Self::leave_out).
    ///
    /// # Errors
    /// [`LogError::Setup`] with all certain errors, their likely causes and remedies.
    pub fn ensure_possible(&self, path: &Path) -> Result<Vec<SetupFinding>, LogError> {
        let certain = self.check_setup().into_iter().filter(|finding| finding.is_certain);
        let (aids, findings): (Vec<_>, Vec<_>) = certain.partition(SetupFinding::can_be_left_out);
        if findings.is_empty() {
            return Ok(aids);
        }
        Err(LogError::Setup { path: path.to_path_buf(), findings })
    }
}

/// Means over about a second: vibration averages out, motion remains.
struct Second {
    middle_s: f64,
    turn_radps: [f64; 3],
    force_mps2: [f64; 3],
}

/// Means over parts of one length; parts with fewer than three samples are skipped.
struct Means {
    length_s: f64,
    first: Option<Time>,
    part: u64,
    /// Sums of turn rates and specific forces, and the number of samples.
    turn_radps: [f64; 3],
    force_mps2: [f64; 3],
    count: usize,
}

impl Means {
    const fn over(length_s: f64) -> Self {
        let [turn_radps, force_mps2] = [[0.0; 3]; 2];
        Self { length_s, first: None, part: 0, turn_radps, force_mps2, count: 0 }
    }

    /// Adds a sample; returns the mean of the previous part if the sample begins a new one.
    fn push(&mut self, at: &Rates) -> Option<Second> {
        let part = ((at.time - *self.first.get_or_insert(at.time)) / self.length_s) as u64;
        let done = if part == self.part { None } else { self.finish() };
        self.part = part;
        let add = |sum: &mut [f64; 3], value: [f64; 3]| *sum = [0, 1, 2].map(|i| sum[i] + value[i]);
        add(&mut self.turn_radps, at.turn_radps);
        add(&mut self.force_mps2, at.force_mps2);
        self.count += 1;
        done
    }

    /// Mean of the current part, which it ends.
    fn finish(&mut self) -> Option<Second> {
        let emptied = Self { first: self.first, ..Self::over(self.length_s) };
        let Self { part, turn_radps, force_mps2, count, .. } = std::mem::replace(self, emptied);
        let mean = |sum: [f64; 3]| sum.map(|sum| sum / count as f64);
        let middle_s = self.first?.seconds() + (part as f64 + 0.5) * self.length_s;
        (count >= 3).then(|| Second {
            middle_s,
            turn_radps: mean(turn_radps),
            force_mps2: mean(force_mps2),
        })
    }
}

fn norm<const D: usize>(vector: [f64; D]) -> f64 {
    vector.into_iter().fold(0.0, f64::hypot)
}

const G: f64 = STANDARD_GRAVITY_MPS2;
