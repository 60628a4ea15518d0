//! Finding the heading does not reduce the one-sigma of the height.

use hovernav::ekf::Notice;
use hovernav::ekf::layout::Full;
use hovernav::event::{BaroReading, Event};
use hovernav_sim::GpsConfig;

use crate::{blocks, unaided};

/// Standard deviation of the height, m, one second before the heading is found and five seconds after, with or without
/// a barometer at 10 Hz.
fn sigmas_m(with_barometer: bool) -> [f64; 2] {
    let gps = GpsConfig { rate_hz: 1.0, ..GpsConfig::default() };
    let (recording, mut estimator) =
        unaided::flown_unaided::<Full, 28>(&blocks::around_blocks(24), &gps, 1);
    let mut fixes = recording.fixes.iter().peekable();
    let (mut found_s, mut sigmas_m) = (None, Vec::new());
    for (index, (sample, truth)) in recording.imu.iter().zip(&recording.truth).enumerate() {
        let mut notify = |notice| {
            if let Notice::HeadingFound { time, .. } = notice {
                found_s = Some(time.seconds());
            }
        };
        while let Some(fix) = fixes.next_if(|fix| fix.time <= sample.time) {
            estimator.push(&Event::Gps(*fix), &mut notify);
        }
        estimator.push(&Event::Imu(*sample), &mut notify);
        if with_barometer && index % 5 == 0 {
            // The readings of a real barometer at rest differ in their last digits.
            let height_m = truth.position.height_m + 0.01 * (index % 7) as f64;
            estimator.push(&Event::Baro(BaroReading::new(sample.time, height_m)), &mut notify);
        }
        if let Some(now) = estimator.solution() {
            sigmas_m.push((sample.time.seconds(), now.position_sigma_m.to_array()[2]));
        }
    }
    let found_s: f64 = found_s.unwrap();
    [found_s - 1.0, found_s + 5.0].map(|at_s| {
        let after = sigmas_m.partition_point(|(time_s, _)| *time_s < at_s);
        sigmas_m[after].1
    })
}

#[test]
fn a_barometer_ties_no_height_to_a_place_that_the_search_took_for_known() {
    let [before_m, alone_m] = sigmas_m(false);
    let [_, with_m] = sigmas_m(true);
    println!("before {before_m:.2} m, after {alone_m:.2} m, with a barometer {with_m:.2} m");
    assert!(with_m > 0.8 * alone_m, "{with_m} of {alone_m}");
}
