//! The second difference of a triad's readings.

use crate::frames::{Body, Vector};
use crate::scalar::Scalar;

/// x_k − 2 x_{k−1} + x_{k−2}: zero for constant values and for constant rates of change. For white noise its variance
/// is six times that of the noise.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SecondDifference<T> {
    before: [Vector<Body, T>; 2],
    /// Number of previous readings, up to two.
    seen: u8,
}

impl<T: Scalar> SecondDifference<T> {
    /// State before the first reading.
    pub const NONE: Self = Self { before: [Vector::ZERO; 2], seen: 0 };

    /// Feeds the next reading; `None` until the third.
    pub fn push(&mut self, reading: Vector<Body, T>) -> Option<[T; 3]> {
        let [newer, older] = self.before;
        self.before = [reading, newer];
        if self.seen < 2 {
            self.seen += 1;
            return None;
        }
        Some((reading - newer * T::of(2.0) + older).to_array())
    }

    /// Whether two previous readings exist.
    pub fn is_full(&self) -> bool {
        self.seen == 2
    }

    /// The last reading of each axis, and its difference from the previous one.
    pub fn lines(&self) -> impl Iterator<Item = (T, T)> {
        let [newer, older] = self.before.map(Vector::to_array);
        newer.into_iter().zip(older).map(|(newer, older)| (newer, newer - older))
    }

    /// Whether the last reading differs from the previous one.
    pub fn is_moving(&self) -> bool {
        let [newer, older] = self.before;
        newer != older
    }

    /// Forgets the last two readings, after a gap.
    pub fn interrupt(&mut self) {
        *self = Self::NONE;
    }
}

/// Variance of the white noise indicated by a second difference, per axis.
pub(crate) fn noise_variance<T: Scalar>(difference: [T; 3]) -> [T; 3] {
    difference.map(|change| change * change / T::of(6.0))
}
