//! The second difference of a triad's readings.

use crate::frames::{Body, Vector};
use crate::scalar::Scalar;

/// x_k − 2 x_{k−1} + x_{k−2}: blind to steady values and to steady change; of noise without memory it
/// has six times the variance.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SecondDifference<T> {
    before: [Vector<Body, T>; 2],
    /// Readings there were, to two.
    seen: u8,
}

impl<T: Scalar> SecondDifference<T> {
    /// No reading yet.
    pub const NONE: Self = Self { before: [Vector::ZERO; 2], seen: 0 };

    /// Takes in the next reading; `None` until there are three.
    pub fn push(&mut self, reading: Vector<Body, T>) -> Option<[T; 3]> {
        let [newer, older] = self.before;
        self.before = [reading, newer];
        if self.seen < 2 {
            self.seen += 1;
            return None;
        }
        Some((reading - newer * T::of(2.0) + older).to_array())
    }

    /// Whether there are two readings.
    pub fn is_full(&self) -> bool {
        self.seen == 2
    }

    /// The last reading of each axis, and by how much it differs from the one before.
    pub fn lines(&self) -> impl Iterator<Item = (T, T)> {
        let [newer, older] = self.before.map(Vector::to_array);
        newer.into_iter().zip(older).map(|(newer, older)| (newer, newer - older))
    }

    /// Whether the last reading differs from the one before it.
    pub fn is_moving(&self) -> bool {
        let [newer, older] = self.before;
        newer != older
    }

    /// Forgets the last two readings, after a gap.
    pub fn interrupt(&mut self) {
        *self = Self::NONE;
    }
}

/// The variance of noise without memory that a second difference tells of, each axis by itself.
pub(crate) fn noise_variance<T: Scalar>(difference: [T; 3]) -> [T; 3] {
    difference.map(|change| change * change / T::of(6.0))
}
