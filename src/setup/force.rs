//! Size and direction of the mean specific force.

use super::{ForceScale, SetupFault};
use crate::earth::STANDARD_GRAVITY_MPS2;
use crate::frames::{Body, Vector};

/// Number of half-second averages that the check of the specific force uses: 10 s.
const PARTS: u8 = 20;
/// Range of the size of the mean specific force over 10 s in any flight, g.
const POSSIBLE_G: core::ops::RangeInclusive<f32> = 0.6..=1.75;
/// Smallest length of the mean unit vector, 0 to 1, with which the specific force has a steady direction.
const STEADY: f32 = 0.85;
/// Cosine of the angle from the vertical within which a vehicle starts its flight, 60°.
const UPRIGHT: f32 = 0.5;

/// Sums over the half-second averages until the check.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MeanForce {
    parts: u8,
    size_mps2: f32,
    direction: Vector<Body, f32>,
}

impl MeanForce {
    pub const NONE: Self = Self { parts: 0, size_mps2: 0.0, direction: Vector::ZERO };

    /// Adds a half-second average of the specific force. Checks once, when all averages are complete.
    pub fn push(&mut self, force_mps2: Vector<Body, f32>) -> Option<SetupFault> {
        if self.parts >= PARTS {
            return None;
        }
        self.parts += 1;
        let size_mps2 = force_mps2.norm();
        self.size_mps2 += size_mps2;
        if size_mps2 > 0.0 {
            self.direction += force_mps2 * (1.0 / size_mps2);
        }
        if self.parts < PARTS {
            return None;
        }
        let share = 1.0 / f32::from(PARTS);
        let mean_mps2 = share * self.size_mps2;
        if !POSSIBLE_G.contains(&(mean_mps2 / STANDARD_GRAVITY_MPS2 as f32)) {
            let scale = ForceScale::of(f64::from(mean_mps2));
            return Some(SetupFault::ForceSize { mean_mps2, scale });
        }
        let length = self.direction.norm();
        let up = self.direction * (1.0 / length);
        (share * length >= STEADY && -up.z() < UPRIGHT)
            .then(|| SetupFault::ForceDirection { up: up.to_array() })
    }
}
