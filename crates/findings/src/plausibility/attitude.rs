//! Check of the gyros against the attitude that the inertial unit computes.

use std::f64::consts::TAU;

use hovernav::frames::{EulerAngles, Rotation};

use super::regression::Regression;
use crate::finding::{Sensor, SetupFinding};
use crate::rates::Rates;

/// Interval over which rotations are compared, s: longer than the lag of an attitude, shorter than a turn.
const OVER_S: f64 = 0.5;
/// Smallest rms rate of the gyros, rad/s.
const MIN_RADPS: f64 = 0.008;
/// Smallest fraction of the attitude's motion that the fit has to explain.
const EXPLAINED: f64 = 0.5;
/// Plausible scales of the gyros.
const SCALES: std::ops::Range<f64> = 0.6..1.6;
/// Plausible scales if the fit explains the fraction [`WELL_EXPLAINED`].
const NEAR_SCALES: std::ops::Range<f64> = 0.77..1.3;
/// Explained fraction from which [`NEAR_SCALES`] applies.
const WELL_EXPLAINED: f64 = 0.8;
const NAMES: [&str; 3] = ["x", "y", "z"];

/// Mean gyro rates, and the rates of the inertial unit's own attitude.
pub(super) struct Turning {
    regression: Regression<3>,
    /// The largest angle of the attitude, rad.
    largest_rad: f64,
    /// Samples of the current part.
    part: Vec<(Rates, Option<EulerAngles>)>,
}

impl Default for Turning {
    fn default() -> Self {
        Self { regression: Regression::NONE, largest_rad: 0.0, part: Vec::new() }
    }
}

impl Turning {
    /// Adds a sample, with the inertial unit's own attitude.
    pub fn push(&mut self, at: &Rates, attitude: Option<EulerAngles>) {
        if let Some(EulerAngles { roll_rad, pitch_rad, yaw_rad }) = attitude {
            let angles = [roll_rad, pitch_rad, yaw_rad];
            self.largest_rad = angles.into_iter().fold(self.largest_rad, |a, b| a.max(b.abs()));
        }
        let is_end = self.part.first().is_some_and(|(start, _)| at.time - start.time >= OVER_S);
        self.part.push((*at, attitude));
        if is_end {
            self.compare();
            self.part.clear();
            self.part.push((*at, attitude));
        }
    }

    /// Compares gyros and attitude over the current part, which the last sample ends.
    fn compare(&mut self) {
        let (Some((start, Some(from))), Some((end, Some(to)))) =
            (self.part.first(), self.part.last())
        else {
            return;
        };
        let length_s = end.time - start.time;
        if length_s >= 1.5 * OVER_S {
            return;
        }
        // Trapezoidal integration over the samples.
        let mut turn = [0.0; 3];
        for pair in self.part.windows(2) {
            let [(before, _), (after, _)] = pair else { continue };
            for ((turn, a), b) in turn.iter_mut().zip(before.turn_radps).zip(after.turn_radps) {
                *turn += 0.5 * (a + b) * (after.time - before.time) / length_s;
            }
        }
        let change =
            (Rotation::from_euler(*from).inverse() * Rotation::from_euler(*to)).rotation_vector();
        self.regression.push(turn, change.to_array().map(|angle_rad| angle_rad / length_s));
    }

    /// Judges the gyros by the attitude. Returns false without an attitude for comparison.
    pub fn check(&self, found: &mut Vec<SetupFinding>) -> bool {
        with_attitude(&self.regression, self.largest_rad, found)
    }
}

/// Judges the gyros by an attitude whose angles are at most `largest_rad`, rad.
fn with_attitude(
    regression: &Regression<3>,
    largest_rad: f64,
    found: &mut Vec<SetupFinding>,
) -> bool {
    let Some(fit) = regression.fit(MIN_RADPS) else { return false };
    if fit.explained.iter().any(|&explained| explained < EXPLAINED) {
        return false;
    }
    let diagonal = [0, 1, 2].map(|axis| fit.matrix[axis][axis]);
    let key = |text: &str| format!("write {text} under [imu] in dataset.toml");
    let is_slow = diagonal.iter().all(|scale| (0.012..0.025).contains(scale));
    // Angles up to a full circle in radians, read as degrees.
    if is_slow && largest_rad <= TAU.to_radians() {
        found.push(SetupFinding {
            sensor: Sensor::UnitAttitude,
            is_certain: true,
            found: format!(
                "it turns at 1/{:.0} of the rate of the gyros, and no angle is larger than {:.1}°",
                3.0 / diagonal.iter().sum::<f64>(),
                largest_rad.to_degrees()
            ),
            cause: "roll, pitch and yaw in radians, expected degrees".into(),
            mend: "multiply the three columns by 57.29578".into(),
        });
        return true;
    }
    if is_slow {
        found.push(SetupFinding {
            sensor: Sensor::InertialUnit,
            is_certain: true,
            found: format!(
                "the gyros turn {:.0} times as fast as the inertial unit's own attitude",
                3.0 / diagonal.iter().sum::<f64>()
            ),
            cause: "angular rates in °/s, expected rad/s".into(),
            mend: key("gyro_unit = \"degps\""),
        });
        return true;
    }
    let wrong: Vec<&str> =
        (0..3).filter(|&axis| diagonal[axis] < -0.5).map(|axis| NAMES[axis]).collect();
    if !wrong.is_empty() {
        let all_but_x = wrong == ["y", "z"];
        found.push(SetupFinding {
            sensor: Sensor::InertialUnit,
            is_certain: true,
            found: format!(
                "gyro {} turns against the inertial unit's own attitude ({:.2}, {:.2}, {:.2} times as fast about \
                 x, y, z; expected 1)",
                wrong.join(" and "),
                diagonal[0],
                diagonal[1],
                diagonal[2]
            ),
            cause: if all_but_x {
                "axes forward, left, up, or gyros of the wrong sign".into()
            } else {
                "these gyros, or these angles of the attitude, of the wrong sign".into()
            },
            mend: if all_but_x {
                key("axes = \"flu\"")
            } else {
                "change the sign of the one that is not positive to the right (z, yaw), nose up (y, pitch) or right \
                 side down (x, roll)"
                    .into()
            },
        });
        return true;
    }
    for (a, b) in [(0, 1), (1, 2), (0, 2)] {
        let [ab, ba] = [fit.matrix[a][b], fit.matrix[b][a]];
        if ab.abs() > 0.6 && ba.abs() > 0.6 && diagonal[a].abs() < 0.4 && diagonal[b].abs() < 0.4 {
            found.push(SetupFinding {
                sensor: Sensor::InertialUnit,
                is_certain: true,
                found: format!(
                    "gyro {} turns like the inertial unit's own attitude about {}, and gyro {} like that about {} \
                     ({ab:.2} and {ba:.2} times as fast)",
                    NAMES[b], NAMES[a], NAMES[a], NAMES[b]
                ),
                cause: "two axes of the inertial unit swapped".into(),
                mend: format!("swap the columns of {} and {}, or set axes under [imu]", NAMES[a], NAMES[b]),
            });
            return true;
        }
    }
    let is_well_explained = fit.explained.iter().all(|&explained| explained > WELL_EXPLAINED);
    let right = if is_well_explained { NEAR_SCALES } else { SCALES };
    let off = diagonal.iter().find(|scale| !right.contains(scale));
    if let Some(scale) = off {
        found.push(SetupFinding {
            sensor: Sensor::InertialUnit,
            is_certain: false,
            found: format!(
                "the inertial unit's own attitude turns {scale:.2} times as fast as its gyros, expected 1"
            ),
            cause: "gyros with a wrong range or unit".into(),
            mend: String::new(),
        });
    }
    true
}
