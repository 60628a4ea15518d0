//! Fraction of the horizontal specific force that is motion and makes the heading observable.
#![expect(clippy::indexing_slicing, reason = "axes count from 0 to 2, in arrays of three")]

use super::filter::Ekf;
use super::layout::{ACCEL_BIAS, ATTITUDE, Layout};
use super::scalar::Scalar;
use super::square;
use crate::earth::STANDARD_GRAVITY_MPS2;
use crate::frames::{Ned, Vector};

/// Averaging time of the horizontal specific force, s.
const AVERAGED_S: f64 = 1.0;
/// Smallest squared mean force that counts as motion, in multiples of the variance of its error.
const VARIANCES: f64 = 2.0;

/// Recent mean of the horizontal specific force, and the fraction of it that is motion.
///
/// A heading error rotates every measured change of velocity. It also rotates noise, and the gravity component from an
/// unknown tilt, but fixes cannot observe that rotation. If both counted as motion, the filter's heading would become
/// more certain every second in a calm hover, without any information.
#[derive(Clone, Copy, Debug)]
pub(super) struct LevelForce<T> {
    mean_mps2: [T; 2],
    /// Variance of the mean's error, both axes together, (m/s²)².
    variance: T,
    share: T,
}

impl<T: Scalar> LevelForce<T> {
    /// State before the first sample: the whole force counts as motion.
    pub const NONE: Self = Self { mean_mps2: [T::ZERO; 2], variance: T::ZERO, share: T::ONE };

    /// Feeds the velocity change by specific force over a sample interval, NED, m/s.
    pub fn push(&mut self, force_mps: Vector<Ned, T>, interval_s: T) {
        let averaged_s = T::of(AVERAGED_S);
        let left = (T::ONE - interval_s / averaged_s).max(T::ZERO);
        let [north, east, _] = force_mps.to_array();
        let north = self.mean_mps2[0] * left + north / averaged_s;
        let east = self.mean_mps2[1] * left + east / averaged_s;
        self.mean_mps2 = [north, east];
        let squared = north * north + east * east;
        let unsure = T::of(VARIANCES) * self.variance;
        // The comparison also maps NaN to zero.
        self.share = if squared > unsure { T::ONE - unsure / squared } else { T::ZERO };
    }

    /// Change of velocity or position by specific force, `force`, reduced horizontally to the fraction that makes the
    /// heading observable.
    ///
    /// # Source
    /// Equation (K23) of docs/equations.md.
    pub fn of_motion(&self, force: Vector<Ned, T>) -> Vector<Ned, T> {
        let [north, east, down] = force.to_array();
        Vector::new(north * self.share, east * self.share, down)
    }
}

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Updates the variance of the mean horizontal force's error. It is called at intervals, because the variance
    /// changes slowly.
    ///
    /// # Source
    /// Equation (K23) of docs/equations.md.
    pub(super) fn judge_level_force(&mut self) {
        if !self.config.mechanisms.level_force {
            self.level_force.variance = T::ZERO;
            return;
        }
        let [north, east, _] = self.state.body_to_ned.rows();
        let over_s = T::of(2.0 * AVERAGED_S);
        let sensed = self.accel_noise(over_s) * T::of(2.0 / 3.0);
        let gravity = T::of(STANDARD_GRAVITY_MPS2);
        let north = self.level_variance(&north, ATTITUDE + 1, -gravity);
        let east = self.level_variance(&east, ATTITUDE, gravity);
        self.level_force.variance = sensed + (north + east).max(T::ZERO);
    }

    /// Variance of the horizontal force along an axis with the body components `row`, (m/s²)². It comes from
    /// accelerometer biases and from the tilt, which projects `gravity` into the axis.
    fn level_variance(&self, row: &[T; 3], tilt: usize, gravity: T) -> T {
        let value = |one: usize, other: usize| self.covariance.value(one, other);
        let mut variance = square(gravity) * value(tilt, tilt);
        // Turns: 3.
        for axis in 0..3 {
            let bias = ACCEL_BIAS + axis;
            let next = (axis + 1) % 3;
            let twice = T::of(2.0) * row[axis];
            variance += square(row[axis]) * value(bias, bias)
                + twice * row[next] * value(bias, ACCEL_BIAS + next)
                - twice * gravity * value(tilt, bias);
        }
        variance
    }
}

#[cfg(test)]
mod tests {
    use super::super::{BaseEkf, EkfConfig};
    use super::*;
    use crate::earth::Geodetic;
    use crate::frames::{Body, Rotation};
    use crate::gps::Fix;
    use crate::imu::{ImuSample, Motion};
    use crate::ins::{Mounting, NavState, Start};
    use crate::time::Time;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng as _;
    use rand_distr::{Distribution as _, StandardNormal};

    const GYRO_BIAS_SIGMA_RADPS: f64 = 0.0015;
    const FORCE_SIGMA_MPS2: f64 = 0.4;
    const STEP_S: f64 = 0.02;

    /// Heading error and its one-sigma, rad, after a motionless hover of 240 s, with all errors drawn from the filter's
    /// assumptions.
    fn hovered(seed: u64) -> [f64; 2] {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        let mut vector = |sigma: f64| {
            let mut drawn = || {
                let normal: f64 = StandardNormal.sample(&mut generator);
                sigma * normal
            };
            [drawn(), drawn(), drawn()]
        };
        let mut config = EkfConfig::default();
        config.imu.gyro_bias_sigma_radps = GYRO_BIAS_SIGMA_RADPS;
        config.imu.gyro_bias_time_s = 1e6;
        config.imu.velocity_random_walk_mps = FORCE_SIGMA_MPS2 * STEP_S.sqrt();
        config.imu.accel_vibration_share = 0.0;
        config.imu.gyro_vibration_share = 0.0;
        let place = Geodetic::from_degrees(48.0, 11.0, 500.0).unwrap();
        let sure = Vector::new(0.01, 0.01, 0.02);
        let start = Start {
            state: NavState {
                time: Time::ZERO,
                position: place,
                velocity_mps: Vector::ZERO,
                body_to_ned: Rotation::IDENTITY,
            },
            attitude_sigma_rad: sure,
            velocity_sigma_mps: Vector::new(0.1, 0.1, 0.1),
            position_sigma_m: Vector::new(1.0, 1.0, 1.0),
            gyro_bias_radps: Vector::ZERO,
            gyro_bias_sigma_radps: None,
        };
        let off = Vector::<Ned>::from(vector(0.01));
        let heading = Vector::new(0.0, 0.0, 2.0 * off.z());
        let off = Vector::new(off.x(), off.y(), 0.0);
        let truth = Rotation::IDENTITY.turned_in_to(off + heading);
        let down = truth.inverse() * Vector::new(0.0, 0.0, -9.807);
        let bias = Vector::<Body>::from(vector(GYRO_BIAS_SIGMA_RADPS));
        let mut filter = BaseEkf::new(config, Mounting::default(), start);
        for k in 1..=12_000_i64 {
            let time = Time::from_nanoseconds(k * 20_000_000);
            let motion = Motion::Rates {
                angular_rate_radps: bias,
                specific_force_mps2: down + Vector::from(vector(FORCE_SIGMA_MPS2)),
            };
            filter.predict(&ImuSample::new(time, motion)).unwrap();
            if k % 10 == 0 {
                let [north, east, fall] = vector(0.1);
                let place = place.displaced(Vector::from(vector(1.0)));
                let fix = Fix {
                    horizontal_velocity_mps: Some([north, east]),
                    down_velocity_mps: Some(fall),
                    ..Fix::at(time, place)
                };
                filter.update_gps(&fix).unwrap();
            }
        }
        let solution = filter.solution();
        let error_rad = solution.body_to_ned.euler().yaw_rad - truth.euler().yaw_rad;
        [error_rad, solution.attitude_sigma_rad[2]]
    }

    /// Forty hovers: the heading drifts with the yaw gyro's bias, and the filter's one-sigma covers it.
    #[test]
    fn a_calm_hover_tells_no_heading() {
        let squares: f64 = (1..=40).map(hovered).map(|[error, sigma]| square(error / sigma)).sum();
        let normalised = (squares / 40.0).sqrt();
        let [error, sigma] = hovered(1);
        println!("{normalised:.2} of its one-sigma, {error:.3} and {sigma:.3} rad in the first");
        assert!((0.6..1.4).contains(&normalised), "{normalised}");
    }

    /// Force beyond its own error counts almost fully and at once as motion.
    #[test]
    fn a_manoeuvre_is_motion_within_a_tenth_of_a_second() {
        let mut force = LevelForce::<f64> { variance: 0.002, ..LevelForce::NONE };
        for _ in 0..5 {
            force.push(Vector::new(0.06, 0.0, -0.196), STEP_S);
        }
        assert!(force.of_motion(Vector::new(1.0, 1.0, 1.0)).x() > 0.95);
        force.push(Vector::new(f64::NAN, 0.0, 0.0), STEP_S);
        assert!(force.of_motion(Vector::new(1.0, 1.0, 1.0)) == Vector::new(0.0, 0.0, 1.0));
    }
}
