//! The shipped filter under observation: its state and covariance as dense numbers, and its actions in order.

use std::ops::Range;

use hovernav::ekf::covariance::{Gain, Sensitivity, Transition};
use hovernav::ekf::layout::{ACCEL_BIAS, ATTITUDE, GYRO_BIAS, Layout, POSITION, VELOCITY};
use hovernav::ekf::{Ekf, Trace};
use hovernav::frames::{Ned, Vector as Framed};
use hovernav::scalar::Scalar;
use nalgebra::{Matrix3, Quaternion, SVector, UnitQuaternion};

use crate::filter::Filter;
use crate::mechanization::{Nominal, Vector, skew};
use crate::noise::Relaxation;
use crate::transition::{Matrix, set, with_position};

/// State, parameters and covariance of the shipped filter.
#[derive(Clone, Debug)]
pub struct Snapshot<const N: usize> {
    pub nominal: Nominal,
    pub parameters: SVector<f64, N>,
    pub covariance: Matrix<N>,
}

impl<const N: usize> Snapshot<N> {
    pub fn of<L: Layout<N>, T: Scalar>(filter: &Ekf<L, N, T>) -> Self {
        let state = filter.state();
        let [x, y, z, w] = state.body_to_ned.to_array().map(Scalar::wide);
        Self {
            nominal: Nominal {
                time: state.time,
                place: state.position,
                velocity_mps: Vector::from(state.velocity_mps.to_array().map(Scalar::wide)),
                attitude: UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)),
            },
            parameters: SVector::from_fn(|state, _| filter.parameter(state)),
            covariance: Matrix::from_fn(|row, column| filter.covariance().entry(row, column)),
        }
    }
}

/// Action of the shipped filter.
#[derive(Clone, Debug)]
pub enum Did<const N: usize> {
    /// Propagated its covariance over time.
    Propagated,
    /// Relaxed its parameters.
    Relaxed,
    /// Increased its covariance; the oracle applies the same increase unchecked.
    Opened(Box<Opening<N>>),
    /// Fused an axis.
    Updated,
    /// Corrected its state: the end of a measurement.
    Corrected,
    /// Reset the variance of some states, or turned its attitude by a rotation vector, NED, rad.
    Reset(Range<usize>),
    Turned(Vector),
}

/// Φ and Q of an increase of the covariance.
#[derive(Clone, Debug)]
pub struct Opening<const N: usize> {
    phi: Matrix<N>,
    noise: Matrix<N>,
    relaxation: Relaxation<N>,
}

/// Records the actions of a filter.
#[derive(Clone, Debug, Default)]
pub struct Recorder<const N: usize>(pub Vec<Did<N>>);

impl<T: Scalar, const N: usize> Trace<T, N> for Recorder<N> {
    fn propagated(&mut self, step: &Transition<T, N>) {
        // A relaxation always changes the biases; an increase of the covariance leaves them unchanged.
        let relaxes = step.relaxation.is_some_and(|all| all.decay[GYRO_BIAS] != T::ONE);
        self.0.push(if step.interval_s > T::ZERO {
            Did::Propagated
        } else if relaxes {
            Did::Relaxed
        } else {
            Did::Opened(Box::new(Opening::of(step)))
        });
    }
    fn updated(&mut self, _: &Sensitivity<T>, _: &Gain<T, N>, _: f64) {
        self.0.push(Did::Updated);
    }
    fn corrected(&mut self, _: &[T; N]) {
        self.0.push(Did::Corrected);
    }
    fn reset(&mut self, states: Range<usize>) {
        self.0.push(Did::Reset(states));
    }
    fn turned(&mut self, turn_rad: Framed<Ned>) {
        self.0.push(Did::Turned(Vector::from(turn_rad.to_array())));
    }
}

impl<const N: usize> Opening<N> {
    fn of<T: Scalar>(step: &Transition<T, N>) -> Self {
        let turn = Matrix3::from_fn(|i, j| step.turn[i][j].wide());
        let force = Vector::from(step.force.map(Scalar::wide));
        let mut phi = Matrix::identity();
        set(&mut phi, ATTITUDE, GYRO_BIAS, &-turn);
        set(&mut phi, VELOCITY, ACCEL_BIAS, &-turn);
        set(&mut phi, VELOCITY, ATTITUDE, &-skew(&force));
        let mut noise = Matrix::zeros();
        for (first, upper) in [(ATTITUDE, step.attitude_noise), (VELOCITY, step.velocity_noise)] {
            let [nn, ne, nd, ee, ed, dd] = upper.map(Scalar::wide);
            set(&mut noise, first, first, &Matrix3::new(nn, ne, nd, ne, ee, ed, nd, ed, dd));
        }
        for (axis, variance) in step.position_noise.into_iter().enumerate() {
            noise[(POSITION + axis, POSITION + axis)] = variance.wide();
        }
        let relaxation = step.relaxation.map_or_else(Relaxation::none, |all| Relaxation {
            decay: SVector::from(all.decay.map(Scalar::wide)),
            noise: SVector::from(all.noise.map(Scalar::wide)),
        });
        Self { phi: with_position(phi, step.interval_s.wide()), noise, relaxation }
    }

    pub fn apply<L: Layout<N>>(&self, filter: &mut Filter<L, N>) {
        filter.propagate(&self.phi, &self.noise);
        filter.apply(&self.relaxation);
    }
}
