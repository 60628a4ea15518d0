//! Effect of vibration on the accelerometers' biases.
//!
//! A vibrating accelerometer has a bias: its response is nonlinear, and motion beyond its band or range is rectified or
//! aliased. Under constant vibration this is part of the bias. When motors start or stop, the bias steps.

use crate::scalar::Scalar;

/// Detector of a change in vibration.
#[derive(Clone, Copy, Debug)]
pub(in crate::ekf) struct Rectification {
    /// Vibration before its last change, variance per axis, (m/s²)².
    before: [f32; 3],
    /// Remaining time, s, for which the bias variance grows.
    left_s: [f32; 3],
    /// Growth rate of the bias variance, (m/s²)²/s.
    opening: [f32; 3],
}

/// One-sigma of the bias step as a fraction of the vibration.
const SHARE: f32 = 0.1;
/// Fraction of the variance growth for a horizontal bias. Fixes separate such a bias from tilt only after minutes.
/// Until then, unnecessary growth costs attitude accuracy.
const LEVEL: f32 = 0.25;
/// Time over which the growth of the bias variance is spread, s.
const SPREAD_S: f32 = 2.0;
/// Factor by which the variance of a vibration must grow or fall to count as a change.
const COMES: f32 = 4.0;
/// Smallest vibration, (m/s²)², that counts as vibration of motors: hands and wind cause less.
const MIN: f32 = 0.04;

impl Rectification {
    /// State before any vibration.
    pub const NONE: Self = Self { before: [0.0; 3], left_s: [0.0; 3], opening: [0.0; 3] };

    /// Feeds the recent `vibration`, variance per axis, (m/s²)², over a sample interval. `assumed_mps2` is the assumed
    /// one-sigma of the biases.
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
            } else if (now > COMES * *before || *before > COMES * now) && now.max(*before) > MIN {
                *left_s = SPREAD_S;
            }
        }
    }

    /// Growth of the bias variances over `interval_s`, (m/s²)². `down` holds the cosines of the axes to the vertical.
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

    /// One-sigma added to the biases, m/s², over `seconds` of a vertical vibration of `rms_mps2`. The assumed one-sigma
    /// of the biases is 0.05 m/s².
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
        // A log that begins in flight, with the motors running.
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
