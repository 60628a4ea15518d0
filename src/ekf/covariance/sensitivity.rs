//! The sensitivity of a scalar measurement to the error state, sparse.

use super::super::scalar::Scalar;

/// The row of H of a scalar measurement: the few states it sees.
#[derive(Clone, Copy, Debug)]
pub struct Sensitivity<T> {
    terms: [(usize, T); 20],
    count: usize,
}

impl<T: Scalar> Default for Sensitivity<T> {
    fn default() -> Self {
        Self { terms: [(0, T::ZERO); 20], count: 0 }
    }
}

impl<T: Scalar> Sensitivity<T> {
    /// Adds ∂z/∂x of one state. A state may be named more than once: the terms add up. At most 20;
    /// zeros do not count, and cost nothing later.
    #[must_use]
    pub fn with(mut self, state: usize, derivative: f64) -> Self {
        if derivative == 0.0 {
            return self;
        }
        if let Some(term) = self.terms.get_mut(self.count) {
            *term = (state, T::of(derivative));
            self.count += 1;
        }
        self
    }

    /// Adds the derivatives of three consecutive states.
    #[must_use]
    pub fn with_block(self, first: usize, derivatives: [f64; 3]) -> Self {
        let [x, y, z] = derivatives;
        self.with(first, x).with(first + 1, y).with(first + 2, z)
    }

    /// The states and their derivatives.
    pub fn terms(&self) -> impl Iterator<Item = (usize, T)> + '_ {
        self.terms.iter().take(self.count).copied()
    }

    /// H x.
    #[must_use]
    pub fn dot<const N: usize>(&self, state: &[T; N]) -> T {
        let mut sum = T::ZERO;
        for (index, derivative) in self.terms() {
            if let Some(&value) = state.get(index) {
                sum += derivative * value;
            }
        }
        sum
    }
}
