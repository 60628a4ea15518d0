//! The covariance of a fast IMU: propagated once over several samples, compared with every sample.

use std::ops::Range;

use hovernav::earth::Geodetic;
use hovernav::ekf::covariance::{Gain, Sensitivity, Transition};
use hovernav::ekf::layout::Full;
use hovernav::ekf::{Estimator, EstimatorConfig, NoHeadingSearch, Smoother, Solution, Trace};
use hovernav::event::Event;
use hovernav::frames::{EulerAngles, Vector, wrap_angle};
use hovernav::gps::Fix;
use hovernav::imu::{ImuSample, Motion};
use hovernav::time::Time;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Normal};

const SPEED_MPS: f64 = 3.0;
const TURN_RADPS: f64 = 1.0;
const FLIGHT_S: i64 = 30;
/// Time without inertial samples, s.
const GAP_S: Range<f64> = 14.2..14.7;
/// Time with a gyro and an accelerometer at full scale, s.
const CLIPPED_S: Range<f64> = 20.301..20.313;

/// Counts propagations, and passes all events to a smoother.
struct Watch {
    propagations: usize,
    smoother: Smoother<Full, 28>,
}

impl Trace<f64, 28> for Watch {
    fn propagated(&mut self, step: &Transition<f64, 28>) {
        self.propagations += 1;
        self.smoother.propagated(step);
    }
    fn updated(&mut self, sensitivity: &Sensitivity<f64>, gain: &Gain<f64, 28>, innovation: f64) {
        self.smoother.updated(sensitivity, gain, innovation);
    }
    fn reset(&mut self, states: Range<usize>) {
        self.smoother.reset(states);
    }
}

/// A flight: its filtered and smoothed solutions at every sample, and the number of propagations.
struct Flown {
    filtered: Vec<Solution>,
    smoothed: Vec<Solution>,
    propagations: usize,
}

/// Half a minute of a circle with a gap and a shock, with ten attitudes and one fix per second. The fixes are valid
/// between samples.
fn fly(rate_hz: i64, covariance_interval_s: f64) -> Flown {
    let mut config = EstimatorConfig::default();
    config.ekf.imu.covariance_interval_s = covariance_interval_s;
    let mut estimator = Box::new(Estimator::<Full, 28, f64, NoHeadingSearch>::with_layout(config));
    let home = Geodetic::from_degrees(48.1, 11.6, 520.0).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let normal = Normal::new(0.0, 1.0).unwrap();
    let mut noise = |sigma: f64| {
        let drawn: [f64; 3] = std::array::from_fn(|_| sigma * normal.sample(&mut random));
        Vector::from(drawn)
    };
    let mut watch = Watch { propagations: 0, smoother: Smoother::with_capacity(0) };
    let mut filtered = Vec::new();
    for k in 0..FLIGHT_S * rate_hz {
        let time = Time::from_nanoseconds(k * 1_000_000_000 / rate_hz);
        let motion = Motion::Rates {
            angular_rate_radps: Vector::new(0.0, 0.0, TURN_RADPS) + noise(0.02),
            specific_force_mps2: Vector::new(0.0, SPEED_MPS * TURN_RADPS, -9.807) + noise(0.5),
        };
        let mut sample = ImuSample::new(time, motion);
        if k % (rate_hz / 10) == 0 {
            let yaw_rad = wrap_angle(TURN_RADPS * time.seconds());
            sample.attitude = Some(EulerAngles { yaw_rad, ..EulerAngles::default() });
        }
        if CLIPPED_S.contains(&time.seconds()) {
            (sample.clipped.gyro[0], sample.clipped.accel[1]) = (true, true);
        }
        if !GAP_S.contains(&time.seconds()) {
            estimator.push_traced(&Event::Imu(sample), &mut watch, |_| {});
        }
        if k % rate_hz == rate_hz / 2 + 1 {
            let true_at = time + -0.123;
            let (sine, cosine) = (TURN_RADPS * true_at.seconds()).sin_cos();
            let radius_m = SPEED_MPS / TURN_RADPS;
            let offset_m = Vector::new(radius_m * sine, radius_m * (1.0 - cosine), 0.0);
            let fix = Fix {
                horizontal_velocity_mps: Some([SPEED_MPS * cosine, SPEED_MPS * sine]),
                down_velocity_mps: Some(0.0),
                ..Fix::at(true_at, home.displaced(offset_m))
            };
            estimator.push_traced(&Event::Gps(fix), &mut watch, |_| {});
        }
        filtered.extend(estimator.solution());
        if let Some(filter) = estimator.filter() {
            watch.smoother.sampled(filter);
        }
    }
    let Watch { propagations, smoother } = watch;
    Flown { filtered, smoothed: smoother.smooth(), propagations }
}

/// Largest differences of solutions: velocity, m/s, position, m, attitude, rad, and one-sigmas, as a fraction.
fn apart(every: &[Solution], seldom: &[Solution]) -> [f64; 4] {
    assert_eq!(every.len(), seldom.len());
    let sigmas = |solution: &Solution| {
        let [vn, ve, vd] = solution.velocity_sigma_mps.to_array();
        let [pn, pe, pd] = solution.position_sigma_m.to_array();
        let [roll, pitch, yaw] = solution.attitude_sigma_rad;
        [vn, ve, vd, pn, pe, pd, roll, pitch, yaw]
    };
    let mut most = [0.0f64; 4];
    for (every, seldom) in every.iter().zip(seldom) {
        let turn = every.body_to_ned * seldom.body_to_ned.inverse();
        let wider = sigmas(every).into_iter().zip(sigmas(seldom)).map(|(a, b)| (b / a - 1.0).abs());
        let found = [
            (every.velocity_mps - seldom.velocity_mps).norm(),
            every.position.displacement_from(&seldom.position).norm(),
            turn.rotation_vector().norm(),
            wider.fold(0.0, f64::max),
        ];
        most = std::array::from_fn(|kind| most[kind].max(found[kind]));
    }
    most
}

fn default_interval_s() -> f64 {
    EstimatorConfig::default().ekf.imu.covariance_interval_s
}

#[test]
fn a_fast_unit_has_the_same_solution_of_far_fewer_propagations() {
    for rate_hz in [200, 250, 400, 1000] {
        let (every, seldom) = (fly(rate_hz, 0.0), fly(rate_hz, default_interval_s()));
        let filtered = apart(&every.filtered, &seldom.filtered);
        let smoothed = apart(&every.smoothed, &seldom.smoothed);
        println!("{rate_hz} Hz: {} and {} propagations", every.propagations, seldom.propagations);
        println!("  filtered {filtered:?}\n  smoothed {smoothed:?}");
        assert!(seldom.propagations < 150 * usize::try_from(FLIGHT_S).unwrap());
        // Limits in m/s, m, rad, and as a fraction of the one-sigmas. The learned slow error of the attitude reference
        // responds to rounding. It moves the position by 0.24 mm and the smoothed attitude by 2.1e-5 rad.
        let within = |found: [f64; 4], most: [f64; 4]| found.iter().zip(most).all(|(a, b)| *a < b);
        assert!(within(filtered, [2e-4, 5e-4, 1e-5, 0.005]), "{rate_hz} Hz: {filtered:?}");
        assert!(within(smoothed, [1e-3, 0.02, 3e-5, 0.005]), "{rate_hz} Hz: {smoothed:?}");
    }
}

#[test]
fn a_unit_of_up_to_120_hz_is_propagated_at_every_sample() {
    for rate_hz in [30, 50, 100, 120] {
        let (every, seldom) = (fly(rate_hz, 0.0), fly(rate_hz, default_interval_s()));
        assert_eq!(every.filtered, seldom.filtered, "{rate_hz} Hz");
        assert_eq!(every.smoothed, seldom.smoothed, "{rate_hz} Hz");
    }
}
