//! What vibration makes of the accelerometers' biases.
//!
//! An accelerometer that is shaken reads a little too much to one side: its response is not straight, and what is beyond
//! its band or its range is folded back. While the vibration stays as it is that is a part of the bias. When motors
//! start or stop the bias steps.

use crate::scalar::Scalar;

/// Watches vibration come and go.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rectification {
    /// Vibration before it last came or went, variance per axis, (m/s²)².
    before: [f32; 3],
    /// What is left of the time over which the bias opens, s.
    left_s: [f32; 3],
    /// By how much the bias opens a second, (m/s²)².
    opening: [f32; 3],
}

/// Share of the vibration by which the bias may step, one-sigma.
const SHARE: f32 = 0.1;
/// A level bias opens by this share of the variance: fixes tell it from tilt only after minutes, in which the attitude
/// pays for what is opened in vain.
const LEVEL: f32 = 0.25;
/// The opening is spread over so long, s.
const SPREAD_S: f32 = 2.0;
/// Vibration comes or goes where its variance grows or falls to so many times what it was.
const COMES: f32 = 4.0;
/// Less of it, (m/s²)², is that of hands and wind.
const LEAST: f32 = 0.04;

impl Rectification {
    /// Nothing shakes yet.
    pub const NONE: Self = Self { before: [0.0; 3], left_s: [0.0; 3], opening: [0.0; 3] };

    /// Takes in the `vibration` of late, variance per axis, (m/s²)², over a step; biases are assumed to be off by
    /// `assumed_mps2`, one-sigma.
    pub fn push<T: Scalar>(&mut self, vibration: [T; 3], interval_s: T, assumed_mps2: f64) {
        let axes = self.before.iter_mut().zip(vibration);
        for ((before, now), (left_s, opening)) in
            axes.zip(self.left_s.iter_mut().zip(&mut self.opening))
        {
            let now = now.wide() as f32;
            if *left_s > 0.0 {
                *left_s -= interval_s.wide() as f32;
                if *left_s <= 0.0 {
                    *before = now;
                    *opening = 0.0;
                } else {
                    let most = (assumed_mps2 * assumed_mps2) as f32;
                    *opening = (SHARE * SHARE * (now - *before).abs()).min(most) / SPREAD_S;
                }
            } else if (now > COMES * *before || *before > COMES * now) && now.max(*before) > LEAST {
                *left_s = SPREAD_S;
            }
        }
    }

    /// What `interval_s` adds to the variance of the biases, (m/s²)², where the axes point `down` by so much, cosines.
    ///
    /// # Source
    /// Equation (K24) of docs/equations.md.
    pub fn variance<T: Scalar>(&self, down: [T; 3], interval_s: T) -> [T; 3] {
        let [x, y, z] = down.map(|cosine| LEVEL + (1.0 - LEVEL) * (cosine * cosine).wide() as f32);
        let [along_x, along_y, along_z] = self.opening;
        [x * along_x, y * along_y, z * along_z].map(|rate| T::of(f64::from(rate)) * interval_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a vertical bias of 0.05 m/s² opens by, m/s², over `seconds` of a vibration of so many m/s² rms.
    fn opened(watch: &mut Rectification, seconds: i32, rms_mps2: f64) -> [f64; 3] {
        let mut variance = [0.0; 3];
        for _ in 0..100 * seconds {
            watch.push([0.0, 0.0, rms_mps2 * rms_mps2], 0.01, 0.05);
            for (sum, opened) in variance.iter_mut().zip(watch.variance([0.0, 0.0, 1.0], 0.01)) {
                *sum += opened;
            }
        }
        variance.map(f64::sqrt)
    }

    #[test]
    fn a_bias_opens_as_motors_start_and_stop_and_not_while_they_run() {
        let mut watch = Rectification::NONE;
        assert_eq!(opened(&mut watch, 60, 0.03), [0.0; 3]);
        for (rms_mps2, expected_mps2) in
            [(0.3, 0.0298), (0.5, 0.0), (0.25, 0.0), (0.03, 0.0298), (5.0, 0.05)]
        {
            let [x, y, z] = opened(&mut watch, 20, rms_mps2);
            assert!(x == 0.0 && y == 0.0, "{x} {y}");
            assert!((z - expected_mps2).abs() < 0.001, "{rms_mps2}: {z}, expected {expected_mps2}");
        }
        // A log that begins in flight.
        let mut watch = Rectification::NONE;
        let [.., z] = opened(&mut watch, 20, 5.0);
        assert!((z - 0.05).abs() < 0.001, "{z}");
    }

    #[test]
    fn numbers_that_are_none_open_nothing() {
        let mut watch = Rectification::NONE;
        watch.push([f64::NAN, f64::INFINITY, 1.0], 0.01, 0.05);
        watch.push([f64::NAN, f64::INFINITY, 1.0], 0.01, 0.05);
        let [x, y, z] = watch.variance([0.0, 0.6, 0.8], 1.0);
        assert!(x == 0.0 && y.is_finite() && z.is_finite(), "{x} {y} {z}");
    }
}
