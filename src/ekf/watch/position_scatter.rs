//! White noise of the positions of a receiver that reports no velocity, from the second differences of its fixes.
//!
//! Most receivers filter their positions: successive errors are nearly equal. Other sources, such as simulators and
//! radio beacons, have errors that change from fix to fix. A filter that models these as slow errors would attribute
//! their changes to motion.

use crate::earth::Geodetic;
use crate::gps::Fix;
use crate::ins::NavState;
use crate::matrix::square;
use crate::time::Time;

/// Mean square second difference of the positions.
#[derive(Clone, Copy, Debug)]
pub(in crate::ekf) struct PositionScatter {
    /// Time and position of the last fix.
    last: (Time, Geodetic),
    /// Displacement, NED, m, between the last two fixes, and their interval, s; zero without two fixes.
    moved_m: [f32; 3],
    interval_s: f32,
    /// Mean variance of an axis, relative to the square of the one-sigma of the fix.
    share: f32,
    /// Number of differences in the mean, at most [`MEMORY`].
    differences: u8,
}

/// Number of second differences over which the variance is averaged.
const MEMORY: u8 = 50;
/// Number of second differences from which the variance is used.
const ENOUGH: u8 = 8;
/// Longest interval of fixes, s: over longer ones the motion hides the noise.
const LONGEST_S: f64 = 1.5;
/// Largest relative difference of two successive intervals.
const EVEN: f32 = 0.2;
/// Largest share from one second difference.
const MAX_SHARE: f32 = 4.0;

impl PositionScatter {
    pub const NONE: Self = Self {
        last: (Time::NEVER, NavState::<f64>::ORIGIN.position),
        moved_m: [0.0; 3],
        interval_s: 0.0,
        share: 0.0,
        differences: 0,
    };

    /// Feeds a fix with this one-sigma of position, NED, m. The vehicle has accelerated by at most `agility_mps2`,
    /// horizontally and vertically.
    ///
    /// # Source
    /// Equation (M21) of docs/equations.md.
    pub fn push(&mut self, fix: &Fix, sigma_m: [f64; 3], agility_mps2: [f32; 2]) {
        let (time, place) = core::mem::replace(&mut self.last, (fix.time, fix.position));
        if fix.time - time > LONGEST_S {
            self.interval_s = 0.0;
            return;
        }
        let interval_s = (fix.time - time) as f32;
        let moved_m = fix.position.displacement_from(&place).to_array().map(|axis| axis as f32);
        let before_m = core::mem::replace(&mut self.moved_m, moved_m);
        let before_s = core::mem::replace(&mut self.interval_s, interval_s);
        if interval_s <= 0.0 || (interval_s - before_s).abs() > EVEN * before_s {
            return;
        }
        let [north, east, down] = core::array::from_fn(|axis| {
            let at = |of: &[f32; 3]| of.get(axis).copied().unwrap_or_default();
            square(at(&moved_m) - at(&before_m))
        });
        let [sigma, _, sigma_down] = sigma_m;
        let [level, vertical] = agility_mps2.map(|mps2| square(mps2 * square(interval_s)));
        let of = |squares_m2: f32, sigma_m: f64| squares_m2 / square(sigma_m) as f32;
        // A second difference of white noise has six times its variance.
        let found = (of(north + east - level, sigma) + of(down - vertical, sigma_down)) / 18.0;
        if found.is_finite() {
            self.differences = self.differences.saturating_add(1).min(MEMORY);
            self.share +=
                (found.clamp(-MAX_SHARE, MAX_SHARE) - self.share) / f32::from(self.differences);
        }
    }

    /// Variance of the white noise, relative to the square of the one-sigma of the fix: 0, also if unknown, to 1.
    pub fn share(&self) -> f64 {
        if self.differences < ENOUGH { 0.0 } else { f64::from(self.share.clamp(0.0, 1.0)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Vector;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    /// White share of a receiver at 5 Hz after 100 fixes; `error_m` gives the north error, m, from white noise
    /// and time.
    fn learned(agility_mps2: f32, mut error_m: impl FnMut(f64, f64) -> f64) -> f64 {
        let mut scatter = PositionScatter::NONE;
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let place = Geodetic::from_degrees(48.0, 11.0, 500.0).unwrap();
        for step in 0..100 {
            let time_s = 0.2 * f64::from(step);
            let noise: f64 = StandardNormal.sample(&mut random);
            let position = place.displaced(Vector::new(error_m(noise, time_s), 0.0, 0.0));
            let fix = Fix::at(Time::ZERO + time_s, position);
            scatter.push(&fix, [1.0; 3], [agility_mps2, 0.0]);
        }
        scatter.share()
    }

    #[test]
    fn white_noise_is_found_and_slow_noise_and_motion_are_none() {
        // Noise on one of three axes: a third of its variance.
        let white = learned(0.0, |noise, _| 0.9 * noise);
        assert!((0.18..0.36).contains(&white), "{white}");
        let slow = learned(0.0, |_, time_s| 3.0 * libm::sin(0.05 * time_s));
        assert!(slow < 1e-6, "{slow}");
        let felt = learned(5.0, |_, time_s| 2.5 * time_s * time_s);
        assert!(felt < 1e-6, "{felt}");
    }

    #[test]
    fn a_jump_counts_for_less_than_a_fifth_of_what_the_fix_states() {
        let share = learned(0.0, |_, time_s| if time_s > 10.0 { 1e4 } else { 0.0 });
        assert!(share < 0.2, "{share}");
    }
}
