//! Detection of single axes that repeat one reading.
#![expect(clippy::indexing_slicing, reason = "axes count from 0 to 2, in arrays of three")]

use crate::scalar::Scalar;

/// Monitors the readings of a triad for an axis whose register is not updated.
///
/// A sensor with coarse resolution repeats readings by chance. The frequency of repetitions is learned; a run that
/// chance does not explain is a fault.
#[derive(Clone, Copy, Debug)]
pub(super) struct Repetition<T> {
    /// Previous readings; `None` before the first.
    last: Option<[T; 3]>,
    /// Duration of the present run of repetitions of each axis, s.
    run_s: [T; 3],
    /// Number of repetitions in the present run of each axis.
    count: [f32; 3],
    /// Fraction of readings that repeat the previous one, learned from the first reading on.
    share: [f32; 3],
}

/// Memory of the learned fraction of repetitions, s.
const MEMORY_S: f64 = 20.0;
/// Smallest fraction of repetitions assumed for any sensor.
const MIN_SHARE: f32 = 0.02;
/// Lower limit of the learned fraction. Without it, the fraction would become denormal after half an hour, which slows
/// the processor.
const FORGOTTEN_SHARE: f32 = 1e-9;
/// Initial fraction of repetitions: the sensor counts as coarse until its fraction is known.
const FIRST_SHARE: f32 = 0.8;
/// Natural logarithm of the probability below which a run is not chance.
const IMPROBABLE: f32 = -20.0;

impl<T: Scalar> Repetition<T> {
    /// State before the first reading.
    pub const NONE: Self =
        Self { last: None, run_s: [T::ZERO; 3], count: [0.0; 3], share: [0.0; 3] };

    /// Feeds readings `interval_s` after the previous ones. Returns for each axis the time, s, for which it has been
    /// stuck; zero if it is not.
    pub fn push(&mut self, values: [T; 3], interval_s: T) -> [T; 3] {
        let mut stuck_s = [T::ZERO; 3];
        // NaN equals nothing, so the first readings repeat nothing.
        let last = self.last.replace(values).unwrap_or_else(|| {
            self.share = [FIRST_SHARE; 3];
            [T::of(f64::NAN); 3]
        });
        let newest = (interval_s / T::of(MEMORY_S)).min(T::ONE).wide() as f32;
        for axis in 0..3 {
            let share = &mut self.share[axis];
            if last[axis] == values[axis] {
                self.count[axis] += 1.0;
                self.run_s[axis] += interval_s;
                if self.count[axis] * libm::logf(share.max(MIN_SHARE)) < IMPROBABLE {
                    stuck_s[axis] = self.run_s[axis];
                } else {
                    *share += newest * (1.0 - *share);
                }
            } else {
                (self.count[axis], self.run_s[axis]) = (0.0, T::ZERO);
                *share = (*share - newest * *share).max(FORGOTTEN_SHARE);
            }
        }
        stuck_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_that_stands_still_is_stuck_and_one_of_coarse_steps_is_not() {
        let mut repetition = Repetition::NONE;
        let mut state = 1u64;
        let (mut stuck, mut coarse) = (0, 0);
        for k in 0..4000 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let noise = (state >> 40) as f64 / (1u64 << 24) as f64;
            let fine = if k >= 3900 { 0.5 } else { noise };
            let found = repetition.push([fine, (1.4 * noise).floor(), 2.0 + noise], 0.01);
            stuck += usize::from(found[0] > 0.0);
            coarse += usize::from(found[1] > 0.0);
            assert_eq!(found[2], 0.0);
            assert!(found[0] == 0.0 || k > 3902, "{k}");
        }
        assert!(stuck > 80 && coarse == 0, "{stuck} {coarse}");
    }

    #[test]
    fn hours_without_a_repetition_leave_no_number_too_small_for_the_processor() {
        let mut repetition = Repetition::NONE;
        for k in 0..200_000 {
            repetition.push([f64::from(k); 3], 0.03);
        }
        assert!(repetition.share.iter().all(|share| share.is_normal()), "{:?}", repetition.share);
    }
}
