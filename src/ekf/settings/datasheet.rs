//! Sensor errors in the units of datasheets. Each method's name states its unit.
//!
//! 1/√Hz is √s, and √h is 60 √s: a noise density of 1 °/s/√Hz is a random walk of 60 °/√h.

use super::config::{GpsModel, ImuModel};
use crate::earth::STANDARD_GRAVITY_MPS2;

/// Square root of an hour, √s.
const SQRT_HOUR: f64 = 60.0;
/// Seconds in an hour.
const HOUR_S: f64 = 3600.0;
/// Radius of the circle that contains half of the positions, in one-sigmas of an axis: √(2 ln 2).
const CIRCULAR_PROBABLE: f64 = 1.177_410_022_515_474_7;

/// # From a datasheet
///
/// ```
/// use hovernav::ekf::ImuModel;
///
/// // A BMI088, calibrated 20 K away.
/// let bmi088 = ImuModel::default()
///     .with_gyro_noise_degps_per_sqrt_hz(0.014)
///     .with_accel_noise_ug_per_sqrt_hz(190.0)
///     .with_gyro_bias_sigma_degps(0.3)
///     .with_accel_bias_sigma_mg(4.0)
///     .with_gyro_range_degps(2000.0)
///     .with_accel_range_g(24.0);
/// assert!((bmi088.angle_random_walk_rad - 2.44e-4).abs() < 1e-6);
/// assert!((bmi088.velocity_random_walk_mps - 1.86e-3).abs() < 1e-5);
/// // 0.014 °/s/√Hz is 0.84 °/√h.
/// let same = bmi088.with_angle_random_walk_deg_per_sqrt_h(0.84);
/// assert!((same.angle_random_walk_rad / bmi088.angle_random_walk_rad - 1.0).abs() < 1e-12);
/// ```
///
/// Every value must be 0 or above, as [`out_of_range`](Self::out_of_range) checks. The one-sigma of a bias describes
/// the bias in flight, which is mostly due to temperature. The bias instability of a datasheet is far smaller, and is
/// not used.
impl ImuModel {
    /// Sets the angle random walk, °/√h.
    #[must_use]
    pub const fn with_angle_random_walk_deg_per_sqrt_h(mut self, walk: f64) -> Self {
        self.angle_random_walk_rad = walk.to_radians() / SQRT_HOUR;
        self
    }

    /// Sets the angle random walk by the noise density of the gyros, °/s/√Hz.
    #[must_use]
    pub const fn with_gyro_noise_degps_per_sqrt_hz(mut self, density: f64) -> Self {
        self.angle_random_walk_rad = density.to_radians();
        self
    }

    /// Sets the velocity random walk, m/s/√h.
    #[must_use]
    pub const fn with_velocity_random_walk_mps_per_sqrt_h(mut self, walk: f64) -> Self {
        self.velocity_random_walk_mps = walk / SQRT_HOUR;
        self
    }

    /// Sets the velocity random walk by the noise density of the accelerometers, µg/√Hz.
    #[must_use]
    pub const fn with_accel_noise_ug_per_sqrt_hz(mut self, density: f64) -> Self {
        self.velocity_random_walk_mps = density * 1e-6 * STANDARD_GRAVITY_MPS2;
        self
    }

    /// Sets the one-sigma of the gyro bias, °/s.
    #[must_use]
    pub const fn with_gyro_bias_sigma_degps(mut self, sigma: f64) -> Self {
        self.gyro_bias_sigma_radps = sigma.to_radians();
        self
    }

    /// Sets the one-sigma of the gyro bias, °/h.
    #[must_use]
    pub const fn with_gyro_bias_sigma_deg_per_h(self, sigma: f64) -> Self {
        self.with_gyro_bias_sigma_degps(sigma / HOUR_S)
    }

    /// Sets the one-sigma of the accelerometer bias, mg.
    #[must_use]
    pub const fn with_accel_bias_sigma_mg(mut self, sigma: f64) -> Self {
        self.accel_bias_sigma_mps2 = sigma * 1e-3 * STANDARD_GRAVITY_MPS2;
        self
    }

    /// Sets the full scale of the gyros, °/s, as configured in the inertial unit.
    #[must_use]
    pub const fn with_gyro_range_degps(mut self, range: f64) -> Self {
        self.gyro_range_radps = range.to_radians();
        self
    }

    /// Sets the full scale of the accelerometers, g, as configured in the inertial unit.
    #[must_use]
    pub const fn with_accel_range_g(mut self, range: f64) -> Self {
        self.accel_range_mps2 = range * STANDARD_GRAVITY_MPS2;
        self
    }
}

/// # From a datasheet
///
/// These one-sigmas apply to fixes that report no accuracy.
impl GpsModel {
    /// Sets the one-sigma of horizontal position by the circular error probable, m: the radius of the circle that
    /// contains half of the positions.
    #[must_use]
    pub const fn with_horizontal_cep_m(mut self, radius_m: f64) -> Self {
        self.horizontal_sigma_m = radius_m / CIRCULAR_PROBABLE;
        self
    }

    /// Sets the one-sigma of height, m.
    #[must_use]
    pub const fn with_vertical_sigma_m(mut self, sigma_m: f64) -> Self {
        self.vertical_sigma_m = sigma_m;
        self
    }

    /// Sets the one-sigmas of velocity, m/s: each horizontal axis, and vertical.
    #[must_use]
    pub const fn with_velocity_sigma_mps(mut self, horizontal_mps: f64, vertical_mps: f64) -> Self {
        self.horizontal_velocity_sigma_mps = horizontal_mps;
        self.vertical_velocity_sigma_mps = vertical_mps;
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_the_positions_lie_within_the_circular_error_probable() {
        let sigma_m = GpsModel::default().with_horizontal_cep_m(2.5).horizontal_sigma_m;
        let inside = 1.0 - (-0.5 * (2.5 / sigma_m).powi(2)).exp();
        assert!((inside - 0.5).abs() < 1e-12, "{inside}");
    }

    #[test]
    fn biases_and_ranges_come_out_in_si_units() {
        let model = ImuModel::default()
            .with_gyro_bias_sigma_deg_per_h(10.0)
            .with_accel_bias_sigma_mg(5.0)
            .with_velocity_random_walk_mps_per_sqrt_h(0.6)
            .with_accel_range_g(16.0);
        let near = |found: f64, expected: f64| (found / expected - 1.0).abs() < 1e-3;
        assert!(near(model.gyro_bias_sigma_radps, 4.848e-5));
        assert!(near(model.accel_bias_sigma_mps2, 0.04903));
        assert!(near(model.velocity_random_walk_mps, 0.01));
        assert!(near(model.accel_range_mps2, 156.9));
    }
}
