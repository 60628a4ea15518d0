//! Search for the right set-up, with which the fixes become consistent with a run.

use hovernav::ekf::{Aid, Channel, EstimatorConfig, Verdict};
use hovernav::frames::{Body, Vector};
use hovernav::imu::Motion;

use crate::finding::{AIDS, Sensor, SetupFinding};
use hovernav_dataset::Dataset;
use hovernav_replay::{Run, estimate};

/// Largest number of samples in a trial run.
const SAMPLES: usize = 20_000;
/// Mean square of the normalised innovations beyond which a run is suspect.
const SUSPECT: f64 = 2.5;
/// Largest contribution of one innovation to the mean square. A rejected innovation contributes this value.
const MAX: f64 = 25.0;
/// Time after an enlargement of the bias uncertainty, s, in which consistent innovations prove nothing.
const OPENED_S: f64 = 2.0;
/// Smallest factor by which the right set-up reduces the mean square.
const BETTER: f64 = 1.7;
/// Largest ratio of the mean squares of two set-ups that fit equally.
const ALIKE: f64 = 1.2;
/// Largest mean square of the normalised innovations with the right set-up.
const GOOD: f64 = 2.0;

/// Axes, signs and ranges of the inertial unit to be tried: source axis and factor of each body axis.
struct Alternative {
    gyro: [(usize, f64); 3],
    accel: [(usize, f64); 3],
    cause: &'static str,
    mend: &'static str,
}

const RIGHT: [(usize, f64); 3] = [(0, 1.0), (1, 1.0), (2, 1.0)];

const fn signs(x: f64, y: f64, z: f64) -> [(usize, f64); 3] {
    [(0, x), (1, y), (2, z)]
}

const fn gyro(gyro: [(usize, f64); 3], cause: &'static str) -> Alternative {
    Alternative { gyro, accel: RIGHT, cause, mend: "change the sign of these columns" }
}

const fn accel(accel: [(usize, f64); 3], cause: &'static str) -> Alternative {
    Alternative { gyro: RIGHT, accel, cause, mend: "change the sign of these columns" }
}

const fn axes(axes: [(usize, f64); 3], cause: &'static str, mend: &'static str) -> Alternative {
    Alternative { gyro: axes, accel: axes, cause, mend }
}

const fn range(factor: f64, cause: &'static str) -> Alternative {
    Alternative {
        gyro: signs(factor, factor, factor),
        accel: RIGHT,
        cause,
        mend: "correct the range with which the counts were converted",
    }
}

const ALTERNATIVES: [Alternative; 18] = [
    gyro(signs(-1.0, -1.0, -1.0), "all gyros of the wrong sign"),
    gyro(signs(-1.0, 1.0, 1.0), "gyro x of the wrong sign"),
    gyro(signs(1.0, -1.0, 1.0), "gyro y of the wrong sign"),
    gyro(signs(1.0, 1.0, -1.0), "gyro z of the wrong sign"),
    gyro(signs(-1.0, -1.0, 1.0), "gyros x and y of the wrong sign"),
    gyro(signs(1.0, -1.0, -1.0), "gyros y and z of the wrong sign"),
    gyro(signs(-1.0, 1.0, -1.0), "gyros x and z of the wrong sign"),
    accel(signs(-1.0, 1.0, 1.0), "accelerometer x of the wrong sign"),
    accel(signs(1.0, -1.0, 1.0), "accelerometer y of the wrong sign"),
    accel(signs(-1.0, -1.0, 1.0), "accelerometers x and y of the wrong sign"),
    axes(
        [(1, 1.0), (0, 1.0), (2, 1.0)],
        "axes x and y swapped",
        "swap the columns of x and y, gyros and accelerometers",
    ),
    axes(
        [(1, 1.0), (0, 1.0), (2, -1.0)],
        "axes right, forward, up",
        "write axes = \"rfu\" under [imu] in dataset.toml",
    ),
    Alternative {
        gyro: [(1, 1.0), (0, 1.0), (2, 1.0)],
        accel: RIGHT,
        cause: "gyros x and y swapped",
        mend: "swap the columns of gyros x and y",
    },
    Alternative {
        gyro: RIGHT,
        accel: [(1, 1.0), (0, 1.0), (2, 1.0)],
        cause: "accelerometers x and y swapped",
        mend: "swap the columns of accelerometers x and y",
    },
    range(2.0, "gyros at half the right scale, as with another range setting"),
    range(4.0, "gyros at a quarter of the right scale, as with another range setting"),
    range(0.5, "gyros at twice the right scale, as with another range setting"),
    range(0.25, "gyros at four times the right scale, as with another range setting"),
];

fn permuted(vector: Vector<Body>, axes: &[(usize, f64); 3]) -> Vector<Body> {
    let values = vector.to_array();
    axes.map(|(axis, sign)| sign * values[axis]).into()
}

impl Alternative {
    fn applied(&self, dataset: &Dataset) -> Dataset {
        let mut other = dataset.clone();
        for sample in &mut other.imu {
            match &mut sample.motion {
                Motion::Rates { angular_rate_radps: turn, specific_force_mps2: force }
                | Motion::Increments { angle_rad: turn, velocity_mps: force } => {
                    *turn = permuted(*turn, &self.gyro);
                    *force = permuted(*force, &self.accel);
                }
            }
        }
        other
    }

    /// Whether the mean specific force points up in the vehicle.
    fn is_upright(&self, part: &Dataset) -> bool {
        let [.., (axis, sign)] = self.accel;
        let felt = part.imu.iter().map(|sample| match sample.motion {
            Motion::Rates { specific_force_mps2: force, .. }
            | Motion::Increments { velocity_mps: force, .. } => sign * force.to_array()[axis],
        });
        felt.sum::<f64>() < 0.0
    }
}

/// Configuration without one source of heading; `None` if the configuration or the log does not have it.
fn without(aid: Aid, config: &EstimatorConfig, part: &Dataset) -> Option<EstimatorConfig> {
    let mut config = *config;
    let aiding = &mut config.aiding;
    let has_field = || part.imu.iter().any(|sample| sample.magnetic_field_gauss.is_some());
    let (is_used, is_there) = match aid {
        Aid::Magnetometer => {
            (&mut aiding.magnetometer, !part.magnetometer.is_empty() || has_field())
        }
        Aid::SecondAntenna => (&mut aiding.second_antenna, !part.headings.is_empty()),
        // A barometer gives no heading.
        Aid::Baro => return None,
        _ => (&mut aiding.attitude, part.imu.iter().any(|sample| sample.attitude.is_some())),
    };
    (core::mem::replace(is_used, false) && is_there).then_some(config)
}

/// Mean square of the normalised innovations of the fixes, relative to the adapted noise and to the configured noise.
/// Each innovation counts at most [`MAX`]. Rejected innovations, and those soon after an enlargement of the bias
/// uncertainty, count [`MAX`]. `None` with too few innovations.
fn disagreement(run: &Run) -> Option<[f64; 2]> {
    let (mut sum, mut count) = (0.0, 0.0);
    let mut opened_until_s = f64::NEG_INFINITY;
    for report in run.reports() {
        for axis in report.innovations() {
            if report.bias_variance_was_raised() {
                opened_until_s = axis.time.seconds() + OPENED_S;
            }
            if matches!(
                axis.channel,
                Channel::VelocityNorth
                    | Channel::VelocityEast
                    | Channel::PositionNorth
                    | Channel::PositionEast
            ) {
                let opened = axis.time.seconds() < opened_until_s;
                let rejected = axis.verdict != Verdict::Accepted;
                sum += if rejected || opened { MAX } else { axis.normalised().powi(2).min(MAX) };
                count += 1.0;
            }
        }
    }
    (count >= 80.0).then(|| [sum / count, run.noise_excess.max(1.0) * sum / count])
}

/// Part of a log whose fixes are inconsistent with its run, to be run with other set-ups.
struct Trial {
    part: Dataset,
    config: EstimatorConfig,
    as_it_is: f64,
}

impl Trial {
    /// Trial for a log and a run; `None` if the fixes are consistent with the run.
    fn of(dataset: &Dataset, config: &EstimatorConfig, run: &Run) -> Option<Self> {
        if disagreement(run).is_some_and(|[_, found]| found < SUSPECT) {
            return None;
        }
        // A wrong set-up causes false accelerations, which must not widen the tolerance for the fixes.
        let mut config = *config;
        config.ekf.gps.velocity_smoothing_s = 0.0;
        let first_fix = dataset.fixes.first()?.time.offset_by(-5.0);
        let near = dataset.samples().filter(|sample| sample.time >= first_fix).take(SAMPLES);
        let part =
            Dataset { imu: near.collect(), imu_file: None, order: Vec::new(), ..dataset.clone() };
        let [_, as_it_is] = disagreement(&estimate(&part, &config, |_| {})).unwrap_or([MAX; 2]);
        Some(Self { part, config, as_it_is })
    }

    /// Disagreement of `run`; `None` if its heading is unknown, because such a run fits any fixes.
    fn judged(run: &Run) -> Option<[f64; 2]> {
        let is_whole = run.solutions.last().is_some_and(|last| last.attitude_sigma_rad[2] < 0.5);
        disagreement(run).filter(|_| is_whole)
    }

    fn is_right(&self, [learned, with]: [f64; 2]) -> bool {
        learned < GOOD && BETTER * with < self.as_it_is
    }

    /// Source of heading without which the fixes are consistent.
    fn denied_aid(&self) -> Option<SetupFinding> {
        AIDS.into_iter().find_map(|(aid, sensor, key)| {
            let run = estimate(&self.part, &without(aid, &self.config, &self.part)?, |_| {});
            let found = Self::judged(&run).filter(|found| self.is_right(*found))?;
            Some(SetupFinding {
                sensor,
                is_certain: false,
                found: format!(
                    "the fixes disagree with the solution ({:.1} times the expected squares), but agree ({:.1}) \
                     without the {sensor}",
                    self.as_it_is, found[1]
                ),
                cause: "its axes or signs, its mounting, or a disturbance".into(),
                mend: format!("correct it, or write {key} = false under [aiding]"),
            })
        })
    }

    /// Axes or signs of the inertial unit with which the fixes are consistent. Axes that put the vehicle on its back
    /// are never proposed.
    fn axes(&self) -> Option<SetupFinding> {
        let upright = ALTERNATIVES.iter().filter(|other| other.is_upright(&self.part));
        let mut right: Vec<([f64; 2], &Alternative)> = upright
            .filter_map(|other| {
                let run = estimate(&other.applied(&self.part), &self.config, |_| {});
                Some((Self::judged(&run).filter(|found| self.is_right(*found))?, other))
            })
            .collect();
        right.sort_by(|a, b| a.0[1].total_cmp(&b.0[1]));
        let found = right.first()?.0;
        // Gyros x and y of the wrong sign, for example, differ only by the heading from such accelerometers.
        right.retain(|(other, _)| other[1] < ALIKE * found[1]);
        let causes: Vec<&str> = right.iter().map(|(_, other)| other.cause).collect();
        let mut mends: Vec<&str> = right.iter().map(|(_, other)| other.mend).collect();
        mends.dedup();
        Some(SetupFinding {
            sensor: Sensor::InertialUnit,
            is_certain: false,
            found: format!(
                "the fixes disagree with the inertial samples ({:.1} times the expected squares), but agree ({:.1}) \
                 with other axes or signs",
                self.as_it_is, found[1]
            ),
            cause: causes.join(", or "),
            mend: mends.join(", or "),
        })
    }
}

/// Source of heading that must be ignored for the fixes to become consistent with the run. `None` if the fixes are
/// consistent already, or if no single source makes them so.
///
/// Runs the estimator over a part of the log up to four times, but only if the fixes contradict `run`.
pub(crate) fn denied_aid(
    dataset: &Dataset,
    config: &EstimatorConfig,
    run: &Run,
) -> Option<SetupFinding> {
    Trial::of(dataset, config, run)?.denied_aid()
}

/// Set-up with which the fixes become consistent with the run. It ignores one source of heading, or has other signs or
/// axes of the inertial unit. `None` if the fixes are consistent already, or with no other set-up. Axes that put the
/// vehicle on its back are never proposed.
///
/// Runs the estimator over a part of the log a dozen times, but only if the fixes contradict `run`.
#[must_use]
pub fn alternative(dataset: &Dataset, config: &EstimatorConfig, run: &Run) -> Option<SetupFinding> {
    let trial = Trial::of(dataset, config, run)?;
    // Ignoring a wrong source makes any axes consistent, and it is the simpler cause.
    trial.denied_aid().or_else(|| trial.axes())
}
