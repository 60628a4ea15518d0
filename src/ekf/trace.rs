//! A filter watched at work: what the smoother records.

use core::ops::Range;

use super::covariance::{Gain, Sensitivity, Transition};
use crate::frames::{Ned, Vector};

/// Watches a filter at work: what a smoother needs to go back over it.
pub trait Trace<T, const N: usize> {
    /// Whether it wants to be told of measurements at all: what it would be told is not worked out else.
    fn watches(&self) -> bool {
        true
    }
    /// The covariance was propagated.
    fn propagated(&mut self, step: &Transition<T, N>);
    /// A scalar measurement was taken in.
    fn updated(&mut self, sensitivity: &Sensitivity<T>, gain: &Gain<T, N>, innovation: f64);
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
    #[inline(always)]
    fn watches(&self) -> bool {
        false
    }
    #[inline(always)]
    fn propagated(&mut self, _: &Transition<T, N>) {}
    #[inline(always)]
    fn updated(&mut self, _: &Sensitivity<T>, _: &Gain<T, N>, _: f64) {}
}
