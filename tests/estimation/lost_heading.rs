//! Gaps in the inertial samples of a turning vehicle whose heading comes from fixes alone.

use hovernav::ekf::Notice;
use hovernav::ekf::layout::Full;
use hovernav::event::Event;
use hovernav::frames::wrap_angle;
use hovernav::gps::Fix;
use hovernav_sim::GpsConfig;

use crate::blocks::around_blocks;
use crate::unaided::flown_unaided;

/// Gaps, from second to second: in corners and on straights, some within seconds of each other.
const GAPS_S: [[f64; 2]; 6] =
    [[60.0, 61.6], [75.3, 76.9], [79.7, 81.3], [101.0, 102.6], [125.5, 127.1], [150.0, 155.0]];

struct Drive {
    /// RMS error of yaw over all solutions from 40 s on, rad.
    yaw_rad: f64,
    /// Largest error of velocity in the same time, m/s.
    velocity_mps: f64,
    /// Largest horizontal error of position in the same time, m.
    horizontal_m: f64,
    /// Fractions of the solutions inside 3 sigma: yaw and horizontal velocity.
    inside: [f64; 2],
    found: usize,
}

fn driven(seed: u64, fix: impl Fn(&Fix) -> Fix) -> Drive {
    let gps = GpsConfig::default();
    let (recording, mut estimator) = flown_unaided::<Full, 28>(&around_blocks(24), &gps, seed);
    let mut fixes = recording.fixes.iter().peekable();
    let (mut count, mut squares, mut inside, mut found) = (0.0, 0.0, [0.0; 2], 0);
    let (mut velocity_mps, mut horizontal_m) = (0.0f64, 0.0f64);
    for (sample, truth) in recording.imu.iter().zip(&recording.truth) {
        let seconds = sample.time.seconds();
        let mut notify =
            |notice| found += usize::from(matches!(notice, Notice::HeadingFound { .. }));
        while let Some(next) = fixes.next_if(|fix| fix.time <= sample.time) {
            estimator.push(&Event::Gps(fix(next)), &mut notify);
        }
        if GAPS_S.iter().any(|[start, end]| (*start..*end).contains(&seconds)) {
            continue;
        }
        estimator.push(&Event::Imu(*sample), &mut notify);
        let Some(solution) = estimator.solution().filter(|_| seconds > 40.0) else { continue };
        let yaw = solution.body_to_ned.heading_rad() - truth.body_to_ned.heading_rad();
        let yaw = wrap_angle(yaw);
        let off = solution.velocity_mps - truth.velocity_mps;
        let away = solution.position.displacement_from(&truth.position);
        count += 1.0;
        squares += yaw * yaw;
        velocity_mps = velocity_mps.max(off.x().hypot(off.y()));
        horizontal_m = horizontal_m.max(away.x().hypot(away.y()));
        inside[0] += f64::from(yaw.abs() <= 3.0 * solution.attitude_sigma_rad[2]);
        let sigma = solution.velocity_sigma_mps;
        let is_inside = off.x().abs() <= 3.0 * sigma.x() && off.y().abs() <= 3.0 * sigma.y();
        inside[1] += f64::from(is_inside);
    }
    let yaw_rad = f64::sqrt(squares / count);
    let inside = inside.map(|inside| inside / count);
    Drive { yaw_rad, velocity_mps, horizontal_m, inside, found }
}

/// Bounds of a drive: smallest fraction inside 3 sigma, and largest errors of yaw (RMS), velocity and position.
struct Bounds {
    inside: f64,
    yaw_deg: f64,
    velocity_mps: f64,
    horizontal_m: f64,
}

/// The worst of ten drives.
fn judge(what: &str, bounds: &Bounds, fix: impl Fn(&Fix) -> Fix) {
    for seed in 0..10 {
        let drive = driven(seed, &fix);
        let yaw_deg = drive.yaw_rad.to_degrees();
        println!(
            "{what}, seed {seed}: yaw {yaw_deg:.1} deg rms; at most {:.1} m/s and {:.1} m off; inside 3 sigma: yaw \
             {:.3}, velocity {:.3}; found {} times",
            drive.velocity_mps, drive.horizontal_m, drive.inside[0], drive.inside[1], drive.found
        );
        assert!(drive.inside.iter().all(|inside| *inside > bounds.inside));
        assert!(yaw_deg < bounds.yaw_deg && drive.velocity_mps < bounds.velocity_mps);
        assert!(drive.horizontal_m < bounds.horizontal_m && drive.found > 1);
    }
}

#[test]
fn a_heading_that_gaps_hide_in_turns_is_found_again() {
    let bounds = Bounds { inside: 0.97, yaw_deg: 20.0, velocity_mps: 8.0, horizontal_m: 12.0 };
    judge("position and velocity", &bounds, Fix::clone);
}

/// A velocity from two positions a second apart is five times less accurate.
#[test]
fn a_heading_that_gaps_hide_in_turns_is_found_again_by_positions_alone() {
    let bounds = Bounds { inside: 0.9, yaw_deg: 40.0, velocity_mps: 14.0, horizontal_m: 20.0 };
    let alone = |fix: &Fix| Fix { horizontal_velocity_mps: None, down_velocity_mps: None, ..*fix };
    judge("position", &bounds, alone);
}
