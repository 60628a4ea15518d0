//! The first attitude, velocity and position: within their stated accuracy, from every source.

use approx::assert_abs_diff_eq;
use hovernav::earth::{Geodetic, LocalEarth};
use hovernav::ekf::{Estimator, EstimatorConfig, Notice, layout};
use hovernav::event::Event;
use hovernav::frames::{Body, EulerAngles, Ned, Rotation, Vector, wrap_angle};
use hovernav::gps::Fix;
use hovernav::imu::{ImuSample, Motion};
use hovernav::ins::{Aligner, Alignment, AlignmentConfig, HeadingSource, Mounting};
use hovernav::time::Time;
use hovernav_dataset::Truth;
use hovernav_sim::*;

const PERIOD_S: f64 = 0.02;

fn place() -> Geodetic {
    Geodetic::from_degrees(47.0, 8.0, 400.0).unwrap()
}

/// A vehicle at rest with a noiseless inertial unit.
struct Still {
    attitude: Rotation<Body, Ned>,
    gyro_bias_radps: Vector<Body>,
    accel_bias_mps2: Vector<Body>,
    shown: Option<EulerAngles>,
    field_gauss: Option<Vector<Ned>>,
}

impl Still {
    fn at(roll_deg: f64, pitch_deg: f64, yaw_deg: f64) -> Self {
        let angles = EulerAngles::from_degrees(roll_deg, pitch_deg, yaw_deg);
        Self {
            attitude: Rotation::from_euler(angles),
            gyro_bias_radps: Vector::ZERO,
            accel_bias_mps2: Vector::ZERO,
            shown: None,
            field_gauss: None,
        }
    }

    /// Two seconds of samples. The fix is pushed once too early, and again after the samples.
    fn aligned(&self, config: AlignmentConfig, fix: Fix) -> Option<Alignment> {
        self.aligned_on(Mounting::default(), config, fix)
    }

    fn aligned_on(
        &self,
        mounting: Mounting,
        config: AlignmentConfig,
        fix: Fix,
    ) -> Option<Alignment> {
        let mut aligner = Aligner::new(config, mounting);
        let earth = LocalEarth::at(&place());
        let lift: Vector<Ned> = Vector::new(0.0, 0.0, -earth.gravity_mps2);
        for step in 0..=100 {
            let sample = ImuSample {
                attitude: self.shown,
                magnetic_field_gauss: self.field_gauss.map(|field| self.attitude.inverse() * field),
                ..ImuSample::new(
                    Time::ZERO + f64::from(step) * PERIOD_S,
                    Motion::Rates {
                        angular_rate_radps: self.attitude.inverse() * earth.earth_rate_radps
                            + self.gyro_bias_radps,
                        specific_force_mps2: self.attitude.inverse() * lift + self.accel_bias_mps2,
                    },
                )
            };
            assert_eq!(aligner.push(&Event::Imu(sample)), None);
            if step == 25 {
                let early = Fix { time: sample.time, ..fix };
                assert_eq!(aligner.push(&Event::Gps(early)), None);
            }
        }
        aligner.push(&Event::Gps(fix))
    }
}

fn fix() -> Fix {
    Fix {
        horizontal_velocity_mps: Some([0.0; 2]),
        down_velocity_mps: Some(0.0),
        ..Fix::at(Time::ZERO + 2.0, place())
    }
}

fn euler_deg(alignment: &Alignment) -> [f64; 3] {
    alignment.start.state.body_to_ned.euler().to_degrees()
}

#[test]
fn at_rest_roll_and_pitch_are_those_by_which_the_force_points_up() {
    for (roll, pitch, yaw) in
        [(0.0, 0.0, 0.0), (12.0, -7.0, 130.0), (-60.0, 35.0, -20.0), (179.0, 5.0, 90.0)]
    {
        let alignment = Still::at(roll, pitch, yaw).aligned(AlignmentConfig::default(), fix());
        let alignment = alignment.unwrap();
        let [found_roll, found_pitch, _] = euler_deg(&alignment);
        assert_abs_diff_eq!(found_roll, roll, epsilon = 1e-9);
        assert_abs_diff_eq!(found_pitch, pitch, epsilon = 1e-9);
        assert!(alignment.at_rest && !alignment.attitude_given);
        assert_eq!(alignment.heading, HeadingSource::Unknown);
        assert_eq!(alignment.start.state.position, place());
    }
}

#[test]
fn an_accelerometer_bias_tilts_the_level_by_its_share_of_gravity() {
    let bias = 0.1;
    let still =
        Still { accel_bias_mps2: Vector::new(bias, -bias, 0.0), ..Still::at(0.0, 0.0, 0.0) };
    let alignment = still.aligned(AlignmentConfig::default(), fix()).unwrap();
    let angles = alignment.start.state.body_to_ned.euler();
    let tilt_rad = bias / LocalEarth::at(&place()).gravity_mps2;
    assert_abs_diff_eq!(angles.pitch_rad, tilt_rad, epsilon = 1e-5);
    assert_abs_diff_eq!(angles.roll_rad, tilt_rad, epsilon = 1e-5);
    // The default one-sigma covers such a bias.
    assert!(alignment.start.attitude_sigma_rad.x() > tilt_rad);
}

#[test]
fn at_rest_the_gyro_bias_is_measured_to_its_stated_one_sigma() {
    let bias = Vector::new(0.004, -0.003, 0.002);
    let still = Still { gyro_bias_radps: bias, ..Still::at(3.0, -2.0, 50.0) };
    let alignment = still.aligned(AlignmentConfig::default(), fix()).unwrap();
    let sigma = alignment.start.gyro_bias_sigma_radps.unwrap();
    let off = (alignment.start.gyro_bias_radps - bias).norm();
    // The Earth's rotation rate, 7e-5 rad/s, remains in the bias.
    assert!(off < 8e-5 && off < sigma, "{off} of {sigma} rad/s");
}

#[test]
fn a_turning_vehicle_has_no_gyro_bias_measured() {
    let turning = Still { gyro_bias_radps: Vector::new(0.0, 0.0, 0.3), ..Still::at(0.0, 0.0, 0.0) };
    let alignment = turning.aligned(AlignmentConfig::default(), fix()).unwrap();
    assert!(!alignment.at_rest);
    assert_eq!(alignment.start.gyro_bias_radps, Vector::ZERO);
    assert_eq!(alignment.start.gyro_bias_sigma_radps, None);
}

#[test]
fn a_vehicle_already_flying_aligns_with_a_wider_level() {
    let config = AlignmentConfig::default();
    let flying =
        Fix { horizontal_velocity_mps: Some([8.0, -3.0]), down_velocity_mps: Some(1.0), ..fix() };
    let alignment = Still::at(4.0, -3.0, 0.0).aligned(config, flying).unwrap();
    assert!(!alignment.at_rest);
    assert_eq!(alignment.start.attitude_sigma_rad.x(), config.moving_level_sigma_rad);
    assert_eq!(alignment.start.state.velocity_mps, Vector::new(8.0, -3.0, 1.0));
    assert_eq!(alignment.start.gyro_bias_sigma_radps, None);
}

#[test]
fn the_units_own_attitude_is_taken_with_its_declination() {
    let shown = EulerAngles::from_degrees(5.0, -4.0, 178.0);
    let still = Still { shown: Some(shown), ..Still::at(0.0, 0.0, 0.0) };
    let config =
        AlignmentConfig { attitude_declination_rad: 7f64.to_radians(), ..Default::default() };
    let alignment = still.aligned(config, fix()).unwrap();
    assert_eq!(alignment.heading, HeadingSource::Attitude);
    assert!(alignment.attitude_given);
    let [roll, pitch, yaw] = euler_deg(&alignment);
    assert_abs_diff_eq!(roll, 5.0, epsilon = 1e-9);
    assert_abs_diff_eq!(pitch, -4.0, epsilon = 1e-9);
    assert!((yaw + 175.0).abs() < 1e-9, "178° and 7° more are −175°, not {yaw}°");
    assert_eq!(alignment.start.attitude_sigma_rad.z(), config.heading_sigma_rad);
}

#[test]
fn the_magnetometer_is_levelled_and_its_declination_added() {
    let declination_rad = (-12f64).to_radians();
    let (sin, cos) = declination_rad.sin_cos();
    for (roll, pitch, yaw) in [(0.0, 0.0, 10.0), (20.0, -15.0, 175.0), (-35.0, 30.0, -100.0)] {
        let field = Vector::new(0.2 * cos, 0.2 * sin, 0.43);
        let still = Still { field_gauss: Some(field), ..Still::at(roll, pitch, yaw) };
        let config = AlignmentConfig { declination_rad, ..Default::default() };
        let alignment = still.aligned(config, fix()).unwrap();
        assert_eq!(alignment.heading, HeadingSource::Magnetometer);
        let off = wrap_angle((euler_deg(&alignment)[2] - yaw).to_radians());
        assert!(off.abs() < 1e-9, "{off} rad at {yaw}°");
    }
}

#[test]
fn a_vertical_field_gives_no_heading() {
    let field = Vector::new(0.0, 0.0, 0.6);
    let still = Still { field_gauss: Some(field), ..Still::at(0.0, 0.0, 10.0) };
    let alignment = still.aligned(AlignmentConfig::default(), fix()).unwrap();
    assert_eq!(alignment.heading, HeadingSource::Unknown);
    assert!(alignment.start.attitude_sigma_rad.z() > 1.8, "any of the circle");
}

#[test]
fn the_course_gives_the_heading_only_when_named_and_fast_enough() {
    let config = AlignmentConfig { heading: Some(HeadingSource::Course), ..Default::default() };
    let at_speed = |north, east| Fix { horizontal_velocity_mps: Some([north, east]), ..fix() };
    let still = Still::at(0.0, 0.0, 0.0);
    let alignment = still.aligned(config, at_speed(-5.0, 5.0)).unwrap();
    assert_eq!(alignment.heading, HeadingSource::Course);
    assert_abs_diff_eq!(euler_deg(&alignment)[2], 135.0, epsilon = 1e-9);
    assert_eq!(still.aligned(config, at_speed(1.0, 1.0)), None);
    let unnamed = still.aligned(AlignmentConfig::default(), at_speed(-5.0, 5.0)).unwrap();
    assert_eq!(unnamed.heading, HeadingSource::Unknown);
}

#[test]
fn position_and_velocity_are_the_units_not_the_antennas() {
    let config = AlignmentConfig { heading: Some(HeadingSource::Attitude), ..Default::default() };
    let mounting = Mounting::default()
        .with_imu_lever_arm_m(Vector::new(0.0, 0.0, 0.3))
        .with_antenna_lever_arm_m(Vector::new(-1.0, 0.0, 0.0));
    let east = EulerAngles::from_degrees(0.0, 0.0, 90.0);
    let turning = Still {
        shown: Some(east),
        gyro_bias_radps: Vector::new(0.0, 0.0, 0.5),
        ..Still::at(0.0, 0.0, 90.0)
    };
    let start = turning.aligned_on(mounting, config, fix()).unwrap().start.state;
    // The inertial unit is 1 m ahead of the antenna, which is east, and 0.3 m below it. A right turn at 0.5 rad/s moves
    // a point ahead to the right, which is south.
    let off = start.position.displacement_from(&place()) - Vector::new(0.0, 1.0, 0.3);
    assert!(off.norm() < 1e-6);
    assert!((start.velocity_mps - Vector::new(-0.5, 0.0, 0.0)).norm() < 1e-3);
}

#[test]
fn without_enough_samples_or_with_a_fix_of_another_time_nothing_is_aligned() {
    let still = Still::at(0.0, 0.0, 0.0);
    let long = AlignmentConfig { duration_s: 3.0, ..Default::default() };
    assert_eq!(still.aligned(long, fix()), None);
    for off_s in [-10.0, 10.0, 1e6] {
        let elsewhen = Fix { time: fix().time + off_s, ..fix() };
        assert_eq!(still.aligned(AlignmentConfig::default(), elsewhen), None);
    }
    let nowhere = Geodetic { latitude_rad: f64::NAN, ..place() };
    let nowhere = Fix { position: nowhere, ..fix() };
    assert_eq!(still.aligned(AlignmentConfig::default(), nowhere), None);
}

/// Flies the test flight without any heading sensor. Returns error and stated one-sigma, rad, when the heading is found
/// and at the end.
fn searched(seed: u64, heading_deg: f64) -> Option<[f64; 4]> {
    let trajectory = FlightPlan::test_flight(place(), heading_deg.to_radians()).build().unwrap();
    let dmu = DmuConfig { attitude: None, magnetometer: None, ..DmuConfig::default() };
    let gps = GpsConfig { rate_hz: 5.0, ..GpsConfig::default() };
    let recording = fly(&trajectory, &dmu, &gps, seed).unwrap();
    let mut config = EstimatorConfig::default();
    config.mounting.imu_lever_arm_m = dmu.lever_arm_m;
    config.mounting.antenna_lever_arm_m = gps.lever_arm_m;
    let mut estimator = Estimator::<layout::Full, 28>::new(config);
    let mut fixes = recording.fixes.iter().peekable();
    let yaw_error = |estimator: &Estimator<layout::Full, 28>, truth: &Truth| {
        let solution = estimator.solution().unwrap();
        let yaw = solution.body_to_ned.euler().yaw_rad;
        let error = wrap_angle(yaw - truth.body_to_ned.euler().yaw_rad);
        [error, solution.attitude_sigma_rad[2]]
    };
    let mut at_found = None;
    for (sample, truth) in recording.imu.iter().zip(&recording.truth) {
        let mut found = false;
        let mut notify = |notice| found |= matches!(notice, Notice::HeadingFound { .. });
        while let Some(fix) = fixes.next_if(|fix| fix.time <= sample.time) {
            estimator.push(&Event::Gps(*fix), &mut notify);
        }
        estimator.push(&Event::Imu(*sample), &mut notify);
        if found {
            at_found = Some(yaw_error(&estimator, truth));
        }
    }
    let [error, sigma] = at_found?;
    let [end_error, end_sigma] = yaw_error(&estimator, recording.truth.last().unwrap());
    Some([error, sigma, end_error, end_sigma])
}

#[test]
fn an_unknown_heading_is_found_in_motion_within_its_stated_one_sigma() {
    for (seed, heading_deg) in [(1, 0.0), (2, 77.0), (3, 163.0), (4, -140.0), (5, -15.0), (6, 40.0)]
    {
        let [error, sigma, end_error, end_sigma] =
            searched(seed, heading_deg).expect("the heading is found");
        println!(
            "{heading_deg}°: found {:.1}° off, one-sigma {:.1}°; at the end {:.2}° of {:.2}°",
            error.to_degrees(),
            sigma.to_degrees(),
            end_error.to_degrees(),
            end_sigma.to_degrees(),
        );
        assert!(error.abs() < 3.0 * sigma);
        assert!(end_error.abs() < 3.0 * end_sigma);
        assert!(end_error.abs() < 5f64.to_radians());
    }
}

/// A fix at any second is accompanied by enough samples, at any interval of the fixes.
#[test]
fn a_lone_fix_aligns_whenever_it_comes() {
    let lift = Vector::new(0.0, 0.0, -LocalEarth::at(&place()).gravity_mps2);
    for tenths in 12..130 {
        let mut aligner = Aligner::new(AlignmentConfig::default(), Mounting::default());
        for step in 0..=tenths * 5 {
            let motion =
                Motion::Rates { angular_rate_radps: Vector::ZERO, specific_force_mps2: lift };
            let sample = ImuSample::new(Time::ZERO + f64::from(step) * PERIOD_S, motion);
            assert_eq!(aligner.push(&Event::Imu(sample)), None);
        }
        let fix = Fix { time: Time::ZERO + 0.1 * f64::from(tenths), ..fix() };
        assert!(aligner.push(&Event::Gps(fix)).is_some(), "{tenths}");
    }
}

/// The fixes in the first `for_s` seconds have no height. Returns the time of the alignment, s, and its one-sigma of
/// height, m.
fn aligned_without_height(for_s: u32) -> (f64, f64) {
    let mut aligner = Aligner::new(AlignmentConfig::default(), Mounting::default());
    let lift = Vector::new(0.0, 0.0, -LocalEarth::at(&place()).gravity_mps2);
    for step in 0..3000 {
        let time = Time::ZERO + f64::from(step) * PERIOD_S;
        let motion = Motion::Rates { angular_rate_radps: Vector::ZERO, specific_force_mps2: lift };
        assert_eq!(aligner.push(&Event::Imu(ImuSample::new(time, motion))), None);
        if step % 50 == 0 {
            let two_dimensional = step < 50 * for_s;
            let fix = Fix { time, two_dimensional, down_velocity_mps: Some(40.0), ..fix() };
            if let Some(Alignment { start, .. }) = aligner.push(&Event::Gps(fix)) {
                let down_mps = start.state.velocity_mps.z();
                assert_eq!(down_mps, if two_dimensional { 0.0 } else { 40.0 });
                return (time - Time::ZERO, start.position_sigma_m.z());
            }
        }
    }
    panic!("never aligned")
}

#[test]
fn fixes_without_a_height_end_an_alignment_where_for_ten_seconds_none_had_one() {
    let (after_s, height_sigma_m) = aligned_without_height(1);
    assert!(after_s <= 2.0 && height_sigma_m < 10.0, "{after_s} {height_sigma_m}");
    let (after_s, height_sigma_m) = aligned_without_height(8);
    assert!(after_s == 8.0 && height_sigma_m < 10.0, "{after_s} {height_sigma_m}");
    let (after_s, height_sigma_m) = aligned_without_height(60);
    assert!(after_s == 10.0 && height_sigma_m >= 1000.0, "{after_s} {height_sigma_m}");
}
