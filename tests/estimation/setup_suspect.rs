//! Sensors with a wrong unit, sign or axis: the estimator names the mistake. For correct sensors it reports none.

use hovernav::earth::{Geodetic, STANDARD_GRAVITY_MPS2};
use hovernav::ekf::{Estimator, EstimatorConfig, Notice};
use hovernav::event::Event;
use hovernav::frames::{Body, Vector};
use hovernav::gps::Fix;
use hovernav::imu::{ImuSample, Motion};
use hovernav::setup::{ForceScale, SetupFault};
use hovernav_dataset::Dataset;
use hovernav_sim::{DmuConfig, FlightPlan, GpsConfig, Recording, fly};
use hovernav_testing::{FLIGHTS, shared};

/// Climbs, turns and manoeuvres of four minutes.
fn recording(seed: u64) -> Recording {
    let start = Geodetic::from_degrees(47.3, 8.5, 420.0).unwrap();
    let forward = |speed_mps| Vector::new(speed_mps, 0.0, 0.0);
    let mut plan = FlightPlan::hover_at(start, 0.4).hold(12.0).climb(10.0, 2.0).test_points();
    for sense in [1.0, -1.0] {
        plan = plan
            .accelerate(forward(6.0), 4.0)
            .turn(sense * 5.0, 0.4)
            .climb(-8.0, 1.5)
            .hold(5.0)
            .climb(12.0, 2.0)
            .turn(sense * 4.0, 0.4)
            .accelerate(forward(-6.0), 4.0)
            .test_points();
    }
    let dmu = DmuConfig { attitude: None, magnetometer: None, ..DmuConfig::default() };
    fly(&plan.build().unwrap(), &dmu, &GpsConfig::default(), seed).unwrap()
}

/// Faults that the estimator reports, with times, s.
fn suspects(events: impl Iterator<Item = Event>) -> Vec<(f64, SetupFault)> {
    let mut estimator = Box::new(Estimator::new(EstimatorConfig::default()));
    let mut suspects = Vec::new();
    for event in events {
        estimator.push(&event, |notice| {
            if let Notice::SetupSuspect { time, fault } = notice {
                suspects.push((time.seconds(), fault));
            }
        });
    }
    suspects
}

/// Faults in a flight whose samples and fixes are changed.
fn changed(
    recording: &Recording,
    motion: impl Fn([f64; 3], [f64; 3]) -> ([f64; 3], [f64; 3]),
    fix: impl Fn(&mut Fix),
) -> Vec<(f64, SetupFault)> {
    let samples = recording.imu.iter().map(|sample| {
        let Motion::Rates { angular_rate_radps, specific_force_mps2 } = sample.motion else {
            panic!("the simulated unit measures rates")
        };
        let (rate, force) = motion(angular_rate_radps.to_array(), specific_force_mps2.to_array());
        let [angular_rate_radps, specific_force_mps2] =
            [rate, force].map(|[x, y, z]| Vector::<Body>::new(x, y, z));
        let motion = Motion::Rates { angular_rate_radps, specific_force_mps2 };
        Event::Imu(ImuSample::new(sample.time, motion))
    });
    let fixes = recording.fixes.iter().map(|fixed| {
        let mut fixed = *fixed;
        fix(&mut fixed);
        Event::Gps(fixed)
    });
    let mut events: Vec<Event> = samples.chain(fixes).collect();
    events.sort_by_key(Event::time);
    suspects(events.into_iter())
}

#[test]
fn right_sensors_are_not_suspect() {
    for seed in 1..=5 {
        let found = changed(&recording(seed), |rate, force| (rate, force), |_| ());
        assert!(found.is_empty(), "seed {seed}: {found:?}");
    }
    let included = concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/heli-hover").into();
    let shared = FLIGHTS.into_iter().filter_map(|name| shared(format!("datasets/{name}")));
    for directory in shared.chain([included]) {
        let dataset = Dataset::open(&directory).unwrap();
        let found = suspects(dataset.events());
        assert!(found.is_empty(), "{}: {found:?}", directory.display());
    }
}

#[test]
fn accelerations_in_g_or_along_other_axes_are_named_within_11_s() {
    let flight = recording(1);
    let times = |factor: f64, vector: [f64; 3]| vector.map(|part| factor * part);
    let g = STANDARD_GRAVITY_MPS2;
    for (factor, expected) in [
        (1.0 / g, ForceScale::InG),
        (1000.0 / g, ForceScale::InThousandthsOfG),
        (g, ForceScale::TimesG),
        (0.5, ForceScale::OtherRange { factor: 0.5 }),
        (4.0, ForceScale::OtherRange { factor: 4.0 }),
    ] {
        let found = changed(&flight, |rate, force| (rate, times(factor, force)), |_| ());
        let [(at_s, SetupFault::ForceSize { scale, .. }), ..] = found[..] else {
            panic!("{factor}: {found:?}")
        };
        assert!(at_s < 11.0 && scale == expected, "{factor}: {found:?}");
    }
    let left_up = |[x, y, z]: [f64; 3]| [x, -y, -z];
    let on_its_side = |[x, y, z]: [f64; 3]| [x, z, -y];
    for (axes, along) in [(left_up as fn([f64; 3]) -> [f64; 3], 2), (on_its_side, 1)] {
        let found = changed(&flight, |rate, force| (axes(rate), axes(force)), |_| ());
        let [(at_s, SetupFault::ForceDirection { up })] = found[..] else {
            panic!("{along}: {found:?}")
        };
        assert!(at_s < 11.0 && up[along].abs() > 0.95, "{found:?}");
    }
    let without = changed(&flight, |rate, [x, y, z]| (rate, [x, y, z + g]), |_| ());
    let expected = ForceScale::WithoutGravity;
    assert!(
        matches!(without[..], [(_, SetupFault::ForceSize { scale, .. }), ..] if scale == expected),
        "{without:?}"
    );
}

#[test]
fn rates_in_degrees_are_named_in_a_flight_with_manoeuvres() {
    for seed in 1..=3 {
        let in_degrees = |rate: [f64; 3], force| (rate.map(f64::to_degrees), force);
        let found = changed(&recording(seed), in_degrees, |_| ());
        let [(_, SetupFault::RatesInDegrees { reported_rad, seen_rad })] = found[..] else {
            panic!("{seed}: {found:?}")
        };
        assert!(reported_rad > 3.0 * seen_rad, "{found:?}");
    }
}

#[test]
fn a_velocity_of_a_wrong_sign_order_or_unit_is_named() {
    let level = |change: fn([f64; 2]) -> [f64; 2]| {
        move |fix: &mut Fix| {
            fix.horizontal_velocity_mps = fix.horizontal_velocity_mps.map(change);
        }
    };
    let up = |fix: &mut Fix| fix.down_velocity_mps = fix.down_velocity_mps.map(|down| -down);
    for seed in 1..=3 {
        let flight = recording(seed);
        let only = |fix: &dyn Fn(&mut Fix)| {
            let found = changed(&flight, |rate, force| (rate, force), fix);
            let [(_, fault)] = found[..] else { panic!("seed {seed}: {found:?}") };
            fault
        };
        assert_eq!(only(&up), SetupFault::VelocityUp);
        assert_eq!(only(&level(|[north, east]| [east, north])), SetupFault::VelocitySwapped);
        assert_eq!(
            only(&level(|[north, east]| [north, -east])),
            SetupFault::VelocityReversed { north: false }
        );
        for (unit_mps, change) in [
            (0.5144, (|velocity| velocity.map(|part| part / 0.5144)) as fn([f64; 2]) -> [f64; 2]),
            (0.2778, |velocity| velocity.map(|part| 3.6 * part)),
            (0.01, |velocity| velocity.map(|part| 100.0 * part)),
        ] {
            let SetupFault::VelocityScale { unit_mps: found } = only(&level(change)) else {
                panic!("{unit_mps}")
            };
            assert!((f64::from(found) / unit_mps - 1.0).abs() < 0.15, "{found} {unit_mps}");
        }
    }
}

#[test]
fn positions_in_radians_and_velocities_that_are_not_measured_are_named() {
    for seed in 1..=3 {
        let flight = recording(seed);
        let only = |fix: &dyn Fn(&mut Fix)| {
            let found = changed(&flight, |rate, force| (rate, force), fix);
            let [(_, fault)] = found[..] else { panic!("seed {seed}: {found:?}") };
            fault
        };
        let in_radians = |fix: &mut Fix| {
            let Geodetic { latitude_rad, longitude_rad, height_m } = fix.position;
            fix.position = Geodetic::from_degrees(latitude_rad, longitude_rad, height_m).unwrap();
        };
        assert_eq!(only(&in_radians), SetupFault::PositionInRadians);
        let zero = |fix: &mut Fix| fix.horizontal_velocity_mps = Some([0.0; 2]);
        let fault = only(&zero);
        assert!(matches!(fault, SetupFault::VelocityZero { .. }), "{fault:?}");
    }
}

#[test]
fn gyros_of_a_wrong_sign_or_order_are_named() {
    type Change = fn([f64; 3]) -> [f64; 3];
    let changes: [(Change, bool, bool); 5] = [
        (|[x, y, z]| [-x, y, z], true, false),
        (|[x, y, z]| [x, -y, z], true, false),
        (|[x, y, z]| [y, x, z], true, false),
        (|[x, y, z]| [x, y, -z], false, true),
        (|[x, y, z]| [x, -y, -z], true, true),
    ];
    for seed in 1..=3 {
        let flight = recording(seed);
        for (change, tilts, yaw) in changes {
            let found = changed(&flight, |rate, force| (change(rate), force), |_| ());
            let is_named =
                matches!(found[..], [(_, fault)] if fault == SetupFault::GyroSigns { tilts, yaw });
            assert!(is_named, "seed {seed}, {:?}: {found:?}", change([1.0, 2.0, 3.0]));
        }
    }
}

#[test]
fn dead_axes_are_named() {
    for seed in 1..=3 {
        let flight = recording(seed);
        for is_gyro in [true, false] {
            for axis in 0..if is_gyro { 3 } else { 2 } {
                let without = |mut rate: [f64; 3], mut force: [f64; 3]| {
                    (if is_gyro { &mut rate } else { &mut force })[axis] = 0.0;
                    (rate, force)
                };
                let found = changed(&flight, without, |_| ());
                let expected = SetupFault::DeadAxis { is_gyro, axis: axis as u8 };
                let is_named = found.iter().any(|(_, fault)| *fault == expected);
                assert!(is_named, "seed {seed}, {expected:?}: {found:?}");
            }
        }
    }
}

#[test]
fn heights_in_feet_are_named() {
    for seed in 1..=3 {
        let in_feet = |fix: &mut Fix| fix.position.height_m /= 0.3048;
        let found = changed(&recording(seed), |rate, force| (rate, force), in_feet);
        let [(_, SetupFault::HeightScale { factor })] = found[..] else {
            panic!("seed {seed}: {found:?}")
        };
        assert!((2.0..4.6).contains(&factor), "{factor}");
    }
}
