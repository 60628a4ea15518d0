//! Memory of one filter beside its state and covariance.

use super::level_force::LevelForce;
use super::net_turn::NetTurn;
use super::scalar::Scalar;
use crate::frames::{Body, Vector};

/// Memory of one filter of a bank that flies the same samples: the bank exchanges it whole.
#[derive(Clone, Copy, Debug)]
pub(super) struct Own<T> {
    /// Angular rate against the ground's axes, less bias.
    pub angular_rate_radps: Vector<Body, T>,
    /// How long the parameters have not relaxed, s, at the last propagation.
    pub unrelaxed_s: T,
    /// Learned size of the GPS errors against what is stated or configured: variances of position and of
    /// horizontal and vertical velocity.
    pub gps_learned: [f32; 3],
    pub net_turn: NetTurn<T>,
    pub level_force: LevelForce<T>,
}

impl<T: Scalar> Own<T> {
    /// Of a filter that starts.
    pub const START: Self = Self {
        angular_rate_radps: Vector::ZERO,
        unrelaxed_s: T::ZERO,
        gps_learned: [1.0; 3],
        net_turn: NetTurn::NONE,
        level_force: LevelForce::NONE,
    };
}
