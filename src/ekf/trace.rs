//! A filter watched at work: what smoothers and controllers need to know of it.

use core::ops::Range;

use super::covariance::{Gain, Sensitivity, Transition};
use crate::frames::{Ned, Vector};

/// Watches a filter at work. Whoever watches says what of it to hear.
pub trait Trace<T, const N: usize> {
    /// The covariance was propagated.
    fn propagated(&mut self, step: &Transition<T, N>) {
        let _ = step;
    }
    /// Whether [`updated`](Self::updated) is to be called; where it does nothing, what it would be told need not
    /// be worked out.
    fn hears_updates(&self) -> bool {
        true
    }
    /// A scalar measurement was taken in.
    fn updated(&mut self, sensitivity: &Sensitivity<T>, gain: &Gain<T, N>, innovation: f64) {
        let _ = (sensitivity, gain, innovation);
    }
    /// The estimates were moved by this, for all axes of a measurement together.
    fn corrected(&mut self, correction: &[T; N]) {
        let _ = correction;
    }
    /// Some states were opened anew, and nothing that is found out of them from now on tells of what they were
    /// before.
    fn reset(&mut self, states: Range<usize>) {
        let _ = states;
    }
    /// The attitude was turned by a rotation vector in NED, rad: a wrong heading was replaced.
    fn turned(&mut self, turn_rad: Vector<Ned>) {
        let _ = turn_rad;
    }
}

/// Watches nothing.
impl<T, const N: usize> Trace<T, N> for () {
    fn hears_updates(&self) -> bool {
        false
    }
}
