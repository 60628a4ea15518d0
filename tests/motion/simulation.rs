//! Simulated sensors: their errors equal their configuration.

use approx::assert_abs_diff_eq;
use hovernav::earth::Geodetic;
use hovernav::frames::{Body, EulerAngles, Ned, Rotation, Vector, wrap_angle};
use hovernav::imu::Motion;
use hovernav::time::Time;
use hovernav_findings::check_setup;
use hovernav_sim::*;

fn field() -> Geodetic {
    Geodetic::from_degrees(1.352, 103.82, 50.0).unwrap()
}

fn hover(duration_s: f64) -> Trajectory {
    FlightPlan::hover_at(field(), 0.7).hold(duration_s).build().unwrap()
}

fn test_flight() -> Trajectory {
    FlightPlan::test_flight(field(), 0.7).build().unwrap()
}

fn deviation(values: impl IntoIterator<Item = f64>) -> f64 {
    let (count, squares) = values
        .into_iter()
        .fold((0.0, 0.0), |(count, sum), value| (count + 1.0, sum + value * value));
    f64::sqrt(squares / count)
}

#[track_caller]
fn assert_near(found: f64, expected: f64, share: f64) {
    assert!((found / expected - 1.0).abs() < share, "found {found}, expected {expected}");
}

#[test]
fn a_seed_is_a_flight() {
    let trajectory = test_flight();
    let (dmu, gps) = (DmuConfig::default(), GpsConfig::default());
    let recording = fly(&trajectory, &dmu, &gps, 5).unwrap();
    assert_eq!(recording, fly(&trajectory, &dmu, &gps, 5).unwrap());
    let other = fly(&trajectory, &dmu, &gps, 6).unwrap();
    assert_eq!(recording.truth, other.truth);
    assert!(recording.imu.iter().zip(&other.imu).all(|(a, b)| a.motion != b.motion));
    assert!(recording.fixes.iter().zip(&other.fixes).all(|(a, b)| a.position != b.position));
}

#[test]
fn one_error_changed_leaves_the_others_as_they_were() {
    let trajectory = hover(20.0);
    let dmu = DmuConfig::default();
    let without = DmuConfig { attitude: None, magnetometer: None, ..dmu.clone() };
    let outage = GpsConfig { outages_s: vec![5.0..12.0], ..GpsConfig::default() };
    let all = fly(&trajectory, &dmu, &GpsConfig::default(), 1).unwrap();
    let less = fly(&trajectory, &without, &outage, 1).unwrap();
    assert!(all.imu.iter().zip(&less.imu).all(|(a, b)| a.motion == b.motion));
    assert!(less.fixes.iter().all(|fix| all.fixes.contains(fix)));
    let times: Vec<f64> = less.fixes.iter().map(|fix| fix.time.seconds()).collect();
    let expected: Vec<f64> = (0..5).chain(12..=20).map(f64::from).collect();
    assert_eq!(times, expected);
}

#[test]
fn samples_come_at_their_rate_from_start_to_end() {
    let recording = fly(&test_flight(), &DmuConfig::default(), &GpsConfig::ideal(5.0), 1).unwrap();
    assert_eq!(recording.imu.len(), 9901);
    assert_eq!(recording.fixes.len(), 1501);
    assert_eq!(recording.imu[0].time, Time::ZERO);
    assert_eq!(recording.imu[1].time, Time::from_nanoseconds(30_303_030));
    assert_eq!(recording.imu[9900].time, Time::from_nanoseconds(300_000_000_000));
    assert!(recording.imu.iter().zip(&recording.truth).all(|(imu, truth)| imu.time == truth.time));
}

#[test]
fn ideal_sensors_tell_the_truth() {
    let trajectory = test_flight();
    let (lever_arm_m, antenna_m) = (Vector::new(0.03, -0.02, 0.28), Vector::new(-0.35, 0.0, 0.2));
    let gps = GpsConfig { lever_arm_m: antenna_m, ..GpsConfig::ideal(4.0) };
    let rates = DmuConfig { lever_arm_m, ..DmuConfig::ideal(33.0, DmuOutput::Rates) };
    let increments = DmuConfig { output: DmuOutput::Increments, ..rates.clone() };
    let recording = fly(&trajectory, &rates, &gps, 1).unwrap();
    for sample in &recording.imu {
        let state = trajectory.at(sample.time.seconds()).at_point(lever_arm_m);
        let Motion::Rates { angular_rate_radps, specific_force_mps2 } = sample.motion else {
            panic!("rates were asked for");
        };
        assert_eq!(angular_rate_radps, state.inertial_rate_radps);
        assert_eq!(specific_force_mps2, state.specific_force_mps2);
    }
    for fix in &recording.fixes {
        let antenna = trajectory.at(fix.time.seconds()).at_point(antenna_m);
        assert_eq!(fix.position, antenna.position);
        assert_eq!(fix.velocity_mps(), Some(antenna.velocity_mps));
    }
    let recording = fly(&trajectory, &increments, &gps, 1).unwrap();
    for pair in recording.imu.windows(2) {
        let [from_s, to_s] = [&pair[0], &pair[1]].map(|sample| sample.time.seconds());
        let (angle, velocity) = trajectory.increments(from_s, to_s, lever_arm_m);
        let Motion::Increments { angle_rad, velocity_mps } = pair[1].motion else {
            panic!("increments were asked for");
        };
        assert!((angle_rad - angle).norm() < 1e-16 && (velocity_mps - velocity).norm() < 1e-15);
    }
}

#[test]
fn the_default_unit_is_as_noisy_as_the_thesis_helicopter() {
    let recording = fly(&hover(300.0), &DmuConfig::default(), &GpsConfig::default(), 3).unwrap();
    let mean_and_deviation = |component: &dyn Fn(Vector<Body>, Vector<Body>) -> f64| {
        let values: Vec<f64> = recording
            .imu
            .iter()
            .map(|sample| match sample.motion {
                Motion::Rates { angular_rate_radps: a, specific_force_mps2: f } => component(a, f),
                Motion::Increments { .. } => f64::NAN,
            })
            .collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (mean, deviation(values.iter().map(|value| value - mean)))
    };
    // Standard deviations of the `heli-hover` data after removal of the motion. Roll rate: 0.014 rad/s; specific force:
    // x 0.9 m/s², z 1.3 m/s².
    assert_near(mean_and_deviation(&|rate, _| rate.x()).1, 0.014, 0.25);
    assert_near(mean_and_deviation(&|_, force| force.x()).1, 0.9, 0.25);
    let (mean, deviation) = mean_and_deviation(&|_, force| force.z());
    assert_near(deviation, 1.3, 0.25);
    assert_abs_diff_eq!(mean, -9.78, epsilon = 4.0 * 0.11);
}

#[test]
fn attitude_wanders_slowly_about_the_truth_from_its_own_north() {
    let config = AttitudeConfig {
        wander_sigma_deg: [1.0, 0.5, 3.0],
        wander_time_s: 1.0,
        noise_sigma_deg: 0.2,
        declination_deg: 10.0,
        ..AttitudeConfig::default()
    };
    let dmu = DmuConfig { attitude: Some(config), ..DmuConfig::ideal(20.0, DmuOutput::Rates) };
    let truth = EulerAngles::from_degrees(20.0, -5.0, -178.0);
    let input = ImuTruth {
        angular_rate_radps: Vector::ZERO,
        specific_force_mps2: Vector::ZERO,
        body_to_ned: Rotation::from_euler(truth),
    };
    let mut unit = SimulatedDmu::new(&dmu, 2).unwrap();
    let mut errors = [const { Vec::new() }; 3];
    for k in 0..100_000 {
        let shown = unit.measure(Time::ZERO + f64::from(k) * 0.05, &input).attitude.unwrap();
        errors[0].push((shown.roll_rad - truth.roll_rad).to_degrees());
        errors[1].push((shown.pitch_rad - truth.pitch_rad).to_degrees());
        let from_magnetic_north = truth.yaw_rad - 10f64.to_radians();
        errors[2].push(wrap_angle(shown.yaw_rad - from_magnetic_north).to_degrees());
        let steps = shown.roll_rad.to_degrees() / (180.0 / 32_768.0);
        assert_abs_diff_eq!(steps, steps.round(), epsilon = 1e-6);
    }
    for (errors, wander) in errors.iter().zip(config.wander_sigma_deg) {
        assert_near(deviation(errors.iter().copied()), f64::hypot(wander, 0.2), 0.05);
        let steps = errors.windows(2).map(|pair| pair[1] - pair[0]);
        let of_wander = wander * (2.0 * (1.0 - (-0.05f64).exp())).sqrt();
        assert_near(deviation(steps), f64::hypot(of_wander, 0.2 * 2f64.sqrt()), 0.03);
    }
}

#[test]
fn the_magnetometer_shows_the_field_in_body_axes() {
    let config = MagnetometerConfig {
        field_gauss: Vector::new(0.2, 0.01, 0.45),
        hard_iron_sigma_gauss: 0.0,
        noise_sigma_gauss: 0.002,
        ..MagnetometerConfig::default()
    };
    let dmu = DmuConfig { magnetometer: Some(config), ..DmuConfig::ideal(33.0, DmuOutput::Rates) };
    let recording = fly(&test_flight(), &dmu, &GpsConfig::ideal(1.0), 8).unwrap();
    let errors = recording.imu.iter().zip(&recording.truth).flat_map(|(sample, truth)| {
        let field: Vector<Ned> = truth.body_to_ned * sample.magnetic_field_gauss.unwrap();
        (field - config.field_gauss).to_array()
    });
    assert_near(deviation(errors), 0.002, 0.02);
}

#[test]
fn gps_errors_have_their_sizes_and_times() {
    let config = GpsConfig {
        position_wander_time_s: 20.0,
        velocity_wander_time_s: 5.0,
        ..GpsConfig::default()
    };
    let mut receiver = SimulatedGps::new(&config, 12).unwrap();
    let velocity = Vector::new(1.0, -2.0, 0.5);
    let fixes: Vec<_> = (0..100_000)
        .map(|k| receiver.measure(Time::ZERO + f64::from(k), &field(), velocity).unwrap())
        .collect();
    let position = |axis: usize| {
        fixes.iter().map(move |fix| fix.position.displacement_from(&field()).to_array()[axis])
    };
    let speed = |axis: usize| {
        fixes.iter().map(move |fix| (fix.velocity_mps().unwrap() - velocity).to_array()[axis])
    };
    for axis in 0..3 {
        let said = fixes[0].position_sigma_m.unwrap().to_array()[axis];
        let pick = |spread: HorizontalVertical| {
            if axis == 2 { spread.vertical } else { spread.horizontal }
        };
        let [noise, wander] = [config.position_noise_m, config.position_wander_m].map(pick);
        assert_near(said, noise.hypot(wander), 1e-12);
        assert_near(deviation(position(axis)), said, 0.05);
        let steps =
            position(axis).skip(1).zip(position(axis)).map(|(after, before)| after - before);
        let of_wander = wander * (2.0 * (1.0 - (-1.0f64 / 20.0).exp())).sqrt();
        assert_near(deviation(steps), of_wander.hypot(noise * 2f64.sqrt()), 0.02);

        let said = fixes[0].velocity_sigma_mps.unwrap().to_array()[axis];
        assert_near(said, if axis == 2 { 0.5 } else { 0.2 }, 1e-12);
        assert_near(deviation(speed(axis)), said, 0.03);
        let products = speed(axis).skip(5).zip(speed(axis)).map(|(after, before)| after * before);
        let covariance = products.sum::<f64>() / (fixes.len() - 5) as f64;
        assert_near(covariance, pick(config.velocity_wander_mps).powi(2) * (-1f64).exp(), 0.1);
    }
}

#[test]
fn fixes_come_in_whole_steps() {
    let recording = fly(&hover(60.0), &DmuConfig::default(), &GpsConfig::default(), 1).unwrap();
    for fix in &recording.fixes {
        let [down, height] = [fix.down_velocity_mps.unwrap(), fix.position.height_m];
        for (value, step) in [
            (fix.position.latitude_deg(), 1e-9),
            (fix.position.longitude_deg(), 1e-9),
            (height, 1e-3),
            (down, 1e-3),
        ] {
            let steps = value / step;
            assert!((steps - steps.round()).abs() < 1e-4, "{value} in steps of {step}");
        }
    }
}

#[test]
fn a_latency_that_is_not_accounted_for_makes_fixes_look_late() {
    let trajectory = test_flight();
    let gps = GpsConfig { latency_s: 0.25, assumed_latency_s: 0.1, ..GpsConfig::ideal(1.0) };
    let recording = fly(&trajectory, &DmuConfig::default(), &gps, 1).unwrap();
    for fix in &recording.fixes {
        let true_when = trajectory.at(fix.time.seconds() - 0.15);
        assert!(fix.position.displacement_from(&true_when.position).norm() < 1e-6);
    }
}

#[test]
fn an_impossible_sensor_is_refused_by_name() {
    let with_gyro = |gyro| DmuConfig { gyro, ..DmuConfig::default() };
    let good = GyroConfig::default();
    for (config, sensor, what) in [
        (DmuConfig { rate_hz: 0.0, ..DmuConfig::default() }, "DMU", "rate"),
        (DmuConfig { rate_hz: f64::NAN, ..DmuConfig::default() }, "DMU", "rate"),
        (DmuConfig { rate_hz: 1e9, ..DmuConfig::default() }, "DMU", "rate"),
        (with_gyro(GyroConfig { range_degps: -1.0, ..good }), "gyro", "range"),
        (with_gyro(GyroConfig { scale_factor_sigma: f64::NAN, ..good }), "gyro", "scale factor"),
        (with_gyro(GyroConfig { bandwidth_hz: 0.0, ..good }), "gyro", "bandwidth"),
    ] {
        let error = fly(&hover(1.0), &config, &GpsConfig::default(), 1).unwrap_err();
        assert_eq!((error.sensor, error.what), (sensor, what), "{error}");
    }
    let gps = GpsConfig { rate_hz: -1.0, ..GpsConfig::default() };
    let error = fly(&hover(1.0), &DmuConfig::default(), &gps, 1).unwrap_err();
    let expected = "GPS: rate is -1, expected above 0 and at most 20000 Hz";
    assert_eq!(error.to_string(), expected);
}

#[test]
fn the_field_of_a_place_is_that_of_the_magnetic_model_and_declared() {
    assert_eq!(MagnetometerConfig::at(&field()), MagnetometerConfig::default());
    for (latitude_deg, longitude_deg) in [(48.1, 11.6), (-60.0, 0.0), (64.8, -147.7)] {
        let place = Geodetic::from_degrees(latitude_deg, longitude_deg, 300.0).unwrap();
        let magnetometer = Some(MagnetometerConfig::at(&place));
        let (dmu, gps) = (DmuConfig { magnetometer, ..DmuConfig::default() }, GpsConfig::default());
        let path = FlightPlan::hover_at(place, 0.7).hold(20.0).build().unwrap();
        let recording = fly(&path, &dmu, &gps, 1).unwrap();
        let mut dataset = hovernav_dataset::Dataset {
            manifest: sensor_manifest("simulated".into(), &dmu, &gps),
            imu: recording.imu,
            fixes: recording.fixes,
            ..hovernav_dataset::Dataset::default()
        };
        assert_eq!(check_setup(&dataset), []);
        let declared = dataset.settings().unwrap().alignment.declination_rad;
        dataset.manifest.imu.magnetic_declination_deg = None;
        let of_model = dataset.settings().unwrap().alignment.declination_rad;
        let off_deg = (declared - of_model).to_degrees();
        assert!(off_deg.abs() < 0.7, "{off_deg}° off that of the model");
    }
}
