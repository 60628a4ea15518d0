//! A heading inconsistent with the fixes is replaced, and a consistent one is kept.

use hovernav::earth::Geodetic;
use hovernav::ekf::layout::Full;
use hovernav::ekf::{Estimator, EstimatorConfig, Notice};
use hovernav::event::Event;
use hovernav::frames::{EulerAngles, Rotation, Vector, wrap_angle};
use hovernav::imu::ImuSample;
use hovernav_sim::{DmuConfig, FlightPlan, GpsConfig, Recording, fly};

fn flight(seed: u64) -> Recording {
    let place = Geodetic::from_degrees(48.0, 11.0, 500.0).unwrap();
    let plan = FlightPlan::test_flight(place, 0.7 * seed as f64);
    fly(&plan.build().unwrap(), &DmuConfig::default(), &GpsConfig::default(), seed).unwrap()
}

/// Result of a flight whose heading source has a given error for a given time, s.
struct Outcome {
    /// Time of the heading's replacement, s.
    resets_s: Vec<f64>,
    /// Time when the heading became suspect, s.
    doubts_s: Vec<f64>,
    /// Time, s, and error of yaw, rad, at every sample.
    yaw_errors: Vec<(f64, f64)>,
    /// Number of samples beyond three one-sigmas.
    beyond: usize,
}

impl Outcome {
    fn worst_yaw_deg(&self, from_s: f64) -> f64 {
        let late = self.yaw_errors.iter().filter(|(seconds, _)| *seconds >= from_s);
        late.fold(0.0, |worst, (_, error)| f64::max(worst, error.abs().to_degrees()))
    }
}

fn estimated(recording: &Recording, off_rad: f64, until_s: f64) -> Outcome {
    let (dmu, gps) = (DmuConfig::default(), GpsConfig::default());
    let mut config = EstimatorConfig::default();
    config.mounting.imu_lever_arm_m = dmu.lever_arm_m;
    config.mounting.antenna_lever_arm_m = gps.lever_arm_m;
    config.ekf.imu.gyro_bias_sigma_radps = dmu.gyro.turn_on_bias_sigma_degps.to_radians();
    config.ekf.imu.accel_bias_sigma_mps2 = dmu.accelerometer.turn_on_bias_sigma_mps2;
    let mut estimator = Box::new(Estimator::<hovernav::ekf::layout::Full, 28>::new(config));
    let mut outcome =
        Outcome { resets_s: Vec::new(), doubts_s: Vec::new(), yaw_errors: Vec::new(), beyond: 0 };
    let mut fixes = recording.fixes.iter().peekable();
    for (sample, truth) in recording.imu.iter().zip(&recording.truth) {
        let off_rad = if sample.time.seconds() < until_s { off_rad } else { 0.0 };
        let turned = ImuSample {
            attitude: sample
                .attitude
                .map(|angles| EulerAngles { yaw_rad: angles.yaw_rad + off_rad, ..angles }),
            magnetic_field_gauss: sample.magnetic_field_gauss.map(|field| {
                let back = Vector::new(0.0, 0.0, -off_rad);
                Rotation::<_, hovernav::frames::Body>::IDENTITY.turned_in_from(back) * field
            }),
            ..*sample
        };
        let Outcome { resets_s, doubts_s, .. } = &mut outcome;
        let mut notify = |notice| match notice {
            Notice::HeadingReset { time, .. } => resets_s.push(time.seconds()),
            Notice::HeadingSuspect { time, .. } => doubts_s.push(time.seconds()),
            _ => {}
        };
        while let Some(fix) = fixes.next_if(|fix| fix.time <= sample.time) {
            estimator.push(&Event::Gps(*fix), &mut notify);
        }
        estimator.push(&Event::Imu(turned), &mut notify);
        if let Some(solution) = estimator.solution() {
            let yaw_rad = solution.body_to_ned.euler().yaw_rad;
            let error = wrap_angle(yaw_rad - truth.body_to_ned.euler().yaw_rad);
            outcome.yaw_errors.push((sample.time.seconds(), error));
            outcome.beyond += usize::from(error.abs() > 3.0 * solution.attitude_sigma_rad[2]);
        }
    }
    outcome
}

#[test]
fn a_right_heading_is_never_replaced() {
    for seed in 1..=6 {
        let outcome = estimated(&flight(seed), 0.0, 0.0);
        assert!(outcome.resets_s.is_empty(), "seed {seed}: {:?}", outcome.resets_s);
        assert!(outcome.doubts_s.is_empty(), "seed {seed}: {:?}", outcome.doubts_s);
    }
}

#[test]
fn a_wrong_heading_is_replaced_within_seconds_of_the_first_manoeuvre() {
    // The first test point begins at 20 s; the heading source stays wrong to the end.
    for (seed, off_deg) in [(1, 60.0), (2, -90.0), (3, 150.0), (4, 180.0)] {
        let outcome = estimated(&flight(seed), f64::to_radians(off_deg), f64::INFINITY);
        let [reset_s] = outcome.resets_s[..] else {
            panic!("{off_deg}°: replaced at {:?}", outcome.resets_s);
        };
        assert!((20.0..50.0).contains(&reset_s), "{off_deg}°: replaced at {reset_s} s");
        let worst_deg = outcome.worst_yaw_deg(reset_s + 60.0);
        println!("{off_deg}°: replaced at {reset_s} s, then at most {worst_deg:.1}° off");
        assert!(worst_deg < 20.0, "{off_deg}°: {worst_deg}° off");
    }
}

#[test]
fn what_gave_a_wrong_heading_is_used_again_once_it_agrees() {
    let outcome = estimated(&flight(5), 2.0, 120.0);
    assert_eq!(outcome.resets_s.len(), 1);
    let worst_deg = outcome.worst_yaw_deg(180.0);
    assert!(worst_deg < 6.0, "{worst_deg}° off");
}

#[test]
fn a_heading_that_is_a_little_off_is_suspect_or_replaced_and_mended_by_the_fixes() {
    for (seed, off_deg) in [(1, 20.0), (2, -20.0), (3, 15.0)] {
        let outcome = estimated(&flight(seed), f64::to_radians(off_deg), f64::INFINITY);
        let said = outcome.doubts_s.iter().chain(&outcome.resets_s).copied();
        let doubted_s = said.fold(f64::INFINITY, f64::min);
        let worst_deg = outcome.worst_yaw_deg(doubted_s + 60.0);
        println!("{off_deg}°: suspect at {doubted_s} s, then at most {worst_deg:.1}° off");
        assert!(doubted_s < 150.0, "{off_deg}°: {doubted_s} s");
        assert!(worst_deg < 0.7 * off_deg.abs(), "{off_deg}°: {worst_deg}° off");
    }
}

#[test]
fn a_heading_that_no_motion_has_proven_is_not_known() {
    // The vehicle is carried slowly and its inertial unit is turned by hand. The hypotheses of the heading search agree
    // on some heading.
    let field = Geodetic::from_degrees(47.0, 8.0, 400.0).unwrap();
    let mut plan = FlightPlan::hover_at(field, 0.7);
    for _ in 0..12 {
        plan = plan
            .accelerate(Vector::new(0.8, 0.0, 0.0), 3.0)
            .turn(2.0, 0.5)
            .accelerate(Vector::new(-0.8, 0.0, 0.0), 3.0)
            .hold(4.0);
    }
    let (dmu, gps) = (DmuConfig::default(), GpsConfig::default());
    let trajectory = plan.build().unwrap();
    for seed in 0..6 {
        let recording = fly(&trajectory, &dmu, &gps, seed).unwrap();
        let mut config = EstimatorConfig::default();
        config.mounting.imu_lever_arm_m = dmu.lever_arm_m;
        config.mounting.antenna_lever_arm_m = gps.lever_arm_m;
        config.aiding.attitude = false;
        config.aiding.magnetometer = false;
        let mut estimator = Box::new(Estimator::<Full, 28>::new(config));
        let mut fixes = recording.fixes.iter().peekable();
        let (mut found, mut worst, mut min_rad) = (false, 0.0, f64::INFINITY);
        for (sample, truth) in recording.imu.iter().zip(&recording.truth) {
            let mut notify = |notice| found |= matches!(notice, Notice::HeadingFound { .. });
            while let Some(fix) = fixes.next_if(|fix| fix.time <= sample.time) {
                estimator.push(&Event::Gps(*fix), &mut notify);
            }
            let bare = ImuSample { attitude: None, magnetic_field_gauss: None, ..*sample };
            estimator.push(&Event::Imu(bare), &mut notify);
            if let Some(solution) = estimator.solution().filter(|_| !found) {
                let [.., sigma_rad] = solution.attitude_sigma_rad;
                let yaw_rad = solution.body_to_ned.euler().yaw_rad;
                let off_rad = wrap_angle(yaw_rad - truth.body_to_ned.euler().yaw_rad);
                worst = f64::max(worst, off_rad.abs() / sigma_rad);
                min_rad = min_rad.min(sigma_rad);
            }
        }
        println!(
            "{seed}: found: {found}; before that {:.0}° at least, {worst:.1} one-sigmas at most",
            min_rad.to_degrees()
        );
        assert!(worst < 3.0, "{worst}");
    }
}
