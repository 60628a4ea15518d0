//! Relative pose error: the error of the motion over a fixed time, which no constant offset changes.

use std::iter;

use hovernav::earth::Geodetic;
use hovernav::ekf::Solution;
use hovernav::frames::{Body, EulerAngles, Ned, Rotation, Vector};
use hovernav::time::Time;

use crate::score::Statistics;
use hovernav_dataset::Reference;
use hovernav_dataset::statistics::thin_to_extremes;

/// Largest deviation of the time between two poses from the requested one, as a fraction of the requested time.
const TOLERANCE: f64 = 0.1;
/// Largest number of points in the series.
const SERIES_POINTS: usize = 2000;

/// Errors of the motion of a solution over a fixed time.
#[derive(Clone, Debug, PartialEq)]
pub struct RelativeError {
    /// Time over which the motion is compared, s.
    pub over_s: f64,
    /// Magnitude of the error of the translation, m.
    pub translation_m: Statistics,
    /// Angle of the error of the rotation, degrees; `None` without attitudes.
    pub rotation_deg: Option<Statistics>,
    /// The errors by the time of the earlier pose, thinned to at most 2 000 points that keep the peaks.
    pub series: Vec<RelativePoint>,
}

impl RelativeError {
    /// Sizes of the errors by unit: of the translation in `m` and, with attitudes, of the rotation in `deg`.
    pub fn sizes(&self) -> impl Iterator<Item = (&'static str, Statistics)> {
        let rotation = self.rotation_deg.map(|size| ("deg", size));
        iter::once(("m", self.translation_m)).chain(rotation)
    }
}

/// Error of the motion from one pose to the pose a fixed time later.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativePoint {
    /// Time of the earlier pose.
    pub time: Time,
    /// Error of the translation, m.
    pub translation_m: f64,
    /// Angle of the error of the rotation, degrees; NaN if an attitude is unknown.
    pub rotation_deg: f64,
}

#[derive(Clone, Copy)]
struct Pose {
    place: Geodetic,
    /// Not finite if unknown.
    body_to_ned: Rotation<Body, Ned>,
}

/// Errors of the motion of `solutions`, in time order, over `over_s` seconds against `reference`. `None` if no two
/// poses that far apart have a reference.
///
/// The translation is resolved in the body axes of the earlier pose, for each trajectory by its own attitude. So
/// neither a constant displacement nor a constant heading error counts. Without attitudes it is resolved in north,
/// east, down.
///
/// # Source
/// Sturm, Engelhard, Endres, Burgard, Cremers, *A benchmark for the evaluation of RGB-D SLAM systems*, IROS 2012,
/// section V.A.
#[must_use]
pub fn relative_error(
    solutions: &[Solution],
    reference: &Reference,
    over_s: f64,
) -> Option<RelativeError> {
    let mut points = Vec::new();
    let mut later = 0;
    for solution in solutions {
        // The pose nearest to the requested time.
        let off_s = |one: &Solution| (one.time - solution.time - over_s).abs();
        while let [now, next, ..] = solutions.get(later..).unwrap_or_default()
            && off_s(next) <= off_s(now)
        {
            later += 1;
        }
        let Some(end) = solutions.get(later) else { break };
        if off_s(end) > over_s * TOLERANCE {
            continue;
        }
        let own =
            [solution, end].map(|one| Pose { place: one.position, body_to_ned: one.body_to_ned });
        let other = [solution, end].map(|one| pose_at(reference, one.time));
        let (translation_m, rotation_deg) = error(own, other);
        if translation_m.is_finite() {
            points.push(RelativePoint { time: solution.time, translation_m, rotation_deg });
        }
    }
    let translations: Vec<f64> = points.iter().map(|point| point.translation_m).collect();
    let rotations: Vec<f64> =
        points.iter().map(|point| point.rotation_deg).filter(|angle| angle.is_finite()).collect();
    let drawn = thin_to_extremes(&[&translations], SERIES_POINTS);
    Some(RelativeError {
        over_s,
        translation_m: Statistics::of(&translations).filter(|_| !points.is_empty())?,
        rotation_deg: Statistics::of(&rotations),
        series: drawn.into_iter().map(|index| points[index]).collect(),
    })
}

fn pose_at(reference: &Reference, time: Time) -> Pose {
    let moment = reference.at(time);
    let [latitude_rad, longitude_rad, height_m] = moment.position;
    let [roll_rad, pitch_rad, yaw_rad] = moment.attitude_rad;
    Pose {
        place: Geodetic { latitude_rad, longitude_rad, height_m },
        body_to_ned: Rotation::from_euler(EulerAngles { roll_rad, pitch_rad, yaw_rad }),
    }
}

/// Error of the motion between the two poses of `own`, compared with that of `other`: translation, m, and rotation,
/// degrees.
fn error(own: [Pose; 2], other: [Pose; 2]) -> (f64, f64) {
    let has_attitude = [own, other].iter().flatten().all(|pose| pose.body_to_ned.is_finite());
    let moved_m = |[from, to]: [Pose; 2]| to.place.displacement_from(&from.place);
    if !has_attitude {
        return ((moved_m(own) - moved_m(other)).norm(), f64::NAN);
    }
    let moved_body_m =
        |poses: [Pose; 2]| -> Vector<Body> { poses[0].body_to_ned.inverse() * moved_m(poses) };
    // Rotation of the body from the earlier to the later pose.
    let turned = |[from, to]: [Pose; 2]| from.body_to_ned.inverse() * to.body_to_ned;
    let turn = turned(other).inverse() * turned(own);
    let angle_rad = turn.rotation_vector().norm();
    ((moved_body_m(own) - moved_body_m(other)).norm(), angle_rad.to_degrees())
}

#[cfg(test)]
mod tests {
    use super::*;
    use hovernav_dataset::Trajectory;

    /// Path from `start` over 10 s at 10 m/s along the heading, at 10 Hz. From 5 s on it turns with `turn_degps`.
    fn path(heading_deg: f64, turn_degps: f64, start: Geodetic) -> Vec<Solution> {
        let mut place = start;
        let of = |tenth: u32| {
            let time_s = 0.1 * f64::from(tenth);
            let heading_rad = (heading_deg + turn_degps * (time_s - 5.0).max(0.0)).to_radians();
            let angles = EulerAngles { roll_rad: 0.0, pitch_rad: 0.0, yaw_rad: heading_rad };
            let velocity = Vector::new(10.0 * heading_rad.cos(), 10.0 * heading_rad.sin(), 0.0);
            let solution = Solution {
                body_to_ned: Rotation::from_euler(angles),
                velocity_mps: velocity,
                ..Solution::at_rest(Time::from_seconds(time_s), place)
            };
            place = place.displaced(velocity * 0.1);
            solution
        };
        (0..100).map(of).collect()
    }

    fn reference(solutions: Vec<Solution>) -> Reference {
        let (local_m, warnings) = (Vec::new(), Vec::new());
        Reference::of_trajectory(&Trajectory { solutions, local_m, origin: None, warnings })
    }

    #[test]
    fn a_constant_displacement_and_heading_error_is_no_relative_error() {
        let start = Geodetic::from_degrees(47.0, 8.0, 400.0).unwrap();
        let elsewhere = start.displaced(Vector::new(30.0, -20.0, 5.0));
        let reference = reference(path(20.0, 0.0, start));
        let found = relative_error(&path(50.0, 0.0, elsewhere), &reference, 1.0).unwrap();
        assert!(found.translation_m.max < 1e-2, "{found:?}");
        assert!(found.rotation_deg.unwrap().max < 1e-6, "{found:?}");
    }

    #[test]
    fn an_error_of_the_turn_rate_shows_from_its_start_on() {
        let start = Geodetic::from_degrees(47.0, 8.0, 400.0).unwrap();
        let reference = reference(path(20.0, 0.0, start));
        let found = relative_error(&path(20.0, 6.0, start), &reference, 1.0).unwrap();
        // 6°/s over a second, and the chord of an arc of 10 m.
        assert!((found.rotation_deg.unwrap().max - 6.0).abs() < 0.1, "{found:?}");
        assert!((found.translation_m.max - 0.5).abs() < 0.06, "{found:?}");
        assert!(found.series[..30].iter().all(|point| point.translation_m < 1e-3), "{found:?}");
        assert_eq!(relative_error(&path(20.0, 6.0, start), &reference, 60.0), None);
    }
}
