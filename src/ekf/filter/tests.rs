use super::super::FullEkf;
use super::*;
use crate::earth::Geodetic;
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
    flown.heading_wander = [1.0, 5.0];
    flown.extra_heading_sigma_rad = 0.5;
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
