//! Comparison of the turns of gravity in body axes with the gyros.
//!
//! In body axes gravity turns opposite to the gyros. If gravity hardly turns while the gyros report full circles, the
//! angular rates are in °/s. In a flip the thrust of a rotor also turns with the body. But no vehicle flips for a
//! quarter of the time at constant thrust.

use super::fault::SetupFault;
use crate::imu::MeanRates;

/// Length of an averaging interval, s: long enough to remove vibration, short enough to keep turns.
pub(super) const PART_S: f64 = 0.5;
/// Smallest angle of a fast turn over an averaging interval, rad.
const FAST_RAD: f32 = 0.5;
/// Smallest number of averaging intervals for a result: 20 s.
const MIN_PARTS: f32 = 40.0;
/// Smallest fraction of averaging intervals with a fast turn that indicates rates in °/s. No flight reaches it while
/// the specific force varies by less than [`VARIATION`].
const FAST_SHARE: f32 = 0.25;
/// Largest relative variation of the specific force (standard deviation over mean) in intervals with a fast turn.
const VARIATION: f32 = 0.3;
/// Fraction of the turn reported by the gyros (limited to 2 rad) below which gravity counts as not turning.
const SEEN_SHARE: f32 = 0.3;

/// Sums over the averaging intervals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GravityTurn {
    before: Option<MeanRates<f32>>,
    parts: f32,
    fast: f32,
    /// Sum over intervals with a fast turn of the squared turn that the gyros report, rad².
    by_gyros: f32,
    /// Sum over intervals with a fast turn of the squared change of the specific force in body axes, divided by its
    /// magnitude. For a force of constant magnitude and a small turn it is the squared turn, rad².
    by_gravity: f32,
    /// Sum over intervals with a fast turn of the magnitude of the specific force, m/s².
    force: f32,
    /// Sum over intervals with a fast turn of the squared specific force, m²/s⁴.
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

    /// Adds the averages of an interval. Returns the fault once.
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
        if self.parts < MIN_PARTS || self.fast < FAST_SHARE * self.parts {
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
