//! Quantiles of a series that is too long for memory.

use std::collections::BTreeMap;

/// Histogram of a series, in bounded memory.
///
/// Exact up to 65 536 different values. With more, the last binary digits of all values are cleared until at most
/// 65 536 different values remain. These differ from their neighbours by less than a ten-thousandth.
#[derive(Clone, Debug, Default)]
pub struct Distribution {
    counts: BTreeMap<u64, u64>,
    total: u64,
    /// Number of last binary digits that are cleared.
    rounded: u32,
}

/// Largest number of different values.
const MAX: usize = 1 << 16;

impl Distribution {
    /// Counts `value`, which must be finite and not negative.
    pub fn push(&mut self, value: f64) {
        *self.counts.entry(rounded(value.to_bits(), self.rounded)).or_default() += 1;
        self.total += 1;
        while self.counts.len() > MAX {
            self.rounded += 1;
            let finer = std::mem::take(&mut self.counts);
            for (bits, count) in finer {
                *self.counts.entry(rounded(bits, self.rounded)).or_default() += count;
            }
        }
    }

    /// Quantile `fraction`, as in [`quantile`](crate::statistics::quantile); `None` without values.
    pub fn quantile(&self, fraction: f64) -> Option<f64> {
        let position = fraction.clamp(0.0, 1.0) * self.total.checked_sub(1)? as f64;
        let below = position as u64;
        let low = self.nth(below)?;
        let high = self.nth(below + 1).unwrap_or(low);
        Some(low + (high - low) * (position - below as f64))
    }

    /// The value at `index` in rising order.
    fn nth(&self, index: u64) -> Option<f64> {
        let mut passed = 0;
        let found = self.counts.iter().find(|(_, count)| {
            passed += **count;
            passed > index
        });
        found.map(|(bits, _)| f64::from_bits(*bits))
    }

    /// The values, rising, with their counts.
    pub fn counts(&self) -> impl Iterator<Item = (f64, u64)> {
        self.counts.iter().map(|(bits, count)| (f64::from_bits(*bits), *count))
    }
}

/// `bits` of a number with the last `digits` binary digits cleared. Non-negative numbers have the same order as their
/// bits.
const fn rounded(bits: u64, digits: u32) -> u64 {
    bits >> digits << digits
}

impl FromIterator<f64> for Distribution {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let mut distribution = Self::default();
        values.into_iter().for_each(|value| distribution.push(value));
        distribution
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::quantile;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn quantiles_of_few_values_are_exact(
            values in prop::collection::vec(0u8..50, 0..200),
            fraction in 0.0..1.0,
        ) {
            let mut values: Vec<f64> = values.into_iter().map(|value| f64::from(value) / 7.0).collect();
            let distribution: Distribution = values.iter().copied().collect();
            prop_assert_eq!(distribution.quantile(fraction), quantile(&mut values, fraction));
        }
    }

    #[test]
    fn of_a_million_different_values_few_are_kept_and_the_median_is_near() {
        let mut state = 1u64;
        let next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            0.005 + 1e-3 * ((state >> 11) as f64 / (1u64 << 53) as f64)
        };
        let mut values: Vec<f64> = std::iter::repeat_with(next).take(1_000_000).collect();
        let distribution: Distribution = values.iter().copied().collect();
        assert!(distribution.counts.len() <= MAX);
        let (found, exact) =
            (distribution.quantile(0.5).unwrap(), quantile(&mut values, 0.5).unwrap());
        assert!((found / exact - 1.0).abs() < 1e-4, "{found} {exact}");
        assert_eq!(distribution.counts().map(|(_, count)| count).sum::<u64>(), 1_000_000);
    }
}
