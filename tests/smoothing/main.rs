//! An estimate from the complete log is at least as accurate as an estimate from the log up to its own time.

mod blocks;
mod denied;
mod reset;
mod textbook;

use std::path::Path;

use hovernav::earth::Geodetic;
use hovernav::ekf::{EkfConfig, EstimatorConfig, Solution};
use hovernav::frames::{Vector, wrap_angle};
use hovernav::ins::HeadingSource;
use hovernav::time::Time;
use hovernav_dataset::Truth;
use hovernav_dataset::{Dataset, Outage, Reference};
use hovernav_replay::smooth;
use hovernav_score::{Axis, Score, score};
use hovernav_sim::{
    AttitudeConfig, DmuConfig, FlightPlan, GpsConfig, HorizontalVertical, Recording, Trajectory,
    fly,
};

fn field() -> Geodetic {
    Geodetic::from_degrees(1.352, 103.82, 50.0).unwrap()
}

fn test_flight() -> Trajectory {
    FlightPlan::test_flight(field(), 0.7).build().unwrap()
}

fn simulated(
    trajectory: &Trajectory,
    gps: &GpsConfig,
    seed: u64,
) -> (Dataset, EstimatorConfig, Vec<Truth>) {
    recorded(trajectory, &DmuConfig::default(), gps, seed)
}

fn recorded(
    trajectory: &Trajectory,
    dmu: &DmuConfig,
    gps: &GpsConfig,
    seed: u64,
) -> (Dataset, EstimatorConfig, Vec<Truth>) {
    let Recording { imu, fixes, truth } = fly(trajectory, dmu, gps, seed).unwrap();
    let mut config = EstimatorConfig::default();
    config.mounting.imu_lever_arm_m = dmu.lever_arm_m;
    config.mounting.antenna_lever_arm_m = gps.lever_arm_m;
    (Dataset { imu, fixes, ..Dataset::default() }, config, truth)
}

/// Position, velocity and attitude errors, SI units, each with its one-sigma.
fn errors(solution: &Solution, truth: &[Truth]) -> [(f64, f64); 9] {
    let there = &truth[truth.partition_point(|truth| truth.time < solution.time)];
    assert_eq!(there.time, solution.time);
    let position = solution.position.displacement_from(&there.position).to_array();
    let velocity = (solution.velocity_mps - there.velocity_mps).to_array();
    let (found, true_angles) = (solution.body_to_ned.euler(), there.body_to_ned.euler());
    let attitude = [
        found.roll_rad - true_angles.roll_rad,
        found.pitch_rad - true_angles.pitch_rad,
        wrap_angle(found.yaw_rad - true_angles.yaw_rad),
    ];
    let errors = [position, velocity, attitude].concat();
    let sigmas = [
        solution.position_sigma_m.to_array(),
        solution.velocity_sigma_mps.to_array(),
        solution.attitude_sigma_rad,
    ]
    .concat();
    std::array::from_fn(|axis| (errors[axis], sigmas[axis]))
}

fn rmse(solutions: &[Solution], truth: &[Truth]) -> [f64; 9] {
    let mut sums = [0.0; 9];
    for solution in solutions {
        for (sum, (error, _)) in sums.iter_mut().zip(errors(solution, truth)) {
            *sum += error * error;
        }
    }
    sums.map(|sum| (sum / solutions.len() as f64).sqrt())
}

const AXES: [&str; 9] = ["n", "e", "d", "vn", "ve", "vd", "roll", "pitch", "yaw"];

/// A flight whose errors match the filter's model. Receiver and attitude reference have the assumed errors, and fixes
/// report their one-sigma. The inertial unit has no scale errors, for which this filter has no states, and the filter
/// knows the size of its biases.
fn as_modelled(seed: u64) -> (Dataset, EstimatorConfig, Vec<Truth>) {
    let EkfConfig { gps: model, attitude, .. } = EkfConfig::default();
    let split = |horizontal: f64, vertical: f64, share: f64| {
        let white = (1.0 - share * share).sqrt();
        (
            HorizontalVertical::new(white * horizontal, white * vertical),
            HorizontalVertical::new(share * horizontal, share * vertical),
        )
    };
    let (position_noise_m, position_wander_m) =
        split(model.horizontal_sigma_m, model.vertical_sigma_m, model.position_wander_share);
    let (horizontal, vertical) =
        (model.horizontal_velocity_sigma_mps, model.vertical_velocity_sigma_mps);
    let (velocity_noise_mps, velocity_wander_mps) =
        split(horizontal, vertical, model.velocity_wander_share);
    let gps = GpsConfig {
        position_noise_m,
        position_wander_m,
        position_wander_time_s: model.position_wander_time_s,
        velocity_noise_mps,
        velocity_wander_mps,
        velocity_wander_time_s: model.velocity_wander_time_s,
        ..GpsConfig::default()
    };
    let tilt_deg = attitude.tilt_wander_rad.to_degrees();
    let reference = AttitudeConfig {
        wander_sigma_deg: [tilt_deg, tilt_deg, attitude.heading_wander_rad.to_degrees()],
        wander_time_s: attitude.wander_time_s,
        noise_sigma_deg: attitude.noise_rad.to_degrees(),
        ..AttitudeConfig::default()
    };
    let mut dmu = DmuConfig { attitude: Some(reference), ..DmuConfig::default() };
    dmu.gyro.scale_factor_sigma = 0.0;
    dmu.accelerometer.scale_factor_sigma = 0.0;
    let (mut dataset, mut config, truth) = recorded(&test_flight(), &dmu, &gps, seed);
    for fix in &mut dataset.fixes {
        let (across, down) = (model.horizontal_sigma_m, model.vertical_sigma_m);
        fix.position_sigma_m = Some(Vector::new(across, across, down));
        fix.velocity_sigma_mps = Some(Vector::new(horizontal, horizontal, vertical));
    }
    config.ekf.imu.gyro_bias_sigma_radps = 0.3f64.to_radians();
    config.ekf.imu.accel_bias_sigma_mps2 = 0.1;
    (dataset, config, truth)
}

#[test]
fn smoothing_improves_every_axis_and_knows_how_good_it_is() {
    let mut squares = [[0.0; 2]; 9];
    let mut within = [0.0; 9];
    let mut count = 0.0;
    for seed in 1..=6 {
        let (dataset, config, truth) = as_modelled(seed);
        let run = smooth(&dataset, &config, |_| ());
        assert_eq!(run.solutions.len(), run.forward.solutions.len());
        for (smoothed, causal) in run.solutions.iter().zip(&run.forward.solutions) {
            assert_eq!(smoothed.time, causal.time);
            let pairs = errors(causal, &truth).into_iter().zip(errors(smoothed, &truth));
            for (axis, ((before, _), (after, sigma))) in pairs.enumerate() {
                squares[axis][0] += before * before;
                squares[axis][1] += after * after;
                within[axis] += f64::from(u8::from(after.abs() <= 3.0 * sigma));
            }
            count += 1.0;
            for (smoothed, causal) in [
                (smoothed.gyro_bias_sigma_radps, causal.gyro_bias_sigma_radps),
                (smoothed.accel_bias_sigma_mps2, causal.accel_bias_sigma_mps2),
            ] {
                for (smoothed, causal) in smoothed.to_array().into_iter().zip(causal.to_array()) {
                    assert!(smoothed > 0.0 && smoothed <= causal * (1.0 + 1e-9));
                }
            }
        }
    }
    for axis in 0..9 {
        let [before, after] = squares[axis].map(|sum: f64| (sum / count).sqrt());
        println!("{:5} {before:.4} to {after:.4}, {:.4}", AXES[axis], within[axis] / count);
    }
    for axis in 0..9 {
        assert!(squares[axis][1] < squares[axis][0], "{}", AXES[axis]);
        // Position is excluded. At the aligning fix the filter initialises it as if this fix were independent of the
        // receiver's slow error. Its sigma is therefore too small from the start, with and without smoothing.
        assert!(axis < 3 || within[axis] >= 0.98 * count, "{}", AXES[axis]);
    }
}

#[test]
fn the_last_moment_is_as_the_filter_left_it() {
    let hover = FlightPlan::hover_at(field(), 0.7).hold(30.0).build().unwrap();
    let (mut dataset, config, _) = simulated(&hover, &GpsConfig::default(), 1);
    let end = dataset.imu.last().unwrap().time;
    dataset.fixes.retain(|fix| fix.time < end);
    let run = smooth(&dataset, &config, |_| ());
    let (smoothed, causal) = (run.solutions.last().unwrap(), run.forward.solutions.last().unwrap());
    assert_eq!(smoothed.velocity_mps, causal.velocity_mps);
    assert_eq!(smoothed.velocity_sigma_mps, causal.velocity_sigma_mps);
}

#[test]
fn an_outage_is_bridged_from_both_sides() {
    let (mut dataset, config, truth) = simulated(&test_flight(), &GpsConfig::default(), 5);
    let start = Time::ZERO + 120.0;
    dataset.withhold(&[Outage { start, duration_s: 20.0 }], None);
    let run = smooth(&dataset, &config, |_| ());
    // The last third of the time, where the filter has drifted longest.
    let drift = |solutions: &[Solution]| {
        let inside = |solution: &&Solution| {
            let into_s = solution.time - start;
            (13.0..19.5).contains(&into_s)
        };
        let chosen: Vec<Solution> = solutions.iter().filter(inside).copied().collect();
        let rmse = rmse(&chosen, &truth);
        (rmse[0].hypot(rmse[1]), rmse[3].hypot(rmse[4]))
    };
    let (causal_m, causal_mps) = drift(&run.forward.solutions);
    let (smoothed_m, smoothed_mps) = drift(&run.solutions);
    println!("{causal_m:.2} m, {causal_mps:.2} m/s to {smoothed_m:.2} m, {smoothed_mps:.2} m/s");
    assert!(smoothed_mps < 0.5 * causal_mps);
    assert!(smoothed_m < causal_m);
}

#[test]
fn a_gap_in_the_inertial_samples_is_bridged() {
    let (mut dataset, config, truth) = simulated(&test_flight(), &GpsConfig::default(), 5);
    dataset.imu.retain(|sample| !(100.0..103.0).contains(&sample.time.seconds()));
    let run = smooth(&dataset, &config, |_| ());
    let (causal, smoothed) = (rmse(&run.forward.solutions, &truth), rmse(&run.solutions, &truth));
    println!("{causal:.3?}\n{smoothed:.3?}");
    for axis in 3..9 {
        assert!(smoothed[axis] < causal[axis], "{}", AXES[axis]);
    }
}

#[test]
fn a_heading_found_in_motion_holds_from_the_start() {
    let (dataset, mut config, truth) = simulated(&test_flight(), &GpsConfig::default(), 2);
    config.alignment.heading = Some(HeadingSource::Unknown);
    config.aiding.attitude = false;
    config.aiding.magnetometer = false;
    let run = smooth(&dataset, &config, |_| ());
    assert_eq!(run.solutions.len(), run.forward.solutions.len());
    let worst = |solutions: &[Solution]| {
        solutions.iter().map(|solution| errors(solution, &truth)[8].0.abs()).fold(0.0, f64::max)
    };
    let (causal, smoothed) = (worst(&run.forward.solutions), worst(&run.solutions));
    println!("{:.1}° to {:.1}°", causal.to_degrees(), smoothed.to_degrees());
    assert!(causal > 30f64.to_radians() && smoothed < 10f64.to_radians());
}

#[test]
fn a_heading_never_found_is_not_guessed() {
    let hover = FlightPlan::hover_at(field(), 0.7).hold(20.0).build().unwrap();
    let (dataset, mut config, _) = simulated(&hover, &GpsConfig::default(), 1);
    config.alignment.heading = Some(HeadingSource::Unknown);
    let run = smooth(&dataset, &config, |_| ());
    assert!(run.solutions.is_empty() && !run.forward.solutions.is_empty());
}

#[test]
fn nothing_gives_nothing() {
    let run = smooth(&Dataset::default(), &EstimatorConfig::default(), |_| ());
    assert!(run.solutions.is_empty() && run.forward.solutions.is_empty());
}

#[test]
fn the_hover_log_smoothed_is_within_the_promised_velocity() {
    let dir = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/heli-hover"));
    let mut dataset = Dataset::open(dir).unwrap();
    let config = dataset.settings().unwrap();
    let reference = Reference::open(dir, &dataset.manifest).unwrap().unwrap();
    let run = smooth(&dataset, &config, |_| ());
    let first = dataset.imu[0].time;
    let causal = score(&run.forward.solutions, &reference, first);
    let smoothed = score(&run.solutions, &reference, first);
    let rmse = |score: &Score, axis| score.axis(axis).unwrap().statistics.rmse;
    for axis in Axis::ALL {
        let within = smoothed.axis(axis).unwrap().within_3_sigma;
        println!("{axis:?}: {:.4} to {:.4} {within:?}", rmse(&causal, axis), rmse(&smoothed, axis));
    }
    for (axis, limit) in
        [(Axis::VelocityNorth, 0.065), (Axis::VelocityEast, 0.065), (Axis::VelocityDown, 0.09)]
    {
        assert!(rmse(&smoothed, axis) <= limit, "{axis:?}: {}", rmse(&smoothed, axis));
        assert!(rmse(&smoothed, axis) < rmse(&causal, axis), "{axis:?}");
    }
}
