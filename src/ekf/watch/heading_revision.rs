//! Part of the filter's heading corrections that is not a turn of the vehicle.

use super::READING_S;
use crate::scalar::Scalar;
use crate::time::Time;

/// Largest rate at which a held heading follows a magnetometer, rad/s: 0.1 °/s. It is faster than gyro drift, and
/// slower than a passing magnet.
const FOLLOWED_RADPS: f64 = 0.0017;

/// Total heading change due to errors found in the heading source.
///
/// # Source
/// Equation (K22) of docs/equations.md.
#[derive(Clone, Copy, Debug)]
pub(in crate::ekf) struct HeadingRevision<T> {
    /// Total heading change up to now, rad.
    pub total_rad: T,
    /// Whether the heading source is a magnetometer: its error is constant at a constant heading. The error of a
    /// heading computed by a sensor drifts in time.
    pub is_magnetic: bool,
    /// Change of the error not yet included in the total, rad.
    pending_rad: T,
    /// Error of the heading source after the previous correction, rad.
    reference_error_rad: T,
    /// Time of the previous correction.
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

    /// Feeds a correction: the heading turned by `turned_rad`, and the error of its source is now
    /// `reference_error_rad`.
    ///
    /// The source's reading, heading plus error, stays constant while the vehicle does not turn. A correction of the
    /// heading matched by an opposite change of the error is therefore a found error: it counts at once. The rest of
    /// the error's change since the previous correction, from decay and re-estimation, may be a disturbance. The total
    /// follows this rest slowly, and only for a magnetometer.
    pub fn corrected(&mut self, time: Time, turned_rad: T, reference_error_rad: T) {
        let opposite = self.reference_error_rad - reference_error_rad;
        let found = turned_rad.min(opposite).max(T::ZERO) + turned_rad.max(opposite).min(T::ZERO);
        self.total_rad += found;
        self.reference_error_rad = reference_error_rad;
        if self.is_magnetic {
            let pending = self.pending_rad + opposite - found;
            let elapsed_s = T::of((time - self.corrected).clamp(0.0, READING_S));
            let farthest = T::of(FOLLOWED_RADPS) * elapsed_s;
            let followed = pending.max(-farthest).min(farthest);
            self.total_rad += followed;
            self.pending_rad = pending - followed;
        } else {
            self.pending_rad = T::ZERO;
        }
        self.corrected = time;
    }

    /// Feeds the replacement of a wrong heading by one turned by `turn_rad`. The error of the source restarts at zero.
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

    /// Feeds a correction every 0.1 s.
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

    /// The vehicle turned: the magnetometer corrects the part that the gyro missed.
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

    /// A magnet of 30° passes: the heading follows at most at 0.1 °/s, and returns.
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
