//! What the whole log says of a moment is at least as good as what the log up to it says.

use std::path::Path;

use hovernav::earth::Geodetic;
use hovernav::ekf::covariance::{Gain, Sensitivity, Transition};
use hovernav::ekf::layout::{Full, Layout, WithScaleFactors};
use hovernav::ekf::{Ekf, EkfConfig, EstimatorConfig, Smoother, Solution, Trace};
use hovernav::frames::{EulerAngles, Rotation, Vector, wrap_angle};
use hovernav::gps::Fix;
use hovernav::imu::{ImuSample, Motion};
use hovernav::ins::{HeadingSource, Mounting, NavState, Start};
use hovernav::time::Time;
use hovernav_log::Truth;
use hovernav_log::{Axis, Dataset, Outage, Reference, Score, score};
use hovernav_sim::{
    AttitudeConfig, DmuConfig, FlightPlan, GpsConfig, HorizontalVertical, Recording, Trajectory,
    fly,
};
use nalgebra::{SMatrix, SVector};

fn field() -> Geodetic {
    Geodetic::from_degrees(1.352, 103.82, 50.0).unwrap()
}

// ---- Against the textbook ----

/// What the filter did, in dense form.
enum Deed<const N: usize> {
    Propagated { phi: SMatrix<f64, N, N>, q: SMatrix<f64, N, N> },
    Updated { h: SVector<f64, N>, gain: SVector<f64, N>, s: f64, innovation: f64 },
    Sampled(Box<Solution>),
}

/// Keeps what the filter did, for the textbook and for the smoother alike.
struct Both<L, const N: usize> {
    deeds: Vec<Deed<N>>,
    smoother: Smoother<L, N>,
}

impl<L: Layout<N>, const N: usize> Trace<f64, N> for Both<L, N> {
    fn propagated(&mut self, step: &Transition<f64, N>) {
        let mut phi = SMatrix::<f64, N, N>::identity();
        let mut q = SMatrix::<f64, N, N>::zeros();
        let relaxation = step.relaxation.unwrap_or_default();
        for state in 9..N {
            phi[(state, state)] = relaxation.decay[state];
        }
        for axis in 0..3 {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            phi[(3 + axis, next)] = step.force[last];
            phi[(3 + axis, last)] = -step.force[next];
            for k in 0..3 {
                phi[(axis, 9 + k)] = -step.turn[axis][k];
                phi[(3 + axis, 12 + k)] = -step.turn[axis][k];
                if let Some(scale) = L::GYRO_SCALE {
                    phi[(axis, scale + k)] = -step.scaled_rotation[axis][k];
                }
                if let Some(scale) = L::ACCEL_SCALE {
                    phi[(3 + axis, scale + k)] = -step.scaled_velocity[axis][k];
                }
            }
        }
        for axis in 0..3 {
            for state in 0..N {
                let moved = f64::from(state == 3 + axis) + phi[(3 + axis, state)];
                phi[(6 + axis, state)] += 0.5 * step.interval_s * moved;
            }
        }
        for (first, noise) in [(0, step.attitude_noise), (3, step.velocity_noise)] {
            let [nn, ne, nd, ee, ed, dd] = noise;
            let block = [[nn, ne, nd], [ne, ee, ed], [nd, ed, dd]];
            for i in 0..3 {
                for j in 0..3 {
                    q[(first + i, first + j)] = block[i][j];
                }
            }
        }
        for axis in 0..3 {
            q[(6 + axis, 6 + axis)] = step.position_noise[axis];
        }
        for state in 9..N {
            q[(state, state)] = relaxation.noise[state];
        }
        self.deeds.push(Deed::Propagated { phi, q });
        self.smoother.propagated(step);
    }

    fn updated(&mut self, sensitivity: &Sensitivity<f64>, gain: &Gain<f64, N>, innovation: f64) {
        let mut h = SVector::<f64, N>::zeros();
        for (state, derivative) in sensitivity.terms() {
            h[state] += derivative;
        }
        let s = gain.innovation_variance;
        self.deeds.push(Deed::Updated { h, gain: gain.gain.into(), s, innovation });
        self.smoother.updated(sensitivity, gain, innovation);
    }
}

/// Flies ten seconds of a tumbling, accelerating vehicle, and smooths them both ways.
fn against_the_textbook<L: Layout<N>, const N: usize>() {
    let attitude = Rotation::from_euler(EulerAngles::from_degrees(3.0, -5.0, 40.0));
    let start = Start {
        state: NavState {
            time: Time::ZERO,
            position: field(),
            velocity_mps: Vector::new(1.0, -2.0, 0.3),
            body_to_ned: attitude,
        },
        attitude_sigma_rad: Vector::new(0.03, 0.03, 0.1),
        velocity_sigma_mps: Vector::new(0.3, 0.3, 0.5),
        position_sigma_m: Vector::new(2.0, 2.0, 3.0),
        gyro_bias_radps: Vector::ZERO,
        gyro_bias_sigma_radps: None,
    };
    let fix = |time_s: f64| Fix {
        time: Time::ZERO + time_s,
        position: field().displaced(Vector::new(
            time_s + (3.0 * time_s).sin(),
            -2.0 * time_s + (2.0 * time_s).cos(),
            0.3 * time_s,
        )),
        two_dimensional: false,
        horizontal_velocity_mps: Some([1.0 + 0.2 * (5.0 * time_s).sin(), -2.0]),
        down_velocity_mps: Some(0.3 + 0.1 * (7.0 * time_s).cos()),
        position_sigma_m: None,
        velocity_sigma_mps: None,
        satellites: None,
    };
    let mut filter = Ekf::<L, N>::new(EkfConfig::default(), Mounting::default(), start);
    // The first fix opens states; from then on the dense form knows all that happens.
    let _ = filter.update_gps(&fix(0.0));
    let first = *filter.covariance().rows();
    let mut both = Both::<L, N> { deeds: Vec::new(), smoother: Smoother::with_capacity(200) };
    for step in 1..=200 {
        let time_s = 0.05 * f64::from(step);
        let sample = ImuSample::new(
            Time::ZERO + time_s,
            Motion::Rates {
                angular_rate_radps: Vector::new(
                    0.1 * (2.0 * time_s).sin(),
                    0.1 * (3.0 * time_s).cos(),
                    0.05,
                ),
                specific_force_mps2: Vector::new(
                    -0.8 + (1.5 * time_s).sin(),
                    -0.5 + (2.5 * time_s).cos(),
                    -9.7,
                ),
            },
        );
        filter.predict_traced(&sample, &mut both).unwrap();
        if step % 20 == 0 {
            filter.update_gps_traced(&fix(time_s), &mut both).unwrap();
        }
        if step % 7 == 0 {
            let own = filter.state().body_to_ned.turned_in_to(Vector::new(0.004, -0.006, 0.01));
            let _ = filter.update_attitude(sample.time, own, &mut both);
        }
        both.deeds.push(Deed::Sampled(Box::new(filter.solution())));
        both.smoother.sampled(&filter);
        if step % 9 == 0 {
            let _ = filter.update_baro(sample.time, 50.0 + 0.2 * time_s.sin(), &mut both);
        }
    }
    let smoothed = both.smoother.smooth();
    assert_eq!(smoothed.len(), 200);

    // Forward: one epoch for each propagation and all that came before the next.
    struct Epoch<const N: usize> {
        phi: SMatrix<f64, N, N>,
        predicted: (SVector<f64, N>, SMatrix<f64, N, N>),
        filtered: (SVector<f64, N>, SMatrix<f64, N, N>),
        /// The estimate at a sample, its number and its solution; none where only time passed for the
        /// parameters, before a measurement.
        sampled: Option<(SVector<f64, N>, usize, Solution)>,
    }
    let mut x = SVector::<f64, N>::zeros();
    let mut p = SMatrix::<f64, N, N>::from_fn(|i, j| first[i][j]);
    let mut epochs: Vec<Epoch<N>> = Vec::new();
    let (mut updates, mut samples) = (0, 0);
    for deed in &both.deeds {
        match deed {
            Deed::Propagated { phi, q } => {
                x = phi * x;
                p = phi * p * phi.transpose() + q;
                let sampled = None;
                epochs.push(Epoch { phi: *phi, predicted: (x, p), filtered: (x, p), sampled });
            }
            Deed::Updated { h, gain, s, innovation } => {
                updates += 1;
                let textbook = p * h / *s;
                assert!(
                    (textbook - gain).component_div(&(gain.abs().add_scalar(1e-3))).amax() < 1e-6
                );
                let noise = s - (h.transpose() * p * h)[0];
                let kept = SMatrix::<f64, N, N>::identity() - textbook * h.transpose();
                p = kept * p * kept.transpose() + textbook * textbook.transpose() * noise;
                x += textbook * *innovation;
                epochs.last_mut().unwrap().filtered = (x, p);
            }
            Deed::Sampled(solution) => {
                epochs.last_mut().unwrap().sampled = Some((x, samples, **solution));
                samples += 1;
            }
        }
    }
    assert!(updates >= 60);

    // Backward: Rauch, Tung and Striebel.
    let (mut x, mut p) = epochs.last().unwrap().filtered;
    for k in (0..epochs.len()).rev() {
        let epoch = &epochs[k];
        if let Some(next) = epochs.get(k + 1) {
            let (predicted, variance) = next.predicted;
            // Scaled to unit variances, so that units do not spoil the inverse; what is known
            // exactly stays apart.
            let scale = variance.diagonal().map(|v| if v > 0.0 { v.sqrt() } else { 1.0 });
            let mut unit =
                SMatrix::<f64, N, N>::from_fn(|i, j| variance[(i, j)] / (scale[i] * scale[j]));
            for i in 0..N {
                unit[(i, i)] = 1.0;
            }
            let inverse = unit.cholesky().unwrap().inverse();
            let inverse =
                SMatrix::<f64, N, N>::from_fn(|i, j| inverse[(i, j)] / (scale[i] * scale[j]));
            let gain = epoch.filtered.1 * next.phi.transpose() * inverse;
            x = epoch.filtered.0 + gain * (x - predicted);
            p = epoch.filtered.1 + gain * (p - variance) * gain.transpose();
        }
        let Some((estimate, sample, causal)) = &epoch.sampled else { continue };
        let correction = x - estimate;
        let block = |first: usize| [0, 1, 2].map(|axis| correction[first + axis]);
        let (k, found) = (sample, &smoothed[*sample]);
        let sigma = |state: usize| p[(state, state)].sqrt();
        let near = |found: [f64; 3], expected: [f64; 3], first: usize| {
            for axis in 0..3 {
                let off = (found[axis] - expected[axis]).abs() / sigma(first + axis);
                assert!(off < 1e-8, "state {} at sample {k}: {off:e} sigmas", first + axis);
            }
        };
        let attitude = causal.body_to_ned.turned_in_to(block(0).into());
        near((found.body_to_ned * attitude.inverse()).rotation_vector().to_array(), [0.0; 3], 0);
        near((found.velocity_mps - causal.velocity_mps).to_array(), block(3), 3);
        let position = causal.position.displaced(block(6).into());
        near(found.position.displacement_from(&position).to_array(), [0.0; 3], 6);
        near((found.gyro_bias_radps - causal.gyro_bias_radps).to_array(), block(9), 9);
        near((found.accel_bias_mps2 - causal.accel_bias_mps2).to_array(), block(12), 12);

        let same = |found: [f64; 3], first: usize| {
            for (axis, found) in found.into_iter().enumerate() {
                let off = (found / sigma(first + axis) - 1.0).abs();
                assert!(off < 1e-8, "sigma {} at sample {k}: {off:e}", first + axis);
            }
        };
        same(found.velocity_sigma_mps.to_array(), 3);
        same(found.position_sigma_m.to_array(), 6);
        same(found.gyro_bias_sigma_radps.to_array(), 9);
        same(found.accel_bias_sigma_mps2.to_array(), 12);
        let (sin, cos) = found.body_to_ned.euler().yaw_rad.sin_cos();
        let pitch = sin * sin * p[(0, 0)] - 2.0 * sin * cos * p[(0, 1)] + cos * cos * p[(1, 1)];
        assert!((found.attitude_sigma_rad[1] / pitch.sqrt() - 1.0).abs() < 1e-8);
    }
}

#[test]
fn the_smoother_is_the_rauch_tung_striebel_smoother() {
    against_the_textbook::<Full, 28>();
}

#[test]
fn with_scale_factors_too() {
    against_the_textbook::<WithScaleFactors, 22>();
}

// ---- On simulated flights ----

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

/// A flight whose receiver and attitude reference have the errors that the filter assumes of them,
/// whose fixes state their one-sigma, and whose inertial unit has no scale errors, for which this
/// filter has no states; of the biases it is told the size.
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
        let run = dataset.smooth(&config, |_| ());
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
        // Position is left out: the filter opens it at the aligning fix as if that fix did not share
        // the receiver's slow error, so its sigma is too small from the start, smoothed or not.
        assert!(axis < 3 || within[axis] >= 0.98 * count, "{}", AXES[axis]);
    }
}

#[test]
fn the_last_moment_is_as_the_filter_left_it() {
    let hover = FlightPlan::hover_at(field(), 0.7).hold(30.0).build().unwrap();
    let (mut dataset, config, _) = simulated(&hover, &GpsConfig::default(), 1);
    let end = dataset.imu.last().unwrap().time;
    dataset.fixes.retain(|fix| fix.time < end);
    let run = dataset.smooth(&config, |_| ());
    let (smoothed, causal) = (run.solutions.last().unwrap(), run.forward.solutions.last().unwrap());
    assert_eq!(smoothed.velocity_mps, causal.velocity_mps);
    assert_eq!(smoothed.velocity_sigma_mps, causal.velocity_sigma_mps);
}

#[test]
fn an_outage_is_bridged_from_both_sides() {
    let (mut dataset, config, truth) = simulated(&test_flight(), &GpsConfig::default(), 5);
    let start = Time::ZERO + 120.0;
    dataset.withhold(&[Outage { start, duration_s: 20.0 }], None);
    let run = dataset.smooth(&config, |_| ());
    // The last third: there the filter has drifted longest.
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
    let run = dataset.smooth(&config, |_| ());
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
    let run = dataset.smooth(&config, |_| ());
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
    let run = dataset.smooth(&config, |_| ());
    assert!(run.solutions.is_empty() && !run.forward.solutions.is_empty());
}

#[test]
fn nothing_gives_nothing() {
    let run = Dataset::default().smooth(&EstimatorConfig::default(), |_| ());
    assert!(run.solutions.is_empty() && run.forward.solutions.is_empty());
}

// ---- On the recorded format ----

#[test]
fn the_hover_log_smoothed_is_within_the_promised_velocity() {
    let dir = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/heli-hover"));
    let mut dataset = Dataset::open(dir).unwrap();
    let config = dataset.settings().unwrap();
    let reference = Reference::open(dir, &dataset.manifest).unwrap().unwrap();
    let run = dataset.smooth(&config, |_| ());
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
