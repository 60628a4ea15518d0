//! Observer of a running filter, for smoothers and controllers.

use core::ops::Range;

use super::covariance::{Gain, Sensitivity, Transition};
use crate::frames::{Ned, Vector};

/// Observer of a running filter. An implementation overrides the methods of the events it needs.
pub trait Trace<T, const N: usize> {
    /// The covariance was propagated.
    fn propagated(&mut self, step: &Transition<T, N>) {
        let _ = step;
    }
    /// Whether the filter shall call [`updated`](Self::updated). `false` saves the computation of its arguments.
    fn wants_updates(&self) -> bool {
        true
    }
    /// The filter fused a scalar measurement.
    fn updated(&mut self, sensitivity: &Sensitivity<T>, gain: &Gain<T, N>, innovation: f64) {
        let _ = (sensitivity, gain, innovation);
    }
    /// The filter corrected its estimates by `correction`, the sum over all axes of a measurement.
    fn corrected(&mut self, correction: &[T; N]) {
        let _ = correction;
    }
    /// The filter reset the variance of some states. Later measurements of these states carry no information about
    /// their earlier values.
    fn reset(&mut self, states: Range<usize>) {
        let _ = states;
    }
    /// The filter turned the attitude by a rotation vector in NED, rad, to replace a wrong heading.
    fn turned(&mut self, turn_rad: Vector<Ned>) {
        let _ = turn_rad;
    }
}

/// Observer that ignores every event.
impl<T, const N: usize> Trace<T, N> for () {
    fn wants_updates(&self) -> bool {
        false
    }
}
