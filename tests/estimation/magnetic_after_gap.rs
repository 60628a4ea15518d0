//! Magnetic heading after a gap with a tilt error. In a steep field a degree of tilt changes the heading by two
//! degrees, and the one-sigma must include that.

use hovernav::earth::Geodetic;
use hovernav::ekf::layout::Full;
use hovernav::ekf::{Estimator, EstimatorConfig};
use hovernav::event::Event;
use hovernav::frames::{Vector, wrap_angle};
use hovernav_sim::{DmuConfig, FlightPlan, GpsConfig, MagnetometerConfig, Recording, fly};

/// Banked turns to both sides, at 38° and 12 m/s, near Minneapolis, where the field dips by 70°.
fn turns(seed: u64) -> Recording {
    let place = Geodetic::from_degrees(45.3, -93.2, 250.0).unwrap();
    let plan = FlightPlan::hover_at(place, 1.0).hold(20.0);
    let plan = plan.accelerate(Vector::new(12.0, 0.0, 0.0), 4.0);
    let plan = (0..6).fold(plan, |plan, turn| {
        let sense = if turn % 2 == 0 { 1.0 } else { -1.0 };
        plan.turn(sense * core::f64::consts::TAU, 0.65).hold(1.0)
    });
    let dmu = DmuConfig {
        rate_hz: 50.0,
        attitude: None,
        magnetometer: Some(MagnetometerConfig::default()),
        ..DmuConfig::default()
    };
    fly(&plan.build().unwrap(), &dmu, &GpsConfig::default(), seed).unwrap()
}

/// Normalised squares of the heading errors in the twenty seconds after a gap, and the largest error, rad.
fn after_gap(recording: &Recording, gap_start_s: f64, gap_s: f64) -> (Vec<f64>, f64) {
    let mut config = EstimatorConfig::default();
    config.mounting.imu_lever_arm_m = DmuConfig::default().lever_arm_m;
    config.mounting.antenna_lever_arm_m = GpsConfig::default().lever_arm_m;
    let mut estimator = Box::new(Estimator::<Full, 28>::new(config));
    let gap = gap_start_s..gap_start_s + gap_s;
    let mut fixes = recording.fixes.iter().peekable();
    let (mut squares, mut max_rad) = (Vec::new(), 0.0f64);
    for (sample, truth) in recording.imu.iter().zip(&recording.truth) {
        let time_s = sample.time.seconds();
        if gap.contains(&time_s) || time_s > gap.end + 20.0 {
            continue;
        }
        while let Some(fix) = fixes.next_if(|fix| fix.time <= sample.time) {
            estimator.push(&Event::Gps(*fix), |_| ());
        }
        estimator.push(&Event::Imu(*sample), |_| ());
        if let Some(solution) = estimator.solution().filter(|_| time_s >= gap.end) {
            let [yaw, true_yaw] =
                [solution.body_to_ned, truth.body_to_ned].map(|turn| turn.euler().yaw_rad);
            let off_rad = wrap_angle(yaw - true_yaw);
            let [.., sigma_rad] = solution.attitude_sigma_rad;
            squares.push((off_rad / sigma_rad).powi(2));
            max_rad = max_rad.max(off_rad.abs());
        }
    }
    (squares, max_rad)
}

/// Both gaps that may hide any turn, as the filter knows, and short gaps as of a memory card.
#[test]
fn a_heading_that_a_leaning_filter_takes_from_a_steep_field_is_as_sure_as_it_leans() {
    for gap_s in [2.5, 0.6, 0.4] {
        let (mut squares, mut max_rad) = (Vec::new(), 0.0f64);
        for seed in 1..=4 {
            let recording = turns(seed);
            for step in 0..8 {
                let start_s = 32.0 + 3.7 * f64::from(step);
                let (of_one, off_rad) = after_gap(&recording, start_s, gap_s);
                squares.extend(of_one);
                max_rad = max_rad.max(off_rad);
            }
        }
        let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        let inside = squares.iter().filter(|&&square| square < 9.0).count() as f64;
        let inside = inside / squares.len() as f64;
        println!(
            "gap of {gap_s} s: heading over its one-sigma {rms:.2} rms, {:.1} % inside 3, at most {:.0} deg off",
            100.0 * inside,
            max_rad.to_degrees()
        );
        assert!(rms < 1.3 && inside > 0.97, "{gap_s} s: {rms} {inside}");
    }
}
