use super::*;
use crate::earth::Geodetic;
use crate::ekf::FullEkf;
use crate::frames::{EulerAngles, Rotation};
use crate::gps::Fix;
use crate::imu::{ImuSample, Motion};

fn start() -> Start {
    let body_to_ned = Rotation::from_euler(EulerAngles::from_degrees(2.0, -1.0, 65.0));
    let place = Geodetic::from_degrees(48.1, 11.6, 500.0).unwrap();
    let velocity_mps = Vector::new(0.3, -0.2, 0.1);
    Start {
        state: NavState { time: Time::ZERO, position: place, velocity_mps, body_to_ned },
        attitude_sigma_rad: Vector::new(0.02, 0.02, 0.1),
        velocity_sigma_mps: Vector::new(0.2, 0.2, 0.3),
        position_sigma_m: Vector::new(1.0, 1.0, 2.0),
        gyro_bias_radps: Vector::ZERO,
        gyro_bias_sigma_radps: None,
    }
}

/// A restarted filter keeps no trace of a flight. The history is excluded: only its length is reset.
#[test]
fn a_filter_that_restarts_is_a_new_one() {
    let fresh = || FullEkf::new(EkfConfig::default(), Mounting::default(), start());
    let mut flown = fresh();
    flown.memory.heading_wander = [1.0, 5.0];
    flown.memory.extra_heading_sigma_rad = 0.5;
    for step in 1..=400_i32 {
        let time = Time::ZERO + 0.01 * f64::from(step);
        let phase = f64::from(step % 7) - 3.0;
        let motion = Motion::Rates {
            angular_rate_radps: Vector::new(0.1 * phase, -0.5, 0.8),
            specific_force_mps2: Vector::new(5.0 * phase, 1.0, -40.0),
        };
        flown.predict(&ImuSample::new(time, motion)).unwrap();
        if step % 20 == 0 {
            let place = start().state.position;
            let horizontal_velocity_mps = Some([9.0, 0.0]);
            let fix = Fix { horizontal_velocity_mps, ..Fix::at(time, place) };
            flown.update_gps(&fix).unwrap();
            let attitude = Rotation::from_euler(EulerAngles::from_degrees(5.0, 0.0, 10.0));
            flown.update_attitude(time, attitude, &mut ()).unwrap();
        }
    }
    flown.restart(&start());
    flown.history = History::EMPTY;
    assert_eq!(format!("{flown:?}"), format!("{:?}", fresh()));
}

/// A filter flown for 4 s with turns and fixes, so that its errors are correlated.
fn flown(mounting: Mounting) -> FullEkf {
    let mut filter = FullEkf::new(EkfConfig::default(), mounting, start());
    for step in 1..=400_i32 {
        let time = Time::ZERO + 0.01 * f64::from(step);
        let motion = Motion::Rates {
            angular_rate_radps: Vector::new(0.1, -0.2, 0.5),
            specific_force_mps2: Vector::new(1.0, -0.5, -9.8),
        };
        filter.predict(&ImuSample::new(time, motion)).unwrap();
        if step % 100 == 0 {
            let fix = Fix::at(time, start().state.position);
            filter.update_gps(&fix).unwrap();
        }
    }
    filter
}

#[test]
fn the_diagonal_of_the_solutions_covariance_is_the_square_of_its_sigmas() {
    let lever_arm = Vector::new(0.6, -0.3, 0.9);
    let filter = flown(Mounting::default().with_imu_lever_arm_m(lever_arm));
    let (solution, covariance) = (filter.unambiguous_solution(), filter.solution_covariance());
    let sigmas = [
        solution.position_sigma_m.to_array(),
        solution.velocity_sigma_mps.to_array(),
        solution.attitude_sigma_rad,
    ];
    for (axis, sigma) in sigmas.as_flattened().iter().enumerate() {
        let variance = covariance[axis][axis];
        assert!((variance.sqrt() / sigma - 1.0).abs() < 1e-9, "{axis}: {variance} {sigma}");
        for other in 0..9 {
            let product = covariance[axis][axis] * covariance[other][other];
            assert!(covariance[axis][other].abs() <= product.sqrt() * (1.0 + 1e-9));
            let difference = covariance[axis][other] - covariance[other][axis];
            assert!(difference.abs() <= 1e-12 * product.sqrt());
        }
    }
}

#[test]
fn without_a_lever_arm_the_solutions_covariance_is_the_filters_own() {
    let filter = flown(Mounting::default());
    let covariance = filter.solution_covariance();
    for row in 0..3 {
        for column in 0..3 {
            let own = |first: usize, second: usize| {
                filter.covariance().value(first + row, second + column)
            };
            assert_eq!(covariance[row][column], own(POSITION, POSITION));
            assert_eq!(covariance[row][3 + column], own(POSITION, VELOCITY));
            assert_eq!(covariance[3 + row][3 + column], own(VELOCITY, VELOCITY));
        }
    }
}
