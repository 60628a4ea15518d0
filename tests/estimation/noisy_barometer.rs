//! A barometer much noisier than stated. The filter learns its scatter, so that height and vertical velocity stay
//! within their one-sigmas.

use hovernav::earth::Geodetic;
use hovernav::ekf::layout::Full;
use hovernav::ekf::{Estimator, EstimatorConfig, Notice};
use hovernav::event::{BaroReading, Event};
use hovernav_sim::{DmuConfig, FlightPlan, GpsConfig, Recording, fly};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;
use rand_distr::{Distribution as _, Normal};

/// An estimator with the lever arms of the simulated sensors, which `learns` the barometer's scatter.
fn estimator(learns: bool) -> Box<Estimator<Full, 28>> {
    let mut config = EstimatorConfig::default();
    config.mounting.imu_lever_arm_m = DmuConfig::default().lever_arm_m;
    config.mounting.antenna_lever_arm_m = GpsConfig::default().lever_arm_m;
    config.ekf.mechanisms.barometer_scatter = learns;
    Box::new(Estimator::new(config))
}

/// Errors from 30 s on: of height, m, and of vertical velocity, m/s. Each is given as the root mean square and as the
/// fraction within 3σ.
fn errors(recording: &Recording, noise_m: f64, learns: bool, seed: u64) -> [[f64; 2]; 2] {
    let mut estimator = estimator(learns);
    let mut noise = ChaCha8Rng::seed_from_u64(seed);
    let normal = Normal::new(0.0, noise_m).unwrap();
    let mut fixes = recording.fixes.iter().peekable();
    let (mut squares, mut inside, mut count) = ([0.0; 2], [0.0; 2], 0.0);
    for (index, (sample, truth)) in recording.imu.iter().zip(&recording.truth).enumerate() {
        while let Some(fix) = fixes.next_if(|fix| fix.time <= sample.time) {
            estimator.push(&Event::Gps(*fix), |_| ());
        }
        estimator.push(&Event::Imu(*sample), |_| ());
        if index % 3 == 0 {
            let height_m = truth.position.height_m + normal.sample(&mut noise);
            estimator.push(&Event::Baro(BaroReading::new(sample.time, height_m)), |_| ());
        }
        if sample.time.seconds() < 30.0 {
            continue;
        }
        let solution = estimator.solution().expect("it is aligned");
        let [.., down_mps] = (solution.velocity_mps - truth.velocity_mps).to_array();
        let [.., sigma_m] = solution.position_sigma_m.to_array();
        let [.., sigma_mps] = solution.velocity_sigma_mps.to_array();
        let off = [solution.position.height_m - truth.position.height_m, down_mps];
        for (quantity, sigma) in [sigma_m, sigma_mps].into_iter().enumerate() {
            squares[quantity] += off[quantity] * off[quantity];
            inside[quantity] += f64::from(u8::from(off[quantity].abs() <= 3.0 * sigma));
        }
        count += 1.0;
    }
    [0, 1].map(|quantity: usize| [f64::sqrt(squares[quantity] / count), inside[quantity] / count])
}

#[test]
fn a_barometer_eight_times_as_noisy_as_stated_spoils_neither_height_nor_vertical_velocity() {
    let start = Geodetic::from_degrees(1.3521, 103.8198, 50.0).unwrap();
    let plan = FlightPlan::hover_at(start, 0.0).hold(10.0).test_points().hold(60.0).test_points();
    let trajectory = plan.build().unwrap();
    for seed in 1..=2 {
        let recording =
            fly(&trajectory, &DmuConfig::default(), &GpsConfig::default(), seed).unwrap();
        let [[quiet_m, _], [quiet_mps, _]] = errors(&recording, 0.5, true, seed);
        let [[height_m, height_inside], [down_mps, down_inside]] =
            errors(&recording, 4.0, true, seed);
        let [[unlearned_m, _], [unlearned_mps, _]] = errors(&recording, 4.0, false, seed);
        println!(
            "{quiet_m:.2} m, {quiet_mps:.3} m/s as stated; {height_m:.2} m, {down_mps:.3} m/s noisy; \
             {unlearned_m:.2} m, {unlearned_mps:.3} m/s unlearned"
        );
        assert!(height_inside > 0.99 && down_inside > 0.99, "{height_inside} {down_inside}");
        assert!(height_m < 1.5 * quiet_m.max(1.0), "{height_m} {quiet_m}");
        assert!(down_mps < 0.7 * unlearned_mps, "{down_mps} {unlearned_mps}");
        assert!(unlearned_m > 1.15 * height_m, "{unlearned_m} {height_m}");
    }
}

/// From 40 s on, heights of a receiver alternate between two levels, which contradict each other and the barometer.
#[test]
fn horizontal_positions_survive_heights_of_two_levels() {
    let start = Geodetic::from_degrees(1.3521, 103.8198, 50.0).unwrap();
    let plan = FlightPlan::hover_at(start, 0.0).hold(10.0).test_points().hold(60.0);
    let mut recording =
        fly(&plan.build().unwrap(), &DmuConfig::default(), &GpsConfig::default(), 3).unwrap();
    for (index, fix) in recording.fixes.iter_mut().enumerate().skip(40) {
        fix.position.height_m += if index % 2 == 0 { 20.0 } else { -20.0 };
    }
    let mut estimator = estimator(true);
    let mut fixes = recording.fixes.iter().peekable();
    let (mut contradictions, mut farthest_m) = (0, 0.0_f64);
    for (sample, truth) in recording.imu.iter().zip(&recording.truth) {
        let mut observe = |notice: Notice| {
            contradictions +=
                u32::from(matches!(notice, Notice::Updated(report) if report.contradicts_itself()));
        };
        while let Some(fix) = fixes.next_if(|fix| fix.time <= sample.time) {
            estimator.push(&Event::Gps(*fix), &mut observe);
        }
        estimator.push(&Event::Imu(*sample), &mut observe);
        estimator.push(
            &Event::Baro(BaroReading::new(sample.time, truth.position.height_m + 20.0)),
            |_| (),
        );
        if sample.time.seconds() > 10.0 {
            let solution = estimator.solution().expect("it is aligned");
            let off = solution.position.displacement_from(&truth.position);
            farthest_m = farthest_m.max(off.x().hypot(off.y()));
        }
    }
    assert!(contradictions > 20, "{contradictions}");
    assert!(farthest_m < 8.0, "{farthest_m} m");
}
