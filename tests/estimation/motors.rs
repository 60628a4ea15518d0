//! Starting motors: only the fixes show their effect on an accelerometer's bias.

use hovernav::earth::Geodetic;
use hovernav::ekf::layout::Full;
use hovernav::ekf::{Ekf, EkfConfig};
use hovernav::frames::{Rotation, Vector};
use hovernav::gps::Fix;
use hovernav::imu::{ImuSample, Motion};
use hovernav::ins::{Mounting, NavState, Start};
use hovernav::time::Time;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;
use rand_distr::{Distribution as _, StandardNormal};

/// Time at which the motors start, s.
const START_S: f64 = 30.0;

/// Mean square of the vertical velocity error over its one-sigma in the 40 s after the motors start. Their vibration is
/// 0.6 m/s², their bias step on the vertical accelerometer `stepped_mps2`. Fixes come five times a second.
fn normalised(seed: u64, stepped_mps2: f64) -> f64 {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let mut vector = |sigma: f64| {
        [(); 3].map(|()| {
            let normal: f64 = StandardNormal.sample(&mut generator);
            sigma * normal
        })
    };
    let place = Geodetic::from_degrees(48.0, 11.0, 500.0).unwrap();
    let sure = |sigma: f64| Vector::new(sigma, sigma, sigma);
    let start = Start {
        state: NavState {
            time: Time::ZERO,
            position: place,
            velocity_mps: Vector::ZERO,
            body_to_ned: Rotation::IDENTITY,
        },
        attitude_sigma_rad: sure(0.01),
        velocity_sigma_mps: sure(0.1),
        position_sigma_m: sure(2.0),
        gyro_bias_radps: Vector::ZERO,
        gyro_bias_sigma_radps: None,
    };
    let mut filter = Ekf::<Full, 28>::new(EkfConfig::default(), Mounting::default(), start);
    let (mut sum, mut count) = (0.0, 0.0);
    for k in 1..=7_000_i64 {
        let time = Time::from_nanoseconds(k * 10_000_000);
        let runs = time.seconds() > START_S;
        let (shaking_mps2, bias_mps2) = if runs { (0.6, stepped_mps2) } else { (0.02, 0.0) };
        let motion = Motion::Rates {
            angular_rate_radps: vector(0.002).into(),
            specific_force_mps2: Vector::new(0.0, 0.0, bias_mps2 - 9.809)
                + vector(shaking_mps2).into(),
        };
        filter.predict(&ImuSample::new(time, motion)).unwrap();
        if k % 20 == 0 {
            let [north, east, down] = vector(0.1);
            let fix = Fix {
                horizontal_velocity_mps: Some([north, east]),
                down_velocity_mps: Some(down),
                velocity_sigma_mps: Some(sure(0.1)),
                ..Fix::at(time, place.displaced(vector(0.5).into()))
            };
            filter.update_gps(&fix).unwrap();
        }
        if runs {
            let solution = filter.solution();
            let off = solution.velocity_mps.z() / solution.velocity_sigma_mps.z();
            sum += off * off;
            count += 1.0;
        }
    }
    sum / count
}

#[test]
fn a_bias_that_motors_make_is_expected_of_them() {
    for (stepped_mps2, most) in [(0.0, 1.0), (0.1, 1.1), (0.2, 1.4)] {
        let mean = (1..=8).map(|seed| normalised(seed, stepped_mps2)).sum::<f64>() / 8.0;
        let off = mean.sqrt();
        println!("a step of {stepped_mps2} m/s²: {off:.2} one-sigmas RMS");
        assert!((0.6..most).contains(&off), "{stepped_mps2}: {off}");
    }
}
