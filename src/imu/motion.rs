//! Gyro and accelerometer measurements, as rates or as increments.

use crate::frames::{Body, Vector};
use crate::scalar::Scalar;

/// Motion at or between samples, in the form output by the inertial unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion<T = f64> {
    /// Instantaneous values at the sample's time.
    Rates {
        /// Angular rate of the body relative to inertial space, rad/s.
        angular_rate_radps: Vector<Body, T>,
        /// Acceleration minus gravitation, m/s²; its z component is −9.81 when level and at rest.
        specific_force_mps2: Vector<Body, T>,
    },
    /// Integrals of rate and specific force since the previous sample, each resolved in the momentary body axes. This
    /// is the output of an integrating IMU before any coning or sculling correction.
    Increments {
        /// Integral of angular rate, rad.
        angle_rad: Vector<Body, T>,
        /// Integral of specific force, m/s.
        velocity_mps: Vector<Body, T>,
    },
}

impl<T: Scalar> Motion<T> {
    /// The same motion in another number type.
    #[must_use]
    #[inline(always)]
    pub fn cast<U: Scalar>(&self) -> Motion<U> {
        match *self {
            Self::Rates { angular_rate_radps, specific_force_mps2 } => Motion::Rates {
                angular_rate_radps: angular_rate_radps.cast(),
                specific_force_mps2: specific_force_mps2.cast(),
            },
            Self::Increments { angle_rad, velocity_mps } => Motion::Increments {
                angle_rad: angle_rad.cast(),
                velocity_mps: velocity_mps.cast(),
            },
        }
    }

    /// Whether every component is finite and within the range of real IMUs: ±10 000 rad/s and m/s², or rad and m/s per
    /// sample.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let measurable = |vector: &Vector<Body, T>| {
            vector.to_array().iter().all(|component| component.abs() <= T::of(MEASURABLE))
        };
        match self {
            Self::Rates { angular_rate_radps: a, specific_force_mps2: b }
            | Self::Increments { angle_rad: a, velocity_mps: b } => measurable(a) && measurable(b),
        }
    }

    /// Mean angular rate and specific force over the interval `interval_s`, s, positive, that ends at the sample.
    /// Instantaneous values are returned as their own mean.
    #[must_use]
    pub fn mean_rates(&self, interval_s: T) -> MeanRates<T> {
        match *self {
            Self::Rates { angular_rate_radps, specific_force_mps2 } => {
                MeanRates { angular_rate_radps, specific_force_mps2 }
            }
            Self::Increments { angle_rad, velocity_mps } => MeanRates {
                angular_rate_radps: angle_rad * (T::ONE / interval_s),
                specific_force_mps2: velocity_mps * (T::ONE / interval_s),
            },
        }
    }
}

/// Means over an interval: see [`Motion::mean_rates`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeanRates<T = f64> {
    /// Angular rate of the body relative to inertial space, rad/s.
    pub angular_rate_radps: Vector<Body, T>,
    /// Acceleration minus gravitation, m/s².
    pub specific_force_mps2: Vector<Body, T>,
}

/// Largest plausible component, rad/s and m/s²: far beyond any IMU, and far below the overflow of squares.
const MEASURABLE: f64 = 1e4;
