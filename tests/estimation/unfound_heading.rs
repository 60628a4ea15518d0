//! One-sigmas of a solution during the search for its heading.

use hovernav::earth::Geodetic;
use hovernav::ekf::layout::Full;
use hovernav::event::{BaroReading, Event};
use hovernav::frames::Vector;
use hovernav_sim::{FlightPlan, GpsConfig, HorizontalVertical};

use crate::unaided::flown_unaided;

/// Two minutes of standing still or of hovering, then a move to one side.
fn plan(sway: bool) -> FlightPlan {
    let place = Geodetic::from_degrees(47.0, 8.0, 400.0).unwrap();
    let plan = FlightPlan::hover_at(place, 2.0);
    let plan = (0..12).fold(plan, |plan, _| {
        if sway { plan.hold(8.0).roll_doublet(0.02, 1.0) } else { plan.hold(10.0) }
    });
    plan.accelerate(Vector::new(7.0, 0.0, 0.0), 4.0).hold(6.0)
}

/// Normalised RMS errors of horizontal velocity and position before the heading is found, and the fraction of both
/// inside 3 sigma.
fn normalised(sway: bool, rate_hz: f64, seed: u64) -> ([f64; 2], f64) {
    let gps = GpsConfig {
        rate_hz,
        position_noise_m: HorizontalVertical::new(0.2, 0.4),
        position_wander_m: HorizontalVertical::new(1.4, 2.4),
        ..GpsConfig::default()
    };
    let (recording, mut estimator) = flown_unaided::<Full, 28>(&plan(sway), &gps, seed);
    let mut fixes = recording.fixes.iter().peekable();
    let (mut squares, mut inside, mut count) = ([0.0; 2], 0.0, 0.0);
    for (sample, truth) in recording.imu.iter().zip(&recording.truth) {
        while let Some(fix) = fixes.next_if(|fix| fix.time <= sample.time) {
            estimator.push(&Event::Gps(*fix), |_| ());
        }
        estimator.push(&Event::Imu(*sample), |_| ());
        let Some(solution) = estimator.solution() else { continue };
        let off = solution.velocity_mps - truth.velocity_mps;
        let away = solution.position.displacement_from(&truth.position);
        for (sum, (error, sigma)) in squares
            .iter_mut()
            .zip([(off, solution.velocity_sigma_mps), (away, solution.position_sigma_m)])
        {
            for (error, sigma) in [(error.x(), sigma.x()), (error.y(), sigma.y())] {
                *sum += 0.5 * (error / sigma) * (error / sigma);
                inside += 0.25 * f64::from(u8::from(error.abs() <= 3.0 * sigma));
            }
        }
        count += 1.0;
    }
    (squares.map(|sum: f64| (sum / count).sqrt()), inside / count)
}

/// The receiver has slow errors, for which the search has no states; neglecting them gives position errors of up to 4.5
/// one-sigmas.
#[test]
fn position_and_velocity_are_no_surer_than_the_receiver_and_the_headings_allow() {
    for sway in [false, true] {
        for rate_hz in [1.0, 5.0] {
            let runs: Vec<_> = (0..6).map(|seed| normalised(sway, rate_hz, seed)).collect();
            let mean = |axis: usize| {
                let squares: f64 = runs.iter().map(|run| run.0[axis] * run.0[axis]).sum();
                (squares / runs.len() as f64).sqrt()
            };
            let inside = runs.iter().map(|run| run.1).fold(1.0, f64::min);
            println!(
                "sways: {sway}, {rate_hz} Hz: velocity {:.2}, position {:.2}, inside {inside:.3}",
                mean(0),
                mean(1)
            );
            assert!(mean(0) < 1.3 && mean(1) < 1.3 && inside > 0.95);
        }
    }
}

/// Fixes end after 40 s of a hover; the barometer continues. The heading is unknown, and the height does not need it.
#[test]
fn a_barometer_holds_the_height_while_the_heading_is_unknown() {
    let (recording, mut estimator) =
        flown_unaided::<Full, 28>(&plan(true), &GpsConfig::default(), 4);
    let mut fixes = recording.fixes.iter().take_while(|fix| fix.time.seconds() < 40.0).peekable();
    let (mut farthest_m, mut farthest_sigmas) = (0.0_f64, 0.0_f64);
    for (count, (sample, truth)) in recording.imu.iter().zip(&recording.truth).enumerate() {
        while let Some(fix) = fixes.next_if(|fix| fix.time <= sample.time) {
            estimator.push(&Event::Gps(*fix), |_| ());
        }
        estimator.push(&Event::Imu(*sample), |_| ());
        if count % 5 == 0 {
            let height_m = truth.position.height_m + 30.0;
            estimator.push(&Event::Baro(BaroReading::new(sample.time, height_m)), |_| ());
        }
        if sample.time.seconds() > 40.0
            && let Some(solution) = estimator.solution()
        {
            let off_m = solution.position.displacement_from(&truth.position).z().abs();
            farthest_m = farthest_m.max(off_m);
            farthest_sigmas = farthest_sigmas.max(off_m / solution.position_sigma_m.z());
        }
    }
    assert!(estimator.filter().is_none(), "its heading is unknown to the end");
    // Without the barometer the error is 500 m and more.
    assert!(farthest_m < 8.0, "{farthest_m} m");
    assert!(farthest_sigmas < 3.0, "{farthest_sigmas} sigma");
}

/// A position of the receiver jumps by 200 m for 15 s; its velocity stays right.
#[test]
fn a_position_that_jumps_alone_is_not_believed_while_the_heading_is_unknown() {
    for seed in 0..3 {
        let (recording, mut estimator) =
            flown_unaided::<Full, 28>(&plan(true), &GpsConfig::default(), seed);
        let mut fixes = recording.fixes.iter().peekable();
        let mut farthest_m = 0.0_f64;
        for (sample, truth) in recording.imu.iter().zip(&recording.truth) {
            while let Some(fix) = fixes.next_if(|fix| fix.time <= sample.time) {
                let mut fix = *fix;
                if (30.0..45.0).contains(&fix.time.seconds()) {
                    fix.position = fix.position.displaced(Vector::new(200.0, 0.0, 0.0));
                }
                estimator.push(&Event::Gps(fix), |_| ());
            }
            estimator.push(&Event::Imu(*sample), |_| ());
            let second = sample.time.seconds();
            assert!(second > 45.0 || estimator.filter().is_none(), "its heading is unknown");
            if (20.0..60.0).contains(&second) {
                let solution = estimator.solution().unwrap();
                let off = solution.position.displacement_from(&truth.position);
                farthest_m = farthest_m.max(off.x().hypot(off.y()));
            }
        }
        assert!(farthest_m < 10.0, "{farthest_m} m, seed {seed}");
    }
}

/// A gap of 1 s interrupts the search. The search starts again with the uncertainty of the gyro bias, which a monitor of
/// a known heading lacks.
#[test]
fn a_gap_leaves_the_gyro_bias_as_uncertain_as_before() {
    let (recording, mut estimator) =
        flown_unaided::<Full, 28>(&plan(false), &GpsConfig::default(), 2);
    let mut fixes = recording.fixes.iter().peekable();
    let mut sigmas_radps = Vec::new();
    for sample in recording.imu.iter().take_while(|sample| sample.time.seconds() < 60.0) {
        while let Some(fix) = fixes.next_if(|fix| fix.time <= sample.time) {
            estimator.push(&Event::Gps(*fix), |_| ());
        }
        if (30.0..31.0).contains(&sample.time.seconds()) {
            continue;
        }
        estimator.push(&Event::Imu(*sample), |_| ());
        if let Some(solution) = estimator.solution() {
            sigmas_radps.push((sample.time.seconds(), solution.gyro_bias_sigma_radps.z()));
        }
    }
    assert!(estimator.filter().is_none(), "its heading is unknown to the end");
    let at = |second: f64| sigmas_radps.iter().find(|(time, _)| *time > second).unwrap().1;
    let [before, after] = [29.5, 40.0].map(at);
    assert!(after > 0.8 * before, "{before} and {after} rad/s");
}
