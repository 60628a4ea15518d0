//! The second difference of a triad's readings.

use crate::frames::{Body, Vector};

/// x_k − 2 x_{k−1} + x_{k−2}: blind to steady values and to steady change; of noise without memory it
/// has six times the variance.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SecondDifference {
    before: [Option<Vector<Body>>; 2],
}

impl SecondDifference {
    /// No reading yet.
    pub const NONE: Self = Self { before: [None; 2] };

    /// Takes in the next reading; `None` until there are three.
    pub fn push(&mut self, reading: Vector<Body>) -> Option<[f64; 3]> {
        let [newer, older] = self.before;
        self.before = [Some(reading), newer];
        Some((reading - newer? * 2.0 + older?).to_array())
    }

    /// Forgets the last two readings, after a gap.
    pub fn interrupt(&mut self) {
        *self = Self::NONE;
    }
}
