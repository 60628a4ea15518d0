//! A fix that the sectors take in one after the other, over the samples that follow it: a step of the
//! search then never takes in a whole bank's fix.
//!
//! The sector that leads takes it in at once, so that its solution waits for nothing; the others in turn,
//! each by looking back to when the fix held. When all have, they are weighed. A fix is done before the next
//! is due and before it is older than what is remembered, or else at the latest when the next comes; and before
//! a gap, over which nobody can look back.

use super::super::scalar::Scalar;
use super::{HeadingSearch, LEAST_WEIGHT, SECTORS};
use crate::gps::Fix;

/// A fix that not all sectors have taken in yet.
#[derive(Clone, Debug)]
pub(super) struct Waiting {
    /// As the sectors take it in.
    fix: Fix,
    /// Its shares of information.
    shares: [f64; 2],
    /// Minus twice the logarithm of its likelihood, of those that have taken it in.
    surprises: [Option<f64>; SECTORS],
    /// How many take it in with each sample.
    pace: usize,
}

impl Waiting {
    /// A fix that none has taken in, with `interval_s` in which all have to and samples every `sample_s`.
    pub fn new(fix: Fix, shares: [f64; 2], interval_s: f64, sample_s: f64) -> Self {
        // One sample may be missing, and the leader has had its turn.
        let samples = (interval_s / sample_s - 1.0).max(1.0);
        let pace = (libm::ceil((SECTORS - 1) as f64 / samples) as usize).max(1);
        Self { fix, shares, surprises: [None; SECTORS], pace }
    }
}

impl<T: Scalar> HeadingSearch<T> {
    /// Lets as many sectors take in the fix that waits as have to with a sample.
    pub(super) fn take_turns(&mut self) {
        if let Some(waiting) = &self.waiting {
            self.take_in_waiting(waiting.pace);
        }
    }

    /// Lets all sectors that have not yet take in the fix that waits.
    pub(super) fn finish_turns(&mut self) {
        self.take_in_waiting(SECTORS);
    }

    // Its frame need not stand beneath the others of its callers.
    #[inline(never)]
    fn take_in_waiting(&mut self, most: usize) {
        let Some(waiting) = &mut self.waiting else { return };
        let mut left = most;
        for (slot, surprise) in self.sectors.iter_mut().zip(&mut waiting.surprises) {
            let Some(sector) = slot.as_mut().filter(|_| surprise.is_none()) else { continue };
            if left == 0 {
                return;
            }
            left -= 1;
            let fix = &waiting.fix;
            let Ok(report) = sector.lend(&mut self.filter, |filter| filter.update_gps_again(fix))
            else {
                // What not all can be compared with weighs none.
                self.waiting = None;
                return;
            };
            *surprise = Some(report.minus_two_log_likelihood(waiting.shares));
        }
        self.weigh();
    }

    /// Weighs the sectors by the fix that all have taken in.
    ///
    /// # Source
    /// Equation (H2) of docs/equations.md.
    #[inline(never)]
    fn weigh(&mut self) {
        let Some(Waiting { fix, surprises, .. }) = &self.waiting else { return };
        let time = fix.time;
        let least = surprises.iter().flatten().fold(f64::INFINITY, |a, &b| a.min(b));
        let mut sum = 0.0;
        for (sector, surprise) in self.sectors.iter_mut().zip(surprises) {
            if let (Some(sector), Some(surprise)) = (sector, surprise) {
                sector.weight *= libm::exp(-0.5 * (surprise - least).min(100.0));
                sum += sector.weight;
            }
        }
        for slot in &mut self.sectors {
            if let Some(sector) = slot {
                sector.weight /= sum;
                if sector.weight < LEAST_WEIGHT {
                    *slot = None;
                }
            }
        }
        self.waiting = None;
        self.bear_out(time);
        self.weighed = true;
    }
}

impl Waiting {
    /// Notes what the fix told a sector.
    pub fn told(&mut self, sector: usize, surprise: f64) {
        if let Some(slot) = self.surprises.get_mut(sector) {
            *slot = Some(surprise);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::earth::Geodetic;
    use crate::time::Time;

    #[test]
    fn as_many_sectors_a_sample_take_in_a_fix_as_it_takes_to_be_done_before_the_next() {
        let place = Geodetic::from_degrees(48.0, 11.0, 500.0).unwrap();
        let pace = |interval_s, sample_s| {
            Waiting::new(Fix::at(Time::ZERO, place), [1.0; 2], interval_s, sample_s).pace
        };
        assert_eq!(pace(1.0, 0.0303), 1);
        assert_eq!(pace(1.0, 0.1), 2);
        assert_eq!(pace(0.2, 0.0303), 2);
        assert_eq!(pace(0.1, 0.0303), 5);
        assert_eq!(pace(0.1, 0.01), 2);
        // Where a fix comes with every sample, or nothing is known of the samples yet.
        assert_eq!(pace(0.1, 0.1), SECTORS - 1);
        assert_eq!(pace(1.0, 0.0), 1);
    }
}
