//! What of the filter's turns of its heading the vehicle did not turn by.

use super::scalar::Scalar;
use crate::time::Time;

/// So fast at the most a heading that is held goes after a magnetometer, rad/s, 0.1 °/s: faster than gyros drift,
/// and slow against a magnet that passes.
const FOLLOWED_RADPS: f64 = 0.0017;
/// Corrections further apart than this, s, count as so far apart.
const FARTHEST_APART_S: f64 = 1.0;

/// How far the heading was turned, in all, because what gives it was found in error.
///
/// # Source
/// Equation (K22) of docs/equations.md.
#[derive(Clone, Copy, Debug)]
pub(super) struct HeadingRevision<T> {
    /// Up to now, rad.
    pub total_rad: T,
    /// Whether what gives the heading is a magnetometer, whose error stays while the heading does. That of a heading
    /// which a unit computes wanders by itself.
    pub is_magnetic: bool,
    /// What of the changes of the error is not in it yet, rad.
    pending_rad: T,
    /// The error after the correction before, rad, and when it was.
    reference_error_rad: T,
    corrected: Time,
}

impl<T: Scalar> HeadingRevision<T> {
    pub const NONE: Self = Self {
        total_rad: T::ZERO,
        is_magnetic: false,
        pending_rad: T::ZERO,
        reference_error_rad: T::ZERO,
        corrected: Time::ZERO,
    };

    /// A correction turned the heading by `turned_rad`, and left the error of what gives it at
    /// `reference_error_rad`.
    ///
    /// The heading as it is shown, error and all, stays where the vehicle does not turn. So what of the turn is
    /// matched by the opposite change of the error is an error found, at once; and what else the error has changed
    /// since the correction before, by being forgotten and found again, comes slowly, and only of a magnetometer:
    /// it may be a disturbance.
    pub fn corrected(&mut self, time: Time, turned_rad: T, reference_error_rad: T) {
        let opposite = self.reference_error_rad - reference_error_rad;
        let found = turned_rad.min(opposite).max(T::ZERO) + turned_rad.max(opposite).min(T::ZERO);
        self.total_rad += found;
        self.reference_error_rad = reference_error_rad;
        if self.is_magnetic {
            let pending = self.pending_rad + opposite - found;
            let elapsed_s = T::of((time - self.corrected).clamp(0.0, FARTHEST_APART_S));
            let farthest = T::of(FOLLOWED_RADPS) * elapsed_s;
            let followed = pending.max(-farthest).min(farthest);
            self.total_rad += followed;
            self.pending_rad = pending - followed;
        } else {
            self.pending_rad = T::ZERO;
        }
        self.corrected = time;
    }

    /// A wrong heading was replaced by one turned by `turn_rad`, and what gave the wrong one is taken to be right.
    pub fn replaced(&mut self, turn_rad: f64) {
        *self = Self {
            total_rad: self.total_rad + T::of(turn_rad),
            is_magnetic: self.is_magnetic,
            ..Self::NONE
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gives a correction every 0.1 s.
    fn corrected(revision: &mut HeadingRevision<f64>, step: i64, turned_rad: f64, error_rad: f64) {
        let time = Time::from_nanoseconds(step * 100_000_000);
        revision.corrected(time, turned_rad, error_rad);
    }

    fn magnetic() -> HeadingRevision<f64> {
        HeadingRevision { is_magnetic: true, ..HeadingRevision::NONE }
    }

    #[test]
    fn a_fix_that_finds_the_magnetometer_in_error_revises_the_heading_at_once() {
        let mut revision = magnetic();
        corrected(&mut revision, 1, 0.05, -0.05);
        assert!((revision.total_rad - 0.05).abs() < 1e-12, "{revision:?}");
        corrected(&mut revision, 2, -0.08, 0.03);
        assert!((revision.total_rad + 0.03).abs() < 1e-12, "{revision:?}");
    }

    /// The vehicle turned: what a gyro missed of it, a magnetometer corrects.
    #[test]
    fn a_correction_that_leaves_the_magnetometers_error_revises_nothing() {
        for is_magnetic in [true, false] {
            let mut revision = HeadingRevision { is_magnetic, ..HeadingRevision::NONE };
            for step in 1..100 {
                corrected(&mut revision, step, 0.01, 0.0);
            }
            assert!(revision.total_rad.abs() < 1e-12, "{revision:?}");
        }
    }

    /// A magnet of 30° passes: what the heading follows of it comes no faster than 0.1 °/s, and goes again.
    #[test]
    fn a_disturbance_is_followed_slowly_and_the_units_own_heading_not_at_all() {
        let mut revision = magnetic();
        let mut own = HeadingRevision::<f64>::NONE;
        for step in 1..=300 {
            let error_rad = if (100..150).contains(&step) { 0.52 } else { 0.0 };
            corrected(&mut revision, step, 0.0, error_rad);
            corrected(&mut own, step, 0.0, error_rad);
            assert!(revision.total_rad.abs() < 5.1 * FOLLOWED_RADPS, "{step}: {revision:?}");
        }
        assert!(revision.total_rad.abs() < 1e-9, "{revision:?}");
        assert!(own.total_rad == 0.0, "{own:?}");
    }

    #[test]
    fn a_heading_that_was_replaced_is_revised_by_its_turn() {
        let mut revision = magnetic();
        corrected(&mut revision, 1, 0.05, -0.05);
        revision.replaced(1.2);
        corrected(&mut revision, 2, 0.0, 0.0);
        assert!((revision.total_rad - 1.25).abs() < 1e-12, "{revision:?}");
    }
}
