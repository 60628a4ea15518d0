//! Heading of the solution compared with the course over ground: inertial units that are mounted backwards or sideways.

use hovernav::frames::wrap_angle;

use super::judged::Judged;
use crate::finding::{Sensor, SetupFinding};

/// Smallest speed at which a vehicle flies or drives forward, m/s: helicopters and multirotors hover and manoeuvre in
/// any direction at lower ones.
const FORWARD_MPS: f64 = 8.0;
/// Largest one-sigma of the heading, rad.
const KNOWN_RAD: f64 = 0.35;
/// Shortest total time at that speed, s.
const LASTING_S: f64 = 60.0;
/// Interval between compared solutions, s.
const STEP_S: f64 = 0.5;
/// Smallest length of the mean direction of motion in body axes, 0 to 1: the vehicle flies in one direction.
const STEADY: f64 = 0.9;
/// Largest length of the mean course, 0 to 1: a vehicle on one course may fly sideways or backwards.
const MANY_COURSES: f64 = 0.8;
/// Smallest angle between heading and course that sideslip and wind do not explain, rad (60°).
const ASKEW_RAD: f64 = 1.05;
/// Angles between the axes of a unit and of the vehicle that mountings usually have, and the distance from them that
/// counts as equal, degrees.
const USUAL_DEG: (f64, f64) = (90.0, 15.0);

/// Set-up error of an inertial unit whose x axis does not point along the course. The filter's heading comes from
/// accelerations, a magnetometer or an attitude, and not from the course.
pub(super) fn find(log: &Judged<'_>) -> Option<SetupFinding> {
    let (mut count, mut off, mut along, mut next_s) = (0.0, [0.0; 2], [0.0; 2], 0.0);
    for solution in &log.run.solutions {
        let [north, east, _] = solution.velocity_mps.to_array();
        let time_s = solution.time.seconds();
        let is_compared = time_s >= next_s
            && north.hypot(east) > FORWARD_MPS
            && solution.attitude_sigma_rad[2] < KNOWN_RAD;
        if is_compared {
            next_s = time_s + STEP_S;
            count += 1.0;
            let course_rad = east.atan2(north);
            for (sum, angle_rad) in [
                (&mut off, solution.body_to_ned.heading_rad() - course_rad),
                (&mut along, course_rad),
            ] {
                let (sin, cos) = angle_rad.sin_cos();
                *sum = [sum[0] + cos, sum[1] + sin];
            }
        }
    }
    let [steady, straight] = [off, along].map(|[cos, sin]| f64::hypot(cos, sin) / count);
    let off_rad = wrap_angle(f64::atan2(off[1], off[0]));
    let is_askew = count * STEP_S > LASTING_S
        && steady > STEADY
        && straight < MANY_COURSES
        && off_rad.abs() > ASKEW_RAD;
    if !is_askew {
        return None;
    }
    let (step_deg, near_deg) = USUAL_DEG;
    let off_deg = off_rad.to_degrees();
    let usual_deg = (off_deg / step_deg).round() * step_deg;
    let mounted_deg = if (off_deg - usual_deg).abs() < near_deg { usual_deg } else { off_deg };
    Some(SetupFinding {
        sensor: Sensor::InertialUnit,
        is_certain: false,
        found: format!(
            "the heading is {off_deg:.0}° off the course in {:.0} s at more than {FORWARD_MPS} m/s, expected about 0° \
             for a vehicle that moves forward",
            count * STEP_S
        ),
        cause: "an inertial unit mounted backwards or sideways, or x and y axes swapped".into(),
        mend: format!(
            "write mounting_deg = [0.0, 0.0, {mounted_deg:.1}] under [imu] in dataset.toml, in addition to angles \
             already there"
        ),
    })
}

#[cfg(test)]
mod tests {
    use hovernav::earth::Geodetic;
    use hovernav::ekf::Solution;
    use hovernav::frames::{EulerAngles, Rotation, Vector};
    use hovernav::time::Time;
    use hovernav_dataset::Dataset;
    use hovernav_replay::Run;

    use super::*;

    /// Remedy for two minutes at `speed_mps` along courses that turn at `turn_radps`, with a heading off the course.
    fn remedy(speed_mps: f64, turn_radps: f64, off_deg: f64) -> Option<String> {
        let place = Geodetic::from_degrees(48.0, 11.0, 500.0).unwrap();
        let solution = |step: u32| {
            let time_s = 0.1 * f64::from(step);
            let course_rad = turn_radps * time_s;
            let (east, north) = course_rad.sin_cos();
            let yaw_rad = course_rad + off_deg.to_radians() + 0.2 * (0.5 * time_s).sin();
            let angles = EulerAngles { roll_rad: 0.1, pitch_rad: 0.05, yaw_rad };
            Solution {
                velocity_mps: Vector::new(north, east, 0.0) * speed_mps,
                body_to_ned: Rotation::from_euler(angles),
                attitude_sigma_rad: [0.02, 0.02, 0.05],
                ..Solution::at_rest(Time::from_seconds(time_s), place)
            }
        };
        let mut run = Run::default();
        run.solutions = (0..1200).map(solution).collect();
        find(&Judged { dataset: &Dataset::default(), run: &run }).map(|found| found.mend)
    }

    #[test]
    fn a_unit_mounted_backwards_or_sideways_is_named() {
        for (off_deg, mounted) in [(178.0, "180.0]"), (-95.0, "-90.0]"), (150.0, "150.4]")] {
            let mend = remedy(15.0, 0.1, off_deg).unwrap();
            assert!(mend.contains(&format!("[0.0, 0.0, {mounted}")), "{mend}");
        }
    }

    #[test]
    fn forward_slow_and_straight_motion_is_right() {
        assert!(remedy(15.0, 0.1, 20.0).is_none());
        assert!(remedy(5.0, 0.1, 180.0).is_none());
        assert!(remedy(15.0, 0.0, 180.0).is_none());
    }
}
