//! Consistency of the filter: over many flights with the errors that the filter assumes, its errors and innovations
//! match its covariance.
//!
//! # Source
//! Y. Bar-Shalom, X. R. Li and T. Kirubarajan (2001), *Estimation with Applications to Tracking and
//! Navigation*, section 5.4 (normalised estimation error squared and normalised innovation squared).

use hovernav::earth::Geodetic;
use hovernav::ekf::layout::BASE;
use hovernav::ekf::{BaseEkf, EkfConfig, GpsModel, ImuModel, Verdict};
use hovernav::frames::{Body, Ned, Rotation, Vector};
use hovernav::gps::Fix;
use hovernav::imu::{ImuSample, Motion};
use hovernav::ins::{Mounting, NavState, Start};
use hovernav::time::Time;
use hovernav_sim::*;
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use statrs::distribution::{ChiSquared, ContinuousCDF};

const RUNS: u64 = 200;
const PERIOD_S: f64 = 0.02;
const SAMPLES_PER_FIX: usize = 50;
const DURATION_S: f64 = 60.0;
const IMU_LEVER_ARM_M: Vector<Body> = Vector::new(0.03, -0.02, 0.28);
const ANTENNA_LEVER_ARM_M: Vector<Body> = Vector::new(-0.35, 0.0, -0.2);
const POSITION_SIGMA_M: HorizontalVertical = HorizontalVertical::new(1.0, 2.0);
const VELOCITY_SIGMA_MPS: HorizontalVertical = HorizontalVertical::new(0.1, 0.2);
const TILT_SIGMA_RAD: f64 = 0.01;
const HEADING_SIGMA_RAD: f64 = 0.03;

/// Inertial unit model of both filter and simulation.
fn imu_model() -> ImuModel {
    let mut model = ImuModel::default();
    model.angle_random_walk_rad = 5e-4;
    model.velocity_random_walk_mps = 0.01;
    model.gyro_vibration_share = 0.0;
    model.turn_error_share = 0.0;
    model.net_turn_error_share = 0.0;
    model.accel_vibration_share = 0.0;
    model.gyro_bias_sigma_radps = 0.004;
    model.gyro_bias_time_s = 100.0;
    model.accel_bias_sigma_mps2 = 0.05;
    model.accel_bias_time_s = 200.0;
    model
}

fn mounting() -> Mounting {
    Mounting::default()
        .with_imu_lever_arm_m(IMU_LEVER_ARM_M)
        .with_antenna_lever_arm_m(ANTENNA_LEVER_ARM_M)
}

fn ekf_config() -> EkfConfig {
    let mut gps = GpsModel::default();
    // The simulated receiver measures its velocity at one moment.
    gps.velocity_smoothing_s = 0.0;
    EkfConfig::default().with_imu(imu_model()).with_gps(gps)
}

/// The same inertial unit for the simulation. Without `noisy` it only has its biases, which are equal for equal seeds.
fn dmu_config(noisy: bool) -> DmuConfig {
    let model = imu_model();
    let white = if noisy { 60.0 } else { 0.0 };
    DmuConfig {
        lever_arm_m: IMU_LEVER_ARM_M,
        gyro: GyroConfig {
            wandering_bias_sigma_degps: model.gyro_bias_sigma_radps.to_degrees(),
            wandering_bias_time_s: model.gyro_bias_time_s,
            angle_random_walk_deg_per_sqrt_h: white * model.angle_random_walk_rad.to_degrees(),
            ..GyroConfig::IDEAL
        },
        accelerometer: AccelerometerConfig {
            wandering_bias_sigma_mps2: model.accel_bias_sigma_mps2,
            wandering_bias_time_s: model.accel_bias_time_s,
            velocity_random_walk_mps_per_sqrt_h: white * model.velocity_random_walk_mps,
            ..AccelerometerConfig::IDEAL
        },
        ..DmuConfig::ideal(1.0 / PERIOD_S, DmuOutput::Increments)
    }
}

fn gps_config() -> GpsConfig {
    GpsConfig {
        lever_arm_m: ANTENNA_LEVER_ARM_M,
        position_noise_m: POSITION_SIGMA_M,
        velocity_noise_mps: VELOCITY_SIGMA_MPS,
        ..GpsConfig::ideal(1.0)
    }
}

/// One moment of the error-free flight, at the inertial unit.
struct Moment {
    time: Time,
    truth: ImuTruth,
    unit: State,
}

fn flight() -> (Trajectory, Vec<Moment>) {
    let start = Geodetic::from_degrees(47.0, 8.0, 400.0).unwrap();
    let forward = |speed_mps| Vector::new(speed_mps, 0.0, 0.0);
    let plan = FlightPlan::hover_at(start, 0.7)
        .hold(3.0)
        .accelerate(forward(8.0), 5.0)
        .turn(core::f64::consts::TAU, 25f64.to_radians())
        .roll_doublet(8f64.to_radians(), 1.5)
        .climb(10.0, 2.5)
        .turn(-core::f64::consts::PI, 30f64.to_radians())
        .accelerate(forward(-6.0), 4.0);
    let rest_s = DURATION_S - plan.duration_s();
    let trajectory = plan.hold(rest_s).build().unwrap();
    let moments = (0..=(DURATION_S / PERIOD_S).round() as u32)
        .map(|k| {
            let (from_s, to_s) = (f64::from(k) * PERIOD_S - PERIOD_S, f64::from(k) * PERIOD_S);
            let (angle, velocity) = trajectory.increments(from_s, to_s, IMU_LEVER_ARM_M);
            let unit = trajectory.at(to_s).at_point(IMU_LEVER_ARM_M);
            let truth = ImuTruth {
                angular_rate_radps: angle * (1.0 / PERIOD_S),
                specific_force_mps2: velocity * (1.0 / PERIOD_S),
                body_to_ned: unit.body_to_ned,
            };
            Moment { time: Time::ZERO + to_s, truth, unit }
        })
        .collect();
    (trajectory, moments)
}

/// A start with errors drawn from its stated covariance.
fn start(truth: &State, seed: u64) -> Start {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let mut drawn = |sigma: Vector<Ned>| {
        Vector::<Ned>::from(sigma.to_array().map(|sigma| {
            let normal: f64 = StandardNormal.sample(&mut generator);
            sigma * normal
        }))
    };
    let attitude_sigma_rad = Vector::new(TILT_SIGMA_RAD, TILT_SIGMA_RAD, HEADING_SIGMA_RAD);
    let velocity_sigma_mps = Vector::new(0.1, 0.1, 0.2);
    let position_sigma_m = Vector::new(1.0, 1.0, 2.0);
    Start {
        state: NavState {
            time: Time::ZERO,
            position: truth.position.displaced(drawn(position_sigma_m)),
            velocity_mps: truth.velocity_mps + drawn(velocity_sigma_mps),
            body_to_ned: truth.body_to_ned.turned_in_to(drawn(attitude_sigma_rad)),
        },
        attitude_sigma_rad,
        velocity_sigma_mps,
        position_sigma_m,
        gyro_bias_radps: Vector::ZERO,
        gyro_bias_sigma_radps: None,
    }
}

/// Normalised squares at each epoch: of the errors just before and just after a fix, and of the innovations.
#[derive(Clone, Copy)]
struct Squares {
    predicted: f64,
    corrected: f64,
    innovations: f64,
}

/// True minus estimated, in the order of the covariance.
fn error(filter: &BaseEkf, truth: &State, biases: &ImuSample) -> DVector<f64> {
    let Motion::Increments { angle_rad, velocity_mps } = biases.motion else { unreachable!() };
    let state = filter.state();
    let errors = filter.imu_errors();
    let turn: Rotation<Ned, Ned> = truth.body_to_ned * state.body_to_ned.inverse();
    let parts = [
        turn.rotation_vector().to_array(),
        (truth.velocity_mps - state.velocity_mps).to_array(),
        truth.position.displacement_from(&state.position).to_array(),
        (angle_rad * (1.0 / PERIOD_S) - errors.gyro_bias_radps).to_array(),
        (velocity_mps * (1.0 / PERIOD_S) - errors.accel_bias_mps2).to_array(),
    ];
    DVector::from_iterator(BASE, parts.into_iter().flatten())
}

fn normalised_square(filter: &BaseEkf, error: &DVector<f64>) -> f64 {
    let covariance = DMatrix::from_fn(BASE, BASE, |i, j| filter.covariance().entry(i, j));
    let root = covariance.cholesky().expect("the covariance is positive definite");
    error.dot(&root.solve(error))
}

/// One flight with errors drawn from `seed`.
fn run(moments: &[Moment], trajectory: &Trajectory, seed: u64) -> Vec<Squares> {
    let mut noisy = SimulatedDmu::new(&dmu_config(true), seed).unwrap();
    let mut biased = SimulatedDmu::new(&dmu_config(false), seed).unwrap();
    let mut gps = SimulatedGps::new(&gps_config(), seed).unwrap();
    let mut filter = BaseEkf::new(ekf_config(), mounting(), start(&moments[0].unit, seed ^ 0x5eed));
    let mut squares = Vec::new();
    for (k, moment) in moments.iter().enumerate() {
        let sample = noisy.measure(moment.time, &moment.truth);
        let nothing = ImuTruth {
            angular_rate_radps: Vector::ZERO,
            specific_force_mps2: Vector::ZERO,
            ..moment.truth
        };
        let biases = biased.measure(moment.time, &nothing);
        if k == 0 {
            continue;
        }
        filter.predict(&sample).unwrap();
        if k % SAMPLES_PER_FIX == 0 {
            let antenna = trajectory.at(moment.time.seconds()).at_point(ANTENNA_LEVER_ARM_M);
            let fix: Fix =
                gps.measure(moment.time, &antenna.position, antenna.velocity_mps).unwrap();
            let predicted = normalised_square(&filter, &error(&filter, &moment.unit, &biases));
            let report = filter.update_gps(&fix).unwrap();
            assert!(report.innovations().all(|axis| axis.verdict == Verdict::Accepted));
            let innovations =
                report.innovations().map(|axis| axis.normalised() * axis.normalised()).sum();
            let corrected = normalised_square(&filter, &error(&filter, &moment.unit, &biases));
            squares.push(Squares { predicted, corrected, innovations });
        }
    }
    squares
}

fn all_runs() -> Vec<Vec<Squares>> {
    let (trajectory, moments) = flight();
    let (trajectory, moments) = (&trajectory, &moments[..]);
    std::thread::scope(|scope| {
        let halves = [0..RUNS / 2, RUNS / 2..RUNS].map(|seeds| {
            scope.spawn(move || -> Vec<_> {
                seeds.map(|seed| run(moments, trajectory, seed)).collect()
            })
        });
        halves.into_iter().flat_map(|half| half.join().unwrap()).collect()
    })
}

/// 95 % bounds for the mean over all runs of a normalised square with `degrees` degrees of freedom.
fn bounds(degrees: usize, count: usize) -> [f64; 2] {
    let sum = ChiSquared::new((degrees * count) as f64).unwrap();
    [0.025, 0.975].map(|probability| sum.inverse_cdf(probability) / count as f64)
}

/// Fraction of the epochs that are within the bounds of an epoch, and the mean over all epochs.
fn judge(name: &str, degrees: usize, epochs: &[f64]) -> (f64, f64) {
    let [low, high] = bounds(degrees, RUNS as usize);
    let within = epochs.iter().filter(|mean| (low..=high).contains(*mean)).count();
    let share = within as f64 / epochs.len() as f64;
    let mean = epochs.iter().sum::<f64>() / epochs.len() as f64;
    println!(
        "{name}: mean {mean:.3} of {degrees}, 95 % bounds [{low:.3}, {high:.3}] hold at {within} of {} epochs",
        epochs.len()
    );
    let shown: Vec<String> = epochs.iter().step_by(6).map(|mean| format!("{mean:.2}")).collect();
    println!("  every sixth: {}", shown.join(" "));
    (share, mean)
}

#[test]
fn errors_and_innovations_are_as_large_as_the_covariance_says() {
    let runs = all_runs();
    let epochs = runs[0].len();
    let means = |square: fn(&Squares) -> f64| -> Vec<f64> {
        (0..epochs)
            .map(|epoch| runs.iter().map(|run| square(&run[epoch])).sum::<f64>() / RUNS as f64)
            .collect()
    };
    let predicted = means(|squares| squares.predicted);
    let corrected = means(|squares| squares.corrected);
    let innovations = means(|squares| squares.innovations);
    for (name, degrees, epochs) in [
        ("NEES before the fix", BASE, &predicted),
        ("NEES after the fix", BASE, &corrected),
        ("NIS", 6, &innovations),
    ] {
        let (share, mean) = judge(name, degrees, epochs);
        let [low, high] = bounds(degrees, RUNS as usize);
        assert!((low..=high).contains(&mean), "{name}: {mean} outside [{low}, {high}]");
        // Errors of neighbouring epochs are correlated, so the fraction scatters about its 95 %.
        assert!(share >= 0.85, "{name}: inside at only {share} of the epochs");
    }
    // Innovations are independent from fix to fix, so their mean over all epochs has tight bounds.
    let [low, high] = bounds(6, RUNS as usize * epochs);
    let mean = innovations.iter().sum::<f64>() / epochs as f64;
    println!("NIS over all: {mean:.4} in [{low:.4}, {high:.4}]");
    assert!((low..=high).contains(&mean));
}
