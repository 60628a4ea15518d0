//! A late fix has the same effect as a fix on time.

use hovernav::earth::Geodetic;
use hovernav::ekf::layout::{Full, Layout};
use hovernav::ekf::{
    Aid, BaseEkf, EkfConfig, Estimator, EstimatorConfig, FullEkf, Notice, Unusable,
};
use hovernav::event::Event;
use hovernav::frames::{EulerAngles, Ned, Rotation, Vector};
use hovernav::gps::Fix;
use hovernav::imu::{ImuSample, Motion};
use hovernav::ins::{Mounting, NavState, Start};
use hovernav::time::Time;
use hovernav_sim::{
    DmuConfig, DmuOutput, FlightPlan, GpsConfig, HorizontalVertical, Recording, fly,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Normal};

use crate::{blocks, unaided};

pub fn recording(rate_hz: f64) -> Recording {
    let start = Geodetic::from_degrees(47.0, 8.0, 400.0).unwrap();
    let trajectory = FlightPlan::hover_at(start, 0.7)
        .hold(2.0)
        .accelerate(Vector::new(8.0, 0.0, 0.0), 4.0)
        .turn(core::f64::consts::TAU, 30f64.to_radians())
        .roll_doublet(8f64.to_radians(), 1.5)
        .accelerate(Vector::new(-8.0, 0.0, 0.0), 4.0)
        .hold(2.0)
        .build()
        .unwrap();
    let gps = GpsConfig {
        lever_arm_m: Vector::new(-0.35, 0.0, -0.2),
        position_noise_m: HorizontalVertical::new(1.0, 2.0),
        velocity_noise_mps: HorizontalVertical::new(0.1, 0.2),
        ..GpsConfig::ideal(1.0)
    };
    let dmu = DmuConfig::ideal(rate_hz, DmuOutput::Increments);
    fly(&trajectory, &dmu, &gps, 5).unwrap()
}

fn mounting() -> Mounting {
    Mounting::default().with_antenna_lever_arm_m(Vector::new(-0.35, 0.0, -0.2))
}

fn start(recording: &Recording) -> Start {
    let truth = &recording.truth[0];
    Start {
        state: NavState {
            time: truth.time,
            position: truth.position,
            velocity_mps: truth.velocity_mps,
            body_to_ned: truth.body_to_ned.turned_in_to(Vector::new(0.01, -0.01, 0.05)),
        },
        attitude_sigma_rad: Vector::new(0.02, 0.02, 0.08),
        velocity_sigma_mps: Vector::new(0.3, 0.3, 0.3),
        position_sigma_m: Vector::new(2.0, 2.0, 2.0),
        gyro_bias_radps: Vector::ZERO,
        gyro_bias_sigma_radps: None,
    }
}

/// The flight with every fix delivered `late_s` after its validity.
pub fn flown(recording: &Recording, late_s: f64) -> Vec<BaseEkf> {
    let mut filter = BaseEkf::new(EkfConfig::default(), mounting(), start(recording));
    let mut fixes = recording.fixes.iter().skip(1).peekable();
    let mut states = Vec::new();
    for sample in &recording.imu[1..] {
        filter.predict(sample).unwrap();
        while let Some(fix) = fixes.next_if(|fix| fix.time + late_s <= sample.time) {
            assert!(filter.update_gps(fix).unwrap().any_accepted());
        }
        states.push(filter.clone());
    }
    states
}

#[test]
fn fixes_delivered_late_lead_to_the_state_that_fixes_on_time_lead_to() {
    let recording = recording(50.0);
    let on_time = flown(&recording, 0.0);
    let mut worst = [0.0f64; 4];
    for late_s in [0.1, 0.3] {
        let late = flown(&recording, late_s);
        // Compared just before the next fix, when both filters have used the same fixes.
        for (a, b) in on_time.iter().zip(&late).skip(48).step_by(50) {
            let (a_sigma, b_sigma) = (a.solution(), b.solution());
            let (a, b) = (a.state(), b.state());
            let turn: Rotation<Ned, Ned> = a.body_to_ned * b.body_to_ned.inverse();
            let [_, _, yaw_sigma] = a_sigma.attitude_sigma_rad;
            let shares = [
                a.position.displacement_from(&b.position).norm() / a_sigma.position_sigma_m.norm(),
                (a.velocity_mps - b.velocity_mps).norm() / a_sigma.velocity_sigma_mps.norm(),
                turn.rotation_vector().norm() / yaw_sigma,
                (a_sigma.position_sigma_m.norm() / b_sigma.position_sigma_m.norm() - 1.0).abs(),
            ];
            for (worst, share) in worst.iter_mut().zip(shares) {
                *worst = worst.max(share);
            }
        }
    }
    println!("apart, in one-sigmas: position, velocity, attitude; one-sigma itself: {worst:?}");
    let [position, velocity, attitude, sigma] = worst;
    assert!(position < 0.1 && velocity < 0.1 && attitude < 0.1 && sigma < 0.05);
}

#[test]
fn a_late_fix_counted_as_of_now_would_be_far_off() {
    let recording = recording(50.0);
    let mut right = BaseEkf::new(EkfConfig::default(), mounting(), start(&recording));
    let fix = recording.fixes[9];
    for sample in recording.imu[1..].iter().take_while(|s| s.time - fix.time <= 0.3) {
        right.predict(sample).unwrap();
    }
    let mut wrong = right.clone();
    let now = right.state().time;
    let late = right.update_gps(&fix).unwrap();
    let as_of_now = wrong.update_gps(&Fix { time: now, ..fix }).unwrap();
    let size = |report: &hovernav::ekf::Report| -> f64 {
        report.innovations().map(|axis| axis.innovation.abs()).sum()
    };
    assert!(size(&as_of_now) > 1.5 * size(&late));
}

#[test]
fn the_memory_reaches_back_half_a_second_at_any_rate_and_what_is_older_is_refused() {
    for rate_hz in [20.0, 33.0, 100.0, 1000.0] {
        let recording = recording(rate_hz);
        let mut filter = FullEkf::new(EkfConfig::default(), mounting(), start(&recording));
        for sample in recording.imu[1..].iter().take_while(|s| s.time.seconds() <= 8.0) {
            filter.predict(sample).unwrap();
        }
        let now = filter.state().time;
        let at = |age_s: f64| Fix { time: now + -age_s, ..recording.fixes[8] };
        assert!(filter.clone().update_gps(&at(0.5)).is_ok(), "{rate_hz} Hz");
        for age_s in [4.0, 1e3, 1e9] {
            let mut asked = filter.clone();
            assert_eq!(asked.update_gps(&at(age_s)), Err(Unusable::TooOld), "{rate_hz} Hz");
            assert_eq!(asked.state(), filter.state());
            assert_eq!(asked.covariance(), filter.covariance());
        }
    }
}

/// `minutes` at 200 Hz of an inertial unit that sways along north at up to `sway_mps`, with a period of 16 s and
/// vibration of `shaking_mps2`. Fixes are valid `late_s` before their time. Returns the final filter and the number of
/// fixes rejected as too old.
fn swayed(
    sway_mps: f64,
    shaking_mps2: f64,
    late_s: f64,
    minutes: u32,
) -> (Box<Estimator<Full, 28>>, u32) {
    const RATE_RADPS: f64 = 0.4;
    const SHAKING_RADPS: f64 = 147.0;
    let mut noise = ChaCha8Rng::seed_from_u64(5);
    let mut about = |sigma: f64| sigma * Normal::new(0.0, 1.0).unwrap().sample(&mut noise);
    let place = Geodetic::from_degrees(1.35, 103.8, 50.0).unwrap();
    let mut estimator = Box::new(Estimator::<Full, 28>::new(EstimatorConfig::default()));
    let mut too_old = 0;
    for sample in 0..200 * 60 * minutes {
        let time_s = f64::from(sample) / 200.0;
        let north_mps2 = sway_mps * RATE_RADPS * (RATE_RADPS * time_s).cos();
        let shaken_mps2 = shaking_mps2 * (SHAKING_RADPS * time_s).sin();
        let time = Time::ZERO + time_s;
        let motion = Motion::Rates {
            angular_rate_radps: Vector::new(about(0.01), about(0.01), about(0.01)),
            specific_force_mps2: Vector::new(
                north_mps2 + shaken_mps2 + about(0.1),
                shaken_mps2 + about(0.1),
                shaken_mps2 + about(0.1) - 9.806,
            ),
        };
        let attitude =
            EulerAngles { roll_rad: about(0.002), pitch_rad: about(0.002), yaw_rad: 0.0 };
        let imu = ImuSample { attitude: Some(attitude), ..ImuSample::new(time, motion) };
        let mut events = vec![Event::Imu(imu)];
        if sample % 200 == 199 {
            let (sine, cosine) = (RATE_RADPS * (time_s - late_s)).sin_cos();
            let north_m = -sway_mps / RATE_RADPS * cosine;
            let off_m = Vector::new(north_m + about(0.6), about(0.6), about(2.0));
            events.push(Event::Gps(Fix {
                horizontal_velocity_mps: Some([sway_mps * sine + about(0.1), about(0.1)]),
                down_velocity_mps: Some(about(0.2)),
                ..Fix::at(time, place.displaced(off_m))
            }));
        }
        for event in &events {
            estimator.push(event, |notice| {
                too_old += u32::from(matches!(
                    notice,
                    Notice::NotUsed { aid: Aid::Gps, reason: Unusable::TooOld, .. }
                ));
            });
        }
    }
    (estimator, too_old)
}

/// Estimate of a state and its one-sigma.
fn found(estimator: &Estimator<Full, 28>, state: Option<usize>) -> (f64, f64) {
    let (filter, state) = (estimator.filter().unwrap(), state.unwrap());
    (filter.parameter(state), filter.covariance().variance(state).sqrt())
}

/// At rest the delay of the fixes is unobservable: its estimate stays within the initial one-sigma, and its one-sigma
/// does not shrink.
#[test]
fn what_is_found_of_a_delay_while_nothing_moves_is_nothing() {
    let (estimator, too_old) = swayed(0.0, 0.0, 0.0, 40);
    assert_eq!(too_old, 0);
    assert!(estimator.solution().unwrap().velocity_mps.norm() < 0.5);
    for state in [Full::LATENCY, Full::GPS_DELAY] {
        let (delay_s, sigma_s) = found(&estimator, state);
        println!("at rest: {delay_s:.4} s, one-sigma {sigma_s:.4}");
        assert!(delay_s.abs() < 0.1 && sigma_s > 0.09, "{delay_s} {sigma_s}");
    }
}

#[test]
fn what_sways_shows_how_late_its_fixes_are() {
    let (estimator, _) = swayed(1.0, 0.0, 0.1, 20);
    let (delay_s, sigma_s) = found(&estimator, Full::GPS_DELAY);
    println!("swaying: {delay_s:.4} s, one-sigma {sigma_s:.4}");
    assert!((delay_s - 0.1).abs() < 3.0 * sigma_s && sigma_s < 0.05, "{delay_s} {sigma_s}");
}

/// If a fix is valid after its time stamp, the motion comes from the later samples. It is not extrapolated from
/// earlier, vibrating samples.
#[test]
fn what_sways_and_shakes_shows_how_early_its_fixes_are_stamped() {
    for early_s in [0.25, 0.15, 0.05, 0.0, -0.05, -0.15, -0.25] {
        let (estimator, too_old) = swayed(2.0, 3.0, -early_s, 10);
        let (delay_s, sigma_s) = found(&estimator, Full::GPS_DELAY);
        println!("swaying, {early_s} s early: {delay_s:.4} s, one-sigma {sigma_s:.4}");
        assert_eq!(too_old, 0);
        assert!((delay_s + early_s).abs() < 0.015, "{delay_s} {sigma_s}");
    }
}

/// Several fixes may wait, and several may become due at one sample.
#[test]
fn fixes_that_wait_are_taken_in_by_their_time() {
    let place = Geodetic::from_degrees(1.35, 103.8, 50.0).unwrap();
    for (unit, receiver) in [(2, 3), (3, 2), (5, 3), (7, 3), (7, 4), (8, 5)] {
        let mut estimator = Box::new(Estimator::<Full, 28>::new(EstimatorConfig::default()));
        let mut taken: Vec<Time> = Vec::new();
        for step in 0..2_000 {
            let time = Time::from_nanoseconds(step * 10_000_000);
            let mut notify = |notice| {
                if let Notice::Updated(report) = notice {
                    let of_fix = report.innovations().find(|axis| axis.channel.is_of_fix());
                    taken.extend(of_fix.map(|axis| axis.time));
                }
            };
            if step % unit == 0 {
                let motion = Motion::Rates {
                    angular_rate_radps: Vector::ZERO,
                    specific_force_mps2: Vector::new(0.0, 0.0, -9.78),
                };
                let attitude = Some(EulerAngles::from_degrees(0.0, 0.0, 20.0));
                let sample = ImuSample { attitude, ..ImuSample::new(time, motion) };
                estimator.push(&Event::Imu(sample), &mut notify);
            }
            if step % receiver == 0 {
                let fix = Fix::at(time, place);
                let still = Fix { horizontal_velocity_mps: Some([0.0; 2]), ..fix };
                estimator.push(&Event::Gps(still), &mut notify);
            }
        }
        let told = i64::try_from(taken.len()).unwrap() * receiver;
        assert!(told > 1_700, "{told} of 2000 steps, {unit} and {receiver}");
        assert!(taken.is_sorted(), "{unit} and {receiver}");
    }
}

#[test]
fn a_fix_ahead_of_the_unit_is_refused_unless_a_sample_is_about_to_come() {
    let recording = recording(33.0);
    let mut filter = BaseEkf::new(EkfConfig::default(), mounting(), start(&recording));
    for sample in recording.imu[1..].iter().take_while(|s| s.time.seconds() <= 5.0) {
        filter.predict(sample).unwrap();
    }
    let now = filter.state().time;
    let at = |ahead_s: f64| Fix { time: now + ahead_s, ..recording.fixes[5] };
    assert!(filter.clone().update_gps(&at(0.03)).is_ok());
    assert_eq!(filter.update_gps(&at(0.2)), Err(Unusable::AheadOfImu));
    assert_eq!(filter.update_gps(&at(1e9)), Err(Unusable::AheadOfImu));
}

#[test]
fn before_the_first_sample_only_a_fix_of_the_start_itself_can_be_compared() {
    let recording = recording(33.0);
    let filter = BaseEkf::new(EkfConfig::default(), mounting(), start(&recording));
    let at = |time: Time| Fix { time, ..recording.fixes[0] };
    assert!(filter.clone().update_gps(&at(Time::ZERO)).is_ok());
    assert_eq!(filter.clone().update_gps(&at(Time::ZERO + -0.01)), Err(Unusable::TooOld));
}

#[test]
fn fixes_that_come_late_do_not_put_the_heading_in_doubt_nor_hide_it() {
    let gps = GpsConfig { rate_hz: 2.0, ..GpsConfig::default() };
    // The history covers a second at 50 Hz.
    for (seed, late_s) in [(1, 0.35), (2, 0.35), (3, 0.35), (1, 0.9), (2, 0.97)] {
        let (recording, mut estimator) =
            unaided::flown_unaided::<Full, 28>(&blocks::around_blocks(24), &gps, seed);
        let mut fixes = recording.fixes.iter().peekable();
        let (mut found, mut denied) = (false, Vec::new());
        for sample in &recording.imu {
            while let Some(fix) = fixes.next_if(|fix| fix.time + late_s <= sample.time) {
                estimator.push(&Event::Gps(*fix), |notice| match notice {
                    Notice::HeadingSuspect { time, .. } | Notice::HeadingReset { time, .. } => {
                        denied.push(time.seconds());
                    }
                    _ => {}
                });
            }
            estimator.push(&Event::Imu(*sample), |_| {});
            found |= estimator.solution().is_some_and(|now| now.attitude_sigma_rad[2] < 0.1);
        }
        assert!(
            found && denied.is_empty(),
            "seed {seed}, {late_s} s: {found}, suspect at {denied:?} s"
        );
    }
}
