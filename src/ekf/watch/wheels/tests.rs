use super::*;

/// Motion straight on at a speed.
const fn at(forward_mps: f32) -> VelocityAcross {
    VelocityAcross {
        forward_mps,
        rate_radps: 0.0,
        force_mps2: 0.0,
        across_mps: 0.0,
        own_variance: 0.0025,
    }
}

/// State after a drive of `seconds` at 10 m/s with turns to both sides. `right` and `down` give the velocities across
/// from time and turn rate.
fn driven(
    seconds: u32,
    right: impl Fn(f32, f32) -> f32,
    down: impl Fn(f32, f32) -> f32,
) -> WheelWatch {
    // The springs let the car roll outwards.
    banked(seconds, right, down, -0.05)
}

/// State after the same drive as `driven`; the sine of the bank is `share` of the centripetal acceleration in g.
fn banked(
    seconds: u32,
    right: impl Fn(f32, f32) -> f32,
    down: impl Fn(f32, f32) -> f32,
    share: f32,
) -> WheelWatch {
    let mut watch = WheelWatch::of(None);
    for second in 1..=seconds {
        let time = second as f32;
        let rate_radps = 0.3 * (0.2 * time).sin();
        let seen = |across_mps, rate_radps| VelocityAcross { rate_radps, across_mps, ..at(10.0) };
        let pitch_rate = 0.05 * (1.3 * time).sin();
        let (right, down) = (right(time, rate_radps), down(time, pitch_rate));
        let time = Time::ZERO + f64::from(second);
        watch.observe_velocity(
            time,
            &[seen(right, rate_radps), seen(down, pitch_rate)],
            share * rate_radps * 10.0 / 9.8,
        );
    }
    watch
}

#[test]
fn a_car_whose_unit_is_turned_and_stands_off_its_axle_is_known_and_so_is_its_line() {
    let watch = driven(
        120,
        |t, rate| 0.3 + 1.2 * rate + 0.05 * (7.0 * t).sin(),
        |t, _| -0.2 + 0.05 * (5.0 * t).cos(),
    );
    assert!(watch.is_active);
    let line = watch.line(false, &at(10.0));
    assert!((line.slope - 0.03).abs() < 0.003 && (line.arm_m - 1.2).abs() < 0.1, "{line:?}");
    assert!((watch.line(true, &at(10.0)).slope + 0.02).abs() < 0.003);
    // Applied five times a second, the constraint is as accurate as one observation in two seconds.
    assert!((line.variance - 10.0 * (0.0025 + 0.0009)).abs() < 2e-3, "{line:?}");
}

#[test]
fn a_car_raises_its_nose_as_it_accelerates_and_its_line_follows() {
    let mut watch = WheelWatch::of(Some(VehicleKind::Wheeled));
    for second in 1..=120_u8 {
        let force_mps2 = (0.3 * f32::from(second)).sin();
        let motion = VelocityAcross { force_mps2, ..at(10.0) };
        let down = VelocityAcross { across_mps: 10.0 * (0.01 + 0.012 * force_mps2), ..motion };
        watch.observe_velocity(Time::ZERO + f64::from(second), &[motion, down], 0.0);
    }
    let slope = |force_mps2| watch.line(true, &VelocityAcross { force_mps2, ..at(10.0) }).slope;
    assert!((slope(0.0) - 0.01).abs() < 1e-3 && (slope(2.0) - 0.034).abs() < 1e-3);
}

#[test]
fn a_declared_car_is_held_from_the_start_within_its_mounting_and_again_after_it_slid() {
    let mut watch = WheelWatch::of(Some(VehicleKind::Wheeled));
    assert!(watch.is_due(Time::ZERO + 1.0));
    // 6° of mounting at 10 m/s.
    let mps = (watch.line(true, &at(10.0)).variance / 10.0).sqrt();
    assert!((0.9..1.2).contains(&mps), "{mps}");
    assert!(watch.is_violated([0.0, 9.0], 5.0) && !watch.is_due(Time::ZERO + 2.0));
    watch.observe_velocity(Time::ZERO + 3.0, &[at(10.0); 2], 0.0);
    assert!(watch.is_due(Time::ZERO + 4.0));
    watch.forget();
    assert!(watch.is_due(Time::ZERO + 5.0));
}

#[test]
fn a_declared_aircraft_never_rolls_on_wheels() {
    let mut watch = WheelWatch::of(Some(VehicleKind::Multirotor));
    for second in 1..=300_u16 {
        let rate_radps = 0.3 * (0.2 * f32::from(second)).sin();
        let seen = VelocityAcross { rate_radps, ..at(10.0) };
        watch.observe_velocity(Time::ZERO + f64::from(second), &[seen; 2], 0.0);
    }
    assert!(!watch.is_active);
}

#[test]
fn what_sideslips_or_climbs_as_aircraft_do_is_not_on_wheels() {
    let wind = driven(600, |t, _| (0.01 * t).sin(), |_, _| 0.0);
    let climbs = driven(600, |_, _| 0.0, |t, _| 0.5 * (0.05 * t).sin());
    assert!(!wind.is_active && !climbs.is_active);
}

#[test]
fn what_banks_into_its_turns_flies_however_still_the_air() {
    assert!(!banked(600, |_, _| 0.0, |_, _| 0.0, 1.0).is_active);
}

#[test]
fn a_straight_road_and_a_short_drive_tell_nothing() {
    let mut straight = WheelWatch::of(None);
    let seen = VelocityAcross { own_variance: 0.0, ..at(10.0) };
    for second in 1..1000 {
        straight.observe_velocity(Time::ZERO + f64::from(second), &[seen; 2], 0.0);
    }
    assert!(!straight.is_active && !driven(8, |_, _| 0.0, |_, _| 0.0).is_active);
}

#[test]
fn a_car_that_lifts_off_is_let_go_within_seconds() {
    let mut watch = driven(300, |_, _| 0.0, |_, _| 0.0);
    assert!(watch.is_active);
    let right = at(10.0);
    let mut seconds = 0;
    while watch.is_active {
        seconds += 1;
        let time = Time::ZERO + f64::from(300 + seconds);
        watch.observe_velocity(time, &[right, VelocityAcross { across_mps: -1.0, ..right }], 0.0);
    }
    assert!(seconds <= 4, "{seconds}");
}

#[test]
fn a_car_that_leaves_its_road_without_fixes_is_let_go_at_once_or_within_two_seconds() {
    let held = driven(300, |_, _| 0.0, |_, _| 0.0);
    let after = |normalised: [f32; 2]| {
        let mut watch = held;
        (1..1000).find(|_| watch.is_violated(normalised, 5.0)).map(|count| (count, watch))
    };
    assert!(after([0.3, -0.5]).is_none());
    let (count, mut off) = after([0.1, -1.2]).unwrap();
    assert!(count <= 10 && !off.is_due(Time::ZERO + 400.0));
    let mut refused = held;
    assert!(refused.is_violated([0.0, -5.1], 5.0) && !refused.is_due(Time::ZERO + 400.0));
    let mut wrong = held;
    assert!(wrong.is_violated([f32::NAN, 0.0], 5.0));
}

#[test]
fn slow_motion_and_what_is_no_number_change_nothing() {
    let mut watch = WheelWatch::of(None);
    let good = VelocityAcross { rate_radps: 0.3, across_mps: 0.1, ..at(10.0) };
    for (second, bad) in [
        VelocityAcross { forward_mps: 2.9, ..good },
        VelocityAcross { forward_mps: f32::NAN, ..good },
        VelocityAcross { rate_radps: f32::NAN, ..good },
        VelocityAcross { across_mps: f32::INFINITY, ..good },
        VelocityAcross { own_variance: f32::NAN, ..good },
    ]
    .into_iter()
    .enumerate()
    {
        watch.observe_velocity(Time::ZERO + second as f64, &[bad, good], 0.0);
        watch.observe_velocity(
            Time::ZERO + second as f64,
            &[VelocityAcross { forward_mps: 1.0, ..good }, bad],
            0.0,
        );
    }
    assert!(watch.tracks[0].seen_s == 0.0 && watch.tracks[0].found().0 == [0.0; CAUSES]);
}
