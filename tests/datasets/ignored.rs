//! An additional sensor that is certainly wrong is excluded and reported, and the flight is estimated without it.

use std::path::{Path, PathBuf};

use hovernav::earth::Geodetic;
use hovernav::frames::{Rotation, Vector, wrap_angle};
use hovernav::gps::AntennaHeading;
use hovernav_dataset::Dataset;
use hovernav_findings::{Sensor, SetupFinding, check_fitness, ignore, ignore_inconsistent};
use hovernav_replay::estimate;
use hovernav_sim::{DmuConfig, FlightPlan, GpsConfig, Recording, fly, sensor_manifest};

fn heli_hover() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/heli-hover")
}

/// Two minutes of turns and accelerations, with an inertial unit without its own attitude.
fn flight(seed: u64) -> (Dataset, Recording) {
    let start = Geodetic::from_degrees(48.0, 11.0, 500.0).unwrap();
    let plan = FlightPlan::hover_at(start, 0.7).hold(15.0).turn(1.5, 0.3).test_points();
    let plan = plan.turn(-2.0, 0.3).test_points().hold(10.0);
    let (dmu, gps) = (DmuConfig::default(), GpsConfig::default());
    let recording = fly(&plan.build().unwrap(), &dmu, &gps, seed).unwrap();
    let mut imu = recording.imu.clone();
    imu.iter_mut().for_each(|sample| sample.attitude = None);
    let dataset = Dataset {
        manifest: sensor_manifest("simulated".into(), &dmu, &gps),
        imu,
        fixes: recording.fixes.clone(),
        ..Dataset::default()
    };
    (dataset, recording)
}

/// Root mean square of the yaw's error over its one-sigma.
fn yaw_over_sigma(dataset: &mut Dataset, recording: &Recording) -> f64 {
    let config = dataset.settings().unwrap();
    let run = estimate(dataset, &config, |_| {});
    let truth = |time| {
        let after = recording.truth.partition_point(|at| at.time < time);
        &recording.truth[after.min(recording.truth.len() - 1)]
    };
    let squares = run.solutions.iter().map(|solution| {
        let yaw_rad = truth(solution.time).body_to_ned.euler().yaw_rad;
        let off = wrap_angle(solution.body_to_ned.euler().yaw_rad - yaw_rad);
        (off / solution.attitude_sigma_rad[2]).powi(2)
    });
    (squares.sum::<f64>() / run.solutions.len() as f64).sqrt()
}

fn ignored(dataset: &mut Dataset) -> Vec<SetupFinding> {
    let denied = check_fitness(dataset, Path::new("log")).unwrap();
    ignore(dataset, denied)
}

#[test]
fn a_magnetometer_that_turns_otherwise_than_the_gyros_is_not_used() {
    let (mut worst_used, mut worst) = (0.0_f64, 0.0_f64);
    for seed in 1..5 {
        let (mut dataset, recording) = flight(seed);
        assert_eq!(ignored(&mut dataset), []);
        for sample in &mut dataset.imu {
            let field = sample.magnetic_field_gauss.map(Vector::to_array);
            sample.magnetic_field_gauss = field.map(|[x, y, z]| [y, x, z].into());
        }
        worst_used = worst_used.max(yaw_over_sigma(&mut dataset.clone(), &recording));

        let mut wanted = dataset.clone();
        wanted.manifest.aiding.insert("magnetometer".into(), true.into());
        assert_eq!(ignored(&mut wanted), []);

        let told = ignored(&mut dataset);
        let [finding] = &told[..] else { panic!("seed {seed}: {told:?}") };
        let words = finding.to_string();
        assert!(
            words.starts_with("magnetometer: not used: the field turns unlike the gyros"),
            "{words}"
        );
        assert!(words.ends_with("; [aiding] magnetometer = true uses it nevertheless"));
        assert!(dataset.samples().all(|sample| sample.magnetic_field_gauss.is_none()));
        worst = worst.max(yaw_over_sigma(&mut dataset, &recording));
    }
    println!("yaw over sigma, worst of 4: {worst_used:.1} with it, {worst:.1} without");
    assert!(worst < 2.0 && worst_used > 5.0, "{worst} {worst_used}");
}

#[test]
fn one_that_stays_in_its_file_is_passed_over_there() {
    let mut dataset = Dataset::open_within(&heli_hover(), 0).unwrap();
    let denied = SetupFinding {
        sensor: Sensor::Magnetometer,
        is_certain: true,
        found: "it lies".into(),
        cause: "a test".into(),
        mend: "end it".into(),
    };
    let before: Vec<_> = dataset.samples().collect();
    assert_eq!(ignore(&mut dataset, vec![denied]).len(), 1);
    let after: Vec<_> = dataset.samples().collect();
    assert!(before.iter().all(|sample| sample.magnetic_field_gauss.is_some()));
    for (mut before, after) in before.into_iter().zip(after) {
        before.magnetic_field_gauss = None;
        assert_eq!(before, after);
    }
}

#[test]
fn what_nothing_can_do_without_is_not_ignored() {
    let mut dataset = Dataset::open(&heli_hover()).unwrap();
    let denied = SetupFinding {
        sensor: Sensor::InertialUnit,
        is_certain: true,
        found: "it lies".into(),
        cause: "a test".into(),
        mend: String::new(),
    };
    assert!(!denied.can_be_ignored());
    assert_eq!(ignore(&mut dataset, vec![denied]), []);
}

/// A second antenna that drifts by 0.3 °/s, too slowly for a gate.
#[test]
fn a_second_antenna_without_which_the_fixes_agree_is_not_used() {
    for seed in 1..5 {
        let (mut dataset, recording) = flight(seed);
        let heading = |drift_degps: f64| {
            let forward = Vector::new(1.0, 0.0, 0.0);
            let every = recording.truth.iter().step_by(7);
            every.map(move |at| {
                let drift_rad = (drift_degps * (at.time.seconds() - 20.0).max(0.0)).to_radians();
                let told: Rotation<_, _> = at.body_to_ned;
                AntennaHeading {
                    time: at.time,
                    heading_rad: wrap_angle((told * forward).azimuth_rad() + drift_rad),
                    sigma_rad: Some(0.01),
                    length_m: None,
                }
            })
        };
        dataset.headings = heading(0.0).collect();
        let config = dataset.settings().unwrap();
        let run = estimate(&dataset, &config, |_| {});
        assert_eq!(ignore_inconsistent(&mut dataset, &config, &run), []);

        dataset.headings = heading(0.3).collect();
        let run = estimate(&dataset, &config, |_| {});
        let told = ignore_inconsistent(&mut dataset, &config, &run);
        let [finding] = &told[..] else { panic!("seed {seed}: {told:?}") };
        assert!(finding.to_string().starts_with("second antenna: not used: "), "{finding}");
        assert!(dataset.headings.is_empty());
        let off = yaw_over_sigma(&mut dataset, &recording);
        assert!(off < 2.0, "seed {seed}: {off}");
    }
}
