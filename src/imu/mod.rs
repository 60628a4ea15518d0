//! What an inertial unit measures, in the units and axes the filter takes, whoever made the unit.

mod vibration;

pub use vibration::Vibration;

use crate::frames::{Body, EulerAngles, Vector};
use crate::time::Time;

/// The motion between or at samples, in the form the unit delivers it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Instantaneous values at the sample's time.
    Rates {
        /// Angular rate of the body against inertial space, rad/s.
        angular_rate_radps: Vector<Body>,
        /// Acceleration less gravitation, m/s²; level and at rest its z is −9.81.
        specific_force_mps2: Vector<Body>,
    },
    /// Integrals of rate and specific force since the sample before, each resolved in the body axes
    /// of its own moment (what an integrating unit puts out before any coning or sculling
    /// correction).
    Increments {
        /// Integral of angular rate, rad.
        angle_rad: Vector<Body>,
        /// Integral of specific force, m/s.
        velocity_mps: Vector<Body>,
    },
}

impl Motion {
    /// Whether every component is finite and one that a unit can measure: within ±10 000 rad/s and
    /// m/s², or rad and m/s a sample.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let measurable = |vector: &Vector<Body>| {
            vector.to_array().iter().all(|&component| libm::fabs(component) <= MEASURABLE)
        };
        match self {
            Self::Rates { angular_rate_radps: a, specific_force_mps2: b }
            | Self::Increments { angle_rad: a, velocity_mps: b } => measurable(a) && measurable(b),
        }
    }
}

/// Far beyond any unit, and far below where squares overflow.
const MEASURABLE: f64 = 1e4;

/// One sample of the inertial unit, axes already turned to forward-right-down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuSample {
    /// When the rates were sampled, or the increments ended.
    pub time: Time,
    /// Rates or increments.
    pub motion: Motion,
    /// The unit's own attitude, if it computes one; yaw from the north its dataset names.
    pub attitude: Option<EulerAngles>,
    /// Magnetic field in body axes, gauss, if the unit measures it.
    pub magnetic_field_gauss: Option<Vector<Body>>,
}
