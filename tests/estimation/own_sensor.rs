//! A user's own sensor: sensitivities of readings at any age, rejected and impossible readings, and the phases of the
//! estimator.

use hovernav::earth::Geodetic;
use hovernav::ekf::covariance::{Gain, Sensitivity};
use hovernav::ekf::{
    BaseEkf, Channel, EkfConfig, Estimator, EstimatorConfig, Expected, ImuModel, Measurement, Row,
    Rows, Solution, Trace, Unusable, Verdict,
};
use hovernav::event::Event;
use hovernav::frames::{Body, EulerAngles, Ned, Rotation, Vector};
use hovernav::gps::Fix;
use hovernav::imu::ImuSample;
use hovernav::ins::{HeadingSource, Mounting, NavState, Start};
use hovernav::time::Time;

const ARM_M: Vector<Body> = Vector::new(0.6, -0.4, 0.9);
const UNIT_M: Vector<Body> = Vector::new(0.1, 0.2, -0.3);
const PERIOD_S: f64 = 0.01;

/// A quantity that is linear in the motion of its sensor.
struct Linear {
    position: Vector<Ned>,
    velocity: Vector<Ned>,
    angular_rate: Vector<Body>,
    velocity_body: Vector<Body>,
}

impl Linear {
    const NONE: Self = Self {
        position: Vector::ZERO,
        velocity: Vector::ZERO,
        angular_rate: Vector::ZERO,
        velocity_body: Vector::ZERO,
    };
}

fn home() -> Geodetic {
    Geodetic::from_degrees(48.1, 11.6, 520.0).unwrap()
}

impl Measurement for Linear {
    fn compare(&self, expected: &Expected, rows: &mut Rows) {
        let value = self.position.dot(expected.position.displacement_from(&home()))
            + self.velocity.dot(expected.velocity_mps)
            + self.angular_rate.dot(expected.angular_rate_radps)
            + self.velocity_body.dot(expected.velocity_body_mps());
        let row = Row::new(-value, 1e3).with_velocity_body(expected, self.velocity_body);
        rows.push(
            row.with_velocity(row.velocity + self.velocity)
                .with_position(self.position)
                .with_angular_rate(self.angular_rate),
        );
    }

    fn lever_arm_m(&self) -> Vector<Body> {
        ARM_M
    }

    fn sensor(&self) -> u8 {
        7
    }
}

#[derive(Default)]
struct Seen(Option<Sensitivity<f64>>);

impl Trace<f64, 16> for Seen {
    fn updated(&mut self, sensitivity: &Sensitivity<f64>, _: &Gain<f64, 16>, _: f64) {
        self.0 = Some(*sensitivity);
    }
}

/// A filter after a second of a turning, accelerating flight whose start is displaced by `error`: attitude, velocity,
/// position, gyro bias.
fn flown(error: &[f64; 12]) -> BaseEkf {
    let block = |first: usize| [error[first], error[first + 1], error[first + 2]];
    let attitude = EulerAngles::from_degrees(12.0, -8.0, 70.0);
    let start = Start {
        state: NavState {
            time: Time::ZERO,
            position: home().displaced::<f64>(block(6).into()),
            velocity_mps: Vector::new(6.0, -4.0, 1.0) + block(3).into(),
            body_to_ned: Rotation::from_euler(attitude).turned_in_to(block(0).into()),
        },
        attitude_sigma_rad: Vector::new(1e-4, 1e-4, 1e-4),
        velocity_sigma_mps: Vector::new(0.1, 0.1, 0.1),
        position_sigma_m: Vector::new(1.0, 1.0, 1.0),
        gyro_bias_radps: block(9).into(),
        gyro_bias_sigma_radps: Some(1e-3),
    };
    // Without noise the whole specific force counts as motion: equation (K23) of docs/equations.md.
    let imu = ImuModel {
        velocity_random_walk_mps: 0.0,
        accel_vibration_share: 0.0,
        accel_bias_sigma_mps2: 1e-6,
        ..ImuModel::default()
    };
    let mounting = Mounting::default().with_imu_lever_arm_m(UNIT_M);
    let mut filter = BaseEkf::new(EkfConfig::default().with_imu(imu), mounting, start);
    for step in 1..=100 {
        let time = Time::from_seconds(f64::from(step) * PERIOD_S);
        let rate_radps = Vector::new(0.4, -0.3, 0.9);
        let sample = ImuSample::from_rates(time, rate_radps, Vector::new(5.0, -3.0, -11.0));
        filter.predict(&sample).unwrap();
    }
    filter
}

/// Innovation and sensitivity of a reading at `seconds`.
fn compared(filter: &mut BaseEkf, sensor: &Linear, seconds: f64) -> (f64, Sensitivity<f64>) {
    let mut seen = Seen::default();
    let report = filter.update(sensor, Time::from_seconds(seconds), &mut seen).unwrap();
    let axis = *report.innovations().next().unwrap();
    assert_eq!((axis.channel, axis.verdict), (Channel::Own(7), Verdict::Accepted));
    (axis.innovation, seen.0.unwrap())
}

#[test]
fn sensitivities_of_late_and_early_readings_are_those_of_moved_filters() {
    let one = |axis: usize| core::array::from_fn(|of| f64::from(u8::from(of == axis)));
    let mut sensors = Vec::new();
    for axis in 0..3 {
        sensors.push(Linear { position: Vector::<Ned>::from(one(axis)), ..Linear::NONE });
        sensors.push(Linear { velocity: Vector::<Ned>::from(one(axis)), ..Linear::NONE });
        sensors.push(Linear { angular_rate: Vector::<Body>::from(one(axis)), ..Linear::NONE });
        sensors.push(Linear { velocity_body: Vector::<Body>::from(one(axis)), ..Linear::NONE });
    }
    // At the last sample, inside the history, between two samples, and ahead.
    for seconds in [1.0, 0.75, 0.523, 1.04] {
        for (which, sensor) in sensors.iter().enumerate() {
            for component in 0..12 {
                let size = [1e-4, 1e-2, 1e-1, 1e-4][component / 3];
                let error =
                    |by: f64| core::array::from_fn(|of| if of == component { by } else { 0.0 });
                let (mut below, mut above) = (flown(&error(-size)), flown(&error(size)));
                let (from, to) = (*below.state(), *above.state());
                let turn: Rotation<Ned, Ned> = to.body_to_ned * from.body_to_ned.inverse();
                let moved = [
                    turn.rotation_vector().to_array(),
                    (to.velocity_mps - from.velocity_mps).to_array(),
                    to.position.displacement_from(&from.position).to_array(),
                    core::array::from_fn(|axis| {
                        above.parameter(9 + axis) - below.parameter(9 + axis)
                    }),
                ];
                let (low, sensitivity) = compared(&mut below, sensor, seconds);
                let (high, _) = compared(&mut above, sensor, seconds);
                let mut change = 0.0;
                for (state, derivative) in sensitivity.terms() {
                    change += moved.as_flattened().get(state).map_or(0.0, |by| derivative * by);
                }
                // The expected value increases where the innovation decreases.
                let found = low - high;
                let scale = moved.as_flattened().iter().fold(0.0f64, |most, by| most.max(by.abs()));
                // The sensitivity neglects, as for fixes, that a bias turns the specific force since the reading.
                let age_s = 1.0 - seconds;
                let turned = if component < 9 { 0.0 } else { 13.0 * age_s * age_s * size };
                assert!(
                    (change - found).abs() < 6e-3 * scale + turned,
                    "sensor {which} at {seconds} s, component {component}: {change} {found}"
                );
            }
        }
    }
}

/// A reading with given rows.
struct Given(Vec<Row>);

impl Measurement for Given {
    fn compare(&self, _: &Expected, rows: &mut Rows) {
        self.0.iter().for_each(|row| rows.push(*row));
    }
}

const NORTH: Vector<Ned> = Vector::new(1.0, 0.0, 0.0);

/// An estimator after some seconds at rest.
fn at_rest() -> Box<Estimator> {
    let mut config = EstimatorConfig::default();
    config.alignment.heading = Some(HeadingSource::Attitude);
    let mut estimator = Box::new(Estimator::new(config));
    for step in 0..300 {
        let time = Time::from_seconds(f64::from(step) * 0.02);
        let sample = ImuSample::from_rates(time, Vector::ZERO, Vector::new(0.0, 0.0, -9.807))
            .with_attitude(EulerAngles::from_degrees(0.0, 0.0, 45.0));
        estimator.push(&Event::Imu(sample), |_| {});
        if step % 50 == 0 {
            estimator.push(&Event::Gps(Fix::at(time, home())), |_| {});
        }
    }
    estimator
}

fn last(estimator: &Estimator) -> Solution {
    estimator.solution().unwrap()
}

#[test]
fn impossible_readings_change_nothing_and_name_the_reason() {
    let mut estimator = at_rest();
    let before = last(&estimator);
    let good = Row::new(0.1, 0.1).with_velocity(NORTH);
    let row = |change: fn(&mut Row)| {
        let mut row = good;
        change(&mut row);
        vec![good, row]
    };
    let impossible = [
        row(|row| row.residual = f64::NAN),
        row(|row| row.residual = 1e300),
        row(|row| row.sigma = 0.0),
        row(|row| row.sigma = -1.0),
        row(|row| row.sigma = f64::INFINITY),
        row(|row| row.position = Vector::new(0.0, f64::NAN, 0.0)),
        row(|row| row.attitude = Vector::new(1e7, 0.0, 0.0)),
        row(|row| row.angular_rate = Vector::new(0.0, 0.0, f64::NEG_INFINITY)),
        vec![good; 7],
    ];
    for rows in impossible {
        let refused = estimator.update(&Given(rows.clone()), before.time);
        assert_eq!(refused, Err(Unusable::NotFinite), "{rows:?}");
    }
    let empty = estimator.update(&Given(Vec::new()), before.time);
    assert_eq!(empty, Err(Unusable::OutOfRange));
    let old = estimator.update(&Given(vec![good]), before.time + -2.0);
    assert_eq!(old, Err(Unusable::TooOld));
    let early = estimator.update(&Given(vec![good]), before.time + 0.2);
    assert_eq!(early, Err(Unusable::AheadOfImu));
    assert_eq!(last(&estimator), before);
}

#[test]
fn a_reading_is_accepted_or_rejected_as_a_whole_and_never_resets_the_filter() {
    let mut estimator = at_rest();
    let before = last(&estimator);
    let near = Row::new(0.05, 0.1).with_velocity(NORTH);
    let far = Row::new(30.0, 0.1).with_velocity(Vector::new(0.0, 1.0, 0.0));
    for count in 1..300 {
        let time = before.time + 0.02 * f64::from(count);
        let sample = ImuSample::from_rates(time, Vector::ZERO, Vector::new(0.0, 0.0, -9.807));
        estimator.push(&Event::Imu(sample), |_| {});
        let unread = estimator.clone();
        let report = estimator.update(&Given(vec![near, far]), time).unwrap();
        assert!(report.innovations().all(|axis| axis.verdict == Verdict::Rejected));
        let (with, without) = (last(&estimator), last(&unread));
        assert!((with.velocity_mps - without.velocity_mps).norm() < 1e-12);
    }
    let report = estimator.update(&Given(vec![near; 6]), last(&estimator).time).unwrap();
    assert_eq!(report.innovations().count(), 6);
    assert!(report.innovations().all(|axis| axis.verdict == Verdict::Accepted));
    assert!(last(&estimator).velocity_mps.x() > 0.0);
}

/// Each row passes the gate alone. The second differs from the first by 20 of their one-sigmas.
#[test]
fn rows_that_contradict_each_other_are_rejected() {
    let mut estimator = at_rest();
    let before = last(&estimator);
    let [sigma, ..] = before.position_sigma_m.to_array();
    let row = |residual| Row::new(residual, 0.05 * sigma).with_position(NORTH);
    let rows = vec![row(0.5 * sigma), row(-0.5 * sigma)];
    for row in &rows {
        let alone = estimator.clone().update(&Given(vec![*row]), before.time).unwrap();
        assert!(alone.innovations().all(|axis| axis.verdict == Verdict::Accepted));
    }
    let report = estimator.update(&Given(rows), before.time).unwrap();
    assert!(report.innovations().all(|axis| axis.verdict == Verdict::Rejected), "{report:?}");
    assert_eq!(last(&estimator).position_sigma_m, before.position_sigma_m);
}

#[test]
fn readings_wait_for_alignment_and_heading() {
    let reading = Given(vec![Row::new(0.0, 1.0).with_velocity(NORTH)]);
    let mut config = EstimatorConfig::default();
    config.alignment.heading = Some(HeadingSource::Unknown);
    let mut estimator = Box::new(Estimator::new(config));
    assert_eq!(estimator.update(&reading, Time::ZERO), Err(Unusable::NotAligned));
    for step in 0..300 {
        let time = Time::from_seconds(f64::from(step) * 0.02);
        let sample = ImuSample::from_rates(time, Vector::ZERO, Vector::new(0.0, 0.0, -9.807));
        estimator.push(&Event::Imu(sample), |_| {});
        if step % 50 == 0 {
            estimator.push(&Event::Gps(Fix::at(time, home())), |_| {});
        }
    }
    let time = last(&estimator).time;
    assert_eq!(estimator.update(&reading, time), Err(Unusable::HeadingUnknown));
}

/// A sensor of a user that computes every number from noise.
#[test]
fn wild_but_possible_rows_leave_a_valid_filter() {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    let mut generator = ChaCha8Rng::seed_from_u64(3);
    let mut wild = |most: f64| {
        let exponent: f64 = StandardNormal.sample(&mut generator);
        let sign: f64 = StandardNormal.sample(&mut generator);
        (10f64.powf(3.0 * exponent)).min(most).copysign(sign)
    };
    let mut estimator = at_rest();
    let mut time = last(&estimator).time;
    for _ in 0..500 {
        time = time + 0.02;
        let sample = ImuSample::from_rates(time, Vector::ZERO, Vector::new(0.0, 0.0, -9.807));
        estimator.push(&Event::Imu(sample), |_| {});
        let mut vector = || [wild(1e6), wild(1e6), wild(1e6)];
        let rows = (0..3)
            .map(|_| Row {
                residual: vector()[0],
                sigma: vector()[0].abs().max(1e-9),
                position: vector().into(),
                velocity: vector().into(),
                attitude: vector().into(),
                angular_rate: vector().into(),
            })
            .collect();
        estimator.update(&Given(rows), time + 0.1 * wild(1.0).min(0.5)).ok();
        let filter = estimator.filter().unwrap();
        assert!(filter.is_healthy());
    }
}
