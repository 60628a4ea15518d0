//! Where the fixes deny a run, other set-ups are tried: the one that they agree with is the likely one.

use hovernav::ekf::{Aid, Channel, EstimatorConfig, Notice, Verdict};
use hovernav::frames::{Body, Vector};
use hovernav::imu::Motion;

use crate::dataset::Dataset;
use crate::finding::{AIDS, Sensor, SetupFinding};
use crate::replay::Run;

/// Samples that are tried at most.
const SAMPLES: usize = 20_000;
/// A larger mean square of the normalised innovations, each counted up to [`MOST`], or a larger share
/// of refused axes, is suspect.
const SUSPECT: f64 = 2.5;
const MOST: f64 = 25.0;
/// For so long, s, what was opened excuses whatever disagrees.
const OPENED_S: f64 = 2.0;
/// An alternative is the right one where it is so many times better.
const BETTER: f64 = 1.7;
/// No right one is worse than this.
const GOOD: f64 = 2.0;

/// Signs and axes of the unit that are tried: which axis goes where, with which sign.
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
    Alternative { gyro, accel: RIGHT, cause, mend: "turn the sign of these columns" }
}

const fn accel(accel: [(usize, f64); 3], cause: &'static str) -> Alternative {
    Alternative { gyro: RIGHT, accel, cause, mend: "turn the sign of these columns" }
}

const fn axes(axes: [(usize, f64); 3], cause: &'static str, mend: &'static str) -> Alternative {
    Alternative { gyro: axes, accel: axes, cause, mend }
}

const ALTERNATIVES: [Alternative; 14] = [
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

    /// Whether the accelerometers feel the vehicle's weight the right way up in the mean.
    fn is_upright(&self, part: &Dataset) -> bool {
        let [.., (axis, sign)] = self.accel;
        let felt = part.imu.iter().map(|sample| match sample.motion {
            Motion::Rates { specific_force_mps2: force, .. }
            | Motion::Increments { velocity_mps: force, .. } => sign * force.to_array()[axis],
        });
        felt.sum::<f64>() < 0.0
    }
}

/// The part of a set-up with one source of heading less, where the log has it.
fn without(aid: Aid, config: &EstimatorConfig, part: &Dataset) -> Option<EstimatorConfig> {
    let mut config = *config;
    let aiding = &mut config.aiding;
    let has_field = || part.imu.iter().any(|sample| sample.magnetic_field_gauss.is_some());
    let (is_used, is_there) = match aid {
        Aid::Magnetometer => {
            (&mut aiding.magnetometer, !part.magnetometer.is_empty() || has_field())
        }
        Aid::SecondAntenna => (&mut aiding.second_antenna, !part.headings.is_empty()),
        // No heading of its own can be wrong.
        Aid::Baro => return None,
        _ => (&mut aiding.attitude, part.imu.iter().any(|sample| sample.attitude.is_some())),
    };
    (core::mem::replace(is_used, false) && is_there).then_some(config)
}

/// Mean square of the normalised innovations of the fixes, each up to [`MOST`], what was refused, or opened for a
/// bias that may have stepped, counting full: of the noise that was learned of them, and of that which is assumed; `None` of too few.
fn disagreement(run: &Run) -> Option<[f64; 2]> {
    let (mut sum, mut count) = (0.0, 0.0);
    let mut opened_until_s = f64::NEG_INFINITY;
    for notice in &run.notices {
        let Notice::Updated(report) = notice else { continue };
        for axis in report.innovations() {
            if report.biases_were_doubted() {
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
                let refused = axis.verdict != Verdict::Accepted;
                sum += if refused || opened { MOST } else { axis.normalised().powi(2).min(MOST) };
                count += 1.0;
            }
        }
    }
    (count >= 80.0).then(|| [sum / count, run.noise_excess.max(1.0) * sum / count])
}

/// A part of a log whose run the fixes deny, to be run again under other set-ups.
struct Trial {
    part: Dataset,
    config: EstimatorConfig,
    as_it_is: f64,
}

impl Trial {
    /// `None` where the fixes do not deny the run.
    fn of(dataset: &Dataset, config: &EstimatorConfig, run: &Run) -> Option<Self> {
        if disagreement(run).is_some_and(|[_, found]| found < SUSPECT) {
            return None;
        }
        // A wrong set-up makes accelerations of its own, which must not excuse the fixes that deny it.
        let mut config = *config;
        config.ekf.gps.velocity_smoothing_s = 0.0;
        let first_fix = dataset.fixes.first()?.time.offset_by(-5.0);
        let near = dataset.samples().filter(|sample| sample.time >= first_fix).take(SAMPLES);
        let part =
            Dataset { imu: near.collect(), imu_file: None, order: Vec::new(), ..dataset.clone() };
        let [_, as_it_is] = disagreement(&part.estimate(&config, |_| {})).unwrap_or([MOST; 2]);
        Some(Self { part, config, as_it_is })
    }

    /// What `run` leaves, if its heading was found, for one that was not fits anything.
    fn judged(run: &Run) -> Option<[f64; 2]> {
        let is_whole = run.solutions.last().is_some_and(|last| last.attitude_sigma_rad[2] < 0.5);
        disagreement(run).filter(|_| is_whole)
    }

    fn is_right(&self, [learned, with]: [f64; 2]) -> bool {
        learned < GOOD && BETTER * with < self.as_it_is
    }

    /// The source of heading without which the fixes agree.
    fn denied_aid(&self) -> Option<SetupFinding> {
        AIDS.into_iter().find_map(|(aid, sensor, key)| {
            let run = self.part.estimate(&without(aid, &self.config, &self.part)?, |_| {});
            let found = Self::judged(&run).filter(|found| self.is_right(*found))?;
            Some(SetupFinding {
                sensor,
                is_certain: false,
                found: format!(
                    "the fixes disagree with the solution ({:.1} times the expected squares), and agree ({:.1}) \
                     without the {sensor}",
                    self.as_it_is, found[1]
                ),
                cause: "axes or signs of its own, a wrong mounting, or what disturbs it".into(),
                mend: format!("mend it, or write {key} = false under [aiding]"),
            })
        })
    }

    /// The axes or signs of the inertial unit with which they do. None are proposed that put the vehicle on its back.
    fn axes(&self) -> Option<SetupFinding> {
        let upright = ALTERNATIVES.iter().filter(|other| other.is_upright(&self.part));
        let tried = upright.filter_map(|other| {
            let run = other.applied(&self.part).estimate(&self.config, |_| {});
            Some((Self::judged(&run)?, other))
        });
        let (found, best) = tried.min_by(|a, b| a.0[1].total_cmp(&b.0[1]))?;
        self.is_right(found).then(|| SetupFinding {
            sensor: Sensor::InertialUnit,
            is_certain: false,
            found: format!(
                "the fixes disagree with the inertial samples ({:.1} times the expected squares), and agree ({:.1}) \
                 once these are read otherwise",
                self.as_it_is, found[1]
            ),
            cause: best.cause.into(),
            mend: best.mend.into(),
        })
    }
}

/// The source of heading without which the fixes agree with a run that they now deny; `None` where they do not deny it, or
/// do so without any.
///
/// Runs the estimator over a part of the log up to four times, and only where a run is denied.
#[must_use]
pub fn denied_aid(dataset: &Dataset, config: &EstimatorConfig, run: &Run) -> Option<SetupFinding> {
    Trial::of(dataset, config, run)?.denied_aid()
}

/// The [denied aid](denied_aid), or the other signs or axes of the inertial unit with which the fixes agree with a
/// run that they now deny; `None` where they do not deny it, or no other set-up is right. No axes are proposed that put the
/// vehicle on its back.
///
/// Runs the estimator over a part of the log a dozen times, and only where a run is denied.
#[must_use]
pub fn alternative(dataset: &Dataset, config: &EstimatorConfig, run: &Run) -> Option<SetupFinding> {
    let trial = Trial::of(dataset, config, run)?;
    // Without something that is wrong the fixes agree whatever else is tried, and it is the simpler cause.
    trial.denied_aid().or_else(|| trial.axes())
}
