//! The transition of the covariance is the derivative of the mechanization, except for the terms in its
//! documentation.

use approx::assert_abs_diff_eq;
use hovernav::earth::Geodetic;
use hovernav::ekf::covariance::{Covariance, Gain, Sensitivity, Transition};
use hovernav::ekf::layout::Base;
use hovernav::ekf::{Ekf, EkfConfig, Trace};
use hovernav::frames::{Body, EulerAngles, Ned, Rotation, Vector};
use hovernav::imu::{ImuErrors, ImuSample, Motion};
use hovernav::ins::{Increment, Integrator, Mounting, NavState, Start};
use hovernav::time::Time;
use nalgebra::SMatrix;

const N: usize = 16;
const STATES: usize = 15;
type Matrix = SMatrix<f64, N, N>;

/// A moment of flight: state, then the rates and specific forces at both ends of the step.
struct Moment {
    state: NavState,
    rates_radps: [Vector<Body>; 2],
    forces_mps2: [Vector<Body>; 2],
    interval_s: f64,
}

impl Moment {
    fn samples(&self) -> [ImuSample; 2] {
        let sample = |end: usize| {
            ImuSample::new(
                self.state.time + end as f64 * self.interval_s,
                Motion::Rates {
                    angular_rate_radps: self.rates_radps[end],
                    specific_force_mps2: self.forces_mps2[end],
                },
            )
        };
        [sample(0), sample(1)]
    }

    fn increment(&self, errors: &ImuErrors) -> Increment {
        let mut integrator = Integrator::default();
        let [first, second] = self.samples();
        integrator.push(&first, errors);
        integrator.push(&second, errors).unwrap()
    }

    /// The state at the end of the step. Its start and the inertial unit have the errors `error`.
    fn end(&self, error: &[f64; STATES]) -> NavState {
        let block = |first: usize| [error[first], error[first + 1], error[first + 2]];
        let mut state = NavState {
            time: self.state.time,
            position: self.state.position.displaced(block(6).into()),
            velocity_mps: self.state.velocity_mps + block(3).into(),
            body_to_ned: self.state.body_to_ned.turned_in_to(block(0).into()),
        };
        let errors =
            ImuErrors { gyro_bias_radps: block(9).into(), accel_bias_mps2: block(12).into() };
        state.advance(state.time + self.interval_s, &self.increment(&errors));
        state
    }

    /// The transition by central differences of the mechanization, with constant errors of the inertial unit.
    fn numeric_transition(&self) -> Matrix {
        let mut phi = Matrix::identity();
        for column in 0..STATES {
            // The difference is small compared with the curvature, and large compared with the rounding of a longitude,
            // 1e-9 m.
            let size = if (3..9).contains(&column) { 0.1 } else { 1e-3 };
            let [above, below] = [size, -size].map(|change| {
                let mut error = [0.0; STATES];
                error[column] = change;
                self.end(&error)
            });
            let turn: Rotation<Ned, Ned> = above.body_to_ned * below.body_to_ned.inverse();
            let differences = [
                turn.rotation_vector(),
                above.velocity_mps - below.velocity_mps,
                above.position.displacement_from(&below.position),
            ];
            let differences = differences.map(Vector::to_array);
            for (row, value) in differences.iter().flatten().enumerate() {
                phi[(row, column)] = value / (2.0 * size);
            }
        }
        phi
    }

    /// The transition of the filter itself, extracted from its kernel column by column. For one unit variance and no
    /// noise, P becomes the square of this column.
    fn kernel_transition(&self) -> (Matrix, Transition<f64, N>) {
        let mut step = self.filter_step();
        let used = step;
        step.attitude_noise = [0.0; 6];
        step.velocity_noise = [0.0; 6];
        step.position_noise = [0.0; 3];
        if let Some(relaxation) = &mut step.relaxation {
            relaxation.noise = [0.0; N];
        }
        let mut phi = Matrix::zeros();
        for column in 0..N {
            let mut covariance = Covariance::<f64, N>::zero();
            covariance.set_variance(column, 1.0);
            covariance.propagate(&step);
            let diagonal = covariance.variance(column).sqrt();
            for row in 0..N {
                phi[(row, column)] = covariance.entry(row, column) / diagonal;
            }
        }
        (phi, used)
    }

    /// The filter's step from its samples.
    fn filter_step(&self) -> Transition<f64, N> {
        let start = Start {
            state: NavState { time: self.state.time + -1e-9, ..self.state },
            attitude_sigma_rad: Vector::ZERO,
            velocity_sigma_mps: Vector::ZERO,
            position_sigma_m: Vector::ZERO,
            gyro_bias_radps: Vector::ZERO,
            gyro_bias_sigma_radps: None,
        };
        let mut config = EkfConfig::default();
        config.imu.covariance_interval_s = 0.0;
        // The accelerometers have no noise, so their output counts as motion only.
        config.imu.velocity_random_walk_mps = 0.0;
        config.imu.accel_vibration_share = 0.0;
        config.imu.accel_bias_sigma_mps2 = 1e-9;
        let mut filter = Ekf::<Base, N>::new(config, Mounting::default(), start);
        let mut steps = Steps::default();
        for sample in self.samples() {
            filter.predict_traced(&sample, &mut steps).unwrap();
        }
        steps.0[1]
    }
}

#[derive(Default)]
struct Steps(Vec<Transition<f64, N>>);

impl Trace<f64, N> for Steps {
    fn propagated(&mut self, step: &Transition<f64, N>) {
        self.0.push(*step);
    }
    fn updated(&mut self, _: &Sensitivity<f64>, _: &Gain<f64, N>, _: f64) {}
}

fn moments() -> Vec<Moment> {
    let mut moments = Vec::new();
    for (place, interval_s) in [((1.35, 103.8, 50.0), 0.03), ((60.0, -20.0, 3000.0), 0.01)] {
        for (angles, velocity) in [
            ((0.0, 0.0, 0.0), Vector::ZERO),
            ((25.0, -15.0, 130.0), Vector::new(20.0, -15.0, 3.0)),
            ((-170.0, 70.0, -60.0), Vector::new(-5.0, 30.0, -8.0)),
        ] {
            moments.push(Moment {
                state: NavState {
                    time: Time::ZERO,
                    position: Geodetic::from_degrees(place.0, place.1, place.2).unwrap(),
                    velocity_mps: velocity,
                    body_to_ned: Rotation::from_euler(EulerAngles::from_degrees(
                        angles.0, angles.1, angles.2,
                    )),
                },
                rates_radps: [Vector::new(0.5, -0.8, 1.1), Vector::new(0.7, -0.9, 0.8)],
                forces_mps2: [Vector::new(3.0, -2.0, -12.0), Vector::new(2.5, -1.0, -9.0)],
                interval_s,
            });
        }
    }
    moments
}

/// Allowed error of ∂(row)/∂(column), the states in blocks of three.
///
/// Neglected according to the block's documentation: the rotation of NED and all other terms under 2e-4 per second.
/// The block uses the attitude at the step's start, and only the first effect of each error. This neglects the
/// rotation of a step, ω Δt, or the specific force in it, f Δt, over half a step.
fn omitted(row: usize, column: usize, interval_s: f64) -> f64 {
    const SLOW: f64 = 2e-4;
    let (rate, force) = (1.7, 12.7);
    let half = 0.51 * interval_s;
    let (turned, pushed) = (rate * interval_s, force * interval_s);
    let velocity = |column: usize| match column {
        0 => SLOW * pushed,
        1 | 2 => SLOW * interval_s,
        3 => half * pushed,
        _ => half * turned,
    };
    1e-8 + match row {
        0 => match column {
            0 | 1 => SLOW * interval_s,
            2 => 1e-10,
            3 => half * turned,
            _ => 1e-10,
        },
        1 => velocity(column),
        // A position one metre higher or further north is on another circle: 30 m/s over its radius, 1e-5 per second.
        _ if column == 2 => 1e-5 * interval_s,
        // The mean of the velocities at both ends replaces the mean over the step.
        _ if column == 0 => interval_s * (velocity(0) + half * force * interval_s),
        _ => interval_s * velocity(column),
    }
}

#[test]
fn the_transition_is_the_derivative_of_the_mechanization() {
    let mut largest = 0.0;
    for moment in moments() {
        let numeric = moment.numeric_transition();
        let (kernel, step) = moment.kernel_transition();
        for row in 0..9 {
            for column in 0..STATES {
                // The biases decay in the kernel, but not in the mechanization.
                let off = kernel[(row, column)] - numeric[(row, column)];
                let allowed = omitted(row / 3, column / 3, moment.interval_s);
                assert!(
                    off.abs() <= allowed,
                    "∂{row}/∂{column}: {} against {}, allowed {allowed:e}",
                    kernel[(row, column)],
                    numeric[(row, column)],
                );
                largest = f64::max(largest, off.abs());
            }
        }
        let relaxation = step.relaxation.unwrap_or_default();
        for state in 9..N {
            assert_abs_diff_eq!(kernel[(state, state)], relaxation.decay[state], epsilon = 1e-15);
        }
    }
    println!("largest difference {largest:e}");
}

#[test]
fn a_second_of_steps_moves_the_covariance_as_the_mechanization_does() {
    for moment in moments() {
        let (_, step) = moment.kernel_transition();
        let mut numeric = moment.numeric_transition();
        let relaxation = step.relaxation.unwrap_or_default();
        for state in 9..N {
            numeric[(state, state)] = relaxation.decay[state];
        }
        let sigmas = [0.05, 0.5, 3.0, 0.005, 0.05];
        let mut covariance = Covariance::<f64, N>::zero();
        let mut dense = Matrix::zeros();
        for state in 0..STATES {
            let variance = sigmas[state / 3] * sigmas[state / 3];
            covariance.set_variance(state, variance);
            dense[(state, state)] = variance;
        }
        let mut noise = Matrix::zeros();
        for (first, [nn, ne, nd, ee, ed, dd]) in
            [(0, step.attitude_noise), (3, step.velocity_noise)]
        {
            let block = [[nn, ne, nd], [ne, ee, ed], [nd, ed, dd]];
            for (i, line) in block.iter().enumerate() {
                for (j, value) in line.iter().enumerate() {
                    noise[(first + i, first + j)] = *value;
                }
            }
        }
        for axis in 0..3 {
            noise[(6 + axis, 6 + axis)] = step.position_noise[axis];
        }
        for state in 9..N {
            noise[(state, state)] = relaxation.noise[state];
        }
        // The same step repeatedly: a hundred of 10 ms, or thirty-three of 30.
        for _ in 0..(1.0 / moment.interval_s) as usize {
            covariance.propagate(&step);
            dense = numeric * dense * numeric.transpose() + noise;
        }
        for row in 0..STATES {
            let sigma = dense[(row, row)].sqrt();
            let off = (covariance.variance(row).sqrt() / sigma - 1.0).abs();
            assert!(off < 0.02, "one-sigma of state {row} off by {off}");
            for column in 0..row {
                let scale = sigma * dense[(column, column)].sqrt();
                let off = (covariance.entry(row, column) - dense[(row, column)]).abs() / scale;
                assert!(off < 0.03, "correlation of {row} and {column} off by {off}");
            }
        }
    }
}
