//! Survey of a log, for programs and for `hovernav info`.

use std::convert::Infallible;
use std::fmt;

use serde::Serialize;

use crate::contents::Contents;
use crate::events::events_and_setup;
use crate::finding::{Finding, sentences};
use crate::paragraph::section;
use crate::plausibility::check_setup;
use hovernav::ekf::Solution;
use hovernav_dataset::Dataset;
use hovernav_replay::{Keep, estimate_each};

/// A log at a glance: its contents, missing data, and what a run of the filter finds. [`Display`](fmt::Display) and
/// [`Serialize`] are what `hovernav info` prints.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Survey {
    /// Sensors, vibration, quality of the fixes.
    #[serde(flatten)]
    pub contents: Contents,
    /// Time by which the fixes are valid earlier than declared, s, with its one-sigma, as the filter estimates it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gps_offset_s: Option<(f64, f64)>,
    /// Missing data and its consequence, one sentence each.
    pub missing: Vec<String>,
    /// Certain and likely errors of the set-up.
    pub setup: Vec<String>,
    /// Findings of a filter run with the log's own settings.
    pub findings: Vec<Finding>,
}

impl Survey {
    /// Surveys `dataset`. Runs the filter over it if that is possible.
    #[must_use]
    pub fn of(dataset: &Dataset) -> Self {
        let nothing_to_run = dataset.fixes.is_empty() || dataset.sample_count() == 0;
        let run = match (nothing_to_run, dataset.configuration()) {
            (false, Ok((config, _))) => {
                let each = |_: &Solution| Ok::<(), Infallible>(());
                estimate_each(dataset, &config, Keep::Thinned, |_| {}, each).ok()
            }
            _ => None,
        };
        let (findings, setup) = match &run {
            Some(run) => events_and_setup(dataset, run),
            None => (Vec::new(), check_setup(dataset)),
        };
        Self {
            contents: Contents::of(dataset),
            gps_offset_s: run.and_then(|run| run.gps_offset),
            missing: missing(dataset),
            setup: setup.iter().map(ToString::to_string).collect(),
            findings,
        }
    }
}

/// Missing data of a log, and its consequence.
fn missing(dataset: &Dataset) -> Vec<String> {
    let mut missing = Vec::new();
    let mut say = |sentence: &str| missing.push(sentence.to_owned());
    let has_attitude = dataset.samples().any(|sample| sample.attitude.is_some());
    let has_field = !dataset.magnetometer.is_empty() || dataset.has_magnetic_samples();
    if dataset.fixes.is_empty() {
        say("no GPS: nothing to start from, so no solution");
    } else if dataset.fixes.iter().all(|fix| fix.horizontal_velocity_mps.is_none()) {
        say(
            "no GPS velocity: velocity is about 1.5 times less accurate, heading takes longer to find",
        );
    }
    if dataset.fixes.iter().all(|fix| fix.position_sigma_m.is_none()) && !dataset.fixes.is_empty() {
        say("no accuracy of the fixes: the filter estimates it from the innovations, slowly");
    }
    if !has_attitude && !has_field {
        say(
            "no attitude and no magnetometer: heading is unknown until the vehicle has accelerated \
             horizontally, and drifts in a hover",
        );
    } else if !has_field {
        say("no magnetometer: heading comes from the inertial unit's own attitude alone");
    }
    if dataset.baro.is_empty() {
        say(
            "no barometer: height comes from GPS alone, two to three times less accurate than position, and a \
             wrong height is not detected",
        );
    }
    let manifest = &dataset.manifest;
    if manifest.gps.antenna_lever_arm_m == hovernav::frames::Vector::ZERO {
        say(
            "no antenna lever arm: each metre of it costs 0.1 m/s of velocity for every 6°/s of turn rate",
        );
    }
    if manifest.imu.accel_range_g.is_none() {
        say("no full-scale ranges of the inertial unit: only repeated clipping is detected");
    }
    missing
}

impl fmt::Display for Survey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The contents end with the quality of the fixes, to which their time belongs.
        write!(f, "{}", self.contents)?;
        if let Some((offset_s, sigma_s)) = self.gps_offset_s {
            let text = format!("{offset_s:.3} s ± {sigma_s:.3} s earlier than declared");
            writeln!(f, "  time        fixes are valid {text}")?;
        }
        section(f, "missing data, and its cost", &self.missing)?;
        section(f, "set-up", &self.setup)?;
        section(f, "found by running the filter", &sentences(&self.findings))
    }
}
