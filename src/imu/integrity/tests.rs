//! Full scale, stuck units, shocks and lost samples.

use super::*;

fn rates(x: f64, turn: f64) -> MeanRates {
    MeanRates {
        angular_rate_radps: Vector::new(0.0, 0.0, turn),
        specific_force_mps2: Vector::new(x, 0.0, -9.8),
    }
}

/// Uniformly distributed numbers from −1 to 1, from a linear congruential generator of 64 bits.
fn noise() -> impl FnMut() -> f64 {
    let mut state = 1u64;
    move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

#[test]
fn steady_vibration_is_no_suspicion() {
    let (mut integrity, mut next) = (Integrity::<f64>::NONE, noise());
    for k in 0..3000 {
        let found = integrity.push(
            (&rates(3.0 * next(), 0.1 * next()), true),
            &ImuAxes::NONE,
            0.01,
            (&FullScale::default(), Checks::ALL),
        );
        assert!(k < 100 || (!found.shaken && !found.clipped.any()), "{k}");
        assert!(k < 100 || found.velocity_variance == [0.0; 3]);
    }
}

#[test]
fn readings_at_a_known_or_learned_full_scale_are_clipped() {
    let known = FullScale { accel_mps2: 20.0, gyro_radps: 0.0 };
    for (scale, from) in [(known, 0), (FullScale::default(), 40)] {
        let (mut integrity, mut next) = (Integrity::<f64>::NONE, noise());
        for k in 0..400 {
            let force = (40.0 * next()).clamp(-20.0, 20.0);
            let found = integrity.push(
                (&rates(force, 0.0), true),
                &ImuAxes::NONE,
                0.01,
                (&scale, Checks::ALL),
            );
            assert!(k < from || force.abs() != 20.0 || found.clipped.accel[0]);
            assert!(force.abs() > 19.9 || !found.clipped.accel[0]);
            assert!(!found.clipped.accel[2] && found.clipped.gyro == [false; 3]);
            assert!(!found.clipped.accel[0] || found.velocity_variance[0] > 0.0);
        }
    }
}

#[test]
fn a_burst_that_the_unit_marks_hides_one_error_and_not_many() {
    let (mut integrity, mut next) = (Integrity::<f64>::NONE, noise());
    let mut hidden = |marked: bool| {
        let marks = ImuAxes { accel: [marked, false, false], ..ImuAxes::NONE };
        let force = 3.0 * next();
        integrity.push(
            (&rates(force, 0.0), true),
            &marks,
            0.01,
            (&FullScale::default(), Checks::ALL),
        )
    };
    for _ in 0..500 {
        assert!(!hidden(false).clipped.any());
    }
    let burst: Vec<Suspicion> = (0..20).map(|_| hidden(true)).collect();
    assert!(burst.iter().all(|found| found.clipped.accel == [true, false, false]));
    let total: f64 = burst.iter().map(|found| found.velocity_variance[0]).sum();
    let one_by_one = 20.0 * burst[0].velocity_variance[0];
    assert!(total > 5.0 * one_by_one, "{total} {one_by_one}");
    assert_eq!(hidden(false).velocity_variance, [0.0; 3]);
}

#[test]
fn a_unit_that_repeats_itself_twice_is_stuck_unless_it_rests() {
    for (strength, expected) in [(3.0, true), (0.0, false)] {
        let (mut integrity, mut next) = (Integrity::<f64>::NONE, noise());
        let mut stuck = |force: f64| {
            let rates = rates(strength * force, 0.0);
            let MeanRates { angular_rate_radps, specific_force_mps2 } = rates;
            let stuck =
                integrity.is_stuck(&Motion::Rates { angular_rate_radps, specific_force_mps2 });
            integrity.push(
                (&rates, true),
                &ImuAxes::NONE,
                0.01,
                (&FullScale::default(), Checks::ALL),
            );
            stuck
        };
        for _ in 0..500 {
            assert!(strength == 0.0 || !stuck(next()));
        }
        assert_eq!([1.0, 1.0, 1.0, 1.0, 0.5].map(&mut stuck)[..2], [false, false]);
        assert_eq!([0.7, 0.7, 0.7, 0.7, 0.5].map(stuck), [false, false, expected, expected, false]);
    }
}

#[test]
fn what_a_logger_draws_between_samples_is_distinguished_from_what_a_unit_measures() {
    let (mut integrity, mut next) = (Integrity::<f64>::NONE, noise());
    let mut since_s = 0.0;
    let mut made_up = |force: f64, turn: f64| {
        since_s += 0.01;
        let rates = rates(force, turn);
        let MeanRates { angular_rate_radps, specific_force_mps2 } = rates;
        let motion = Motion::Rates { angular_rate_radps, specific_force_mps2 };
        let found = integrity.is_interpolated(&motion, since_s);
        if !found {
            integrity.push(
                (&rates, true),
                &ImuAxes::NONE,
                since_s,
                (&FullScale::default(), Checks::ALL),
            );
            since_s = 0.0;
        }
        found
    };
    for _ in 0..500 {
        assert!(!made_up(0.2 * next(), 0.01 * next()));
    }
    let line = |step: u32| (0.1 + 0.004 * f64::from(step), 0.01 - 0.000_2 * f64::from(step));
    let found: Vec<bool> = (0..150).map(line).map(|(force, turn)| made_up(force, turn)).collect();
    assert_eq!(found.iter().filter(|&&found| !found).count(), 11, "{found:?}");
    assert!(found[11..].iter().all(|&found| found));
    assert!(!made_up(0.2 * next(), 0.01 * next()));
    // A register that is not written is not a line.
    assert!(!(0..50).any(|_| made_up(0.05, 0.002)));
}

#[test]
fn a_blow_with_samples_lost_in_it_moves_no_more_than_its_readings() {
    let tone = |k: f64| (35.0 * (1.3 * k).sin()).clamp(-29.4, 29.4);
    for lost in 0..10 {
        for late_s in [0.06, 0.09, 0.15, 0.24] {
            let (mut integrity, mut next) = (Integrity::<f64>::NONE, noise());
            let (mut error_mps, mut before) = (0.0, 0.0);
            for step in 0..400 {
                let place = step - 300;
                let force = if (0..10).contains(&place) { tone(f64::from(place)) } else { 0.0 };
                let reading = force + 0.3 * next();
                let interval_s = if place == lost { late_s } else { 0.03 };
                let scale = FullScale::default();
                let rates = rates(reading, 0.0);
                let found = integrity.push(
                    (&rates, true),
                    &ImuAxes::NONE,
                    interval_s,
                    (&scale, Checks::ALL),
                );
                let withheld = found.withheld_mps2.to_array()[0];
                error_mps += (0.5 * (before + reading) - withheld) * interval_s;
                before = reading;
                assert!(error_mps.abs() < 8.0, "{lost} {late_s}: {error_mps} m/s at {place}");
            }
        }
    }
}

#[test]
fn a_shock_and_a_lost_sample_leave_an_error_of_full_size() {
    let (mut integrity, mut next) = (Integrity::<f64>::NONE, noise());
    let mut push = |force: f64, interval_s: f64| {
        integrity.push(
            (&rates(force, 0.0), true),
            &ImuAxes::NONE,
            interval_s,
            (&FullScale::default(), Checks::ALL),
        )
    };
    for _ in 0..1000 {
        push(1.7 * next(), 0.03);
    }
    let lost = push(1.0, 0.09).velocity_variance[0];
    assert!(lost > 0.3 * 0.045f64.powi(2), "{lost}");
    let shock = [30.0, -30.0, 30.0, -30.0, 30.0].map(|force| push(force, 0.03));
    assert!(shock[4].shaken);
    let variance: f64 = shock.iter().map(|found| found.velocity_variance[0]).sum();
    assert!(variance > (5.0f64 * 0.03).powi(2), "{variance}");
    let missed: f64 = shock.iter().map(|found| found.withheld_mps2.to_array()[0] * 0.03).sum();
    assert!(missed.abs() < 3.0 * variance.sqrt(), "{missed} m/s with a variance of {variance}");
}

/// Vibration as noise or as a tone, with 1, 2 or 4 successive samples lost at random. The error of the trapezoid over
/// the gap must agree with the reported variance.
#[test]
fn lost_samples_leave_the_error_that_is_reported() {
    const USUAL_S: f64 = 0.03;
    let mut shaking = noise();
    let mut next = noise();
    next();
    for (lost, turn_rad) in [1, 2, 4].into_iter().flat_map(|n| [(n, 0.0), (n, 1.5), (n, 2.4)]) {
        let mut integrity = Integrity::<f64>::NONE;
        let (mut squares, mut variances) = (0.0, 0.0);
        let (mut before, mut missed_mps, mut missing) = (0.0, 0.0, 0);
        for k in 0..20_000u32 {
            let tone = (turn_rad * f64::from(k)).sin();
            let force = if turn_rad == 0.0 { 3.0 * shaking() } else { 3.0 * tone };
            if missing == 0 && k > 1000 && next() > 0.95 {
                missing = lost;
            }
            if missing > 0 {
                missing -= 1;
                missed_mps += force * USUAL_S;
                continue;
            }
            let length = if missed_mps == 0.0 { 1 } else { lost + 1 };
            let interval_s = USUAL_S * f64::from(length);
            let found = integrity.push(
                (&rates(force, 0.0), true),
                &ImuAxes::NONE,
                interval_s,
                (&FullScale::default(), Checks::ALL),
            );
            if length > 1 {
                let off = 0.5 * (before + force) * f64::from(lost) * USUAL_S - missed_mps;
                squares += off * off;
                variances += found.velocity_variance[0];
                missed_mps = 0.0;
            }
            before = force;
        }
        let ratio = f64::sqrt(squares / variances);
        assert!((0.6..1.3).contains(&ratio), "{lost} lost, {turn_rad}: {ratio}");
    }
}

#[test]
fn a_burst_is_forgotten_whole() {
    let (mut integrity, mut next) = (Integrity::<f64>::NONE, noise());
    for k in 0..3000 {
        let marks = ImuAxes { accel: [k < 30, false, false], ..ImuAxes::NONE };
        integrity.push(
            (&rates(3.0 * next(), 0.0), true),
            &marks,
            0.01,
            (&FullScale::default(), Checks::ALL),
        );
    }
    assert_eq!(integrity.accel.clipped_s, [0.0; 3]);
}

#[test]
fn a_suspicion_names_the_axes_it_falls_on() {
    let words = |suspicion: Suspicion| suspicion.to_string();
    let none = Suspicion::NONE;
    let (x, yz) = ([true, false, false], [false, true, true]);
    assert_eq!(words(none), "no fault found");
    assert_eq!(
        words(Suspicion { stuck: ImuAxes { gyro: x, ..ImuAxes::NONE }, ..none }),
        "gyro x stuck at one reading"
    );
    assert_eq!(
        words(Suspicion { stuck: ImuAxes { accel: yz, ..ImuAxes::NONE }, ..none }),
        "accelerometers y, z stuck at one reading"
    );
    assert_eq!(
        words(Suspicion { clipped: ImuAxes { accel: x, ..ImuAxes::NONE }, shaken: true, ..none }),
        "accelerometer x at full scale"
    );
    assert_eq!(
        words(Suspicion { clipped: ImuAxes { gyro: yz, ..ImuAxes::NONE }, ..none }),
        "gyros y, z at full scale"
    );
}

#[test]
fn the_axis_that_repeats_itself_is_the_one_suspected() {
    for axis in 0..6 {
        let mut integrity = Integrity::<f64>::NONE;
        let mut suspicion = Suspicion::NONE;
        let mut values = [0.0; 6];
        for step in 0..600 {
            for (k, value) in values.iter_mut().enumerate() {
                if k != axis || step < 500 {
                    *value = ((step * (7 + k) + k) as f64).sin() * if k < 3 { 0.1 } else { 1.0 };
                }
            }
            let [p, q, r, x, y, z] = values;
            let rates = MeanRates {
                angular_rate_radps: Vector::new(p, q, r),
                specific_force_mps2: Vector::new(x, y, z - 9.8),
            };
            let scale = FullScale::default();
            suspicion =
                integrity.push((&rates, true), &ImuAxes::default(), 0.01, (&scale, Checks::ALL));
        }
        let found = [suspicion.stuck.gyro, suspicion.stuck.accel].concat();
        let expected: Vec<bool> = (0..6).map(|k| k == axis).collect();
        assert_eq!(found, expected, "{axis}");
    }
}
