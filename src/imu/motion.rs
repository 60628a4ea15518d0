//! What gyros and accelerometers measured, as rates or as increments.

use crate::frames::{Body, Vector};
use crate::scalar::Scalar;

/// The motion between or at samples, in the form the unit delivers it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion<T = f64> {
    /// Instantaneous values at the sample's time.
    Rates {
        /// Angular rate of the body against inertial space, rad/s.
        angular_rate_radps: Vector<Body, T>,
        /// Acceleration less gravitation, m/s²; level and at rest its z is −9.81.
        specific_force_mps2: Vector<Body, T>,
    },
    /// Integrals of rate and specific force since the sample before, each resolved in the body axes
    /// of its own moment (what an integrating unit puts out before any coning or sculling
    /// correction).
    Increments {
        /// Integral of angular rate, rad.
        angle_rad: Vector<Body, T>,
        /// Integral of specific force, m/s.
        velocity_mps: Vector<Body, T>,
    },
}

impl<T: Scalar> Motion<T> {
    /// The same motion in numbers of another type.
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

    /// Whether every component is finite and one that a unit can measure: within ±10 000 rad/s and
    /// m/s², or rad and m/s a sample.
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

    /// Mean angular rate and specific force over the `interval_s` seconds, positive, that end at the
    /// sample. Instantaneous values stand for their own mean.
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
    /// Angular rate of the body against inertial space, rad/s.
    pub angular_rate_radps: Vector<Body, T>,
    /// Acceleration less gravitation, m/s².
    pub specific_force_mps2: Vector<Body, T>,
}

/// Far beyond any unit, and far below where squares overflow.
const MEASURABLE: f64 = 1e4;
