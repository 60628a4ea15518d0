//! The covariance of a small filter in a quarter of the memory, where many are kept.

use super::super::scalar::Scalar;
use super::Covariance;

const STATES: usize = PackedCovariance::STATES;

/// The upper triangle of the covariance, row by row, in single precision.
#[derive(Clone, Debug)]
pub(in super::super) struct PackedCovariance([f32; STATES * (STATES + 1) / 2]);

impl PackedCovariance {
    /// The states of such a filter.
    pub const STATES: usize = 16;

    pub const ZERO: Self = Self([0.0; STATES * (STATES + 1) / 2]);

    /// Keeps a filter's covariance.
    pub fn pack<T: Scalar, const N: usize>(&mut self, covariance: &Covariance<T, N>) {
        let mut rest = &mut self.0[..];
        for (state, row) in covariance.rows.iter().enumerate().take(STATES) {
            let (Some(from), Some((to, after))) =
                (row.get(state..STATES), rest.split_at_mut_checked(STATES - state))
            else {
                return;
            };
            for (to, &from) in to.iter_mut().zip(from) {
                *to = from.wide() as f32;
            }
            rest = after;
        }
    }

    /// Puts the covariance back into a filter.
    pub fn unpack<T: Scalar, const N: usize>(&self, covariance: &mut Covariance<T, N>) {
        let mut rest = &self.0[..];
        for state in 0..STATES {
            let (Some((from, after)), Some((row, below))) = (
                rest.split_at_checked(STATES - state),
                covariance.rows.get_mut(state..).and_then(<[_]>::split_first_mut),
            ) else {
                return;
            };
            if let Some(to) = row.get_mut(state..STATES) {
                for (to, &from) in to.iter_mut().zip(from) {
                    *to = T::of(from.into());
                }
            }
            for (row, &entry) in below.iter_mut().zip(from.iter().skip(1)) {
                if let Some(mirror) = row.get_mut(state) {
                    *mirror = T::of(entry.into());
                }
            }
            rest = after;
        }
    }

    /// The variance of one state.
    pub fn variance(&self, state: usize) -> f64 {
        let before = state * (2 * STATES + 1 - state) / 2;
        self.0.get(before).copied().unwrap_or(0.0).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_packed_covariance_comes_back_whole() {
        let mut covariance = Covariance::<f64, 16>::zero();
        for row in 0..STATES {
            for column in 0..STATES {
                covariance.rows[row][column] = (row.min(column) * 100 + row.max(column)) as f64;
            }
        }
        let mut packed = PackedCovariance::ZERO;
        packed.pack(&covariance);
        let mut back = Covariance::<f64, 16>::zero();
        packed.unpack(&mut back);
        assert_eq!(back, covariance);
        for state in 0..STATES {
            assert_eq!(packed.variance(state), covariance.variance(state));
        }
    }
}
