//! An accelerometer on the vertical axis whose bias steps far beyond the range consistent with a good receiver's fixes.

use hovernav::ekf::layout::Full;
use hovernav::event::Event;
use hovernav::frames::Vector;
use hovernav::imu::{ImuSample, Motion};
use hovernav_sim::{GpsConfig, HorizontalVertical};

use crate::blocks::around_blocks;
use crate::unaided::flown_unaided;

/// Time of the step, s.
const STEP_S: f64 = 60.0;

/// Effect of the step on the solution.
#[derive(Debug, Default)]
struct Cost {
    /// Time for which the vertical velocity is outside 3 sigma, s.
    outside_s: f64,
    /// Part of this time after the first ten seconds, s.
    later_s: f64,
    /// Largest error of velocity, m/s.
    velocity_mps: f64,
    /// Largest error of height, m.
    height_m: f64,
}

fn flown(step_mps2: f64, rate_hz: f64, seed: u64) -> Cost {
    let gps = GpsConfig {
        rate_hz,
        velocity_noise_mps: HorizontalVertical::new(0.04, 0.05),
        velocity_wander_mps: HorizontalVertical::new(0.02, 0.03),
        ..GpsConfig::default()
    };
    let (recording, mut estimator) = flown_unaided::<Full, 28>(&around_blocks(20), &gps, seed);
    let mut fixes = recording.fixes.iter().peekable();
    let mut cost = Cost::default();
    for (sample, truth) in recording.imu.iter().zip(&recording.truth) {
        while let Some(fix) = fixes.next_if(|fix| fix.time <= sample.time) {
            estimator.push(&Event::Gps(*fix), |_| ());
        }
        let since_s = sample.time.seconds() - STEP_S;
        let rates = sample.motion.mean_rates(0.02);
        let step = Vector::new(0.0, 0.0, if since_s > 0.0 { step_mps2 } else { 0.0 });
        let motion = Motion::Rates {
            angular_rate_radps: rates.angular_rate_radps,
            specific_force_mps2: rates.specific_force_mps2 + step,
        };
        estimator.push(&Event::Imu(ImuSample { motion, ..*sample }), |_| ());
        let Some(solution) = estimator.solution().filter(|_| since_s > 0.0) else { continue };
        let off = (solution.velocity_mps - truth.velocity_mps).z().abs();
        let height = solution.position.displacement_from(&truth.position).z().abs();
        cost.velocity_mps = cost.velocity_mps.max(off);
        cost.height_m = cost.height_m.max(height);
        if off > 3.0 * solution.velocity_sigma_mps.z() {
            cost.outside_s += 0.02;
            cost.later_s += if since_s > 10.0 { 0.02 } else { 0.0 };
        }
    }
    cost
}

/// A filter that rejects these fixes for 15 s at a time would have vertical velocity errors of up to 35 m/s until the
/// log ends.
#[test]
fn it_is_learned_in_seconds_and_no_right_receiver_is_shut_out_by_it() {
    for rate_hz in [1.0, 5.0] {
        for step_mps2 in [-3.0, -2.0, -1.0, 1.0, 2.0, 3.0] {
            for seed in 0..3 {
                let cost = flown(step_mps2, rate_hz, seed);
                println!("{step_mps2} m/s² at {rate_hz} Hz, seed {seed}: {cost:.1?}");
                assert!(cost.outside_s < 7.0 && cost.later_s < 1.5);
                assert!(cost.velocity_mps < 3.5 * step_mps2.abs() + 1.0 && cost.height_m < 20.0);
            }
        }
    }
}
