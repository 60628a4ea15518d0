//! A model of a fixed-wing aircraft in cruise, from computed motion.

use approx::assert_relative_eq;
use hovernav::ekf::Solution;
use hovernav::frames::{EulerAngles, Rotation, Vector};
use hovernav::time::Time;
use hovernav_sysid::helicopter::{IdentifyError, ModelStructure, Request, Velocity, identify};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use crate::data::flown;

/// Sample period, s, and number of samples: two minutes.
const PERIOD_S: f64 = 0.02;
const SAMPLES: usize = 6000;
/// Forward speed, m/s.
const SPEED_MPS: f64 = 18.0;
/// True parameters.
const TRUTH: [(&str, f64); 5] =
    [("Zw", -3.5), ("Mw", -0.6), ("Mq", -5.0), ("Mlon", 30.0), ("u0", SPEED_MPS)];
const GRAVITY_MPS2: f64 = 9.81;

/// Elevator: doublets of 8 % to alternating sides, each side held 0.4 to 0.7 s, one in 8 s at changing times. Harmonics of
/// equal times would count as vibration.
fn elevator(second: f64) -> f64 {
    let turn = (second / 8.0).floor();
    let side = if turn % 2.0 == 0.0 { 0.08 } else { -0.08 };
    let held_s = 0.4 + 0.3 * (0.618 * turn).fract();
    match second - 8.0 * turn - 2.0 - 1.5 * (0.414 * turn).fract() {
        after if (0.0..held_s).contains(&after) => side,
        after if (held_s..2.0 * held_s).contains(&after) => -side,
        _ => 0.0,
    }
}

/// The motion as smoothed solutions: the rate with noise of the gyro, the velocity without white noise.
fn motion() -> (Vec<(Time, [f64; 4])>, Vec<Solution>) {
    let (_, flown) = flown();
    let place = flown[0].position;
    let [zw, mw, mq, mlon, _] = TRUTH.map(|(_, value)| value);
    let mut random = ChaCha8Rng::seed_from_u64(18);
    let mut noise = |sigma: f64| -> f64 {
        let unit: f64 = StandardNormal.sample(&mut random);
        sigma * unit
    };
    let (mut w, mut q, mut theta) = (0.0, 0.0, 0.0f64);
    let (mut controls, mut solutions) = (Vec::new(), Vec::new());
    for sample in 0..SAMPLES {
        let time = Time::from_seconds(sample as f64 * PERIOD_S);
        let longitudinal = elevator(time.seconds());
        controls.push((time, [0.0, longitudinal, 0.0, 0.0]));
        let body_to_ned =
            Rotation::from_euler(EulerAngles { roll_rad: 0.0, pitch_rad: theta, yaw_rad: 0.6 });
        solutions.push(Solution {
            body_to_ned,
            velocity_mps: body_to_ned * Vector::new(SPEED_MPS, 0.0, w),
            angular_rate_radps: Vector::new(0.0, q + noise(0.003), 0.0),
            velocity_sigma_mps: Vector::new(0.05, 0.05, 0.05),
            ..Solution::at_rest(time, place)
        });
        // Ten steps a sample: the stick is held for a sample.
        for _ in 0..10 {
            let step_s = PERIOD_S / 10.0;
            let dw = zw * w + q * SPEED_MPS + GRAVITY_MPS2 * (theta.cos() - 1.0);
            let dq = mw * w + mq * q + mlon * longitudinal;
            (w, q, theta) = (w + step_s * dw, q + step_s * dq, theta + step_s * q);
        }
    }
    (controls, solutions)
}

#[test]
fn the_short_period_of_an_aircraft_at_18_m_per_s_is_found() {
    let (mut dataset, _) = flown();
    let (controls, solutions) = motion();
    dataset.injected = vec![[0.0; 4]; controls.len()];
    dataset.controls = controls;
    let structure = ModelStructure::built_in("short-period").unwrap();
    let found = identify(&dataset, &solutions, structure.clone(), Velocity::Estimated).unwrap();
    for (name, truth) in TRUTH {
        let own = found.identified.estimates.get(name).unwrap();
        println!("{name}: {:.3} ± {:.3}, truth {truth}", own.value, own.bound);
        assert_relative_eq!(own.value, truth, max_relative = 0.05);
    }
    let vehicle = found.vehicle().unwrap();
    assert_relative_eq!(vehicle.trim_speed_mps(), SPEED_MPS, max_relative = 0.01);
    // No part of this flight is a hover.
    let hover = Request { structure: Some(structure), speed_mps: Some(0.0) };
    let refused = identify(&dataset, &solutions, hover, Velocity::Estimated).unwrap_err();
    assert!(matches!(refused, IdentifyError::NotFlown { .. }), "{refused}");
}
