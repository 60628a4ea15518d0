//! The sensitivity of a scalar measurement to the error state, sparse.

use crate::scalar::Scalar;

/// Largest number of measurements of one moment: position and velocity.
pub const MAX_AXES: usize = 6;
/// Largest number of terms of a sensitivity.
const TERMS: usize = 16;

/// The row of H of a scalar measurement: the few states with a derivative.
#[derive(Clone, Copy, Debug)]
pub struct Sensitivity<T> {
    derivatives: [T; TERMS],
    states: [u8; TERMS],
    count: u8,
}

impl<T: Scalar> Default for Sensitivity<T> {
    fn default() -> Self {
        Self { derivatives: [T::ZERO; TERMS], states: [0; TERMS], count: 0 }
    }
}

impl<T: Scalar> Sensitivity<T> {
    /// Adds ∂z/∂x of one state, at most 16 in total. Repeated states are allowed: their terms add up. Zeros are not
    /// stored and cost nothing later.
    #[must_use]
    pub fn with(mut self, state: usize, derivative: T) -> Self {
        self.add(state, derivative);
        self
    }

    /// Adds the derivatives of three consecutive states.
    #[must_use]
    pub fn with_block(mut self, first: usize, derivatives: [T; 3]) -> Self {
        self.add_block(first, derivatives);
        self
    }

    /// [`with`](Self::with), in place.
    pub fn add(&mut self, state: usize, derivative: T) {
        if derivative == T::ZERO {
            return;
        }
        let term = usize::from(self.count);
        if let (Some(index), Some(slot), Ok(state)) =
            (self.states.get_mut(term), self.derivatives.get_mut(term), u8::try_from(state))
        {
            (*index, *slot) = (state, derivative);
            self.count += 1;
        }
    }

    /// [`with_block`](Self::with_block), in place.
    pub fn add_block(&mut self, first: usize, derivatives: [T; 3]) {
        for (axis, derivative) in derivatives.into_iter().enumerate() {
            self.add(first + axis, derivative);
        }
    }

    /// The states and their derivatives.
    pub fn terms(&self) -> impl Iterator<Item = (usize, T)> + '_ {
        let (states, derivatives) = self.parts();
        states.iter().zip(derivatives).map(|(&state, &derivative)| (usize::from(state), derivative))
    }

    /// States and derivatives in groups of four, at least one group; the last group is padded with zero derivatives.
    #[inline(always)]
    pub(super) fn fours(&self) -> impl Iterator<Item = (&[u8; 4], &[T; 4])> {
        let (states, derivatives) = (self.states.as_chunks().0, self.derivatives.as_chunks().0);
        states.iter().zip(derivatives).take(usize::from(self.count).div_ceil(4).max(1))
    }

    /// The states and their derivatives, index by index.
    #[inline(always)]
    fn parts(&self) -> (&[u8], &[T]) {
        let count = usize::from(self.count).min(TERMS);
        (
            self.states.get(..count).unwrap_or_default(),
            self.derivatives.get(..count).unwrap_or_default(),
        )
    }

    /// H x: the product of this row with a `state`.
    #[must_use]
    #[inline]
    pub fn dot<const N: usize>(&self, state: &[T; N]) -> T {
        let at = |index: u8| state.get(usize::from(index)).copied().unwrap_or(T::ZERO);
        let mut sum = T::ZERO;
        for (&[a, b, c, d], &[by_a, by_b, by_c, by_d]) in self.fours() {
            sum = sum + by_a * at(a) + by_b * at(b) + by_c * at(c) + by_d * at(d);
        }
        sum
    }
}
