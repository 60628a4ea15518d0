//! Each measurement's sensitivity against numeric differentiation of its own prediction.

use crate::earth::Geodetic;
use crate::ekf::FullEkf;
use crate::ekf::kernel::covariance::{Covariance, Gain, Sensitivity, Transition};
use crate::ekf::kernel::layout::{ATTITUDE, Full, GYRO_BIAS, Layout, POSITION};
use crate::ekf::kernel::trace::Trace;
use crate::ekf::outcome::report::{Report, Unusable};
use crate::ekf::settings::config::{AntennaHeadingModel, EkfConfig};
use crate::ekf::settings::estimator_config::Rangefinder;
use crate::ekf::watch::level_force::LevelForce;
use crate::event::RangeReading;
use crate::frames::{EulerAngles, Ned, Rotation, Vector};
use crate::gps::{AntennaHeading, Fix};
use crate::imu::{ImuSample, Motion};
use crate::ins::{Mounting, NavState, Start};
use crate::time::Time;

const N: usize = 28;
const PERIOD_S: f64 = 0.01;
const STEPS: i64 = 40;

/// Perturbation of each state: small against its curvature, large against rounding.
fn perturbation(state: usize) -> f64 {
    match state {
        9..12 => 1e-4,
        _ => 1e-3,
    }
}

fn mounting() -> Mounting {
    Mounting::default()
        .with_imu_lever_arm_m(Vector::new(0.03, -0.02, 0.28))
        .with_antenna_lever_arm_m(Vector::new(-0.6, 0.2, -0.4))
}

/// A filter in a turning, accelerating flight. Its parameters are, over its whole memory, `parameters`; its present
/// state is `nominal`, if given.
fn filter(parameters: &[f64; N], nominal: Option<NavState>) -> FullEkf {
    let start = Start {
        state: NavState {
            time: Time::ZERO,
            position: Geodetic::from_degrees(48.1, 11.6, 500.0).unwrap(),
            velocity_mps: Vector::new(7.0, -4.0, 1.5),
            body_to_ned: Rotation::from_euler(EulerAngles::from_degrees(12.0, -8.0, 65.0)),
        },
        attitude_sigma_rad: Vector::ZERO,
        velocity_sigma_mps: Vector::ZERO,
        position_sigma_m: Vector::ZERO,
        gyro_bias_radps: Vector::ZERO,
        gyro_bias_sigma_radps: None,
    };
    let mut filter = FullEkf::new(EkfConfig::default(), mounting(), start);
    for step in 1..=STEPS {
        filter.parameters = *parameters;
        let phase = step as f64 * PERIOD_S;
        let sample = ImuSample::new(
            Time::ZERO + phase,
            Motion::Rates {
                angular_rate_radps: Vector::new(0.3, -0.5 + phase, 0.8),
                specific_force_mps2: Vector::new(2.0, 1.0 - 3.0 * phase, -11.0),
            },
        );
        filter.predict(&sample).unwrap();
    }
    filter.parameters = *parameters;
    // The complete specific force counts as motion, as before the first sample.
    filter.memory.level_force = LevelForce::NONE;
    if let Some(state) = nominal {
        filter.state = state;
    }
    // With zero covariance the filter corrects nothing: every axis reports its whole innovation.
    filter.covariance = Covariance::zero();
    filter.memory.gps_wander = Some([0.0; 4]);
    filter
}

/// Stores the rows of H that a measurement used.
#[derive(Default)]
struct Rows(Vec<[f64; N]>);

impl Trace<f64, N> for Rows {
    fn propagated(&mut self, _: &Transition<f64, N>) {}
    fn updated(&mut self, sensitivity: &Sensitivity<f64>, _: &Gain<f64, N>, _: f64) {
        let mut row = [0.0; N];
        for (state, derivative) in sensitivity.terms() {
            row[state] += derivative;
        }
        self.0.push(row);
    }
}

/// The effect of a measurement on a filter.
type Measurement<'a> = &'a dyn Fn(&mut FullEkf, &mut Rows) -> Report;

/// Largest difference between each column of H and the central difference of minus the innovation,
/// for every axis: `[axis][state]`.
fn errors(measurement: Measurement<'_>) -> Vec<[f64; N]> {
    let parameters: [f64; N] = std::array::from_fn(|state| match state {
        9..12 => 0.01,
        12..15 => 0.1,
        24 => 0.08,
        _ => 0.0,
    });
    let base = filter(&parameters, None);
    let innovations = |perturbed: &mut FullEkf| -> Vec<f64> {
        measurement(perturbed, &mut Rows::default())
            .innovations()
            .map(|axis| axis.innovation)
            .collect()
    };
    let mut rows = Rows::default();
    measurement(&mut base.clone(), &mut rows);
    assert!(!rows.0.is_empty(), "no axis was accepted");
    let mut errors = rows.0.clone();
    for state in 0..N {
        let size = perturbation(state);
        let [above, below] = [size, -size].map(|change| {
            let mut correction = [0.0; N];
            correction[state] = change;
            let mut parameters = parameters;
            if state >= GYRO_BIAS {
                parameters[state] += change;
            }
            let mut perturbed = filter(&parameters, Some(base.state));
            if state < GYRO_BIAS {
                perturbed.correct(&correction);
            }
            innovations(&mut perturbed)
        });
        assert_eq!(above.len(), errors.len());
        for (axis, (above, below)) in above.iter().zip(&below).enumerate() {
            errors[axis][state] += (above - below) / (2.0 * size);
        }
    }
    errors
}

#[track_caller]
fn assert_exact(errors: &[[f64; N]], allowed: impl Fn(usize, usize) -> f64) {
    for (axis, row) in errors.iter().enumerate() {
        for (state, error) in row.iter().enumerate() {
            assert!(
                error.abs() <= allowed(axis, state),
                "axis {axis} state {state}: off by {error:e}"
            );
        }
    }
}

/// The fix, `age_s` old, that the unperturbed filter predicts.
fn expected_fix(age_s: f64) -> Fix {
    // Wide enough to be accepted anywhere: the test is about the sensitivity, not the fit.
    let sigma = Some(Vector::new(100.0, 100.0, 100.0));
    let now = filter(&[0.0; N], None).state;
    Fix {
        position_sigma_m: sigma,
        horizontal_velocity_mps: Some([now.velocity_mps.x(), now.velocity_mps.y()]),
        down_velocity_mps: Some(now.velocity_mps.z()),
        velocity_sigma_mps: sigma,
        ..Fix::at(now.time + -age_s, now.position)
    }
}

fn fix_errors(age_s: f64) -> Vec<[f64; N]> {
    let fix = expected_fix(age_s);
    errors(&|filter, rows| filter.update_gps_traced(&fix, rows).unwrap())
}

/// Index of the first position axis of a fix: velocity comes first.
const POSITION_AXES: usize = 3;

/// Terms that the sensitivity of a fix neglects. For an age L: second order in the rotation |ω| L and in the velocity
/// change |f| L over this age. For a bias: the rotation of the arm.
fn allowed_for_fix(age_s: f64) -> impl Fn(usize, usize) -> f64 {
    let (rate, force) = (1.0, 12.0);
    move |axis, state| {
        let position = axis >= POSITION_AXES;
        // A position is older than the velocity of the same fix by the latency, 0.08 s.
        let age_s = if position { age_s + 0.08 } else { age_s };
        let steps = if position { age_s } else { 1.0 };
        1e-5 + match state {
            // Transport and Earth rate turn the velocity change over the age by 1e-4 rad/s.
            0..9 => 2e-3 * age_s * steps,
            // A gyro bias causes an attitude error, which rotates the specific force.
            9..12 => force * age_s * age_s * steps + rate * age_s,
            12..15 => rate * age_s * age_s * steps + PERIOD_S * age_s,
            // The acceleration is the mean from 0.06 s before to 0.06 s after. If less than 0.06 s has passed, it ends
            // now and lags by up to 0.03 s. The antenna's own acceleration relative to the inertial unit, 0.7 m of arm,
            // is neglected.
            26 if !position => 0.5 * 0.06 * rate * force + 0.2,
            // The body rate changes within a sample interval: 0.01 rad/s on the arm of the antenna.
            _ => 1e-2,
        }
    }
}

#[test]
fn a_fix_on_time_sees_the_states_as_its_sensitivity_says() {
    let errors = fix_errors(0.0);
    assert_eq!(errors.len(), 6);
    assert_exact(&errors, allowed_for_fix(0.0));
}

#[test]
fn a_late_fix_sees_the_states_as_its_sensitivity_says() {
    // In the middle of a sample interval: at its ends the rate of the body jumps.
    for age_s in [0.055, 0.155, 0.305] {
        assert_exact(&fix_errors(age_s), allowed_for_fix(age_s));
    }
}

#[test]
fn an_attitude_reference_sees_the_attitude_error_and_its_own_slow_error() {
    let errors = errors(&|filter, rows| {
        let (time, reference) = (filter.state.time, filter_now().body_to_ned);
        filter.update_attitude(time, reference, rows).unwrap()
    });
    assert_eq!(errors.len(), 3);
    assert_exact(&errors, |_, _| 2e-6);
}

fn filter_now() -> NavState {
    let parameters = std::array::from_fn(|state| match state {
        9..12 => 0.01,
        12..15 => 0.1,
        _ => 0.0,
    });
    filter(&parameters, None).state
}

#[test]
fn a_magnetic_heading_sees_the_heading_and_leaves_what_its_dip_makes_of_the_tilt() {
    let reference = filter_now().body_to_ned;
    for (down_gauss, declination_rad) in [(0.0, 0.0), (-0.1, 0.03), (0.44, -0.2)] {
        let (sin, cos) = libm::sincos(declination_rad);
        let field: Vector<Ned> = Vector::new(0.2 * cos, 0.2 * sin, down_gauss);
        let field_gauss = reference.inverse() * field;
        let errors = errors(&|filter, rows| {
            let time = filter.state.time;
            filter.update_magnetic_heading(time, field_gauss, declination_rad, rows).unwrap()
        });
        assert_eq!(errors.len(), 1);
        // A tilt turns the levelled field by the tangent of the dip. By design this is an error of the reference, so
        // that no heading moves the tilt.
        let dip = libm::fabs(down_gauss) / 0.2;
        assert!((f64::hypot(errors[0][0], errors[0][1]) - dip).abs() < 1e-5);
        assert_exact(&errors, |_, state| if state < 2 { dip + 1e-5 } else { 1e-5 });
    }
}

#[test]
fn a_barometer_sees_the_height_and_its_own_slow_error() {
    let offset_m = 12.0;
    let height_m = filter_now().position.height_m + offset_m;
    let errors = errors(&|filter, rows| {
        filter.memory.barometer.start(offset_m, filter.config.baro.noise_m);
        let time = filter.state.time;
        filter.update_baro(time, height_m, rows).unwrap()
    });
    assert_eq!(errors.len(), 1);
    assert_exact(&errors, |_, _| 2e-6);
    assert_eq!(<Full as Layout<N>>::BARO, Some(25));
}

#[test]
fn a_barometer_whose_level_is_that_of_the_first_height_tells_nothing_of_it() {
    let mut filter = filter(&[0.0; N], None);
    filter.set_block_sigmas();
    filter.covariance.set_variance(POSITION + 2, 36.0);
    for reading in 0..100 {
        let height_m = 500.0 + 1e-3 * f64::from(reading % 2);
        filter.update_baro(filter.state.time, height_m, &mut ()).unwrap();
        let sigma_m = filter.covariance.variance(POSITION + 2).sqrt();
        assert!((5.95..6.05).contains(&sigma_m), "{sigma_m} m after {reading} readings more");
    }
    // The correction of the height applies to the barometer's level as well.
    let level = <Full as Layout<N>>::BARO.unwrap();
    assert!((filter.covariance.entry(POSITION + 2, level) - 36.0).abs() < 1.0);
}

#[test]
fn a_magnetometer_leaves_the_heading_as_unsure_as_its_own_slow_error() {
    let mut filter = filter(&[0.0; N], None);
    filter.set_block_sigmas();
    filter.covariance.set_variance(ATTITUDE + 2, 0.02);
    let field = filter.state.body_to_ned.inverse() * Vector::new(0.2, 0.0, 0.4);
    let model = filter.config.magnetometer;
    for reading in 1..30 {
        filter.state.time = filter.state.time + model.interval_s;
        filter.update_magnetic_heading(filter.state.time, field, 0.0, &mut ()).unwrap();
        let sigma_rad = filter.covariance.variance(ATTITUDE + 2).sqrt();
        assert!(sigma_rad > 0.9 * model.heading_wander_rad, "{sigma_rad} rad after {reading}");
    }
}

#[test]
fn a_field_without_a_level_part_is_refused_as_too_steep() {
    let mut filter = filter(&[0.0; N], None);
    let (time, to_body) = (filter.state.time, filter.state.body_to_ned.inverse());
    for field in [Vector::new(0.0, 0.0, 0.5), Vector::new(0.009, 0.0, -0.5), Vector::ZERO] {
        let told = filter.update_magnetic_heading(time, to_body * field, 0.0, &mut ());
        assert_eq!(told, Err(Unusable::HorizontalFieldTooWeak));
    }
    let told = filter.update_magnetic_heading(time, Vector::new(1e200, 0.0, 0.0), 0.0, &mut ());
    assert_eq!(told, Err(Unusable::NotFinite));
}

#[test]
fn a_heading_is_refused_as_not_levelled_after_a_gap_until_the_tilt_is_known() {
    let mut filter = filter(&[0.0; N], None);
    let time = filter.state.time;
    let field = filter.state.body_to_ned.inverse() * Vector::new(0.2, 0.0, 0.4);
    filter.memory.gates.suspected = time;
    filter.covariance.set_variance(ATTITUDE, 0.1);
    let told = filter.update_magnetic_heading(time, field, 0.0, &mut ());
    assert_eq!(told, Err(Unusable::NotLevelled));
    filter.covariance.set_variance(ATTITUDE, 1e-6);
    filter.update_magnetic_heading(time, field, 0.0, &mut ()).unwrap();
    let told = filter.update_magnetic_heading(time, field, 0.0, &mut ());
    assert_eq!(told, Err(Unusable::TooSoon));
}

#[test]
fn a_barometric_height_that_repeats_the_one_before_tells_nothing_new() {
    let mut filter = filter(&[0.0; N], None);
    let time = filter.state.time;
    // The first one only sets the level.
    for height_m in [500.0, 500.1] {
        filter.update_baro(time, height_m, &mut ()).unwrap();
    }
    let told = filter.update_baro(time + 0.1, 500.1, &mut ());
    assert_eq!(told, Err(Unusable::RepeatedReading));
    assert!(!Unusable::RepeatedReading.is_fault());
    filter.update_baro(time + 0.2, 500.2, &mut ()).unwrap();
}

#[test]
fn a_distance_to_the_ground_sees_height_tilt_and_the_ground() {
    // Steep beams and a long arm: a tilt moves the spot along the ground.
    for beam in [Vector::new(0.0, 0.0, 1.0), Vector::new(0.3, -0.2, 0.9)] {
        let rangefinder = Rangefinder {
            lever_arm_m: Vector::new(0.4, -0.1, 0.2),
            beam: beam * (1.0 / beam.norm()),
            ..Rangefinder::default()
        };
        let now = filter_now();
        let errors = errors(&|filter, rows| {
            let range_m = 12.0;
            let arm = rangefinder.lever_arm_m - mounting().imu_lever_arm_m;
            let hit = now.body_to_ned * (arm + rangefinder.beam * range_m);
            filter.memory.ground.height_m = Some(now.position.height_m - hit.z());
            let reading = RangeReading::new(filter.state.time, range_m);
            filter.update_range(&reading, &rangefinder, rows).unwrap()
        });
        assert_eq!(errors.len(), 1);
        assert_exact(&errors, |_, _| 1e-4);
    }
    assert_eq!(<Full as Layout<N>>::GROUND, Some(27));
}

#[test]
fn a_heading_of_two_antennas_sees_the_heading_and_leaves_what_a_sloping_baseline_makes_of_the_tilt()
{
    let now = filter_now();
    for baseline in [Vector::new(0.0, 1.0, 0.0), Vector::new(0.5, -0.3, 0.2)] {
        let in_ned = now.body_to_ned * baseline;
        let slope = libm::fabs(in_ned.z()) / f64::hypot(in_ned.x(), in_ned.y());
        let errors = errors(&|filter, rows| {
            let reading = AntennaHeading::new(filter.state.time, in_ned.azimuth_rad(), Some(0.01));
            let model = AntennaHeadingModel::default();
            filter.update_antenna_heading(&reading, Some(baseline), &model, rows).unwrap()
        });
        assert_eq!(errors.len(), 1);
        assert!((f64::hypot(errors[0][0], errors[0][1]) - slope).abs() < 1e-5);
        assert_exact(&errors, |_, state| if state < 2 { slope + 1e-5 } else { 1e-5 });
    }
}
