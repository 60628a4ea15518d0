//! Survey of a log, for programs and for `hovernav info`.

use std::convert::Infallible;
use std::fmt;

use serde::Serialize;

use crate::clock::gaps;
use crate::dataset::Dataset;
use crate::finding::{Finding, sentences};
use crate::info::{self, paragraph};
use crate::kept::Keep;
use crate::rates::{Rates, rates};
use crate::statistics::{median_interval_s, quantile};
use crate::vibration_lines::{VibrationLine, vibration_lines};
use hovernav::gps::Fix;
use hovernav::imu::ImuSample;
use hovernav::time::Time;

/// A log at a glance: sensors, vibration, GPS quality, missing data, findings. Its [`Display`](fmt::Display) is the
/// part of `hovernav info` below the tables of [`Info`](crate::Info).
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Survey {
    /// The log's name.
    pub name: String,
    /// The sensors present.
    pub sensors: Vec<SensorSurvey>,
    /// The inertial unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub imu: Option<ImuSurvey>,
    /// The fixes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gps: Option<GpsSurvey>,
    /// Time by which the fixes are valid earlier than declared, s, with its one-sigma, as the filter estimates it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gps_offset_s: Option<(f64, f64)>,
    /// Missing data and its consequence, one sentence each.
    pub missing: Vec<String>,
    /// Certain and likely errors of the set-up.
    pub setup: Vec<String>,
    /// Findings of a filter run with the log's own settings.
    pub findings: Vec<Finding>,
    /// Repairs and skipped rows while reading.
    pub warnings: Vec<String>,
}

/// One sensor.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct SensorSurvey {
    /// Name of the sensor.
    pub name: &'static str,
    /// Number of samples.
    pub samples: usize,
    /// First and last sample, s on the log's clock.
    pub span_s: (f64, f64),
    /// Sample rate from the median interval, Hz.
    pub rate_hz: f64,
    /// Longest interval, s.
    pub longest_s: f64,
    /// Gaps: time before each, s, and length, s.
    pub gaps_s: Vec<(f64, f64)>,
}

/// The inertial unit; axes forward, right, down.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct ImuSurvey {
    /// Fraction of samples with the inertial unit's own attitude.
    pub with_attitude: f64,
    /// Fraction of samples with a magnetic field.
    pub with_magnetic_field: f64,
    /// Mean angular rate, rad/s.
    pub mean_rate_radps: [f64; 3],
    /// Mean specific force, m/s².
    pub mean_force_mps2: [f64; 3],
    /// Vibration between samples, rms, rad/s.
    pub vibration_radps: [f64; 3],
    /// Vibration of the accelerometers, m/s².
    pub vibration_mps2: [f64; 3],
    /// Strongest vibration lines.
    pub lines: Vec<VibrationLine>,
}

/// The fixes.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct GpsSurvey {
    /// Fraction of fixes with velocity.
    pub with_velocity: f64,
    /// Fraction of fixes with a stated one-sigma of position.
    pub with_position_sigma: f64,
    /// Median of the stated horizontal one-sigma, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position_sigma_m: Option<f64>,
    /// Median of the satellites used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub satellites: Option<f64>,
    /// Greatest speed over ground, m/s.
    pub fastest_mps: f64,
}

impl Survey {
    /// Surveys `dataset`. Runs the filter over it if that is possible.
    #[must_use]
    pub fn of(dataset: &Dataset) -> Self {
        let nothing_to_run = dataset.fixes.is_empty() || dataset.sample_count() == 0;
        let run = match (nothing_to_run, dataset.configuration()) {
            (false, Ok((config, _))) => dataset
                .estimate_each(&config, Keep::Thinned, |_| {}, |_| Ok::<(), Infallible>(()))
                .ok(),
            _ => None,
        };
        let (findings, setup) = match &run {
            Some(run) => dataset.events_and_setup(run),
            None => (Vec::new(), dataset.check_setup()),
        };
        Self {
            name: dataset.manifest.name.clone(),
            sensors: sensors(dataset),
            imu: imu(dataset, &rates(dataset.samples())),
            gps: gps(&dataset.fixes),
            gps_offset_s: run.and_then(|run| run.gps_offset),
            missing: missing(dataset),
            setup: setup.iter().map(ToString::to_string).collect(),
            findings,
            warnings: dataset.warnings.clone(),
        }
    }
}

fn sensors(dataset: &Dataset) -> Vec<SensorSurvey> {
    let survey = |(name, times): (&'static str, Vec<Time>)| {
        let span_s = (times.first()?.seconds(), times.last()?.seconds());
        Some(SensorSurvey {
            name,
            samples: times.len(),
            span_s,
            rate_hz: 1.0 / median_interval_s(&times).unwrap_or(f64::INFINITY),
            longest_s: times.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max),
            gaps_s: gaps(&times).iter().map(|gap| (gap.after.seconds(), gap.length_s)).collect(),
        })
    };
    info::sensors(dataset).into_iter().filter_map(survey).collect()
}

fn share<T>(items: &[T], has: impl Fn(&T) -> bool) -> f64 {
    items.iter().filter(|item| has(item)).count() as f64 / items.len().max(1) as f64
}

fn imu(dataset: &Dataset, rates: &[Rates]) -> Option<ImuSurvey> {
    if rates.len() < 3 {
        return None;
    }
    let mean = |of: fn(&Rates) -> [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|axis| {
            rates.iter().map(|at| of(at)[axis]).sum::<f64>() / rates.len() as f64
        })
    };
    let rough = |of: fn(&Rates) -> [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|axis| {
            let bends = rates
                .windows(3)
                .map(|three| of(&three[0])[axis] - 2.0 * of(&three[1])[axis] + of(&three[2])[axis]);
            let squares: f64 = bends.map(|bend| bend * bend).sum();
            (squares / (6.0 * (rates.len() - 2) as f64)).sqrt()
        })
    };
    let of_samples = |has: fn(&ImuSample) -> bool| {
        dataset.samples().filter(has).count() as f64 / dataset.sample_count().max(1) as f64
    };
    Some(ImuSurvey {
        with_attitude: of_samples(|sample| sample.attitude.is_some()),
        with_magnetic_field: of_samples(|sample| sample.magnetic_field_gauss.is_some()),
        mean_rate_radps: mean(|at| at.turn_radps),
        mean_force_mps2: mean(|at| at.force_mps2),
        vibration_radps: rough(|at| at.turn_radps),
        vibration_mps2: rough(|at| at.force_mps2),
        lines: vibration_lines(rates),
    })
}

fn gps(fixes: &[Fix]) -> Option<GpsSurvey> {
    if fixes.is_empty() {
        return None;
    }
    let horizontal = |fix: &Fix| {
        let [north, east, _] = fix.position_sigma_m?.to_array();
        Some(north.hypot(east) / std::f64::consts::SQRT_2)
    };
    let mut sigmas: Vec<f64> = fixes.iter().filter_map(horizontal).collect();
    let mut satellites: Vec<f64> =
        fixes.iter().filter_map(|fix| fix.satellites.map(f64::from)).collect();
    let speeds = fixes.iter().filter_map(|fix| fix.horizontal_velocity_mps);
    Some(GpsSurvey {
        with_velocity: share(fixes, |fix| fix.velocity_mps().is_some()),
        with_position_sigma: share(fixes, |fix| fix.position_sigma_m.is_some()),
        position_sigma_m: quantile(&mut sigmas, 0.5),
        satellites: quantile(&mut satellites, 0.5),
        fastest_mps: speeds.map(|[north, east]| north.hypot(east)).fold(0.0, f64::max),
    })
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
        say("no magnetometer: heading comes from the unit's own attitude alone");
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
        if let Some(imu) = self.imu.as_ref().filter(|imu| !imu.lines.is_empty()) {
            writeln!(
                f,
                "\nvibration, strongest lines as sampled (a faster one shows at its alias)"
            )?;
            for line in &imu.lines {
                writeln!(
                    f,
                    "  {:<16}{:>8.2} Hz{:>10.3} {}",
                    line.axis, line.frequency_hz, line.amplitude, line.unit
                )?;
            }
        }
        if let Some(gps) = &self.gps {
            let sigma = |sigma: Option<f64>, unit: &str| {
                sigma.map_or("not stated".into(), |sigma| format!("{sigma:.1}{unit}"))
            };
            writeln!(f, "\ngps quality")?;
            writeln!(
                f,
                "  one-sigma   {} (median, horizontal)",
                sigma(gps.position_sigma_m, " m")
            )?;
            writeln!(f, "  satellites  {} (median)", sigma(gps.satellites, ""))?;
            writeln!(f, "  fastest     {:.1} m/s", gps.fastest_mps)?;
            if let Some((offset_s, sigma_s)) = self.gps_offset_s {
                let text = format!("{offset_s:.3} s ± {sigma_s:.3} s earlier than declared");
                writeln!(f, "  time        fixes are valid {text}")?;
            }
        }
        section(f, "missing data, and its cost", &self.missing)?;
        section(f, "set-up", &self.setup)?;
        let words: Vec<String> = sentences(&self.findings);
        section(f, "found by running the filter", &words)
    }
}

fn section(f: &mut fmt::Formatter<'_>, title: &str, sentences: &[String]) -> fmt::Result {
    if sentences.is_empty() {
        return Ok(());
    }
    writeln!(f, "\n{title}")?;
    sentences.iter().try_for_each(|sentence| paragraph(f, "  ", sentence))
}
