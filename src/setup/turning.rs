//! Turns of gravity against the gyros.
//!
//! In body axes gravity turns opposite to the gyros. If it hardly turns while they report full circles, they are in
//! °/s. The thrust of a rotor turns with the body in a flip, but no flip lasts a quarter of the time at constant thrust.

use super::{PART_S, SetupFault};
use crate::imu::MeanRates;

/// Angle of a fast turn over a part, rad.
const FAST_RAD: f32 = 0.5;
/// Least number of parts for a judgement: 20 s.
const LEAST_PARTS: f32 = 40.0;
/// Share of fast parts that no flight reaches while the specific force varies by less than [`VARIATION`].
const FAST_SHARE: f32 = 0.25;
/// Relative variation of the specific force.
const VARIATION: f32 = 0.3;
/// Share of the reported turn, at most two radians of it, below which gravity hardly turns.
const SEEN_SHARE: f32 = 0.3;

/// Sums over the parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GravityTurn {
    before: Option<MeanRates<f32>>,
    parts: f32,
    fast: f32,
    /// Of the fast parts: squared turn by the gyros and by gravity, rad²; specific force and its square, m/s².
    by_gyros: f32,
    by_gravity: f32,
    force: f32,
    force_squared: f32,
    is_judged: bool,
}

impl GravityTurn {
    pub const NONE: Self = Self {
        before: None,
        parts: 0.0,
        fast: 0.0,
        by_gyros: 0.0,
        by_gravity: 0.0,
        force: 0.0,
        force_squared: 0.0,
        is_judged: false,
    };

    /// Adds the means of a part; reports once.
    pub fn push(&mut self, after: &MeanRates<f32>) -> Option<SetupFault> {
        let before = self.before.replace(*after)?;
        let size = before.specific_force_mps2.norm();
        if self.is_judged || size <= 0.0 {
            return None;
        }
        let rate_radps = (before.angular_rate_radps + after.angular_rate_radps) * 0.5;
        let turned = rate_radps.cross(before.specific_force_mps2).norm() / size * PART_S as f32;
        self.parts += 1.0;
        if turned > FAST_RAD {
            let change = (after.specific_force_mps2 - before.specific_force_mps2).norm() / size;
            self.fast += 1.0;
            self.by_gyros += turned * turned;
            self.by_gravity += change * change;
            self.force += size;
            self.force_squared += size * size;
        }
        if self.parts < LEAST_PARTS || self.fast < FAST_SHARE * self.parts {
            return None;
        }
        let [by_gyros, by_gravity, force, force_squared] =
            [self.by_gyros, self.by_gravity, self.force, self.force_squared]
                .map(|sum| sum / self.fast);
        let varies = force_squared - force * force;
        let [reported_rad, seen_rad] = [by_gyros, by_gravity].map(libm::sqrtf);
        self.is_judged = varies < VARIATION * force * (VARIATION * force)
            && seen_rad < SEEN_SHARE * reported_rad.min(2.0);
        self.is_judged.then_some(SetupFault::RatesInDegrees { reported_rad, seen_rad })
    }
}
