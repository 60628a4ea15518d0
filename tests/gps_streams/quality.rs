//! A bad fix is rejected with the reason.

use hovernav::frames::Vector;
use hovernav::gps::quality::{Failure, Limits, QualityCheck};
use hovernav::gps::{Dimension, Protocol, ReceiverFix};
use hovernav::time::Time;

use crate::fixes;
use hovernav_fly::devices::encode;
use hovernav_fly::devices::encode::Epoch;

/// Good fixes a second apart.
fn flight(seconds: u32) -> Vec<ReceiverFix> {
    let wire: Vec<u8> =
        (0..seconds).flat_map(|index| encode::ubx_pvt(&Epoch::flying(index))).collect();
    let mut flight = fixes(Protocol::Ubx, &wire);
    for (second, fix) in flight.iter_mut().enumerate() {
        fix.arrival = Time::ZERO + second as f64 + 0.1;
    }
    flight
}

fn failures(check: &mut QualityCheck, fix: &ReceiverFix) -> Vec<Failure> {
    check.check(fix).iter().copied().collect()
}

/// Failed checks of the second fix of a flight after `spoil`.
fn found(spoil: impl Fn(&mut ReceiverFix)) -> Vec<Failure> {
    let mut flight = flight(2);
    let mut check = QualityCheck::new(Limits::default());
    assert_eq!(failures(&mut check, &flight[0]), []);
    spoil(&mut flight[1]);
    failures(&mut check, &flight[1])
}

#[test]
fn a_flight_of_good_fixes_passes() {
    let mut check = QualityCheck::new(Limits::default());
    for fix in flight(60) {
        assert_eq!(failures(&mut check, &fix), []);
    }
}

#[test]
fn each_limit_that_is_broken_is_named_with_its_numbers() {
    assert_eq!(found(|fix| fix.satellites = Some(3)), [Failure::Satellites { found: 3, min: 4 }]);
    assert_eq!(found(|fix| fix.dimension = Some(Dimension::TwoD)), [Failure::TwoDimensional]);
    assert_eq!(
        found(|fix| fix.dilution.position = Some(7.0)),
        [Failure::PositionDilution { found: 7.0, max: 6.0 }]
    );
    assert_eq!(
        found(|fix| fix.dilution.horizontal = Some(4.5)),
        [Failure::HorizontalDilution { found: 4.5, max: 4.0 }]
    );
    assert_eq!(
        found(|fix| fix.position_sigma_m = Some(Vector::new(1.0, 25.0, 1.0))),
        [Failure::HorizontalSigma { found_m: 25.0, max_m: 20.0 }]
    );
    assert_eq!(
        found(|fix| fix.position_sigma_m = Some(Vector::new(1.0, 1.0, 40.0))),
        [Failure::VerticalSigma { found_m: 40.0, max_m: 30.0 }]
    );
    assert_eq!(
        found(|fix| fix.velocity_sigma_mps = Some(Vector::new(0.1, 0.1, 5.0))),
        [Failure::VelocitySigma { found_mps: 5.0, max_mps: 3.0 }]
    );
    assert_eq!(
        found(|fix| fix.ground_speed_mps = Some(90.0)),
        [Failure::GroundSpeed { found_mps: 90.0, max_mps: 60.0 }]
    );
    assert_eq!(
        found(|fix| fix.down_velocity_mps = Some(-25.0)),
        [Failure::VerticalSpeed { found_mps: 25.0, max_mps: 20.0 }]
    );
    assert!(matches!(
        found(|fix| fix.height_m = Some(500.0))[..],
        [Failure::Jump { found_m: 450.0..460.0, max_m: 90.0..95.0 }]
    ));
    assert!(matches!(
        found(|fix| fix.arrival = Time::ZERO + 2.0)[..],
        [Failure::Delay { found_s: 0.89..0.91, max_s: 0.5 }]
    ));
}

#[test]
fn all_that_is_wrong_is_reported_and_in_words() {
    let all = found(|fix| {
        fix.satellites = Some(2);
        fix.dilution.position = Some(99.0);
        fix.latitude_rad += 1e-3;
    });
    let words: Vec<String> = all.iter().map(ToString::to_string).collect();
    assert_eq!(words.len(), 3);
    assert_eq!(words[0], "2 satellites, need 4");
    assert_eq!(words[1], "PDOP 99.0, limit 6.0");
    assert!(words[2].starts_with("position jumped 63"), "{}", words[2]);
}

#[test]
fn an_epoch_that_comes_again_or_out_of_order_is_refused() {
    let flight = flight(3);
    let mut check = QualityCheck::new(Limits::default());
    assert_eq!(failures(&mut check, &flight[1]), []);
    let again = ReceiverFix { arrival: flight[2].arrival, ..flight[1] };
    assert!(matches!(
        failures(&mut check, &again)[..],
        [Failure::TimeNotAdvancing { step_s: 0.0 }, Failure::Delay { .. }]
    ));
    let mut check = QualityCheck::new(Limits::default());
    failures(&mut check, &flight[1]);
    let late = ReceiverFix { arrival: flight[1].arrival, ..flight[0] };
    assert!(failures(&mut check, &late).contains(&Failure::TimeNotAdvancing { step_s: -1.0 }));
}

#[test]
fn one_outlier_is_refused_and_costs_none_of_the_fixes_after_it() {
    let mut flight = flight(6);
    flight[3].longitude_rad += 1e-4;
    let mut check = QualityCheck::new(Limits::default());
    let good: Vec<bool> = flight.iter().map(|fix| check.check(fix).is_empty()).collect();
    assert_eq!(good, [true, true, true, false, true, true]);
}

#[test]
fn a_wrong_first_fix_does_not_refuse_all_that_follow() {
    let mut flight = flight(5);
    flight[0].latitude_rad += 0.1;
    let mut check = QualityCheck::new(Limits::default());
    let good: Vec<bool> = flight.iter().map(|fix| check.check(fix).is_empty()).collect();
    assert_eq!(good, [true, false, true, true, true]);
}

#[test]
fn what_the_receiver_does_not_send_cannot_fail() {
    let nmea: Vec<u8> =
        encode::nmea_sentence("GPRMC,094812.00,A,0120.5,N,10341.0,E,4.0,90.0,230305,,,A");
    let mut check = QualityCheck::new(Limits::default());
    assert_eq!(failures(&mut check, &fixes(Protocol::Nmea, &nmea)[0]), []);
}

#[test]
fn clocks_that_drift_apart_slowly_are_not_a_delay() {
    let mut check = QualityCheck::new(Limits::default());
    let first = flight(1)[0];
    for hour in 0..20u32 {
        let mut fix = first;
        // The host's crystal is 50 ppm fast: 0.18 s an hour.
        let seconds = f64::from(hour) * 3_600.0;
        fix.arrival = first.arrival + seconds * (1.0 + 5e-5);
        if let Some(hovernav::gps::ReceiverTime::Gps { time_of_week_ns, .. }) = &mut fix.time {
            *time_of_week_ns += u64::from(hour) * 3_600_000_000_000;
        }
        assert_eq!(failures(&mut check, &fix), [], "hour {hour}");
    }
}
