//! Impossible set-ups are reported with their likely cause before the estimation; possible set-ups are not reported.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use hovernav::earth::Geodetic;
use hovernav::frames::{Ned, Vector};
use hovernav::gps::Fix;
use hovernav::imu::{ImuSample, Motion};
use hovernav::time::Time;
use hovernav_dataset::{Dataset, LogError};
use hovernav_findings::{
    FindingKind, Sensor, alternative, check_fitness, check_setup, ensure_possible, findings,
};
use hovernav_replay::estimate;
use hovernav_sim::faults::{Fault, Log};
use hovernav_testing::{FLIGHTS, shared};
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

fn heli_hover() -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/heli-hover")).into()
}

fn dataset(name: &str) -> Option<PathBuf> {
    shared(format!("datasets/{name}"))
}

/// The available datasets, including real ones if present.
fn datasets() -> Vec<PathBuf> {
    FLIGHTS.into_iter().filter_map(dataset).chain([heli_hover()]).collect()
}

/// A copy of `log` with a fault.
fn copy(log: &Path, fault: &str) -> tempfile::TempDir {
    let faults: [Fault; 1] = [fault.parse().unwrap()];
    let dir = tempfile::tempdir().unwrap();
    Log::open(log).unwrap().with_faults(&faults, 1).unwrap().write(dir.path()).unwrap();
    dir
}

/// Reasons for which `hovernav estimate` rejects a log.
fn refusal(dir: &Path) -> String {
    let dataset = Dataset::open(dir).unwrap();
    check_fitness(&dataset, dir).err().map_or_else(String::new, |error| error.to_string())
}

#[test]
fn flights_as_they_were_flown_are_not_suspected() {
    for dir in datasets() {
        let mut dataset = Dataset::open(&dir).unwrap();
        assert_eq!(check_setup(&dataset), [], "{}", dir.display());
        let config = dataset.settings().unwrap();
        let run = estimate(&dataset, &config, |_| {});
        assert_eq!(alternative(&dataset, &config, &run), None, "{}", dir.display());
    }
}

#[test]
fn vibration_clipping_and_bad_fixes_are_no_wrong_set_up() {
    for fault in ["vibration=4", "clip-accel=2", "packet-loss=25", "glitch-step=60", "no-velocity"]
    {
        let dir = copy(&heli_hover(), fault);
        assert_eq!(check_setup(&Dataset::open(dir.path()).unwrap()), [], "{fault}");
    }
}

#[test]
fn a_wrong_set_up_of_a_unit_with_its_own_attitude_is_refused_by_name() {
    for (fault, expected) in [
        ("accel-sign=xyz", "axes = \"flu\""),
        ("accel-scale=0.5", "2 g for 4 g"),
        ("gyro-sign=x", "gyro x turns against"),
        ("gyro-sign=z", "gyro z turns against"),
        ("swap-axes=xy", "two axes of the inertial unit swapped"),
        ("swap-axes=xz", "axis is vertical"),
        ("unit=g", "accel_unit = \"g\""),
        ("unit=degps", "gyro_unit = \"degps\""),
        ("swap-latlon", "latitude and longitude swapped"),
        ("radians", "latitude and longitude in radians"),
    ] {
        let dir = copy(&heli_hover(), fault);
        let refusal = refusal(dir.path());
        assert!(refusal.contains(expected), "{fault}: {refusal}");
    }
}

#[test]
fn a_velocity_of_a_wrong_unit_or_sign_is_refused_with_and_without_its_vertical_part() {
    for dir in
        [dataset("car-rtk"), dataset("uav-thor75-1hz"), Some(heli_hover())].into_iter().flatten()
    {
        for (scale, expected) in [
            ([3.6, 3.6], "velocity in km/h"),
            ([1.944, 1.944], "velocity in knots"),
            ([100.0, 100.0], "velocity in cm/s"),
            ([1.0, -1.0], "wrong sign"),
        ] {
            for is_level in [true, false] {
                let mut dataset = Dataset::open(&dir).unwrap();
                for fix in &mut dataset.fixes {
                    fix.horizontal_velocity_mps = fix
                        .horizontal_velocity_mps
                        .map(|[north, east]| [scale[0] * north, scale[1] * east]);
                    fix.down_velocity_mps = fix.down_velocity_mps.filter(|_| !is_level);
                }
                let refusal = ensure_possible(&dataset, &dir).unwrap_err().to_string();
                assert!(refusal.contains(expected), "{} {scale:?}: {refusal}", dir.display());
            }
        }
    }
}

#[test]
fn a_velocity_of_the_fix_before_or_after_is_named() {
    let Some(dir) = dataset("uav-thor75-1hz") else { return };
    for (later, expected) in [(1, "of the fix before"), (-1, "of the fix after")] {
        let mut dataset = Dataset::open(&dir).unwrap();
        let told: Vec<_> = dataset.fixes.iter().map(|fix| fix.horizontal_velocity_mps).collect();
        for (index, fix) in dataset.fixes.iter_mut().enumerate() {
            let other = index.checked_add_signed(later).and_then(|other| told.get(other));
            fix.horizontal_velocity_mps = other.copied().flatten();
        }
        let found = check_setup(&dataset);
        assert!(found.iter().any(|one| one.to_string().contains(expected)), "{later}: {found:?}");
    }
}

#[test]
fn a_wrong_set_up_of_a_unit_without_attitude_is_refused_or_named_after_trying_others() {
    for (name, fault, expected) in [
        ("car-rtk", "accel-sign=xyz", "axes = \"flu\""),
        ("car-rtk", "unit=degps", "gyro_unit"),
        ("car-rtk", "gyro-sign=z", "gyro z of the wrong sign"),
        ("car-rtk", "swap-axes=xy", "axes x and y swapped"),
        ("quad-p4rtk-vibration", "unit=g", "accel_unit"),
        ("quad-p4rtk-vibration", "gyro-sign=x", "gyro x of the wrong sign"),
        ("quad-p4rtk-vibration", "swap-latlon", "swapped"),
        ("quad-ardupilot-5hz", "gyro-sign=xyz", "all gyros of the wrong sign"),
        ("uav-thor75-1hz", "accel-sign=x", "accelerometer x of the wrong sign"),
        ("uav-thor75-1hz", "radians", "radians"),
    ] {
        let Some(log) = dataset(name) else { continue };
        let dir = copy(&log, fault);
        let mut told = refusal(dir.path());
        if told.is_empty() {
            let mut dataset = Dataset::open(dir.path()).unwrap();
            let config = dataset.settings().unwrap();
            let run = estimate(&dataset, &config, |_| {});
            told = alternative(&dataset, &config, &run).map_or(told, |found| found.to_string());
        }
        assert!(told.contains(expected), "{name} {fault}: {told}");
    }
}

#[test]
fn set_ups_that_fit_alike_are_all_named() {
    // A unit that is turned by 180° about z has gyros x and y of the wrong sign, and accelerometers that are right.
    let Some(log) = dataset("quad-p4rtk-vibration") else { return };
    let mut dataset = Dataset::open(&log).unwrap();
    for sample in &mut dataset.imu {
        if let Motion::Rates { angular_rate_radps: turn, .. } = &mut sample.motion {
            let [x, y, z] = turn.to_array();
            *turn = Vector::new(-x, -y, z);
        }
    }
    let config = dataset.settings().unwrap();
    let run = estimate(&dataset, &config, |_| {});
    let found = alternative(&dataset, &config, &run).unwrap().to_string();
    assert!(found.contains("gyros x and y of the wrong sign"), "{found}");
    assert!(found.contains("or accelerometers x and y of the wrong sign"), "{found}");
}

#[test]
fn gyros_at_a_quarter_or_four_times_their_scale_are_named() {
    for name in ["car-rtk", "quad-p4rtk-vibration"] {
        for (scale, expected) in [(0.25, "gyros at a quarter"), (4.0, "gyros at four times")] {
            let Some(log) = dataset(name) else { return };
            let mut dataset = Dataset::open(&log).unwrap();
            for sample in &mut dataset.imu {
                if let Motion::Rates { angular_rate_radps: turn, .. } = &mut sample.motion {
                    *turn = *turn * scale;
                }
            }
            let config = dataset.settings().unwrap();
            let run = estimate(&dataset, &config, |_| {});
            let found = findings(&dataset, &run);
            let has = |kind: FindingKind| found.iter().any(|one| one.kind == kind);
            assert!(found.iter().any(|one| one.words.contains(expected)), "{name}: {found:?}");
            // Delays and lever arms by the accelerations of a wrong attitude are wrong.
            assert!(
                !has(FindingKind::TimeOffset) && !has(FindingKind::LeverArm),
                "{name}: {found:?}"
            );
        }
    }
}

#[test]
fn the_line_that_mends_a_set_up_mends_it() {
    let truth = Dataset::open(&heli_hover()).unwrap();
    for (fault, key) in [
        ("accel-sign=xyz", "accel_is_gravity = true"),
        ("unit=g", "accel_unit = \"g\""),
        ("unit=degps", "gyro_unit = \"degps\""),
    ] {
        let dir = copy(&heli_hover(), fault);
        let path = dir.path().join("dataset.toml");
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text.replacen("[imu]", &format!("[imu]\n{key}"), 1)).unwrap();
        let mended = Dataset::open(dir.path()).unwrap();
        assert!(ensure_possible(&mended, dir.path()).is_ok(), "{fault}");
        assert_eq!(mended.manifest.imu.axes, truth.manifest.imu.axes);
        let size = |dataset: &Dataset| {
            let means = dataset.imu.iter().map(|sample| sample.motion.mean_rates(0.03));
            means.map(|mean| mean.specific_force_mps2.z()).sum::<f64>()
        };
        assert!((size(&mended) / size(&truth) - 1.0).abs() < 0.01, "{fault}");
    }
}

#[test]
fn spans_that_do_not_overlap_are_printed_with_the_likely_cause() {
    let mut dataset = Dataset::open(&heli_hover()).unwrap();
    for fix in &mut dataset.fixes {
        fix.time = fix.time.offset_by(604_800.0);
    }
    let error = ensure_possible(&dataset, "log".as_ref()).unwrap_err();
    assert!(matches!(error, LogError::Setup { .. }));
    let text = error.to_string();
    assert!(
        text.contains("from 0.050 to 299.989 s") && text.contains("1 whole weeks apart"),
        "{text}"
    );
}

#[test]
fn samples_too_slow_for_inertial_work_are_refused_with_the_rate() {
    let mut dataset = Dataset::open(&heli_hover()).unwrap();
    let mut index = 0;
    dataset.imu.retain(|_| {
        index += 1;
        index % 4 == 0
    });
    let text = ensure_possible(&dataset, "log".as_ref()).unwrap_err().to_string();
    assert!(text.contains("found 8.250 samples a second"), "{text}");
}

/// Three minutes of slow motion at half a metre a second, with a receiver whose velocity error is as large.
fn wandering(seed: u64) -> Vec<Fix> {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let mut noise = |sigma: f64| -> f64 {
        let unit: f64 = StandardNormal.sample(&mut random);
        sigma * unit
    };
    let start = Geodetic::from_degrees(48.0, 11.0, 500.0).unwrap();
    let rates = [12.0, 16.0, 30.0, 41.0].map(|period_s: f64| TAU / (period_s * (1.0 + noise(0.1))));
    let phases = [(); 4].map(|()| noise(3.0));
    let mut fixes = Vec::new();
    for second in 0..180 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| {
            let (sin, cos) = (rates[k] * f64::from(second) + phases[k]).sin_cos();
            (0.5 * sin, -0.5 / rates[k] * cos)
        });
        let velocity = [a.0 + c.0 + noise(0.5), b.0 + d.0 + noise(0.5)];
        let place = Vector::<Ned>::new(a.1 + c.1 + noise(0.7), b.1 + d.1 + noise(0.7), 0.0);
        fixes.push(Fix {
            horizontal_velocity_mps: Some(velocity),
            ..Fix::at(Time::ZERO + f64::from(second), start.displaced(place))
        });
    }
    fixes
}

#[test]
fn a_velocity_that_scatters_as_much_as_the_vehicle_moves_is_in_no_other_unit() {
    for seed in 0..100 {
        let dataset = Dataset { fixes: wandering(seed), ..Dataset::default() };
        let found = check_setup(&dataset);
        assert!(
            found.iter().all(|finding| finding.sensor != Sensor::Gps),
            "seed {seed}: {found:?}"
        );
    }
}

/// A minute of `dataset`'s clock in which the vehicle sways by 0.1 rad/s, and rolls fully over within a second every
/// `every_s`. Its thrust is always along its own axis, and halved upside down; rates are multiplied by `scale`.
fn turning_over(mut dataset: Dataset, every_s: f64, scale: f64) -> Dataset {
    let sample = |k: i64| {
        let time_s = 0.01 * k as f64;
        let within_s = time_s % every_s;
        let (roll_radps, thrust_g) =
            if within_s < 1.0 { (TAU, if within_s < 0.5 { 1.4 } else { 0.6 }) } else { (0.0, 1.0) };
        let sway_radps = 0.1 * (2.0 * time_s).sin();
        let rate = Vector::new(roll_radps, sway_radps, 0.02);
        let motion = Motion::Rates {
            angular_rate_radps: rate * scale,
            specific_force_mps2: Vector::new(0.0, 0.0, -9.8 * thrust_g),
        };
        ImuSample::new(Time::from_nanoseconds(k * 10_000_000), motion)
    };
    dataset.imu = (1..=6_000).map(sample).collect();
    dataset.fixes.clear();
    dataset
}

#[test]
fn a_vehicle_that_turns_over_is_not_in_degrees() {
    let found = |every_s: f64, scale: f64| {
        let dataset = turning_over(Dataset::open(&heli_hover()).unwrap(), every_s, scale);
        check_setup(&dataset).iter().any(|one| one.to_string().contains("°/s"))
    };
    for every_s in [100.0, 14.0, 5.0, 2.5] {
        assert!(!found(every_s, 1.0), "every {every_s} s");
    }
    for every_s in [100.0, 14.0] {
        assert!(found(every_s, 57.3), "every {every_s} s, in °/s");
    }
}
