//! Impossible readings are rejected with their reason, and change nothing.

use hovernav::earth::Geodetic;
use hovernav::ekf::{
    BaseEkf, EkfConfig, Estimator, EstimatorConfig, FullEkf, ImuFault, Prediction, ResetCause,
    Unusable, layout,
};
use hovernav::event::Event;
use hovernav::frames::{EulerAngles, Rotation, Vector};
use hovernav::gps::Fix;
use hovernav::imu::{ImuSample, Motion};
use hovernav::ins::Mounting;
use hovernav::time::Time;

use super::{PERIOD_S, Rest, RestBase, fix, start, still};

#[test]
fn a_fix_that_is_no_fix_is_refused_by_name_and_changes_nothing() {
    let mut rest = RestBase::new();
    for _ in 0..5 {
        rest.fix(Vector::ZERO);
    }
    let time = rest.sit();
    let good = fix(time, Vector::ZERO);
    let mut bad = Vec::new();
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300] {
        bad.push(Fix { position: Geodetic { latitude_rad: value, ..good.position }, ..good });
        bad.push(Fix { position: Geodetic { height_m: value, ..good.position }, ..good });
        bad.push(Fix { horizontal_velocity_mps: Some([0.0, value]), ..good });
        bad.push(Fix { down_velocity_mps: Some(value), ..good });
        bad.push(Fix { position_sigma_m: Some(Vector::new(1.0, 1.0, value)), ..good });
        bad.push(Fix { velocity_sigma_mps: Some(Vector::new(value, 1.0, 1.0)), ..good });
    }
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        bad.push(Fix { position: Geodetic { longitude_rad: value, ..good.position }, ..good });
    }
    for sigma in [0.0, -1.0] {
        bad.push(Fix { position_sigma_m: Some(Vector::new(1.0, sigma, 1.0)), ..good });
        bad.push(Fix { velocity_sigma_mps: Some(Vector::new(1.0, sigma, 1.0)), ..good });
    }
    let before = rest.filter.clone();
    for fix in bad {
        assert_eq!(rest.filter.update_gps(&fix), Err(Unusable::NotFinite), "{fix:?}");
    }
    assert_eq!(rest.filter.state(), before.state());
    assert_eq!(rest.filter.covariance(), before.covariance());
    assert!(rest.filter.update_gps(&good).unwrap().any_accepted());
}

#[test]
fn a_sample_that_is_no_sample_is_passed_over_by_name_and_changes_nothing() {
    let mut rest = RestBase::new();
    let now = rest.sit();
    let before = rest.filter.clone();
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300] {
        let vector = Vector::new(0.0, value, 0.0);
        for motion in [
            Motion::Rates { angular_rate_radps: vector, specific_force_mps2: Vector::ZERO },
            Motion::Rates { angular_rate_radps: Vector::ZERO, specific_force_mps2: vector },
            Motion::Increments { angle_rad: vector, velocity_mps: Vector::ZERO },
            Motion::Increments { angle_rad: Vector::ZERO, velocity_mps: vector },
        ] {
            let sample = ImuSample { motion, ..still(now + PERIOD_S) };
            assert_eq!(rest.filter.predict(&sample), Err(ImuFault::NotFinite));
        }
    }
    for time in [now, now + -PERIOD_S, Time::from_nanoseconds(i64::MIN)] {
        assert_eq!(rest.filter.predict(&still(time)), Err(ImuFault::NotLater));
    }
    assert_eq!(rest.filter.state(), before.state());
    assert_eq!(rest.filter.covariance(), before.covariance());
    rest.filter.predict(&still(now + PERIOD_S)).unwrap();
}

#[test]
fn one_sample_far_ahead_does_not_block_the_samples_after_it() {
    let mut rest = RestBase::new();
    let now = rest.sit();
    let before = rest.filter.clone();
    for time in [now + 61.0, now + 1e9, Time::from_nanoseconds(i64::MAX)] {
        assert_eq!(rest.filter.predict(&still(time)), Err(ImuFault::FarAhead));
        assert_eq!(rest.filter.state(), before.state());
    }
    rest.filter.predict(&still(now + PERIOD_S)).unwrap();
    // Two samples that agree show that the IMU was off for an hour.
    assert_eq!(rest.filter.predict(&still(now + 3600.0)), Err(ImuFault::FarAhead));
    let reset = rest.filter.predict(&still(now + (3600.0 + PERIOD_S))).unwrap();
    assert!(matches!(reset, Prediction::Reset(ResetCause::LongGap { .. })), "{reset:?}");
}

#[test]
fn aids_that_are_none_are_refused_by_name_and_change_nothing() {
    let mut rest = Rest::<layout::Full, 28>::new();
    let time = rest.sit();
    let before = rest.filter.clone();
    let filter: &mut FullEkf = &mut rest.filter;
    for value in [f64::NAN, f64::INFINITY, 1e300] {
        assert_eq!(filter.update_baro(time, value, &mut ()), Err(Unusable::NotFinite));
        let field = Vector::new(value, 0.1, 0.4);
        let told = filter.update_magnetic_heading(time, field, 0.0, &mut ());
        assert_eq!(told, Err(Unusable::NotFinite));
    }
    let vertical = Vector::new(0.0, 0.0, 0.5);
    for steep in [vertical, Vector::ZERO] {
        let told = filter.update_magnetic_heading(time, steep, 0.0, &mut ());
        assert_eq!(told, Err(Unusable::HorizontalFieldTooWeak));
    }
    let nan = EulerAngles { roll_rad: f64::NAN, pitch_rad: 0.0, yaw_rad: 0.0 };
    let told = filter.update_attitude(time, Rotation::from_euler(nan), &mut ());
    assert_eq!(told, Err(Unusable::NotFinite));
    assert_eq!(filter.state(), before.state());
    assert_eq!(filter.covariance(), before.covariance());
    let mut base = BaseEkf::new(EkfConfig::default(), Mounting::default(), start());
    assert_eq!(base.update_baro(Time::ZERO, 1.0, &mut ()), Err(Unusable::NoState));
}

#[test]
fn fixes_from_a_clock_far_ahead_do_not_keep_out_the_right_ones() {
    let mut estimator = Estimator::<layout::Full, 28>::new(EstimatorConfig::default());
    let mut accepted = 0;
    for step in 0..1500 {
        let time = Time::ZERO + f64::from(step) * PERIOD_S;
        estimator.push(&Event::Imu(still(time)), |_| {});
        if step % 50 == 0 {
            let ahead = fix(time + 1e6, Vector::ZERO);
            estimator.push(&Event::Gps(ahead), |_| {});
            // This fix only waits for the next sample.
            let next = fix(time + 0.5 * PERIOD_S, Vector::ZERO);
            estimator.push(&Event::Gps(next), |_| {});
        }
        if step % 50 == 1 {
            let now = estimator.solution().map(|solution| solution.time);
            accepted += i32::from(now.is_some());
        }
    }
    assert!(accepted > 20);
    let sigma_m = estimator.solution().unwrap().position_sigma_m.x();
    assert!(sigma_m < 2.0, "fixes still come through: {sigma_m} m");
}
