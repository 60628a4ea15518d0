//! A receiver that states its velocity as too accurate. The filter detects this, rejects almost nothing, and is never
//! reset.

use hovernav::earth::Geodetic;
use hovernav::ekf::layout::Full;
use hovernav::ekf::{Channel, Estimator, EstimatorConfig, Notice, Solution, Verdict};
use hovernav::event::Event;
use hovernav::frames::Vector;
use hovernav::gps::Fix;
use hovernav_dataset::Truth;
use hovernav_sim::{DmuConfig, FlightPlan, GpsConfig, fly};

/// Flies the test flight with fixes changed by `altered`, and passes each notice, and each solution with the truth, to
/// callbacks.
fn flown_through(
    seed: u64,
    altered: impl Fn(Fix) -> Option<Fix>,
    mut observe: impl FnMut(Notice),
    mut see: impl FnMut(&Solution, &Truth),
) {
    let (dmu, gps) = (DmuConfig::default(), GpsConfig::default());
    let place = Geodetic::from_degrees(1.35, 103.8, 50.0).unwrap();
    let plan = FlightPlan::test_flight(place, 0.9 * seed as f64);
    let recording = fly(&plan.build().unwrap(), &dmu, &gps, seed).unwrap();
    let mut config = EstimatorConfig::default();
    config.mounting.imu_lever_arm_m = dmu.lever_arm_m;
    config.mounting.antenna_lever_arm_m = gps.lever_arm_m;
    let mut estimator = Box::new(Estimator::<Full, 28>::new(config));
    let mut fixes = recording.fixes.iter().peekable();
    for (sample, truth) in recording.imu.iter().zip(&recording.truth) {
        while let Some(fix) = fixes.next_if(|fix| fix.time <= sample.time) {
            if let Some(fix) = altered(*fix) {
                estimator.push(&Event::Gps(fix), &mut observe);
            }
        }
        estimator.push(&Event::Imu(*sample), &mut observe);
        if let Some(solution) = estimator.solution() {
            see(&solution, truth);
        }
    }
}

/// Number of rejected vertical velocities, largest one-sigma of the tilt after 20 s, degrees, and number of resets. The
/// vertical velocity has a one-sigma of 0.5 m/s and is stated as `stated_mps`.
fn flown(seed: u64, stated_mps: f64) -> (usize, f64, usize) {
    let (mut refused, mut tilt_deg, mut reopened) = (0, 0.0, 0);
    let stated = Some(Vector::new(0.2, 0.2, stated_mps));
    flown_through(
        seed,
        |fix| Some(Fix { velocity_sigma_mps: stated, ..fix }),
        |notice| {
            let Notice::Updated(report) = notice else { return };
            reopened += usize::from(report.any_reset());
            refused += report
                .innovations()
                .filter(|axis| axis.channel == Channel::VelocityDown)
                .filter(|axis| axis.verdict == Verdict::Rejected)
                .count();
        },
        |solution, _| {
            if solution.time.seconds() > 20.0 {
                let [roll, pitch, _] = solution.attitude_sigma_rad;
                tilt_deg = f64::max(tilt_deg, roll.max(pitch).to_degrees());
            }
        },
    );
    (refused, tilt_deg, reopened)
}

#[test]
fn a_vertical_velocity_stated_too_good_is_found_out_and_locks_nobody_out() {
    for seed in 1..=10 {
        let (refused, tilt_deg, reopened) = flown(seed, 0.2);
        println!("seed {seed}: {refused} of 300 refused, tilt known to {tilt_deg:.2}°");
        assert!(refused <= 3, "seed {seed}: {refused} refused");
        assert!(reopened == 0 && tilt_deg < 1.5, "seed {seed}: {reopened} times, {tilt_deg}°");
    }
}

#[test]
fn what_is_stated_rightly_is_accepted() {
    for seed in 1..=4 {
        let (refused, _, reopened) = flown(seed, 0.5);
        assert_eq!((refused, reopened), (0, 0), "seed {seed}");
    }
}

/// RMS horizontal velocity error over its one-sigma after 20 s, for fixes of 0.2 m/s stated as a tenth of that.
#[test]
fn velocities_that_are_stated_ten_times_too_good_are_found_out() {
    for seed in 1..=6 {
        let stated = Vector::new(0.02, 0.02, 0.05);
        let (mut squares, mut count) = (0.0, 0.0);
        flown_through(
            seed,
            |fix| Some(Fix { velocity_sigma_mps: Some(stated), ..fix }),
            |_| (),
            |solution, truth| {
                if solution.time.seconds() > 20.0 {
                    let off = solution.velocity_mps - truth.velocity_mps;
                    let [north, east, _] = solution.velocity_sigma_mps.to_array();
                    squares += (off.x() / north).powi(2) + (off.y() / east).powi(2);
                    count += 2.0;
                }
            },
        );
        let rms = f64::sqrt(squares / count);
        println!("seed {seed}: velocity over its one-sigma {rms:.2} rms");
        assert!(rms < 2.5, "seed {seed}: {rms}");
    }
}

/// A receiver that starts with an error of 15 m and converges. After an outage it starts with an error of 12 m and
/// converges again. Its stated one-sigma is right throughout.
#[test]
fn a_receiver_that_converges_takes_its_error_back_with_it() {
    for seed in 1..=6 {
        let off = |time_s: f64| match time_s {
            ..120.0 => Some(14.0 * (-(time_s - 5.0) / 6.0).exp()),
            ..140.0 => None,
            _ => Some(11.0 * (-(time_s - 140.0) / 5.0).exp()),
        };
        let (mut squares, mut count, mut worst_m) = (0.0, 0.0, 0.0_f64);
        flown_through(
            seed,
            |fix| {
                let off_m = off(fix.time.seconds())?;
                Some(Fix {
                    position: fix.position.displaced(Vector::new(off_m, 0.0, 0.0)),
                    position_sigma_m: Some(
                        [1.6_f64, 1.6, 3.0].map(|usual_m| usual_m.hypot(off_m)).into(),
                    ),
                    ..fix
                })
            },
            |_| (),
            |solution, truth| {
                let off_m = solution.position.displacement_from(&truth.position).x();
                let sigma_m = solution.position_sigma_m.to_array()[0];
                squares += (off_m / sigma_m).powi(2);
                count += 1.0;
                if matches!(solution.time.seconds(), 50.0..120.0 | 170.0..) {
                    worst_m = worst_m.max(off_m.abs());
                }
            },
        );
        let rms = f64::sqrt(squares / count);
        println!(
            "seed {seed}: position over its one-sigma {rms:.2} rms, {worst_m:.1} m at worst once it has converged"
        );
        assert!(rms < 1.6 && worst_m < 6.0, "seed {seed}: {rms}, {worst_m}");
    }
}
