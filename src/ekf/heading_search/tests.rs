//! Filters of a bank do not mix what is their own.

use super::*;
use crate::earth::Geodetic;
use crate::ins::NavState;

const STEP_S: f64 = 0.02;
const TURN_RADPS: f64 = 0.5;

/// A search that has flown so many samples of a slow turn, and a fix every 0.2 s.
fn flown(samples: u32) -> HeadingSearch {
    let place = Geodetic::from_degrees(48.0, 11.0, 500.0).unwrap();
    let mut search = HeadingSearch::unstarted(EkfConfig::default(), Mounting::default());
    let start = Start {
        state: NavState { position: place, ..NavState::ORIGIN },
        attitude_sigma_rad: Vector::new(0.02, 0.02, 3.0),
        velocity_sigma_mps: Vector::new(0.2, 0.2, 0.2),
        position_sigma_m: Vector::new(2.0, 2.0, 4.0),
        gyro_bias_radps: Vector::ZERO,
        gyro_bias_sigma_radps: None,
    };
    search.start(&start, Some(Vector::new(0.0, 0.0, 1.0)));
    for sample in 1..=samples {
        let time = Time::ZERO + STEP_S * f64::from(sample);
        let motion = crate::imu::Motion::Rates {
            angular_rate_radps: Vector::new(0.0, 0.0, TURN_RADPS),
            specific_force_mps2: Vector::new(0.0, 0.0, -9.81),
        };
        search.predict(&ImuSample::new(time, motion)).unwrap();
        if sample % 10 == 0 {
            let fix = Fix {
                horizontal_velocity_mps: Some([0.0; 2]),
                down_velocity_mps: Some(0.0),
                ..Fix::at(time, place)
            };
            search.update_gps(&fix).unwrap();
        }
    }
    search
}

#[test]
fn each_sector_counts_a_turn_and_a_fix_once_however_many_fly() {
    let search = flown(150);
    assert_eq!(search.sectors.iter().flatten().count(), SECTORS);
    for sector in search.sectors.iter().flatten() {
        // 1.5 rad in 3 s, less what a memory of 30 s has forgotten: 1.43.
        let net_turn = sector.own.net_turn.angle_rad[2];
        assert!((net_turn - 1.43).abs() < 0.02, "{net_turn} rad");
        let taken_s = sector.gates.place_taken_s;
        assert!(taken_s > 2.0 && taken_s < 3.0, "{taken_s} s");
    }
}
